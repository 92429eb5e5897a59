//! First weights from a net that was fitted before: to a larger cell around this one, to fewer of
//! its rows, or with fewer units.
//!
//! The net is written in this cell's scales, so that it answers as before; units that it does not
//! have read what they like and are not listened to yet, which changes nothing either.

use super::initialization::random_weights;
use crate::cell::Cell;
use crate::rows::chunk::Chunk;
use rrf_field::columns::Columns;
use rrf_field::inputs;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;

/// First weights of a net of `shape` that goes on from the cell's earlier one, if there is one
/// that it can go on from.
pub(crate) fn earlier_weights(cell: &Cell, shape: &Shape) -> Option<Vec<f64>> {
    let earlier = cell.earlier.filter(|_| cell.train.len() > 0)?;
    let mut one = Columns::default();
    let row = |chunk: &Chunk, at: usize| chunk.columns.row(at);
    one.push(cell.raw.show(0, 1, row));
    let value = |id: u8| {
        let mut values = Vec::new();
        inputs::fill(id, &one, &mut values);
        values.first().copied().unwrap_or(f32::NAN)
    };
    let to = cell.model(Kind::Net, shape.clone(), Vec::new());
    weights(earlier, &to, value, &random_weights(cell, shape, 0))
}

/// The weights of a net of the shape and the units of `to` that answers as `model` does; where `model`
/// has fewer units the others' incoming weights are those of `fresh`, their outgoing ones zero.
/// `value` tells an input that `to` does not have. None where the two differ in kind, in depth, or
/// `model` has more units.
fn weights(
    model: &CellModel,
    to: &CellModel,
    value: impl Fn(u8) -> f32,
    fresh: &[f64],
) -> Option<Vec<f64>> {
    let (old, new, shape) = (&model.shape.sizes, &to.shape.sizes, &to.shape);
    let hidden = |sizes: &[usize]| {
        sizes
            .get(1..sizes.len().saturating_sub(1))
            .map(<[usize]>::to_vec)
    };
    let (had, has) = (hidden(old)?, hidden(new)?);
    let fits = had.len() == has.len() && had.iter().zip(&has).all(|(a, b)| a <= b);
    let same = model.divide_base == to.divide_base && model.exponential == to.exponential;
    if !model.kind.is_net() || !fits || !same || had.is_empty() || fresh.len() != shape.weights() {
        return None;
    }
    let mut w = fresh.to_vec();
    let layers = old.windows(2).zip(new.windows(2));
    let places = model.shape.offsets().into_iter().zip(shape.offsets());
    for (layer, ((old, new), (from, into))) in layers.zip(places).enumerate() {
        let from = model.weights.get(from..)?.chunks_exact(old[0] + 1);
        let into = w.get_mut(into..)?.chunks_exact_mut(new[0] + 1);
        for (from, into) in from.take(old[1]).zip(into) {
            let from: Vec<f64> = from.iter().map(|&w| f64::from(w)).collect();
            if layer == 0 {
                first_layer(model, to, &value, &from, into);
            } else {
                into.fill(0.0);
                into[..from.len()].copy_from_slice(&from);
            }
        }
    }
    let outputs = shape.offsets().last().copied()?;
    let width = has.last()? + 1;
    for (c, row) in w[outputs..].chunks_exact_mut(width).enumerate() {
        output(model, to, c, row);
    }
    w.iter().all(|w| w.is_finite()).then_some(w)
}

/// w_old (x - o_old) s_old = w_new (x - o_new) s_new + what the bias takes.
fn first_layer(
    model: &CellModel,
    to: &CellModel,
    value: impl Fn(u8) -> f32,
    from: &[f64],
    into: &mut [f64],
) {
    into.fill(0.0);
    into[0] = from[0];
    for (k, id) in model.inputs.iter().enumerate() {
        let slope = from[k + 1] * f64::from(model.input_scale[k]);
        let old_offset = f64::from(model.input_offset[k]);
        match to.inputs.iter().position(|new| new == id) {
            Some(place) => {
                let (offset, scale) = (to.input_offset[place], to.input_scale[place]);
                into[place + 1] = slope / f64::from(scale);
                into[0] += slope * (f64::from(offset) - old_offset);
            }
            None => into[0] += slope * (f64::from(value(*id)) - old_offset),
        }
    }
}

