//! The inputs that a cell's net gets, and their scales.

use super::redundant::{Redundant, is_redundant};
use crate::config::TrainConfig;
use crate::error::TrainError;
use crate::rows::order::OrderedRows;
use crate::rows::units::Input;
use rrf_field::columns;
use rrf_field::inputs::{self, INPUTS, NAMES};
use std::ops::Range;

/// Whether the light over the base colour of a Lambertian point can depend on an input: not on
/// the viewer, not on the material.
fn matters_to_lambert(id: u8) -> bool {
    let (viewer, material) = (columns::V..columns::L, columns::BASE..columns::COUNT);
    !inputs::depends_on(id, viewer) && !inputs::depends_on(id, material)
}

/// Inputs named in the configuration that a cell gets, in its order, and those that it does without.
pub(crate) fn choose(config: &TrainConfig) -> Result<(Vec<u8>, Vec<u8>), TrainError> {
    let named = input_ids(config)?;
    Ok(named
        .into_iter()
        .partition(|&id| !config.divide_base || matters_to_lambert(id)))
}

/// Normal and material, where they are asked for beside a position that tells them, and the inputs that
/// are left.
pub(crate) fn redundant(
    ids: Vec<u8>,
    rows: &OrderedRows,
    train: Range<usize>,
) -> (Vec<u8>, Vec<u8>) {
    let position = (columns::P..columns::N).all(|c| ids.contains(&(c as u8)));
    let left_out: Vec<Redundant> = [Redundant::Normal, Redundant::Material]
        .into_iter()
        .filter(|what| {
            let asked_for = |id: &u8| what.columns().contains(&usize::from(*id));
            position && ids.iter().any(asked_for) && is_redundant(*what, rows, train.clone())
        })
        .collect();
    ids.into_iter().partition(|&id| {
        let says = |what: &Redundant| what.columns().contains(&usize::from(id));
        left_out.iter().any(says)
    })
}

fn input_ids(config: &TrainConfig) -> Result<Vec<u8>, TrainError> {
    let find = |name: &String| {
        inputs::place(name).ok_or_else(|| TrainError::Input {
            name: name.clone(),
            known: NAMES.join(", "),
        })
    };
    config.inputs.iter().map(find).collect()
}

/// Hands on an input's values over some rows, in order.
fn each_value(id: u8, rows: &OrderedRows, range: Range<usize>, mut see: impl FnMut(f64)) {
    let mut values = Vec::new();
    rows.each(range, |chunk, rows| {
        inputs::fill(id, &chunk.columns, &mut values);
        values[rows].iter().for_each(|x| see(f64::from(*x)));
    });
}

/// The inputs `ids` scaled over the training rows `train`, and those that do not vary there:
/// whose standard deviation is below [`WOBBLE`] of the largest absolute value among the coordinates
/// they belong with (f32 coordinates of a plane wobble by 1e-7 of that).
///
/// In a `lambert` cell also those that differ from their usual value in fewer than [`FEWEST`] rows. A
/// strip of wall in a cell of floor is a few rows, many deviations away: points there would get
/// whatever a net makes of such inputs, and shine. Where materials are glossy such a strip may be
/// ten times as dark as its cell; even three rows are then better than none (docs/science/report.md).
pub(crate) fn scale(
    ids: &[u8],
    rows: &OrderedRows,
    train: Range<usize>,
    lambert: bool,
) -> (Vec<Input>, Vec<u8>) {
    let n = train.len().max(1) as f64;
    // largest absolute value, mean
    let sized: Vec<(u8, f64, f64)> = (ids.iter())
        .map(|&id| {
            let (mut largest, mut sum) = (0.0f64, 0.0);
            each_value(id, rows, train.clone(), |x| {
                largest = largest.max(x.abs());
                sum += x;
            });
            (id, largest, sum / n)
        })
        .collect();
    let (mut inputs, mut dropped) = (Vec::new(), Vec::new());
    for &(id, _, mean) in &sized {
        let family = (sized.iter())
            .filter(|(other, ..)| same_family(*other, id))
            .map(|(_, size, _)| *size)
            .fold(0.0, f64::max);
        let usual = usual(id, rows, train.clone());
        let (mut squares, mut differ) = (0.0, 0);
        each_value(id, rows, train.clone(), |x| {
            squares += (x - mean) * (x - mean);
            differ += usize::from((x - usual).abs() > WOBBLE * family);
        });
        let deviation = (squares / n).sqrt();
        let (offset, scale) = (mean as f32, (1.0 / deviation) as f32);
        // An f32 scale underflows for spreads beyond 1e38: such an input cannot be stored.
        let varies = deviation > WOBBLE * family && !(lambert && differ < FEWEST);
        if varies && scale.is_normal() && offset.is_finite() {
            inputs.push(Input { id, offset, scale });
        } else {
            dropped.push(id);
        }
    }
    (inputs, dropped)
}

/// Share of the largest coordinate that rounding makes.
const WOBBLE: f64 = 1e-5;
/// Rows that have to differ.
const FEWEST: usize = 5;
/// Rows that tell what is usual.
const FEW: usize = 33;

/// An input's usual value: the median over the first few rows, which are in random order.
fn usual(id: u8, rows: &OrderedRows, train: Range<usize>) -> f64 {
    let mut first = Vec::with_capacity(FEW);
    each_value(
        id,
        rows,
        train.start..train.end.min(train.start + FEW),
        |x| {
            first.push(x);
        },
    );
    first.sort_by(f64::total_cmp);
    first.get(first.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Coordinates of one vector in one unit; every other input stands alone.
fn same_family(a: u8, b: u8) -> bool {
    let vector = |id: u8| INPUTS.get(usize::from(id)).map(|input| input.vector);
    vector(a) == vector(b)
}
