//! What a fit goes on from, and when it gives up.

use crate::rows::Halt;
use rrf_field::model::CellModel;

/// What a fit goes on from, and when it gives up; by default from random weights, and never.
#[derive(Clone, Copy, Default)]
pub struct Start<'a> {
    /// An earlier net: that of a cell around this one or of fewer rows. It is used where the two are
    /// of one kind and the earlier one is no larger.
    pub earlier: Option<&'a CellModel>,
    /// Asked many times a second: once it says so, the fit ends with
    /// [`crate::TrainError::Halted`]. It must not change its mind.
    pub halt: Halt<'a>,
}

impl<'a> From<Option<&'a CellModel>> for Start<'a> {
    fn from(earlier: Option<&'a CellModel>) -> Start<'a> {
        Start {
            earlier,
            halt: None,
        }
    }
}
