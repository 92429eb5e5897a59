//! Lights of all kinds as [`crate::DirectLight`]: sources, lamps, and both by way of mirrors.

mod conditions;
mod lamp;
mod mirrors;
mod numbers;
mod source;
mod triangle;

pub use conditions::{ConditionPlan, LightConditions};
pub use lamp::Lamp;
pub use mirrors::{FlatMirrors, Mirrored};
pub use source::SourceLight;
