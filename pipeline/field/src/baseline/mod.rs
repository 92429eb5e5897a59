//! Models that nets are compared with, evaluated row by row in f64: plain, not fast.

mod nearest;
pub mod probes;
pub mod quadratic;

use crate::columns::{self, Columns};
use crate::inputs;
use crate::light::Light;
use crate::model::{CellModel, Kind};
use nearest::Nearest;
use probes::{Grid, Probes};
use quadratic::Quadratic;

/// Rows whose inputs are computed together.
const TOGETHER: usize = 1024;

/// A cell's model of another kind than a net, ready for evaluation.
#[derive(Clone, Debug)]
pub struct Baseline {
    inputs: Vec<u8>,
    offset: Vec<f32>,
    scale: Vec<f32>,
    output_scale: [f32; 3],
    output_offset: [f32; 3],
    divide_base: bool,
    form: Form,
}

/// What stands in the net's place.
#[derive(Clone, Debug)]
enum Form {
    Quadratic(Quadratic),
    Nearest(Nearest),
    Probes(Probes),
}

impl Baseline {
    /// Of a model whose lengths agree; none where it is a net.
    pub fn new(model: &CellModel) -> Option<Baseline> {
        let form = match model.kind {
            Kind::Net => return None,
            Kind::Quadratic => Form::Quadratic(Quadratic::new(&model.weights)),
            Kind::Probes => {
                let &[_, places, lights, _] = model.shape.sizes.as_slice() else {
                    return None;
                };
                Form::Probes(Probes::new(Grid { places, lights }, &model.weights))
            }
            Kind::Nearest => {
                let inputs = model.inputs.len();
                let rows = model.weights.len() / (inputs + 3);
                Form::Nearest(Nearest::new(inputs, rows, &model.weights))
            }
        };
        Some(Baseline {
            inputs: model.inputs.clone(),
            offset: model.input_offset.clone(),
            scale: model.input_scale.clone(),
            output_scale: model.output_scale,
            output_offset: model.output_offset,
            divide_base: model.divide_base,
            form,
        })
    }

    /// Adds the radiance of the rows `ids` to `out`: under a light of 1 W/sr at their own light
    /// position, or under `light`.
    pub fn add(&self, rows: &Columns, ids: &[u32], light: Option<&Light>, out: &mut [Vec<f32>; 3]) {
        let (mut x, mut work) = (Vec::new(), Vec::new());
        let intensity = light.map_or([1.0; 3], |light| light.intensity);
        for ids in ids.chunks(TOGETHER) {
            let mut some = rows.take(ids);
            if let Some(light) = light {
                let columns = some.columns[columns::L..].iter_mut();
                columns
                    .zip(light.position)
                    .for_each(|(column, l)| column.fill(l));
            }
            let scaled = self.scaled(&some);
            for (row, &id) in ids.iter().enumerate() {
                x.clear();
                x.extend(scaled.iter().map(|column| column[row]));
                let y = self.form.answer(&x, &mut work);
                let base = some.vec3(columns::BASE, row);
                for c in 0..3 {
                    let (scale, offset) = (self.output_scale[c], self.output_offset[c]);
                    let y = y[c] * f64::from(scale) + f64::from(offset);
                    let base = if self.divide_base { base[c] } else { 1.0 };
                    out[c][id as usize] += intensity[c] * (y * f64::from(base)) as f32;
                }
            }
        }
    }

    /// Each input of the rows, scaled.
    fn scaled(&self, rows: &Columns) -> Vec<Vec<f32>> {
        let scales = self.offset.iter().zip(&self.scale);
        let column = |(&input, (&offset, &scale)): (&u8, (&f32, &f32))| {
            let mut column = Vec::new();
            inputs::fill(input, rows, &mut column);
            column.iter_mut().for_each(|x| *x = (*x - offset) * scale);
            column
        };
        self.inputs.iter().zip(scales).map(column).collect()
    }
}

impl Form {
    /// Three outputs at the scaled inputs `x`.
    fn answer(&self, x: &[f32], work: &mut Vec<f64>) -> [f64; 3] {
        match self {
            Form::Quadratic(quadratic) => quadratic.answer(x, work),
            Form::Nearest(nearest) => nearest.answer(x, work),
            Form::Probes(probes) => probes.answer(x),
        }
    }
}

#[cfg(test)]
mod tests;
