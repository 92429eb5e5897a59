//! From a scene to a model: patches, lights, rows, cells.

mod batch;
mod cell;
mod compress;
mod config;
mod directions;
mod draw;
mod exact;
mod judge;
mod level;
mod lighting;
mod memory;
mod model;
mod part_rows;
mod parts;
mod progress;
mod rounds;
mod sizes;
mod sketch;
mod smooth;
mod tree;
mod watch;

pub use config::{CellChoice, TRUST_ERROR, TransferConfig};
pub use draw::PointDraw;
pub use model::bake_transfer;
pub use progress::TransferProgress;
pub use watch::{TransferStage, TransferWatch};
