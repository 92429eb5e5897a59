//! The end of a round: its fits become the model, which is evaluated, and the next round is planned.

use crate::error::{BakeError, Halt};
use crate::exec::stage::unfinished;
use crate::exec::watch::Watch;
use crate::plan::evaluation::{EvaluatedRound, Evaluation};
use crate::plan::next::Next;
use crate::plan::refinement::Refinement;
use crate::plan::round::{CellPlan, PartPlan, RoundPlan};
use crate::plan::task::TaskKind;
use crate::policy::actions::refinements_of;
use crate::policy::boundary::Boundaries;
use crate::policy::budget::budget;
use crate::policy::compress::{compression_pass, restore_worst, restored};
use crate::policy::evaluate::evaluate;
use crate::policy::gain::{self, GainCalibration};
use crate::policy::{refine, test_rows};
use crate::run::folder::Run;
use crate::run::samples::{held_out_rows, read_some};
use rayon::prelude::*;
use rrf_field::Field;
use rrf_field::tree::Domain;
use rrf_metrics::relative::epsilon;
use rrf_store::layout::{TEST, fit_folder, remove_unfinished};
use rrf_store::model::{self, Fit, ModelTree, Seams};
use rrf_store::parts;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Rows of a cell at which its boundaries are compared: a commit reads no more parts than hold them.
const BOUNDARY_ROWS: usize = 400;

/// Commits a round whose tasks are done, evaluates its model and plans the next round. Where the watch
/// has a time limit, that round takes no more than what should be done in time. A signal ends it, and
/// the same call does it again; a time limit does not, for the evaluation is what a bake is for.
///
/// # Errors
/// [`BakeError::Unfinished`] where a task is not done, [`BakeError::Gone`], [`BakeError::Store`],
/// [`BakeError::Halted`].
pub fn evaluate_round(
    run: &Run,
    plan: &RoundPlan,
    watch: &dyn Watch,
) -> Result<(Evaluation, Next), BakeError> {
    run.unless_gone(finish(run, plan, watch))
}

/// An error once a signal has asked to stop.
fn unless_interrupted(watch: &dyn Watch) -> Result<(), BakeError> {
    match watch.halted() {
        Some(why @ Halt::Interrupt) => Err(BakeError::Halted { why }),
        _ => Ok(()),
    }
}

fn finish(run: &Run, plan: &RoundPlan, watch: &dyn Watch) -> Result<(Evaluation, Next), BakeError> {
    let start = Instant::now();
    let (plan, evaluation) = commit_compressed(run, plan, watch)?;
    let budget = match watch.left() {
        Some(left) => seconds_left(run, &plan, left)?,
        None => None,
    };
    let (next, refinements) = decide(run, &plan, &evaluation, budget, watch)?;
    let stop = match &next {
        Next::Stop(stop) => Some(*stop),
        Next::Round(next) => {
            run.write_plan(next)?;
            None
        }
    };
    run.add_time(plan.round, |timings| &mut timings.evaluate, start)?;
    // no task is left to do: unfinished files belong to killed ones. What follows is the one file that says
    // so: a bake that is killed before it is whole comes here again.
    remove_unfinished(&run.folder)?;
    run.write_evaluated(&EvaluatedRound {
        round: plan.round,
        evaluation: evaluation.clone(),
        stop,
        refinements,
    })?;
    Ok((evaluation, next))
}

/// Commits a round. Where test rows show that a compression pass misses the target, the worst half of
/// its cells get their earlier nets back, again and again.
fn commit_compressed<'a>(
    run: &Run,
    plan: &'a RoundPlan,
    watch: &dyn Watch,
) -> Result<(Cow<'a, RoundPlan>, Evaluation), BakeError> {
    let mut plan = Cow::Borrowed(plan);
    loop {
        let evaluation = commit(run, &plan, watch)?;
        let restored = match plan.compresses {
            Some(_) => match (run.plan_before(&plan)?, run.evaluated_before(&plan)?) {
                (Some(before), Some(evaluated)) => {
                    let before = (&before, &evaluated.evaluation);
                    restore_worst(&run.config, &plan, &evaluation, before)
                }
                _ => None,
            },
            None => None,
        };
        let Some(restored) = restored else {
            return Ok((plan, evaluation));
        };
        rewrite(run, &restored)?;
        plan = Cow::Owned(restored);
    }
}

