//! The whole model as one ONNX graph (operator set 17): kd-tree walk, derived inputs, nets.
//!
//! Input `raw`, f32 \[rows, 18\]: the raw columns in the order of `schemas/samples.toml`. Outputs
//! `rgb`, f32 \[rows, 3\]: indirect outgoing radiance [W/(sr m²)] for an isotropic point light of
//! 1 W/sr a channel; `cell`, i64 \[rows\]: the cell that answered. Rows of one cell are gathered,
//! go through that cell's net together and are scattered back.

mod expression;
mod format;
mod graph;

use crate::ExportError;
use crate::error::write_file;
use expression::Expression;
use format::{Entry, FLOAT, INT64, Model, OperatorSet};
use graph::{Builder, Value, value_info};
use prost::Message;
use rrf_field::MAX_EXPONENT;
use rrf_field::columns;
use rrf_field::inputs;
use rrf_field::model::CellModel;
use rrf_field::tree::{LEAF, Tree};
use std::cell::RefCell;
use std::path::Path;

const OPERATOR_SET: i64 = 17;
const IR_VERSION: i64 = 8;

/// Writes the model; `facts` become metadata.
///
/// # Errors
/// [`ExportError::NoNet`], [`ExportError::Model`] for nets that contradict themselves, [`ExportError::Write`].
pub fn write_onnx(
    path: &Path,
    tree: &Tree,
    cells: &[CellModel],
    facts: &[(&str, String)],
) -> Result<(), ExportError> {
    crate::nets_only(cells)?;
    let mut g = Builder::default();
    let raw = Value::Input;
    let cell = walk(&mut g, tree, raw);
    g.name(cell, "cell");
    let inputs = all_inputs(&mut g, raw);
    let base = columns_of(&mut g, raw, columns::BASE, 3);
    let (rows, three) = (row_count(&mut g, raw), g.ints(&[1], &[3]));
    let shape = g.op_int("Concat", &[rows, three], "axis", 0);
    let mut rgb = g.zeros(shape, FLOAT);
    for model in cells {
        rgb = one_cell(&mut g, model, cell, inputs, base, rgb)?;
    }
    g.name(rgb, "rgb");
    let outputs = vec![
        value_info("rgb", FLOAT, &[3]),
        value_info("cell", INT64, &[]),
    ];
    let graph = g.finish(value_info(graph::INPUT, FLOAT, &[columns::COUNT]), outputs);
    let entry = |(key, value): &(&str, String)| Entry {
        key: key.to_string(),
        value: value.clone(),
    };
    let model = Model {
        ir_version: IR_VERSION,
        producer_name: "rrf".into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        graph: Some(graph),
        opset_import: vec![OperatorSet {
            domain: String::new(),
            version: OPERATOR_SET,
        }],
        metadata: facts.iter().map(entry).collect(),
    };
    write_file(path, &model.encode_to_vec())
}

/// \[rows\], as a tensor of shape \[1\].
fn row_count(g: &mut Builder, raw: Value) -> Value {
    let shape = g.op("Shape", &[raw]);
    let first = g.ints(&[1], &[0]);
    g.op("Gather", &[shape, first])
}

/// The cell of every row: as many steps as the tree is deep; a leaf leads to itself.
fn walk(g: &mut Builder, tree: &Tree, raw: Value) -> Value {
    let nodes = tree.axis.len();
    let leaf = |i: usize| tree.axis[i] == LEAF;
    let each = |f: &dyn Fn(usize) -> i64| (0..nodes).map(f).collect::<Vec<i64>>();
    let axis = each(&|i| if leaf(i) { 0 } else { tree.axis[i].into() });
    let left = each(&|i| {
        if leaf(i) {
            i as i64
        } else {
            tree.left[i].into()
        }
    });
    let cell = each(&|i| tree.cell[i].into());
    let threshold: Vec<f32> = (0..nodes)
        .map(|i| {
            if leaf(i) {
                f32::INFINITY
            } else {
                tree.threshold[i]
            }
        })
        .collect();
    let [axis, left, cell] = [axis, left, cell].map(|ids| g.ints(&[nodes], &ids));
    let threshold = g.floats(&[nodes], &threshold);
    let one = g.ints(&[1], &[1]);
    let rows = row_count(g, raw);
    let mut node = g.zeros(rows, INT64);
    for _ in 0..depth(tree) {
        let column = g.op("Gather", &[axis, node]);
        let column = g.op("Unsqueeze", &[column, one]);
        let value = g.op_int("GatherElements", &[raw, column], "axis", 1);
        let value = g.op("Squeeze", &[value, one]);
        let at = g.op("Gather", &[threshold, node]);
        let right = g.op("GreaterOrEqual", &[value, at]);
        let right = g.op_int("Cast", &[right], "to", INT64.into());
        let below = g.op("Gather", &[left, node]);
        node = g.op("Add", &[below, right]);
    }
    g.op("Gather", &[cell, node])
}

