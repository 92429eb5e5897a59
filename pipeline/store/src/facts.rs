//! What every table of a run says in its metadata about where it belongs.

use crate::error::StoreError;
use crate::manifest::RunFacts;
use arrow::array::RecordBatch;
use arrow::datatypes::Schema;
use std::path::Path;

pub(crate) const KEY_SCENE: &str = "rrf.scene_hash";
pub(crate) const KEY_SEED: &str = "rrf.seed";
pub(crate) const KEY_RUN: &str = "rrf.run";
pub(crate) const KEY_TASK: &str = "rrf.task";
pub(crate) const KEY_CELL: &str = "rrf.cell";
pub(crate) const KEY_PART: &str = "rrf.part";
pub(crate) const KEY_CONTENT: &str = "rrf.content_hash";

/// Adds the run's facts to a batch's metadata.
pub(crate) fn stamp(batch: &mut RecordBatch, facts: &RunFacts) {
    let metadata = batch.schema_metadata_mut();
    metadata.insert(KEY_SCENE, facts.scene_hash.clone());
    metadata.insert(KEY_SEED, facts.seed.to_string());
}

/// One fact, empty where the file does not say.
pub(crate) fn fact(schema: &Schema, key: &str) -> String {
    schema.metadata().get(key).cloned().unwrap_or_default()
}

/// Checks that a table is of the run at hand.
///
/// # Errors
/// [`StoreError::Foreign`].
pub(crate) fn expect(path: &Path, schema: &Schema, facts: &RunFacts) -> Result<(), StoreError> {
    let found = RunFacts {
        scene_hash: fact(schema, KEY_SCENE),
        // Any seed but the one expected is refused; so is one that is no number.
        seed: fact(schema, KEY_SEED).parse().unwrap_or(!facts.seed),
    };
    found.expect(path, facts)
}
