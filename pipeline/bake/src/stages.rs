//! The stages of a run, each from files to files.

use crate::error::BakeError;
use crate::run::Run;
use crate::split::is_held_out;
use rayon::prelude::*;
use rrf_extract::{CellPlan, Lookout, Plan, extract_cell};
use rrf_field::columns::{self, Columns};
use rrf_field::model::CellModel;
use rrf_field::tree;
use rrf_scene::Scene;
use rrf_store::layout::list_parts;
use rrf_store::model::{self, CellMetrics, Domain, ModelTree, SquareError};
use rrf_store::parts;
use rrf_store::samples::SampleTable;
use rrf_trace::Tracer;
use rrf_train::{CellFit, ErrorEstimate, TrainConfig, fit_cell};

/// Who follows a long stage.
pub trait Watch: Sync {
    /// A stage of `total` steps begins.
    fn begin(&self, stage: &'static str, total: u64);
    /// So many more steps are done.
    fn advance(&self, steps: u64);
    /// The stage is over.
    fn end(&self);
}

/// Part number of a cell's first rows.
const FIRST_PART: u32 = 0;

/// Draws the first tree and shares the rows out; a run that goes on has them already.
pub fn plan(run: &Run, scene: &Scene, tracer: &Tracer) -> Result<Plan, BakeError> {
    if let Some(plan) = run.read_plan()? {
        return Ok(plan);
    }
    let plan = rrf_extract::plan(scene, tracer, &run.config.extract)?;
    run.write_plan(&plan)?;
    Ok(plan)
}

/// Extracts every cell of the plan, or those named by `only`. Parts that are there stay.
pub fn extract(
    run: &Run,
    scene: &Scene,
    tracer: &Tracer,
    plan: &Plan,
    only: Option<&[u32]>,
    watch: &dyn Watch,
) -> Result<(), BakeError> {
    let cells = chosen(plan, only)?;
    watch.begin("extract", cells.iter().map(|c| u64::from(c.rows)).sum());
    let domains = plan.tree.domains();
    let lookout = Lookout::new(scene, tracer);
    // a few cells at a time: within one, rows are traced by all threads
    cells.par_iter().with_max_len(1).try_for_each(|&cell| {
        extract_one(
            run,
            scene,
            tracer,
            &lookout,
            domains[cell.cell as usize],
            cell,
        )?;
        watch.advance(u64::from(cell.rows));
        Ok::<(), BakeError>(())
    })?;
    watch.end();
    Ok(())
}

fn chosen(plan: &Plan, only: Option<&[u32]>) -> Result<Vec<CellPlan>, BakeError> {
    let Some(only) = only else {
        return Ok(plan.cells.clone());
    };
    only.iter()
        .map(|&cell| {
            plan.cells
                .get(cell as usize)
                .copied()
                .ok_or(BakeError::NoSuchCell {
                    cell,
                    last: plan.cells.len().saturating_sub(1) as u32,
                })
        })
        .collect()
}

fn extract_one(
    run: &Run,
    scene: &Scene,
    tracer: &Tracer,
    lookout: &Lookout,
    domain: tree::Domain,
    cell: CellPlan,
) -> Result<(), BakeError> {
    if list_parts(&run.folder, cell.cell)?.contains(&FIRST_PART) {
        return Ok(());
    }
    let extracted = extract_cell(scene, tracer, lookout, domain, cell, &run.config.extract)?;
    parts::write_part(&run.folder, FIRST_PART, &extracted.table, &run.facts())?;
    Ok(())
}

/// Fits every cell's net and writes the model's tables.
pub fn train(run: &Run, plan: &Plan, watch: &dyn Watch) -> Result<(), BakeError> {
    let tables = plan
        .cells
        .iter()
        .map(|cell| read_cell(run, cell.cell))
        .collect::<Result<Vec<_>, _>>()?;
    watch.begin("train", plan.cells.iter().map(|c| u64::from(c.rows)).sum());
    let mut config = run.config.train.clone();
    config.mean_luminance = Some(mean_luminance(plan, &tables));
    let fits = tables
        .par_iter()
        .with_max_len(1)
        .map(|table| {
            let fit = fit_one(table, &plan.lambert, &config);
            watch.advance(table.len() as u64);
            fit
        })
        .collect::<Result<Vec<CellFit>, BakeError>>()?;
    watch.end();
    write_model(run, plan, &tables, fits)
}

fn read_cell(run: &Run, cell: u32) -> Result<SampleTable, BakeError> {
    if list_parts(&run.folder, cell)?.is_empty() {
        return Err(BakeError::NotExtracted {
            path: run.folder.clone(),
            cell,
        });
    }
    Ok(parts::read_cell(&run.folder, cell, &run.facts())?.table)
}

/// One cell's fit; rows are held out by a hash of their index.
fn fit_one(
    table: &SampleTable,
    lambert: &[bool],
    config: &TrainConfig,
) -> Result<CellFit, BakeError> {
    let held_out: Vec<bool> = table
        .index
        .iter()
        .map(|&index| is_held_out(config.seed, table.cell_id, index))
        .collect();
    let all_lambert = table
        .material
        .iter()
        .all(|&m| lambert.get(m as usize).copied().unwrap_or(false));
    let config = TrainConfig {
        divide_base: all_lambert,
        ..config.clone()
    };
    let halves = [table.halves[0].as_slice(), table.halves[1].as_slice()];
    Ok(fit_cell(
        table.cell_id,
        &table.columns,
        halves,
        &held_out,
        &config,
    )?)
}

fn write_model(
    run: &Run,
    plan: &Plan,
    tables: &[SampleTable],
    fits: Vec<CellFit>,
) -> Result<(), BakeError> {
    let facts = run.facts();
    let mut tree = ModelTree::new(plan.tree.clone());
    for (node, cell) in tree.leaves().collect::<Vec<_>>() {
        tree.domains[node] = tables.get(cell as usize).and_then(|t| span(&t.columns));
    }
    let (models, metrics): (Vec<CellModel>, Vec<CellMetrics>) = fits
        .into_iter()
        .zip(tables)
        .map(|(fit, table)| (fit.model, metrics(&fit.metrics, table)))
        .unzip();
    model::write_tree(&run.folder, &tree, &facts)?;
    model::write_weights(&run.folder, &models, &facts)?;
    model::write_metrics(&run.folder, &metrics, &facts)?;
    Ok(())
}

/// The box that rows span, or none without rows.
fn span(rows: &Columns) -> Option<Domain> {
    let bound = |pick: fn(f32, f32) -> f32| -> Option<[f32; columns::COUNT]> {
        let bounds: Vec<f32> = rows
            .columns
            .iter()
            .filter_map(|c| c.iter().copied().reduce(pick))
            .collect();
        bounds.try_into().ok()
    };
    Some(Domain {
        min: bound(f32::min)?,
        max: bound(f32::max)?,
    })
}

fn metrics(fit: &rrf_train::CellMetrics, table: &SampleTable) -> CellMetrics {
    let error = |e: &ErrorEstimate| {
        (e.rows > 0).then_some(SquareError {
            mean: e.square,
            se: e.square_se,
        })
    };
    CellMetrics {
        cell_id: fit.cell,
        round: 0,
        rows: fit.rows as u64,
        train_rows: fit.train_rows as u64,
        validation_rows: fit.validation_rows as u64,
        quarantined_rows: fit.quarantined_rows as u64,
        iterations: fit.iterations as u32,
        stop_reason: fit.stop.name().into(),
        train: error(&fit.train_error),
        validation: error(&fit.validation_error),
        noise: noise(table, fit.floor),
        effective_parameters: Some(fit.effective_parameters),
        alpha: fit.alpha,
        damping: fit.mu,
        weights: fit.weights as u32,
        seed: fit.seed,
    }
}

/// Relative standard error of the targets: Var[(y0 + y1) / 2] = E[(y0 - y1)²] / 4, over the
/// same divisor as the relative error.
fn noise(table: &SampleTable, floor: f64) -> Option<f64> {
    let squares: Vec<f64> = (0..table.len())
        .map(|row| {
            let (a, b) = (table.halves[0][row], table.halves[1][row]);
            let y = table.mean(row).map(f64::from);
            let divisor = ((y[0] + y[1] + y[2]) / 3.0).max(floor);
            let square: f64 = (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum();
            square / 12.0 / (divisor * divisor)
        })
        .filter(|x| x.is_finite())
        .collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Mean luminance (mean of r, g, b) of the targets over the whole scene.
fn mean_luminance(plan: &Plan, tables: &[SampleTable]) -> f32 {
    let weighted = plan.cells.iter().zip(tables).map(|(cell, table)| {
        let lums = (0..table.len()).map(|row| {
            let y = table.mean(row);
            f64::from(y[0] + y[1] + y[2]) / 3.0
        });
        let finite: Vec<f64> = lums.filter(|lum| lum.is_finite()).collect();
        cell.measure * finite.iter().sum::<f64>() / finite.len().max(1) as f64
    });
    weighted.sum::<f64>() as f32
}
