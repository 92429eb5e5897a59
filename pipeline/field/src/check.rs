//! Whether a model is one that can be evaluated.

use crate::model::{CellModel, INPUTS, Kind};

/// What is wrong with a model, if anything.
pub fn check(cell: usize, model: &CellModel) -> Result<(), &'static str> {
    let sizes = &model.shape.sizes;
    let fault = if model.cell as usize != cell {
        "it names another cell"
    } else if model.kind != Kind::Net {
        return check_baseline(model);
    } else if sizes.len() < 2 || sizes[1..].contains(&0) {
        // no inputs: a cell that is one colour all over
        "its net has no layer or an empty one"
    } else if sizes.last() != Some(&3) {
        "its net does not have 3 outputs"
    } else if model.inputs.len() != sizes[0] {
        "its net does not have as many inputs as are named"
    } else if model.inputs.iter().any(|&i| usize::from(i) >= INPUTS.len()) {
        "it reads an input that this program does not know"
    } else if model.input_offset.len() != sizes[0] || model.input_scale.len() != sizes[0] {
        "it does not scale each input"
    } else if model.weights.len() != model.shape.weights() {
        "it does not have as many weights as its shape needs"
    } else if !finite(model) {
        "a weight or scale is not finite"
    } else {
        return Ok(());
    };
    Err(fault)
}

/// The same of one that is no net.
fn check_baseline(model: &CellModel) -> Result<(), &'static str> {
    let inputs = model.inputs.len();
    let fault = if model.kind.weights(&model.shape.sizes) != Some(model.weights.len()) {
        "it does not have the weights that its kind and layers ask for"
    } else if [model.input_offset.len(), model.input_scale.len()] != [inputs; 2]
        || model.shape.sizes.first() != Some(&inputs)
    {
        "it does not scale each input"
    } else if model.inputs.iter().any(|&i| usize::from(i) >= INPUTS.len()) {
        "it reads an input that this program does not know"
    } else if model.exponential {
        "its outputs are exponents, as only those of nets are"
    } else if !finite(model) {
        "a weight or scale is not finite"
    } else {
        return Ok(());
    };
    Err(fault)
}

fn finite(model: &CellModel) -> bool {
    [
        model.input_offset.as_slice(),
        &model.input_scale,
        &model.weights,
        &model.output_scale,
        &model.output_offset,
    ]
    .iter()
    .all(|values| values.iter().all(|x| x.is_finite()))
}
