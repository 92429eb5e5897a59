//! Refinement actions: what the next round may do about a cell.

use rrf_train::Size;
use rrf_train::cut::{Cut, Rule};
use serde::{Deserialize, Serialize};

/// An action on one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Action {
    /// Replaces the cell by two, each with as many rows as it has now.
    Split {
        /// The rule that chose the cut.
        rule: Rule,
        /// The cut.
        cut: Cut,
        /// Share of the cell's rows on the left.
        left: f64,
    },
    /// Draws as many rows again.
    #[serde(rename = "More")]
    MoreRows,
    /// Fits a larger net to the same rows.
    #[serde(rename = "Grow")]
    LargerNet(Size),
}

/// Kind of an [`Action`], by which its gain is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum RefinementKind {
    Split(Rule),
    MoreRows,
    LargerNet,
}

impl Action {
    /// The kind of the action.
    pub(crate) fn kind(&self) -> RefinementKind {
        match self {
            Action::Split { rule, .. } => RefinementKind::Split(*rule),
            Action::MoreRows => RefinementKind::MoreRows,
            Action::LargerNet(_) => RefinementKind::LargerNet,
        }
    }
}

/// An action on one cell with its predicted gain and cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refinement {
    /// The cell.
    pub cell: u32,
    /// The action.
    pub action: Action,
    /// Contribution of the cell to the squared error of the whole model.
    pub share: f64,
    /// Predicted contribution after the action, before calibration by earlier rounds.
    pub left: f64,
    /// Predicted seconds of one core.
    pub seconds: f64,
    /// Rows to draw.
    pub rows: u32,
    /// Paths for each of these rows.
    pub paths: u32,
}
