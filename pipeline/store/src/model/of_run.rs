//! Which run a model's tables belong to: another run of the same scene and seed has other nets.

use crate::error::StoreError;
use crate::facts::{KEY_RUN, fact};
use crate::manifest::RunManifest;
use arrow::datatypes::Schema;
use std::path::Path;

/// The run's hash as metadata; none in a folder without a manifest.
pub(super) fn stamp(run: &Path) -> Result<Vec<(&'static str, String)>, StoreError> {
    Ok(hash(run)?.map(|hash| (KEY_RUN, hash)).into_iter().collect())
}

/// Checks that a table of the model was made by the run that it lies in.
///
/// # Errors
/// [`StoreError::Foreign`].
pub(super) fn expect(
    run: &Path,
    path: &Path,
    schema: &Schema,
    remedy: &'static str,
) -> Result<(), StoreError> {
    let Some(expected) = hash(run)? else {
        return Ok(());
    };
    let found = fact(schema, KEY_RUN);
    if found == expected {
        return Ok(());
    }
    Err(StoreError::Foreign {
        path: path.into(),
        fact: "hash of the run",
        expected,
        found: match found.is_empty() {
            true => "missing".into(),
            false => found,
        },
        remedy,
    })
}

fn hash(run: &Path) -> Result<Option<String>, StoreError> {
    match RunManifest::read(run) {
        Ok(manifest) => manifest.hash(run).map(Some),
        Err(StoreError::NotARun { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}