/// The finished part of a compression pass that was interrupted, as a plan: the other cells keep their
/// earlier fits. None for another kind of round, or where no fit is done.
pub(crate) fn finished_part(run: &Run, plan: &RoundPlan) -> Result<Option<RoundPlan>, BakeError> {
    let before = match plan.compresses {
        Some(_) => run.plan_before(plan)?,
        None => None,
    };
    let Some(before) = before else {
        return Ok(None);
    };
    let todo = unfinished(run, plan, TaskKind::Train)?;
    let todo: Vec<u32> = todo.iter().map(|task| task.cell).collect();
    let part = restored(plan, &before, &todo);
    if part.cells.iter().all(|c| c.fitted != plan.round) {
        return Ok(None);
    }
    rewrite(run, &part)?;
    Ok(Some(part))
}

/// Replaces the plan of a round and keeps its timings.
fn rewrite(run: &Run, plan: &RoundPlan) -> Result<(), BakeError> {
    let timings = run.read_timings(plan.round)?;
    run.write_plan(plan)?;
    timings.map_or(Ok(()), |timings| run.write_timings(plan.round, &timings))
}

/// Makes the fits of a round, and those kept from earlier rounds, the model of the run.
fn commit(run: &Run, plan: &RoundPlan, watch: &dyn Watch) -> Result<Evaluation, BakeError> {
    let missing = run.unfinished(plan)?;
    if missing > 0 {
        return Err(BakeError::Unfinished {
            path: run.folder.clone(),
            round: plan.round,
            missing,
        });
    }
    let facts = run.facts();
    let fits = plan
        .cells
        .iter()
        .map(|cell| model::read_fit(&fit_folder(&run.folder, cell.fitted, cell.cell), &facts))
        .collect::<Result<Vec<Fit>, _>>()?;
    let mut tree = ModelTree::new(plan.tree.clone());
    for (node, cell) in tree.leaves().collect::<Vec<_>>() {
        tree.domains[node] = fits.get(cell as usize).and_then(|fit| fit.domain);
    }
    let mut evaluation = evaluate(plan, &fits);
    let spans: Vec<Option<Domain>> = fits.iter().map(|fit| fit.domain).collect();
    let (models, mut metrics): (Vec<_>, Vec<_>) =
        fits.into_iter().map(|fit| (fit.model, fit.metrics)).unzip();
    let field = Field::new(plan.tree.clone(), models)?;
    let floor = epsilon(run.config.train.epsilon, f64::from(plan.mean_radiance));
    evaluation.test = test_rows::evaluate(&test_predictions(run, plan, &field)?, floor);
    let borders = Boundaries::new(&field, &spans, floor);
    let found = boundaries(run, plan, &borders, watch)?;
    for (metrics, found) in metrics.iter_mut().zip(found) {
        metrics.seams = Some(found);
    }
    model::write_tree(&run.folder, &tree, &facts)?;
    model::write_weights(&run.folder, field.models(), &facts)?;
    model::write_metrics(&run.folder, &metrics, &facts)?;
    run.remove_replaced(plan)?;
    Ok(evaluation)
}

fn test_predictions(
    run: &Run,
    plan: &RoundPlan,
    field: &Field,
) -> Result<Vec<test_rows::TestRow>, BakeError> {
    let of_part = |part: &PartPlan| -> Result<Vec<test_rows::TestRow>, BakeError> {
        let table = parts::read_part(&run.folder, TEST, part.part, &run.facts())?;
        Ok(test_rows::predicted(field, &table)?)
    };
    let rows = plan.tests.par_iter().map(of_part);
    Ok(rows.collect::<Result<Vec<_>, BakeError>>()?.concat())
}

