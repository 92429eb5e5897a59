//! The method that a run was baked by.

use crate::error::BakeError;
use rrf_store::manifest::RunManifest;
use std::path::Path;

/// Method that a run was baked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunMethod {
    /// Nets that see the light, or a baseline in their place.
    Nets,
    /// A transfer.
    Transfer,
}

impl RunMethod {
    /// Reads it from the manifest of a run.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub fn of(folder: &Path) -> Result<RunMethod, BakeError> {
        Ok(RunMethod::told(&RunManifest::read(folder)?))
    }

    /// As a manifest tells it.
    pub(crate) fn told(manifest: &RunManifest) -> RunMethod {
        match manifest.config.get("method") {
            Some(method) if method == "transfer" => RunMethod::Transfer,
            _ => RunMethod::Nets,
        }
    }
}
