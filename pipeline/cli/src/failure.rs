//! Exit codes: 0 done, 1 failed (could succeed if tried again), 2 bad input or usage, 3 target missed
//! (`--require-target`).

use rrf_bake::BakeError;
use rrf_export::ExportError;
use rrf_extract::ExtractError;
use rrf_field::FieldError;
use rrf_metrics::MetricsError;
use rrf_remote::RemoteError;
use rrf_render::RenderError;
use rrf_scene::SceneError;
use rrf_store::StoreError;
use rrf_trace::TraceError;
use rrf_transfer::TransferError;
use rrf_view::ViewError;
use std::error::Error;
use std::path::Path;

/// Bad input found by the command line itself.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct BadInput(pub String);

/// A bake that ended without reaching its target, where that is required.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct TargetMissed(pub String);

/// Fails unless the target is met, or need not be.
pub fn require_target(
    run: &Path,
    (error, target): (f64, f32),
    is_met: bool,
) -> Result<(), TargetMissed> {
    match is_met {
        true => Ok(()),
        false => Err(TargetMissed(format!(
            "{}: the target of {:.2} % is missed: the relative error is {:.2} %",
            run.display(),
            100.0 * target,
            100.0 * error
        ))),
    }
}

/// The error and what caused it, without the causes that the error itself already quotes.
pub fn message(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// The exit code of an error: bad input wherever one of the libraries says so.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    fn is<E: Error + Send + Sync + 'static>(
        cause: &(dyn Error + 'static),
        bad: impl Fn(&E) -> bool,
    ) -> bool {
        cause.downcast_ref().is_some_and(bad)
    }
    let bad = error.chain().any(|cause| {
        is(cause, |_: &BadInput| true)
            || is(cause, |_: &SceneError| true)
            || is(cause, TraceError::is_bad_input)
            || is(cause, ExtractError::is_bad_input)
            || is(cause, |_: &FieldError| true)
            || is(cause, |_: &TransferError| true)
            || is(cause, |_: &MetricsError| true)
            || is(cause, ViewError::is_bad_input)
            || is(cause, ExportError::is_bad_input)
            || is(cause, RemoteError::is_bad_input)
            || is(cause, RenderError::is_bad_input)
            || is(cause, StoreError::is_bad_input)
            || is(cause, BakeError::is_bad_input)
    });
    let missed = error.chain().any(|cause| cause.is::<TargetMissed>());
    match (missed, bad) {
        (true, _) => 3,
        (false, true) => 2,
        (false, false) => 1,
    }
}
