//! The model's tables, against the fits that they are made of.

use super::found::{Found, RESUME, noted};
use super::rounds::Rounds;
use crate::error::BakeError;
use crate::run::folder::Run;
use rrf_store::layout::{fit_folder, model_folder};
use rrf_store::model::{self, Fit};

/// Reads the model and compares it with the last committed round.
pub(super) fn check(run: &Run, rounds: &Rounds, found: &mut Found) -> Result<(), BakeError> {
    let folder = model_folder(&run.folder);
    let [tree, weights, metrics] =
        ["tree", "weights", "metrics"].map(|name| folder.join(format!("{name}.arrow")));
    found
        .known
        .extend([tree.clone(), weights.clone(), metrics.clone()]);
    let Some(plan) = rounds.committed() else {
        return Ok(());
    };
    let facts = run.facts();
    let read = model::read_metrics(&run.folder, &facts).map_err(BakeError::from);
    let rows = noted(found, &metrics, read, RESUME)?;
    let read = model::read_model(&run.folder, &facts).map_err(BakeError::from);
    let Some(model) = noted(found, &folder, read, RESUME)? else {
        return Ok(());
    };
    let fits: Result<Vec<Fit>, _> = (plan.cells.iter())
        .map(|cell| model::read_fit(&fit_folder(&run.folder, cell.fitted, cell.cell), &facts))
        .collect();
    // fits that are damaged are noted with their tasks
    let Ok(fits) = fits else {
        return Ok(());
    };
    let other = "it is not made of the fits of the last committed round";
    if !model.cells.iter().eq(fits.iter().map(|fit| &fit.model)) {
        found.damage(&weights, other, RESUME);
    }
    if model.tree.tree != plan.tree {
        found.damage(
            &tree,
            "it is not the tree of the last committed round",
            RESUME,
        );
    }
    let cells = rows.iter().flatten().map(|row| row.cell_id);
    if rows.is_some() && !cells.eq(fits.iter().map(|fit| fit.metrics.cell_id)) {
        found.damage(&metrics, other, RESUME);
    }
    Ok(())
}
