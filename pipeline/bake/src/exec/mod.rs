//! The work of a round: its tasks side by side, then the commit and evaluation of its model.

pub(crate) mod context;
pub(crate) mod endless;
pub(crate) mod evaluate;
mod extract;
mod fit;
pub(crate) mod perform;
pub(crate) mod plan;
mod pool;
pub(crate) mod stage;
pub(crate) mod watch;
