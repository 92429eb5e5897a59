//! The outcome of a round: the plan of the next one, or the reason to stop.

use crate::plan::round::RoundPlan;
use crate::plan::stop::StopReason;

/// The successor of a round.
#[derive(Clone, Debug)]
pub enum Next {
    /// Another round.
    Round(Box<RoundPlan>),
    /// The end of the bake.
    Stop(StopReason),
}

impl Next {
    /// The next round where there is one, otherwise the end.
    pub(crate) fn or_stop(plan: Option<RoundPlan>, reason: StopReason) -> Next {
        plan.map_or(Next::Stop(reason), |plan| Next::Round(Box::new(plan)))
    }
}
