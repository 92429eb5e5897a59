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
use rrf_view::ViewError;

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
    let bad = error.chain().any(|cause| {
        cause.is::<BadInput>()
            || cause.is::<SceneError>()
            || cause.is::<TraceError>()
            || cause.is::<ExtractError>()
            || cause.is::<FieldError>()
            || cause.is::<MetricsError>()
            || matches!(cause.downcast_ref(), Some(ViewError::Bind { .. }))
            || matches!(
                cause.downcast_ref::<ExportError>(),
                Some(ExportError::Model { .. } | ExportError::NoNet { .. })
            )
            || cause
                .downcast_ref::<RemoteError>()
                .is_some_and(RemoteError::is_bad_input)
            || cause
                .downcast_ref::<RenderError>()
                .is_some_and(RenderError::is_bad_input)
            || cause
                .downcast_ref::<StoreError>()
                .is_some_and(StoreError::is_bad_input)
            || cause
                .downcast_ref::<BakeError>()
                .is_some_and(BakeError::is_bad_input)
    });
    if bad { 2 } else { 1 }
}