fn boundaries(
    run: &Run,
    plan: &RoundPlan,
    boundaries: &Boundaries,
    watch: &dyn Watch,
) -> Result<Vec<Seams>, BakeError> {
    let of_cell = |cell: &CellPlan| {
        unless_interrupted(watch)?;
        let rows = held_out_rows(run, cell, BOUNDARY_ROWS)?;
        Ok(boundaries.discontinuity(cell.cell as usize, &rows)?)
    };
    plan.cells.par_iter().map(of_cell).collect()
}

/// Core seconds, as predicted, that fit into the time left.
fn seconds_left(run: &Run, plan: &RoundPlan, left: Duration) -> Result<Option<f64>, BakeError> {
    let Some(timings) = run.read_timings(plan.round).ok().flatten() else {
        return Ok(None);
    };
    let first_draw = run
        .plan_before(plan)?
        .map_or(0, |before| before.draws.len());
    Ok(budget(&run.config, plan, first_draw, &timings, left))
}

/// Decides from files of the run alone, so that a resumed run decides the same. Returns the
/// refinements of all cells that miss the target too: those of cells that are left alone remain valid in
/// the round after.
fn decide(
    run: &Run,
    plan: &RoundPlan,
    evaluation: &Evaluation,
    budget: Option<f64>,
    watch: &dyn Watch,
) -> Result<(Next, Vec<Refinement>), BakeError> {
    if let Some(stop) = refine::stop_reason(&run.config, plan, evaluation) {
        let pass = compression_pass(run.inputs(), plan, evaluation, stop, budget)?;
        return Ok((Next::or_stop(pass, stop), Vec::new()));
    }
    let valid = refine::still_valid(plan, run.evaluated_before(plan)?);
    if let Some(next) = test_rows::more(&run.config, plan, evaluation) {
        let valid = valid.into_values().flatten().collect();
        return Ok((Next::Round(Box::new(next)), valid));
    }
    let possible = possible(run, plan, evaluation, &valid, watch)?;
    let gains = calibrated(run, plan, evaluation)?;
    let next = refine::next_round(run.inputs(), plan, evaluation, &possible, &gains, budget)?;
    Ok((next, possible))
}

/// All refinements of the cells that miss the target, those that are still valid among them.
fn possible(
    run: &Run,
    plan: &RoundPlan,
    evaluation: &Evaluation,
    valid: &BTreeMap<u32, Vec<Refinement>>,
    watch: &dyn Watch,
) -> Result<Vec<Refinement>, BakeError> {
    let found = refine::missing_target(&run.config, evaluation)
        .into_par_iter()
        .map(|evaluated| match plan.cells.get(evaluated.cell as usize) {
            Some(cell) => match valid.get(&cell.cell) {
                Some(refinements) => Ok(refinements.clone()),
                None => {
                    unless_interrupted(watch)?;
                    let (table, rows) = read_some(run, cell)?;
                    let config = &run.config;
                    Ok(refinements_of(config, plan, cell, evaluated, &table, rows))
                }
            },
            None => Ok(Vec::new()),
        })
        .collect::<Result<Vec<Vec<Refinement>>, BakeError>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// The gains of the last rounds.
fn calibrated(
    run: &Run,
    plan: &RoundPlan,
    evaluation: &Evaluation,
) -> Result<GainCalibration, BakeError> {
    let mut gains = GainCalibration::new(&evaluation.cells);
    for round in gain::rounds(plan.round) {
        let Some(before) = run.read_evaluated(round - 1)? else {
            continue;
        };
        let predicted = &before.refinements;
        if round == plan.round {
            gains.add(plan, predicted, &evaluation.cells);
        } else if let (Some(plan), Some(after)) =
            (run.read_plan(round)?, run.read_evaluated(round)?)
        {
            gains.add(&plan, predicted, &after.evaluation.cells);
        }
    }
    Ok(gains)
}
