//! From a scene to a model: patches, rows, basis, cells.

mod cell;
mod config;
mod draw;
mod judge;
mod rows;
mod tree;

use crate::TransferError;
use crate::basis::{Basis, Ensemble};
use crate::irradiance::Receivers;
use crate::lights::DirectLight;
use crate::model::{LightBasis, TransferCell, TransferModel, receiver_stream};
use crate::patches::Patches;
use crate::reflectance::Reflectances;
use crate::regression::{LocalFits, RowTable};
use crate::rows::{RowPoint, trace_rows};
use crate::tracing::{Stream, Tracer};
use cell::CellFitter;
use glam::Vec3;
use ndarray::Array2;
use rayon::prelude::*;
use rows::Projector;
use rrf_sampling::Stage;

pub use config::{CellChoice, TransferConfig};
pub use draw::PointDraw;

/// One light of so many judges and is not in the ensemble.
const JUDGING_LIGHTS: usize = 10;

/// Everything that is traced: what cells are fitted to.
#[derive(Clone, Debug)]
pub struct TransferRowsSet {
    /// Patches.
    pub patches: Patches,
    /// The lights' part of the basis.
    pub basis: LightBasis,
    /// Albedos of the scene's materials.
    pub reflectances: Reflectances,
    /// Which materials are metals.
    pub metals: Vec<bool>,
    /// Weighted coefficients of the ensemble's lights, shape [rank, lights].
    pub lights: Array2<f64>,
    /// Irradiances of the lights that judge.
    pub judges: Vec<Vec<Vec3>>,
    /// The rows.
    pub rows: RowTable,
}

/// Bakes a scene: everything but the lights, which are only examples of what may come.
///
/// The same bits for the same input at any number of threads.
pub fn bake_transfer(
    tracer: &Tracer,
    points: &dyn PointDraw,
    lights: &[&dyn DirectLight],
    config: &TransferConfig,
    halt: &(dyn Fn() -> bool + Sync),
) -> Result<TransferModel, TransferError> {
    let rows = extract_transfer(tracer, points, lights, config, halt)?;
    fit_transfer(rows, config, halt)
}

/// Traces rows and projects them onto a basis for the lights.
pub fn extract_transfer(
    tracer: &Tracer,
    points: &dyn PointDraw,
    lights: &[&dyn DirectLight],
    config: &TransferConfig,
    halt: &(dyn Fn() -> bool + Sync),
) -> Result<TransferRowsSet, TransferError> {
    let stream = Stream::new(config.seed, Stage::Transfer, 0);
    let patches = Patches::new(tracer.scene(), &config.patches, &|_: Vec3| 1.0)?;
    let chosen = draw::choose(tracer, &patches, points, config, stream)?;
    let (few, picked) = some(&chosen.points, config.basis_rows);
    let first = trace_rows(tracer, &patches, &few, &config.paths, stream.part(4), 0)?;
    let mut used = first.used();
    used.iter_mut()
        .zip(&chosen.used)
        .for_each(|(u, &more)| *u |= more);
    let receivers = Receivers::new(
        tracer,
        &patches,
        config.receiver_points,
        Some(&used),
        receiver_stream(config.seed),
    );
    let (mut shone, mut judges) = (Vec::new(), Vec::new());
    for (i, light) in lights.iter().enumerate() {
        if halt() {
            return Err(TransferError::Halted);
        }
        let irradiance = receivers.irradiance(*light);
        if i % JUDGING_LIGHTS == JUDGING_LIGHTS - 1 {
            judges.push(irradiance);
        } else {
            shone.push(irradiance);
        }
    }
    let ensemble = Ensemble::new(&shone);
    let colours: Vec<Vec3> = (few.iter())
        .map(|point| tracer.material_at(&point.point).base_color)
        .collect();
    let basis = Basis::new(
        &first,
        &colours,
        &ensemble,
        config.rank,
        config.floor,
        stream.part(5),
    )?;
    drop((first, picked));
    let reflectances = Reflectances::new(tracer.scene());
    let projector = Projector {
        tracer,
        patches: &patches,
        basis: &basis,
        reflectances: &reflectances,
        mean: ensemble.mean(),
        judges: &judges,
        config,
    };
    let rows = projector.trace(&chosen.points, stream.part(6), 0, halt)?;
    let lights = rows::weighted_lights(&basis, &ensemble);
    let materials = tracer.scene().materials.iter();
    Ok(TransferRowsSet {
        basis: LightBasis::new(&basis, &used),
        metals: materials.map(|m| m.metallic > 0.5).collect(),
        reflectances,
        lights,
        judges,
        rows,
        patches,
    })
}

