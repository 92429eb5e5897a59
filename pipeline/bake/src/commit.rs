//! The end of a round: its fits become the model, samples that it replaced go.

use crate::error::BakeError;
use crate::judge::{Judgement, judge};
use crate::plan::RoundPlan;
use crate::run::Run;
use crate::seams::seams;
use crate::task::{is_done, tasks};
use crate::test_rows;
use rrf_field::Field;
use rrf_field::tree::Domain;
use rrf_store::layout::{TEST, fit_folder};
use rrf_store::model::{self, Fit, ModelTree};
use rrf_store::parts::remove_part;
use std::collections::BTreeSet;

/// Makes the round's fits, and those that stay of earlier rounds, the model of the run.
///
/// # Errors
/// [`BakeError::Unfinished`] where a task is not done, [`BakeError::Store`].
pub fn commit(run: &Run, plan: &RoundPlan) -> Result<Judgement, BakeError> {
    let missing = missing(run, plan)?;
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
    let mut judgement = judge(plan, &fits);
    let spans: Vec<Option<Domain>> = fits.iter().map(|fit| fit.domain).collect();
    let (models, mut metrics): (Vec<_>, Vec<_>) =
        fits.into_iter().map(|fit| (fit.model, fit.metrics)).unzip();
    let field = Field::new(plan.tree.clone(), models)?;
    judgement.test = test_rows::judge(run, plan, &field)?;
    let seams = seams(run, plan, &field, &spans)?;
    for (metrics, seams) in metrics.iter_mut().zip(seams) {
        metrics.seams = Some(seams);
    }
    model::write_tree(&run.folder, &tree, &facts)?;
    model::write_weights(&run.folder, field.models(), &facts)?;
    model::write_metrics(&run.folder, &metrics, &facts)?;
    remove_replaced(run, plan)?;
    Ok(judgement)
}

/// How many tasks of a round are not done.
pub fn missing(run: &Run, plan: &RoundPlan) -> Result<usize, BakeError> {
    let mut count = 0;
    for task in tasks(run, plan)? {
        count += usize::from(!is_done(run, &task)?);
    }
    Ok(count)
}

/// Parts of the round before that this one has taken apart.
fn remove_replaced(run: &Run, plan: &RoundPlan) -> Result<(), BakeError> {
    let Some(before) = plan.round.checked_sub(1) else {
        return Ok(());
    };
    let Some(before) = run.read_plan(before)? else {
        return Ok(());
    };
    let needed: BTreeSet<[u32; 2]> = places(plan).collect();
    for [cell, part] in places(&before).filter(|place| !needed.contains(place)) {
        remove_part(&run.folder, cell, part)?;
    }
    Ok(())
}

/// Cell and part of every part of a plan, test rows included.
pub(crate) fn places(plan: &RoundPlan) -> impl Iterator<Item = [u32; 2]> {
    let of = |cell: &crate::plan::CellPlan| {
        let id = cell.cell;
        let parts: Vec<[u32; 2]> = cell.parts.iter().map(|p| [id, p.part]).collect();
        parts
    };
    let tests = plan.tests.iter().map(|p| [TEST, p.part]);
    plan.cells.iter().flat_map(of).chain(tests)
}
