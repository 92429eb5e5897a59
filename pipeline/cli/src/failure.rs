//! Exit codes: 0 done, 1 failed (could succeed if tried again), 2 bad input or usage.

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

/// Bad input found by the command line itself.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct BadInput(pub String);

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
    if bad { 2 } else { 1 }
}