/// About `count` of the points, evenly picked, and which.
fn some(points: &[RowPoint], count: usize) -> (Vec<RowPoint>, Vec<usize>) {
    let step = points.len().div_ceil(count.max(1)).max(1);
    let picked: Vec<usize> = (0..points.len()).step_by(step).collect();
    (picked.iter().map(|&i| points[i]).collect(), picked)
}

/// Fits cells to rows.
pub fn fit_transfer(
    set: TransferRowsSet,
    config: &TransferConfig,
    halt: &(dyn Fn() -> bool + Sync),
) -> Result<TransferModel, TransferError> {
    let table = &set.rows;
    let judging: Vec<bool> = table.judged.iter().map(|j| !j.is_empty()).collect();
    let fits = LocalFits::new(table, config.local, &judging);
    let (judges, training): (Vec<u32>, Vec<u32>) =
        (0..table.len() as u32).partition(|&row| judging[row as usize]);
    let (tree, cells) = tree::cut(table, &fits.weights, &training, config.cell_rows);
    let fitter = CellFitter {
        table,
        fits: &fits,
        reflectances: &set.reflectances,
        metals: &set.metals,
        lights: &set.lights,
        config,
    };
    let stream = Stream::new(config.seed, Stage::Transfer, 1);
    let fitted: Vec<Result<[TransferCell; 2], TransferError>> = cells
        .par_iter()
        .enumerate()
        .map(|(cell, rows)| {
            if halt() {
                return Err(TransferError::Halted);
            }
            fitter.fit(rows, stream.part(cell as u32))
        })
        .collect();
    let (mut nets, mut nodes) = (Vec::new(), Vec::new());
    for pair in fitted {
        let [net, node] = pair?;
        nets.push(net);
        nodes.push(node);
    }
    let model = |cells| TransferModel {
        patches: set.patches.clone(),
        receiver_points: config.receiver_points,
        seed: config.seed,
        basis: set.basis.clone(),
        reflectances: set.reflectances.clone(),
        tree: tree.clone(),
        cells,
    };
    let models = [model(nets), model(nodes)];
    choose(models, table, &judges, &set.judges, config)
}

/// Takes of every cell the fit that errs less on rows that judge; nets, unless they are clearly
/// worse.
fn choose(
    models: [TransferModel; 2],
    table: &RowTable,
    judges: &[u32],
    lights: &[Vec<Vec3>],
    config: &TransferConfig,
) -> Result<TransferModel, TransferError> {
    let mut errors = Vec::new();
    for model in &models {
        let lights: Result<Vec<_>, _> = lights.iter().map(|e| model.coefficients(e)).collect();
        let squares = judge::squares(model, table, judges, &lights?);
        errors.push(judge::by_cell(model, table, judges, &squares));
    }
    let [mut chosen, nodes] = models;
    for (i, (cell, node)) in chosen.cells.iter_mut().zip(nodes.cells).enumerate() {
        let (net_error, local_error) = (errors[0][i].0, errors[1][i].0);
        let patience = f64::from(config.patience * config.patience);
        let is_net = match config.choice {
            CellChoice::Nets => true,
            CellChoice::Nodes => false,
            CellChoice::Best => net_error <= patience * local_error.max(0.0),
        };
        if !is_net {
            *cell = node;
        }
        cell.error = judge::root(if is_net { net_error } else { local_error });
        cell.trusted = cell.error <= config.trust;
    }
    Ok(chosen)
}
