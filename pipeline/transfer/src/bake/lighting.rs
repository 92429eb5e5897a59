//! The ensemble of lights that a bake weighs things by.

use super::watch::TransferWatch;
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::ensemble::{Ensemble, RelativeWeights, radiances};
use crate::irradiance::Receivers;
use crate::lights::DirectLight;
use crate::rows::TransferRows;
use glam::Vec3;

/// One light of so many judges and is not in the ensemble.
const JUDGING_LIGHTS: usize = 10;
/// Lights that clusters are judged by.
const CLUSTER_LIGHTS: usize = 64;
/// Levels below this share of the mean count no less.
const FLOOR: f64 = 0.05;

/// Lights, each weighted so that the mean row gets about 1 of it.
pub(crate) struct Lighting {
    /// Shape [columns, lights], row-major.
    pub(crate) ensemble: Ensemble,
    /// Mean over the ensemble's lights, every column.
    pub(crate) mean: Vec<Vec3>,
    /// Irradiances of the lights that judge.
    pub(crate) judges: Vec<Vec<Vec3>>,
    /// The same, shape [columns, judges, 3].
    judges_on_columns: Vec<f32>,
    /// What of them reaches each node of the column tree.
    pub(crate) judges_on_nodes: Vec<Vec<Vec3>>,
    /// Some of the ensemble's lights on every node of the column tree, shape [nodes, some].
    pub(crate) on_nodes: Vec<f32>,
    /// Which those are.
    pub(crate) some: Vec<usize>,
    /// What they are on every column, shape [columns, some].
    on_columns: Vec<f32>,
}

impl Lighting {
    /// Asks every light, and weighs it by what pilot rows of these colours get of it.
    pub(crate) fn new(
        receivers: &Receivers,
        lights: &[&dyn DirectLight],
        pilot: &TransferRows,
        colours: &[Vec3],
        columns: &ColumnTree,
        watch: &dyn TransferWatch,
    ) -> Result<Lighting, TransferError> {
        let mut shone = Vec::with_capacity(lights.len());
        for light in lights {
            shone.push(receivers.irradiance(*light));
            if watch.halted() {
                return Err(TransferError::Halted);
            }
            watch.advance(1);
        }
        let all = Ensemble::new(&shone);
        let matrix = radiances(pilot, colours, &all);
        let weights = RelativeWeights::new(&matrix, FLOOR);
        let lit: Vec<usize> = (0..all.lights)
            .filter(|&l| weights.lights[l] > 0.0)
            .collect();
        if lit.is_empty() || pilot.is_empty() {
            return Err(TransferError::NoLight {
                rows: pilot.len(),
                lights: all.lights,
            });
        }
        // a row's level is its mean over weighted lights: that is 1 for the mean row
        let mean = |l: usize| matrix.column(l).mean().unwrap_or(0.0) * weights.lights[l];
        let mean = lit.iter().map(|&l| mean(l)).sum::<f64>() / lit.len() as f64;
        let scale = |l: usize| (weights.lights[l] / mean.max(f64::MIN_POSITIVE)) as f32;
        let (mut kept, mut judges) = (Vec::new(), Vec::new());
        for (i, &l) in lit.iter().enumerate() {
            let mut light = std::mem::take(&mut shone[l]);
            light.iter_mut().for_each(|e| *e *= scale(l));
            if i % JUDGING_LIGHTS == JUDGING_LIGHTS - 1 {
                judges.push(light);
            } else {
                kept.push(light);
            }
        }
        Ok(Lighting::of(Ensemble::new(&kept), &kept, judges, columns))
    }

    /// Some lights on a column.
    pub(crate) fn some_on(&self, column: u32) -> &[f32] {
        let first = column as usize * self.some.len();
        &self.on_columns[first..first + self.some.len()]
    }

    /// The judging lights on a column, shape [judges, 3].
    pub(crate) fn judges_on(&self, column: usize) -> &[f32] {
        let width = 3 * self.judges.len();
        &self.judges_on_columns[column * width..(column + 1) * width]
    }

    /// From lights that are weighted.
    fn of(
        ensemble: Ensemble,
        lights: &[Vec<Vec3>],
        judges: Vec<Vec<Vec3>>,
        columns: &ColumnTree,
    ) -> Lighting {
        let step = ensemble.lights.div_ceil(CLUSTER_LIGHTS).max(1);
        let some: Vec<usize> = (0..ensemble.lights).step_by(step).collect();
        let mut on_nodes = vec![0.0; columns.len() * some.len()];
        for (s, &l) in some.iter().enumerate() {
            for (node, flux) in columns.fluxes(&lights[l]).iter().enumerate() {
                on_nodes[node * some.len() + s] = flux.element_sum() / 3.0;
            }
        }
        let on_columns = (0..columns.columns() as u32).flat_map(|column| {
            let row = ensemble.row(column);
            some.iter().map(|&l| row[l])
        });
        let judged = (0..columns.columns()).flat_map(|column| {
            let own = judges.iter().map(move |light| light[column]);
            own.flat_map(|e| e.to_array())
        });
        Lighting {
            judges_on_columns: judged.collect(),
            judges_on_nodes: judges.iter().map(|light| columns.fluxes(light)).collect(),
            on_columns: on_columns.collect(),
            mean: ensemble.mean(),
            ensemble,
            judges,
            on_nodes,
            some,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::patches::Patches;
    use rrf_sampling::{Stage, Stream};

    /// Point lights in a room without shadows.
    pub(crate) fn even_lighting(patches: &Patches, columns: &ColumnTree) -> Lighting {
        let stream = Stream::new(2, Stage::Test, 6);
        let light = |i: u64| -> Vec<Vec3> {
            let u = stream.units(i, 0, 0);
            let at = Vec3::new(1.4 * u[0] - 0.7, 0.3 + 1.4 * u[1], 1.4 * u[2] - 0.7);
            let on = |p: usize, back: bool| {
                let way = at - patches.centre[p];
                let n = if back {
                    -patches.normal[p]
                } else {
                    patches.normal[p]
                };
                let cosine = n.dot(way.normalize()).max(0.0);
                Vec3::splat(cosine / way.length_squared())
            };
            (0..patches.len())
                .flat_map(|p| [on(p, false), on(p, true)])
                .collect()
        };
        let kept: Vec<_> = (0..120).map(light).collect();
        Lighting::of(Ensemble::new(&kept), &kept, Vec::new(), columns)
    }
}
