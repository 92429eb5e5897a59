//! Nets, and what stands in their place, over batches of rows.

pub mod borders;
mod exp;
mod field;
mod kernel;
mod lights;
mod packed;
mod tanh;
mod timings;
mod walk;

pub use exp::{EXP_ERROR, MAX_EXPONENT};
pub use field::Field;
pub use lights::{LitField, Workspace};
pub use tanh::{TANH_ERROR, rational_tanh};
pub use timings::EvaluationTimings;
