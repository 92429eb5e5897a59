//! Whether a model is one that can be evaluated.

use crate::inputs;
use crate::model::CellModel;

impl CellModel {
    /// Whether the model can be evaluated: every length fits its kind and layers, every number is
    /// finite. Otherwise what is wrong with it.
    pub fn fault(&self) -> Option<String> {
        let sizes = &self.shape.sizes;
        let count = self.inputs.len();
        let unknown = |input: &&u8| usize::from(**input) >= inputs::COUNT;
        if let Some(input) = self.inputs.iter().find(unknown) {
            return Some(format!("input {input} is not known"));
        }
        // a cell that is one colour all over has a net of no inputs: its mean
        let hidden = sizes.get(1..).unwrap_or_default();
        if self.kind.is_net()
            && (hidden.is_empty() || hidden.contains(&0) || !sizes.ends_with(&[3]))
        {
            return Some(format!("layers {sizes:?} are not inputs, hidden units, 3"));
        }
        if self.exponential && !self.kind.is_net() {
            return Some("its outputs are exponents, as only those of nets are".into());
        }
        let lengths = [count, self.input_offset.len(), self.input_scale.len()];
        if sizes.first() != Some(&count) || lengths != [count; 3] {
            return Some(format!(
                "{lengths:?} inputs, offsets and scales for layers {sizes:?}"
            ));
        }
        let weights = self.kind.weights(sizes);
        if weights != Some(self.weights.len()) {
            let (found, kind) = (self.weights.len(), self.kind.name());
            let own = weights.map_or("more than can be".into(), |n| n.to_string());
            return Some(format!(
                "{found} weights, layers {sizes:?} of kind {kind} have {own}"
            ));
        }
        let parts: [(&str, &[f32]); 5] = [
            ("input_offset", &self.input_offset),
            ("input_scale", &self.input_scale),
            ("weights", &self.weights),
            ("output_scale", &self.output_scale),
            ("output_offset", &self.output_offset),
        ];
        let bad = parts.iter().find(|(_, x)| !x.iter().all(|x| x.is_finite()));
        bad.map(|(name, _)| format!("{name} holds a number that is not finite"))
    }
}
