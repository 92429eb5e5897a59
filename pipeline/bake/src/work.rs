//! How a task is done.

use crate::error::BakeError;
use crate::plan::{CellPlan, PartPlan, RoundPlan};
use crate::run::Run;
use crate::split::is_held_out;
use crate::task::{Stage, Task, draw, fit_config};
use rrf_extract::{Draw, Lookout};
use rrf_field::columns::{self, Columns};
use rrf_field::model::CellModel;
use rrf_field::tree::{self, Tree};
use rrf_scene::Scene;
use rrf_store::layout::{fit_folder, list_parts, part_path};
use rrf_store::model::{self, CellMetrics, Domain, Fit, FitStep, SquareError};
use rrf_store::parts;
use rrf_store::samples::SampleTable;
use rrf_trace::Tracer;
use rrf_train::{ErrorEstimate, HistoryRow, TrainConfig, fit_cell_from};

/// A scene ready to be sampled. Training needs none.
pub struct Site<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    lookout: Lookout<'a>,
}

impl<'a> Site<'a> {
    /// Of a scene without its own lights.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer<'a>) -> Site<'a> {
        Site {
            scene,
            tracer,
            lookout: Lookout::new(scene, tracer),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Its tracer.
    pub fn tracer(&self) -> &'a Tracer<'a> {
        self.tracer
    }
}

/// Does a task: its output is there afterwards.
///
/// # Errors
/// [`BakeError::NoSite`] for an extraction without a site; whatever the stages find.
pub fn perform(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    task: &Task,
) -> Result<(), BakeError> {
    let cell = plan
        .cells
        .get(task.cell as usize)
        .ok_or(BakeError::NoSuchCell {
            cell: task.cell,
            last: plan.cells.len().saturating_sub(1) as u32,
        })?;
    match (task.stage, task.part) {
        (Stage::Extract, Some(number)) => {
            let part = cell.parts.iter().find(|p| p.part == number);
            let part = part.ok_or_else(|| BakeError::Plan {
                round: plan.round,
                reason: format!("cell {} has no part {number}", cell.cell),
            })?;
            extract(run, plan, site, cell, part, &task.hash)
        }
        _ => train(run, plan, cell, &task.hash),
    }
}

fn extract(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    cell: &CellPlan,
    part: &PartPlan,
    hash: &str,
) -> Result<(), BakeError> {
    let table = match taken(run, plan, part)? {
        Some(table) => table,
        None => drawn(run, plan, site, part)?,
    };
    let table = within(table, &plan.tree, cell.cell);
    parts::write_part_of(&run.folder, part.part, &table, &run.facts(), hash)?;
    Ok(())
}

/// The draw's rows from the part that holds them, where it is still there and whole.
fn taken(run: &Run, plan: &RoundPlan, part: &PartPlan) -> Result<Option<SampleTable>, BakeError> {
    let Some([cell, number]) = part.from else {
        return Ok(None);
    };
    if !part_path(&run.folder, cell, number).exists() {
        return Ok(None);
    }
    let table = parts::read_part(&run.folder, cell, number, &run.facts())?;
    let of_draw = |index: &u64| (index >> 32) as u32 == part.draw;
    if !table.index.iter().all(of_draw) {
        return Err(BakeError::Plan {
            round: plan.round,
            reason: format!("part {number} of cell {cell} is of another draw"),
        });
    }
    Ok(Some(table))
}

fn drawn(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    part: &PartPlan,
) -> Result<SampleTable, BakeError> {
    let site = site.ok_or(BakeError::NoSite)?;
    let asked = draw(plan, part)?;
    let domain = plan.tree.node_domains().get(asked.node as usize).copied();
    let draw = Draw {
        stream: part.draw,
        domain: domain.unwrap_or(tree::Domain::EMPTY),
        rows: asked.rows,
        paths: asked.paths,
    };
    let light_box = run.config.extract.light_box;
    let drawn = rrf_extract::extract(
        site.scene,
        site.tracer,
        &site.lookout,
        light_box,
        run.manifest.seed,
        &draw,
    )?;
    Ok(SampleTable {
        cell_id: 0,
        paths: vec![asked.paths; drawn.index.len()],
        index: drawn.index,
        columns: drawn.rows,
        material: drawn.material,
        halves: drawn.halves,
    })
}

/// The rows that lie in a cell.
fn within(table: SampleTable, tree: &Tree, cell: u32) -> SampleTable {
    let cells = tree.find_all(&table.columns);
    let mut kept = SampleTable {
        cell_id: cell,
        ..SampleTable::default()
    };
    for (row, _) in cells.iter().enumerate().filter(|(_, c)| **c == cell) {
        kept.index.push(table.index[row]);
        kept.columns.push(table.columns.row(row));
        kept.material.push(table.material[row]);
        kept.halves[0].push(table.halves[0][row]);
        kept.halves[1].push(table.halves[1][row]);
        kept.paths.push(table.paths[row]);
    }
    kept
}

/// A cell's rows, its parts in the plan's order.
pub(crate) fn read_cell(run: &Run, cell: &CellPlan) -> Result<SampleTable, BakeError> {
    let mut whole = SampleTable {
        cell_id: cell.cell,
        ..SampleTable::default()
    };
    // a stray file would stop every other reader of the dataset too: said here, by name
    list_parts(&run.folder, cell.cell)?;
    for part in &cell.parts {
        if !part_path(&run.folder, cell.cell, part.part).exists() {
            return Err(BakeError::NotExtracted {
                path: run.folder.clone(),
                cell: cell.cell,
            });
        }
        let table = parts::read_part(&run.folder, cell.cell, part.part, &run.facts())?;
        whole.extend(&table);
    }
    Ok(whole)
}

fn train(run: &Run, plan: &RoundPlan, cell: &CellPlan, hash: &str) -> Result<(), BakeError> {
    let table = read_cell(run, cell)?;
    let earlier = earlier(run, cell)?;
    let config = fit_config(run, plan, cell);
    let fit = fit(earlier.as_ref(), &table, &plan.lambert, &config)?;
    let steps: Vec<FitStep> = fit.report.history.iter().map(step).collect();
    let fit = Fit {
        domain: span(&table.columns),
        metrics: metrics(&fit.metrics, &table, cell.fitted),
        model: fit.model,
        task: hash.into(),
    };
    let folder = fit_folder(&run.folder, cell.fitted, cell.cell);
    model::write_steps(&folder, &steps, &run.facts())?;
    Ok(model::write_fit(&folder, &fit, &run.facts())?)
}

fn step(row: &HistoryRow) -> FitStep {
    let known = |x: f64| x.is_finite().then_some(x);
    FitStep {
        step: row.iteration as u32,
        residuals: row.residuals as u64,
        cost: known(row.cost),
        square_error: known(row.validation),
        damping: row.mu,
        gain: known(row.gain),
    }
}

/// The net that a cell's fit goes on from.
fn earlier(run: &Run, cell: &CellPlan) -> Result<Option<CellModel>, BakeError> {
    let Some([round, from]) = cell.earlier else {
        return Ok(None);
    };
    let folder = fit_folder(&run.folder, round, from);
    Ok(Some(model::read_fit(&folder, &run.facts())?.model))
}

/// One cell's fit; rows are held out by a hash of their index.
fn fit(
    earlier: Option<&CellModel>,
    table: &SampleTable,
    lambert: &[bool],
    config: &TrainConfig,
) -> Result<rrf_train::CellFit, BakeError> {
    let held_out: Vec<bool> = table
        .index
        .iter()
        .map(|&index| is_held_out(config.seed, index))
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
    Ok(fit_cell_from(
        earlier,
        table.cell_id,
        &table.columns,
        halves,
        &held_out,
        &config,
    )?)
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

fn metrics(fit: &rrf_train::CellMetrics, table: &SampleTable, round: u32) -> CellMetrics {
    let error = |e: &ErrorEstimate| {
        (e.rows > 0).then_some(SquareError {
            mean: e.square,
            se: e.square_se,
        })
    };
    CellMetrics {
        cell_id: fit.cell,
        round,
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
