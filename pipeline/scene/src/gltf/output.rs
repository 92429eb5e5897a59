//! The scene as read so far.

use crate::Scene;
use crate::warn::Warnings;

/// A scene on its way.
#[derive(Default)]
pub(super) struct Output {
    pub(super) scene: Scene,
    pub(super) warnings: Warnings,
}
