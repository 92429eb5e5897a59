//! Indirect light as a linear function of direct light.
//!
//! Transport is linear in the light. If E_g is the direct irradiance of surface patch g, whatever
//! lights it, the light that leaves a point p toward a viewer v after two reflections or
//! more is
//!
//! ```text
//! s+(p, v) = sum over g of T_g(p, v) E_g
//! ```
//!
//! (Hasan, Pellacini, Bala, *Direct-to-Indirect Transfer for Cinematic Relighting*, SIGGRAPH
//! 2006). [`Patches`] cuts the surface into patches; [`Receivers`] asks for their irradiance under
//! any [`DirectLight`]; [`trace_rows`] estimates rows of T by paths that know no light;
//! [`Basis`] says which few numbers of an irradiance an ensemble of lights needs, and [`CellBasis`]
//! which of them the rows of one cell need.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bake;
mod basis;
mod book;
mod entry;
mod error;
mod irradiance;
mod lights;
mod model;
mod patches;
mod query;
mod reflectance;
mod regression;
mod rows;
mod sources;
mod tracing;
mod walk;

pub use bake::{
    CellChoice, PointDraw, TransferConfig, TransferRowsSet, bake_transfer, extract_transfer,
    fit_transfer,
};
pub use basis::{Basis, CellBasis, Ensemble, RelativeWeights, radiances};
pub use book::{LightBook, LitTransfer};
pub use entry::Entry;
pub use error::TransferError;
pub use irradiance::Receivers;
pub use lights::{
    DirectLight, DistantSource, IncidentLight, Leg, PointSource, Receiver, ReceiverId,
};
pub use model::{
    CellNode, LEAF_AXIS, LightBasis, LightCoefficients, PartFit, SurfaceCells, TransferAnswer,
    TransferCell, TransferModel, TransferNet, TransferNodes,
};
pub use patches::{PatchConfig, PatchPoint, Patches, SizeField};
pub use query::{SurfaceKey, TransferQuery};
pub use reflectance::{COSINES, Reflectances};
pub use regression::{LocalConfig, NetConfig, RowTable};
pub use rows::{RowConfig, RowPoint, TransferRows, trace_rows};
pub use sources::{
    ConditionPlan, FlatMirrors, Lamp, LightConditions, Mirrored, SourceLight, finer_near_lamps,
    in_white, named_light,
};
