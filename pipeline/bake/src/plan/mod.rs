//! Plain data that the stages of a bake share: plans of rounds, their tasks, evaluations and
//! refinements. Nothing here reads a file or decides anything.

pub(crate) mod evaluation;
pub(crate) mod next;
pub(crate) mod refinement;
pub(crate) mod round;
pub(crate) mod shard;
pub(crate) mod stop;
pub(crate) mod task;
pub(crate) mod timings;
