//! Lights of all kinds as [`crate::DirectLight`]: sources, lamps, and both by way of mirrors.

mod conditions;
mod lamp;
mod mirrors;
mod numbers;
mod own;
mod source;
mod triangle;
mod white;

pub use conditions::{ConditionPlan, LightConditions};
pub use lamp::{Lamp, finer_near_lamps};
pub use mirrors::{FlatMirrors, Mirrored};
pub use own::named_light;
pub use source::SourceLight;
pub use white::in_white;

pub(crate) use lamp::{WhiteLamp, white_lamps};
pub(crate) use white::fingerprint;
