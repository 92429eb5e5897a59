//! The nets and their kd-tree as one safetensors file.
//!
//! | tensor | type, shape | what |
//! |---|---|---|
//! | `tree.axis` | i32 \[nodes\] | raw column that a node splits, -1 at a leaf |
//! | `tree.threshold` | f32 \[nodes\] | a row goes left where its column is below |
//! | `tree.left` | u32 \[nodes\] | left child; the right one is the next node; 0 at a leaf |
//! | `tree.cell` | u32 \[nodes\] | cell of a leaf, 4294967295 elsewhere |
//! | `cell.N.inputs` | u8 \[inputs\] | places in the list `inputs` of the metadata |
//! | `cell.N.input_offset`, `cell.N.input_scale` | f32 \[inputs\] | h = (x - offset) * scale |
//! | `cell.N.layer.K.weight`, `cell.N.layer.K.bias` | f32 \[out, in\], \[out\] | tanh after all but the last |
//! | `cell.N.exponential` | u8 \[1\] | 1: h = exp(min(h, 12)) after the last layer |
//! | `cell.N.output_scale`, `cell.N.output_offset` | f32 \[3\] | y = h * scale + offset |
//! | `cell.N.divide_base` | u8 \[1\] | 1: times the base colour |
//!
//! y is indirect outgoing radiance [W/(sr m²)] for an isotropic point light of 1 W/sr a channel.

use crate::ExportError;
use crate::tensor_file::{Tensor, floats, ids, write_tensors};
use rrf_field::columns;
use rrf_field::inputs::NAMES;
use rrf_field::model::CellModel;
use rrf_field::tree::Tree;
use safetensors::tensor::Dtype;
use std::path::Path;

/// Writes the model; `facts` go into the metadata beside the lists of names.
///
/// # Errors
/// [`ExportError::NoNet`], [`ExportError::Model`] for nets that contradict themselves, [`ExportError::Write`].
pub fn write_safetensors(
    path: &Path,
    tree: &Tree,
    cells: &[CellModel],
    facts: &[(&str, String)],
) -> Result<(), ExportError> {
    crate::nets_only(cells)?;
    let mut tensors = tree_tensors(tree);
    for cell in cells {
        tensors.extend(cell_tensors(cell)?);
    }
    let names = [
        ("format", "rrf-nets-1".into()),
        ("inputs", NAMES.join(" ")),
        ("raw_columns", columns::NAMES.join(" ")),
    ];
    write_tensors(path, &tensors, facts.iter().cloned().chain(names))
}

fn tree_tensors(tree: &Tree) -> Vec<Tensor> {
    let nodes = vec![tree.axis.len()];
    let axis = tree.axis.iter().flat_map(|&a| i32::from(a).to_le_bytes());
    vec![
        (
            "tree.axis".into(),
            Dtype::I32,
            nodes.clone(),
            axis.collect(),
        ),
        floats("tree.threshold", nodes.clone(), &tree.threshold),
        ids("tree.left", nodes.clone(), &tree.left),
        ids("tree.cell", nodes, &tree.cell),
    ]
}

