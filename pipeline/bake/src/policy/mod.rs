//! The decisions of a bake as pure functions: plans and evaluations go in, plans come out.

pub(crate) mod actions;
pub(crate) mod boundary;
pub(crate) mod budget;
pub(crate) mod compress;
pub(crate) mod cost;
pub(crate) mod evaluate;
pub(crate) mod first;
pub(crate) mod gain;
pub(crate) mod held_out;
pub(crate) mod refine;
pub(crate) mod tasks;
pub(crate) mod test_rows;
