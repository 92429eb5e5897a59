//! Light that is followed along the ray, since no net can follow it: mirrors, glass, coats and metals
//! that are nearly smooth.
//!
//! A surface's narrow part ([`rrf_materials::Bsdf::narrow`]) sends its rays on to the next surface.
//! Direct light and nets answer there for the broad part, and the narrow part goes on, up to
//! [`MOST_FOLLOWED`] times. [`FollowedPart`] says which part of a visible point is followed and by how
//! many rays; [`RayQueue`] holds the rays of a whole tile. Where a model is not believed, or by final
//! gather, the broad part sends rays as well, in place of the model's answer.
//!
//! The same rays meet lamps and the sky. Together with shadow rays they would count that light twice:
//! both are weighted by the balance heuristic (Veach and Guibas 1995). Broad lobes that are still
//! glossy send rays for the lamps' sake alone.

mod carried;
mod part;
mod patches;
mod queue;

pub(crate) use carried::{Carried, Lit};
pub(crate) use part::{FollowedPart, Following, RAYS, has_lobes};
pub(crate) use patches::MetPatches;
pub(crate) use queue::{Launch, RayQueue, least};

/// Surfaces that a chain of followed rays may meet.
pub const MOST_FOLLOWED: usize = 8;