fn cell_tensors(cell: &CellModel) -> Result<Vec<Tensor>, ExportError> {
    let refused = |reason: &str| ExportError::Model {
        cell: cell.cell,
        reason: reason.into(),
    };
    let sizes = &cell.shape.sizes;
    let inputs = cell.inputs.len();
    if cell.weights.len() != cell.shape.weights() || sizes.first() != Some(&inputs) {
        return Err(refused("as many weights as its layers need are not there"));
    }
    let name = |what: &str| format!("cell.{}.{what}", cell.cell);
    let mut tensors = vec![
        (name("inputs"), Dtype::U8, vec![inputs], cell.inputs.clone()),
        floats(&name("input_offset"), vec![inputs], &cell.input_offset),
        floats(&name("input_scale"), vec![inputs], &cell.input_scale),
        floats(&name("output_scale"), vec![3], &cell.output_scale),
        floats(&name("output_offset"), vec![3], &cell.output_offset),
        (
            name("divide_base"),
            Dtype::U8,
            vec![1],
            vec![u8::from(cell.divide_base)],
        ),
        (
            name("exponential"),
            Dtype::U8,
            vec![1],
            vec![u8::from(cell.exponential)],
        ),
    ];
    for (layer, (start, pair)) in cell
        .shape
        .offsets()
        .into_iter()
        .zip(sizes.windows(2))
        .enumerate()
    {
        let [fan_in, units] = [pair[0], pair[1]];
        let rows = cell.weights[start..start + units * (fan_in + 1)].chunks(fan_in + 1);
        let (bias, weight): (Vec<f32>, Vec<&[f32]>) = rows.map(|row| (row[0], &row[1..])).unzip();
        let layer = |what| name(&format!("layer.{layer}.{what}"));
        tensors.push(floats(
            &layer("weight"),
            vec![units, fan_in],
            &weight.concat(),
        ));
        tensors.push(floats(&layer("bias"), vec![units], &bias));
    }
    Ok(tensors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_field::net::{Shape, evaluate};
    use safetensors::SafeTensors;
    use safetensors::tensor::TensorView;
    use std::collections::HashMap;

    fn cell() -> CellModel {
        let shape = Shape {
            sizes: vec![2, 4, 3],
        };
        CellModel {
            cell: 0,
            kind: rrf_field::model::Kind::Net,
            inputs: vec![0, 21],
            input_offset: vec![0.5, -1.0],
            input_scale: vec![2.0, 0.25],
            weights: (0..shape.weights()).map(|i| (i as f32).sin()).collect(),
            shape,
            output_scale: [1.0, 2.0, 3.0],
            output_offset: [0.1, 0.2, 0.3],
            divide_base: true,
            exponential: true,
        }
    }

    fn read(view: &TensorView) -> Vec<f64> {
        let numbers = view.data().chunks_exact(4);
        numbers
            .map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap())))
            .collect()
    }

    /// A matrix product of the tensors is what the flat weights give.
    #[test]
    fn layers_are_the_nets() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nets.safetensors");
        let cell = cell();
        write_safetensors(&path, &Tree::single(), std::slice::from_ref(&cell), &[]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let file = SafeTensors::deserialize(&bytes).unwrap();
        let input = [0.3, -0.7];
        let mut h = input.to_vec();
        for layer in 0..2 {
            let weight = file
                .tensor(&format!("cell.0.layer.{layer}.weight"))
                .unwrap();
            let bias = read(&file.tensor(&format!("cell.0.layer.{layer}.bias")).unwrap());
            assert_eq!(weight.shape(), [bias.len(), h.len()]);
            h = read(&weight)
                .chunks(h.len())
                .zip(&bias)
                .map(|(row, b)| b + row.iter().zip(&h).map(|(w, x)| w * x).sum::<f64>())
                .map(|z| if layer == 0 { z.tanh() } else { z })
                .collect();
        }
        let weights: Vec<f64> = cell.weights.iter().map(|&w| w.into()).collect();
        let wanted = evaluate(&cell.shape, &weights, &input);
        // the same sums, the bias added at another place
        for (got, wanted) in h.iter().zip(&wanted) {
            assert!((got - wanted).abs() < 16.0 * f64::EPSILON, "{got} {wanted}");
        }
    }

    #[test]
    fn the_same_model_has_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let facts: Vec<(String, String)> = (0..8).map(|i| (format!("f{i}"), "1".into())).collect();
        let facts: Vec<(&str, String)> = facts.iter().map(|(n, v)| (&**n, v.clone())).collect();
        let write = |name: &str| {
            let path = folder.path().join(name);
            write_safetensors(&path, &Tree::single(), &[cell()], &facts).unwrap();
            std::fs::read(&path).unwrap()
        };
        let first = write("a");
        assert_eq!(first, write("b"));
        let (_, metadata) = SafeTensors::read_metadata(&first).unwrap();
        assert_eq!(metadata.metadata().as_ref().map(HashMap::len), Some(11));
        assert_eq!(SafeTensors::deserialize(&first).unwrap().len(), 4 + 11);
    }

    #[test]
    fn contradictions_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nets.safetensors");
        let mut short = cell();
        short.weights.pop();
        let error = write_safetensors(&path, &Tree::single(), &[short], &[]).unwrap_err();
        assert!(matches!(error, ExportError::Model { cell: 0, .. }));
        assert!(!path.exists());
    }
}
