//! The tables of a transfer, against each other and the scene.

use super::found::{Found, RESUME, noted};
use crate::error::BakeError;
use crate::transfer::TransferRun;
use rrf_store::model::{TRANSFER_TABLES, model_table_path, read_transfer};
use rrf_store::schema::Table;
use std::path::Path;

/// Reads the model of a run; whether it is baked. A run without any of its tables is not, which is no
/// damage. The model is put together where the scene's file is at hand.
pub(super) fn check(folder: &Path, found: &mut Found) -> Result<bool, BakeError> {
    let paths = TRANSFER_TABLES.map(|table| model_table_path(folder, table));
    let begun = paths.iter().any(|path| path.exists());
    found.known.extend(paths);
    let run = TransferRun::open(folder);
    let manifest = rrf_store::manifest::RunManifest::path(folder);
    let remedy =
        "Restore it from a backup: all other files are read by it. Or bake into a new folder";
    let Some(run) = noted(found, &manifest, run, remedy)? else {
        return Ok(true);
    };
    let progress = model_table_path(folder, Table::TransferProgress);
    if progress.exists() {
        // not finished; what is damaged is made again
        found.known.insert(progress);
        return Ok(false);
    }
    if !begun {
        return Ok(false);
    }
    let whole = model_table_path(folder, Table::Transfer);
    let tables = read_transfer(folder, &run.facts()).map_err(BakeError::from);
    if noted(found, &whole, tables, RESUME)?.is_none() {
        return Ok(true);
    }
    if let Ok(scene) = run.load_scene() {
        noted(found, &whole, run.model(&scene.unlit()), RESUME)?;
    }
    Ok(true)
}