/// s_old exp(z) = s_new exp(z + ln(s_old / s_new)); or o + s z in other scales.
fn output(model: &CellModel, to: &CellModel, c: usize, row: &mut [f64]) {
    let [old, new] = [model.output_scale[c], to.output_scale[c]].map(f64::from);
    if to.exponential {
        if old > 0.0 && new > 0.0 {
            row[0] += (old / new).ln();
        }
        return;
    }
    let moved = f64::from(model.output_offset[c]) - f64::from(to.output_offset[c]);
    row.iter_mut().for_each(|w| *w *= old / new);
    row[0] += moved / new;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::synthetic;
    use rrf_field::net;

    /// The net as before, in other scales, with an input less, one more, and more units:
    /// equal answers.
    #[test]
    fn answers_as_before() {
        for exponential in [false, true] {
            let old = Shape {
                sizes: vec![4, 5, 3, 3],
            };
            let model = CellModel {
                kind: Kind::Net,
                cell: 0,
                inputs: vec![0, 3, 7, 9],
                input_offset: vec![0.3, -0.1, 0.7, 0.2],
                input_scale: vec![2.0, 0.5, 1.5, 3.0],
                weights: synthetic::weights(&old, 1, 0.9)
                    .iter()
                    .map(|w| *w as f32)
                    .collect(),
                shape: old,
                output_scale: [2.0, 0.7, 1.3],
                output_offset: if exponential {
                    [0.0; 3]
                } else {
                    [0.1, 0.4, -0.2]
                },
                divide_base: false,
                exponential,
            };
            let to = CellModel {
                inputs: vec![0, 1, 7, 9],
                input_offset: vec![0.5, 0.0, 0.6, -0.3],
                input_scale: vec![4.0, 1.0, 2.5, 1.0],
                shape: Shape {
                    sizes: vec![4, 7, 6, 3],
                },
                output_scale: [1.1, 0.2, 2.0],
                output_offset: if exponential {
                    [0.0; 3]
                } else {
                    [-0.3, 0.0, 0.2]
                },
                ..model.clone()
            };
            let value = |id| if id == 3 { 0.45 } else { f32::NAN };
            let fresh = synthetic::weights(&to.shape, 2, 0.9);
            let w = weights(&model, &to, value, &fresh).unwrap();
            let values = [0.4f64, -0.8, 0.9, 0.35];
            let seen = [values[0], 0.45f32.into(), values[2], values[3]];
            let scaled = |of: &CellModel, values: [f64; 4]| -> Vec<f64> {
                let scales = of.input_offset.iter().zip(&of.input_scale);
                (scales.zip(values))
                    .map(|((o, s), x)| (x - f64::from(*o)) * f64::from(*s))
                    .collect()
            };
            let stored: Vec<f64> = model.weights.iter().map(|&w| f64::from(w)).collect();
            let was = net::evaluate(&model.shape, &stored, &scaled(&model, seen));
            let is = net::evaluate(&to.shape, &w, &scaled(&to, values));
            for c in 0..3 {
                let radiance = |scale: f32, offset: f32, z: f64| {
                    let z = if exponential { z.exp() } else { z };
                    f64::from(offset) + f64::from(scale) * z
                };
                let a = radiance(model.output_scale[c], model.output_offset[c], was[c]);
                let b = radiance(to.output_scale[c], to.output_offset[c], is[c]);
                assert!((a - b).abs() < 1e-12 * a.abs().max(1.0), "{a} {b}");
            }
            let kind = CellModel {
                divide_base: true,
                ..to
            };
            assert!(weights(&model, &kind, value, &fresh).is_none());
        }
    }
}
