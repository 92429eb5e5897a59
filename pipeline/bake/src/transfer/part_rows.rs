//! Parts of cells as rows of a table, and back.

use rrf_store::model::TransferPartRow;
use rrf_transfer::{PackedRows, PartFit, TransferNet, TransferNodes};

/// Names of what nets may see, in the order of their numbers.
const INPUTS: [&str; 9] = ["px", "py", "pz", "nx", "ny", "nz", "rx", "ry", "rz"];
const NET: &str = "net";
const NODES: &str = "nodes";

/// A part as a row; none of a part that is nothing.
pub(super) fn part_row(cell_id: u32, name: &str, part: &PartFit) -> Option<TransferPartRow> {
    let row = TransferPartRow {
        cell_id,
        part: name.into(),
        ..TransferPartRow::default()
    };
    match part {
        PartFit::Nothing => None,
        PartFit::Net(net) => {
            let inputs = net.inputs.iter();
            let inputs = inputs.filter_map(|&input| INPUTS.get(usize::from(input)));
            Some(TransferPartRow {
                kind: NET.into(),
                inputs: inputs.map(|name| name.to_string()).collect(),
                input_mean: net.mean.clone(),
                input_scale: net.scale.clone(),
                input_low: net.low.clone(),
                input_high: net.high.clone(),
                hidden: net.hidden.clone(),
                output_scales: net.output.scales.clone(),
                output: net.output.values.clone(),
                ..row
            })
        }
        PartFit::Nodes(nodes) => Some(TransferPartRow {
            kind: NODES.into(),
            turns: nodes.turns.to_vec(),
            places: nodes.places.clone(),
            normals: nodes.normals.clone(),
            value_scales: nodes.values.scales.clone(),
            values: nodes.values.values.clone(),
            ..row
        }),
    }
}

/// The part of a row of a cell with so many coefficients, or what is wrong with it.
pub(super) fn part(row: TransferPartRow, rank: usize) -> Result<PartFit, String> {
    let numbers = [
        ("input_mean", &row.input_mean),
        ("input_scale", &row.input_scale),
        ("input_low", &row.input_low),
        ("input_high", &row.input_high),
        ("hidden", &row.hidden),
        ("output_scales", &row.output_scales),
        ("turns", &row.turns),
        ("places", &row.places),
        ("normals", &row.normals),
        ("value_scales", &row.value_scales),
    ];
    finite(&numbers)?;
    if rank == 0 {
        return Err("its cell has no coefficients".into());
    }
    match row.kind.as_str() {
        NET => net(row, rank).map(PartFit::Net),
        NODES => nodes(row, rank).map(PartFit::Nodes),
        kind => Err(format!(
            "kind {kind:?} is not known; known are {NET}, {NODES}"
        )),
    }
}

/// The first column of some that holds a number that is none.
pub(super) fn finite(columns: &[(&str, &Vec<f32>)]) -> Result<(), String> {
    let odd = |values: &[f32]| values.iter().any(|x| !x.is_finite());
    match columns.iter().find(|(_, values)| odd(values)) {
        Some((name, _)) => Err(format!("{name} holds a number that is not finite")),
        None => Ok(()),
    }
}

fn net(row: TransferPartRow, rank: usize) -> Result<TransferNet, String> {
    let place = |name: &String| {
        let at = INPUTS.iter().position(|input| input == name);
        at.map(|at| at as u8)
            .ok_or_else(|| format!("input {name:?} is not known"))
    };
    let inputs: Vec<u8> = row.inputs.iter().map(place).collect::<Result<_, _>>()?;
    let count = inputs.len();
    let mut net = TransferNet {
        inputs,
        mean: row.input_mean,
        scale: row.input_scale,
        low: row.input_low,
        high: row.input_high,
        hidden: row.hidden,
        output: PackedRows::default(),
    };
    for (name, values) in [
        ("input_mean", &net.mean),
        ("input_scale", &net.scale),
        ("input_low", &net.low),
        ("input_high", &net.high),
    ] {
        length(name, values, count)?;
    }
    if count > INPUTS.len() {
        return Err(format!(
            "{count} inputs; a net has {} at most",
            INPUTS.len()
        ));
    }
    if net.low.iter().zip(&net.high).any(|(low, high)| low > high) {
        return Err("an input_low is above its input_high".into());
    }
    length("hidden", &net.hidden, net.units() * (count + 1))?;
    let shape = (net.features(), 3 * rank);
    net.output = packed("output", (row.output_scales, row.output), shape)?;
    Ok(net)
}

fn nodes(row: TransferPartRow, rank: usize) -> Result<TransferNodes, String> {
    let turns = <[f32; 2]>::try_from(row.turns.as_slice());
    let mut nodes = TransferNodes {
        turns: turns.map_err(|_| "turns are not two numbers".to_string())?,
        places: row.places,
        normals: row.normals,
        values: PackedRows::default(),
    };
    length("places", &nodes.places, nodes.len() * INPUTS.len())?;
    length("normals", &nodes.normals, nodes.len() * 3)?;
    let shape = (3 * nodes.len(), 3 * rank);
    nodes.values = packed("values", (row.value_scales, row.values), shape)?;
    Ok(nodes)
}

/// Packed numbers of so many rows and columns.
pub(super) fn packed<T>(
    name: &str,
    (scales, values): (Vec<f32>, Vec<T>),
    (rows, width): (usize, usize),
) -> Result<PackedRows<T>, String> {
    length(&format!("the scales of {name}"), &scales, rows)?;
    length(name, &values, rows * width)?;
    Ok(PackedRows {
        width,
        scales,
        values,
    })
}

/// Checks how many numbers a column holds.
pub(super) fn length<T>(name: &str, values: &[T], expected: usize) -> Result<(), String> {
    match values.len() {
        found if found == expected => Ok(()),
        found => Err(format!("{name} has {found} numbers, not {expected}")),
    }
}