/// Splits between the root and the deepest leaf.
fn depth(tree: &Tree) -> usize {
    let mut depth = vec![0usize; tree.axis.len()];
    for node in 0..tree.axis.len() {
        if tree.axis[node] != LEAF {
            let left = tree.left[node] as usize;
            // children come after their parent
            (depth[left], depth[left + 1]) = (depth[node] + 1, depth[node] + 1);
        }
    }
    depth.into_iter().max().unwrap_or(0)
}

/// `count` columns from `first` on, \[rows, count\].
fn columns_of(g: &mut Builder, raw: Value, first: usize, count: usize) -> Value {
    let places: Vec<i64> = (first..first + count).map(|c| c as i64).collect();
    let places = g.ints(&[count], &places);
    g.op_int("Gather", &[raw, places], "axis", 1)
}

/// Raw and derived inputs in the order of `rrf_field::inputs`, \[rows, inputs\].
fn all_inputs(g: &mut Builder, raw: Value) -> Value {
    let columns: [Value; inputs::RAW] = std::array::from_fn(|c| columns_of(g, raw, c, 1));
    let graph = RefCell::new(std::mem::take(g));
    let all = inputs::evaluate_all(columns.map(|value| Expression {
        graph: &graph,
        value,
    }));
    let all = all.map(|expression| expression.value);
    *g = graph.into_inner();
    g.op_int("Concat", &all, "axis", 1)
}

/// `rgb` with the rows of one cell replaced by its net's answers.
fn one_cell(
    g: &mut Builder,
    model: &CellModel,
    cell: Value,
    inputs: Value,
    base: Value,
    rgb: Value,
) -> Result<Value, ExportError> {
    let sizes = &model.shape.sizes;
    if model.weights.len() != model.shape.weights() || sizes.first() != Some(&model.inputs.len()) {
        return Err(ExportError::Model {
            cell: model.cell,
            reason: "as many weights as its layers need are not there".into(),
        });
    }
    let id = g.ints(&[1], &[model.cell.into()]);
    let here = g.op("Equal", &[cell, id]);
    let places = g.op("NonZero", &[here]);
    // [1, m] to [m, 1]
    let places = g.op("Transpose", &[places]);
    let one = g.ints(&[1], &[1]);
    let rows = g.op("Squeeze", &[places, one]);
    let mine = g.op("Gather", &[inputs, rows]);
    let columns: Vec<i64> = model.inputs.iter().map(|&i| i.into()).collect();
    let columns = g.ints(&[columns.len()], &columns);
    let mut h = g.op_int("Gather", &[mine, columns], "axis", 1);
    let offset = g.floats(&[model.input_offset.len()], &model.input_offset);
    let scale = g.floats(&[model.input_scale.len()], &model.input_scale);
    h = g.op("Sub", &[h, offset]);
    h = g.op("Mul", &[h, scale]);
    let layers = sizes.len() - 1;
    for (layer, start) in model.shape.offsets().into_iter().enumerate() {
        let (fan_in, units) = (sizes[layer], sizes[layer + 1]);
        let flat = model.weights[start..start + units * (fan_in + 1)].chunks(fan_in + 1);
        let (bias, weight): (Vec<f32>, Vec<&[f32]>) = flat.map(|row| (row[0], &row[1..])).unzip();
        let weight = g.floats(&[units, fan_in], &weight.concat());
        let bias = g.floats(&[units], &bias);
        h = g.op_int("Gemm", &[h, weight, bias], "transB", 1);
        if layer + 1 < layers {
            h = g.op("Tanh", &[h]);
        }
    }
    if model.exponential {
        let most = g.floats(&[], &[MAX_EXPONENT]);
        h = g.op("Min", &[h, most]);
        h = g.op("Exp", &[h]);
    }
    let scale = g.floats(&[3], &model.output_scale);
    let offset = g.floats(&[3], &model.output_offset);
    h = g.op("Mul", &[h, scale]);
    h = g.op("Add", &[h, offset]);
    if model.divide_base {
        let base = g.op("Gather", &[base, rows]);
        h = g.op("Mul", &[h, base]);
    }
    Ok(g.op("ScatterND", &[rgb, places, h]))
}
