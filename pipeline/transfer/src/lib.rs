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
//! any [`DirectLight`]; [`trace_rows`] estimates rows of T by paths that know no light.
//!
//! [`bake_transfer`] makes a [`TransferModel`] of them. Rows of one surface are smoothed by local
//! fits and cut into cells; a cell reads a few combinations of the light on clusters of patches
//! ([`ColumnTree`], [`LightRead`]), and a small net says what its points make of them. Under a given
//! light ([`LightCoefficients`]) a point costs one net with three outputs.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bake;
mod book;
mod bright;
mod columns;
mod ensemble;
mod entry;
mod error;
mod irradiance;
mod lights;
mod model;
mod patches;
mod query;
mod reflectance;
mod regression;
mod row_config;
mod rows;
mod sources;
mod svd;
mod tracing;
mod walk;

pub use bake::{
    CellChoice, PointDraw, TRUST_ERROR, TransferConfig, TransferProgress, TransferStage,
    TransferWatch, bake_transfer,
};
pub use book::{LightBook, LitTransfer, MOST_RESIDUAL};
pub use bright::{BrightPatches, BrightPlace};
pub use columns::ColumnTree;
pub use ensemble::{Ensemble, RelativeWeights, radiances};
pub use entry::Entry;
pub use error::TransferError;
pub use irradiance::Receivers;
pub use lights::{
    DirectLight, DistantSource, IncidentLight, Leg, PointSource, Receiver, ReceiverId,
};
pub use model::{
    CellNode, LEAF_AXIS, LightCoefficients, LightRead, PackedNumber, PackedRows, PartFit, SKETCHES,
    SurfaceCells, TransferAnswer, TransferCell, TransferModel, TransferNet, TransferNodes,
};
pub use patches::{PatchConfig, PatchPoint, PatchSizes, Patches, SizeField};
pub use query::{SurfaceKey, TransferQuery};
pub use reflectance::{COSINES, Reflectances};
pub use regression::{LocalConfig, NetConfig, RowTable};
pub use row_config::RowConfig;
pub use rows::{RowPoint, TransferRows, trace_rows};
pub use sources::{
    ConditionPlan, FlatMirrors, Lamp, LightConditions, Mirrored, SourceLight, finer_near_lamps,
    in_white, named_light,
};
