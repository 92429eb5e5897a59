//! The fit of one cell, with its rows in memory, or in a scratch file where they are too many.

use crate::error::BakeError;
use crate::exec::watch::HaltCheck;
use crate::plan::round::CellPlan;
use crate::plan::shard::Job;
use crate::policy::held_out::is_held_out;
use crate::policy::tasks::fit_config;
use crate::run::folder::Run;
use crate::run::samples::{each_part, read_cell};
use rrf_field::model::CellModel;
use rrf_field::tree::Domain;
use rrf_metrics::estimate::{ErrorEstimate, SquareError};
use rrf_store::atomic::create_folder;
use rrf_store::layout::{fit_folder, staging_folder};
use rrf_store::model::{self, CellMetrics, Fit, FitStep};
use rrf_store::samples::SampleTable;
use rrf_store::{StoreError, atomic};
use rrf_train::fit::spill::{SpillError, fit_spilled};
use rrf_train::{CellFit, HistoryRow, Samples, Start, TrainConfig, fit_from};

/// Fits a cell and writes the fit.
pub(crate) fn fit_cell(
    run: &Run,
    job: &Job,
    memory: Option<u64>,
    halt: Option<HaltCheck>,
) -> Result<(), BakeError> {
    let (task, cell) = (&job.task, &job.cell.plan);
    let config = fit_config(&run.config, job.facts.mean_radiance, cell);
    let spills = memory.is_some_and(|memory| task.memory > memory);
    let earlier = earlier(run, cell)?;
    let start = Start {
        earlier: earlier.as_ref(),
        halt,
    };
    let (fit, facts) = match spills {
        true => spilled(run, job, config, start),
        false => held(run, job, config, start),
    }?;
    let steps: Vec<FitStep> = (1..).zip(&fit.history).map(step).collect();
    let fit = Fit {
        domain: facts.domain,
        metrics: metrics(&fit, run.config.train.seed, facts.noise(), cell.fitted),
        model: fit.model,
        task: task.hash.clone(),
    };
    let folder = fit_folder(&run.folder, cell.fitted, cell.cell);
    model::write_steps(&folder, &steps, &run.facts())?;
    model::write_fit(&folder, &fit, &run.facts())?;
    Ok(())
}

fn step((step, row): (u32, &HistoryRow)) -> FitStep {
    let known = |x: f64| x.is_finite().then_some(x);
    FitStep {
        step,
        residuals: row.residuals as u64,
        cost: known(row.cost),
        relative_square_error: known(row.validation),
        damping: row.damping,
        gain: known(row.gain),
    }
}

/// The net that a cell's fit starts from, which has to be the one that was planned.
fn earlier(run: &Run, cell: &CellPlan) -> Result<Option<CellModel>, BakeError> {
    let Some(planned) = &cell.earlier else {
        return Ok(None);
    };
    let folder = fit_folder(&run.folder, planned.round, planned.cell);
    let facts = run.facts();
    if model::fit_task(&folder, &facts)?.as_deref() != Some(planned.task.as_str()) {
        return Err(BakeError::EarlierFit {
            path: folder,
            cell: cell.cell,
        });
    }
    Ok(Some(model::read_fit(&folder, &facts)?.model))
}

/// Fits with all rows in memory.
fn held(
    run: &Run,
    job: &Job,
    config: TrainConfig,
    start: Start,
) -> Result<(CellFit, RowFacts), BakeError> {
    let (cell, lambert) = (&job.cell.plan, &job.facts.lambert);
    let table = read_cell(run, cell)?;
    let mut facts = RowFacts::default();
    facts.add(&table, lambert);
    let config = facts.config(config);
    let held_out = held_out(&table, config.seed);
    let samples = samples(&table, &held_out);
    let fit = fit_from(start, cell.cell, samples, &config)?;
    facts.add_noise(&table, fit.floor);
    Ok((fit, facts))
}

/// Fits with the rows in a scratch file and one part in memory at a time.
fn spilled(
    run: &Run,
    job: &Job,
    config: TrainConfig,
    start: Start,
) -> Result<(CellFit, RowFacts), BakeError> {
    let (cell, lambert) = (&job.cell.plan, &job.facts.lambert);
    let mut facts = RowFacts::default();
    each_part(run, cell, &mut |table| facts.add(table, lambert))?;
    let config = facts.config(config);
    let staging = staging_folder(&run.folder);
    create_folder(&staging)?;
    let scratch = atomic::scratch_file(&staging, &format!("scratch-cell={:06}", cell.cell))?;
    let pass = |see: &mut dyn FnMut(&Samples)| {
        each_part(run, cell, &mut |table| {
            let held_out = held_out(table, config.seed);
            see(&samples(table, &held_out));
        })
    };
    let fit =
        fit_spilled(start, cell.cell, pass, &scratch, &config).map_err(|error| match error {
            SpillError::Train(error) => error.into(),
            SpillError::Rows(error) => error,
            SpillError::Scratch(source) => BakeError::Store(StoreError::Io {
                path: staging.clone(),
                action: "use a scratch file in",
                source,
            }),
        })?;
    each_part(run, cell, &mut |table| {
        facts.add_noise(table, fit.floor);
    })?;
    Ok((fit, facts))
}

/// Rows are held out by a hash of their index.
fn held_out(table: &SampleTable, seed: u64) -> Vec<bool> {
    let index = table.index.iter();
    index.map(|&index| is_held_out(seed, index)).collect()
}

fn samples<'a>(table: &'a SampleTable, held_out: &'a [bool]) -> Samples<'a> {
    Samples {
        rows: &table.columns,
        halves: [&table.halves[0], &table.halves[1]],
        validation: held_out,
    }
}

/// Facts about the rows of a cell.
#[derive(Default)]
struct RowFacts {
    /// The box that the rows span; none without rows.
    domain: Option<Domain>,
    /// Whether a row lies on a material that is not Lambertian.
    glossy: bool,
    /// Sum and number of the finite squared relative standard errors.
    noise: (f64, usize),
}

impl RowFacts {
    fn add(&mut self, table: &SampleTable, lambert: &[bool]) {
        let is_lambert = |m: &u32| lambert.get(*m as usize).copied().unwrap_or(false);
        self.glossy |= !table.material.iter().all(is_lambert);
        for row in 0..table.len() {
            let row = table.columns.row(row);
            self.domain.get_or_insert(Domain::EMPTY).include(&row);
        }
    }

    /// Demodulates the albedo where all materials are Lambertian.
    fn config(&self, config: TrainConfig) -> TrainConfig {
        TrainConfig {
            divide_base: !self.glossy,
            ..config
        }
    }

    /// Adds the relative variance of the targets: Var[(y0 + y1) / 2] = E[(y0 - y1)²] / 4, with the same
    /// divisor as the relative error.
    fn add_noise(&mut self, table: &SampleTable, floor: f64) {
        for row in 0..table.len() {
            let (a, b) = (table.halves[0][row], table.halves[1][row]);
            let y = table.mean(row).map(f64::from);
            let divisor = ((y[0] + y[1] + y[2]) / 3.0).max(floor);
            let square: f64 = (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum();
            let square = square / 12.0 / (divisor * divisor);
            if square.is_finite() {
                self.noise = (self.noise.0 + square, self.noise.1 + 1);
            }
        }
    }

    fn noise(&self) -> Option<f64> {
        let (sum, rows) = self.noise;
        (rows > 0).then(|| (sum / rows as f64).sqrt())
    }
}

fn metrics(fit: &CellFit, seed: u64, noise: Option<f64>, round: u32) -> CellMetrics {
    let error = |e: &ErrorEstimate| (e.rows > 0).then(|| SquareError::from(*e));
    CellMetrics {
        cell_id: fit.model.cell,
        round,
        rows: fit.rows as u64,
        train_rows: fit.train_rows as u64,
        validation_rows: fit.validation_rows as u64,
        quarantined_rows: fit.quarantined.len() as u64,
        iterations: fit.history.len() as u32,
        stop_reason: fit.end.name().into(),
        train: error(&fit.train_error),
        validation: error(&fit.validation_error),
        noise,
        effective_parameters: Some(fit.effective_parameters),
        alpha: fit.alpha,
        damping: fit.damping,
        weights: fit.model.weights.len() as u32,
        seed,
        seams: None,
    }
}
