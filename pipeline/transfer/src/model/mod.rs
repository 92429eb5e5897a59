//! A model that answers any light: patches, and cells that read their light.

mod block;
mod cells;
mod evaluate;
mod light;
mod net;
mod nodes;
mod packed;
mod part;
mod read;
mod structure;
mod sums;
mod transfer;

pub(crate) use block::{PartAnswer, answer_block};
pub(crate) use cells::{AXES, coordinate};
pub use cells::{CellNode, LEAF_AXIS, SurfaceCells};
pub use evaluate::TransferAnswer;
pub use light::LightCoefficients;
pub use net::TransferNet;
pub use nodes::TransferNodes;
pub use packed::{PackedNumber, PackedRows};
pub use part::PartFit;
pub use read::LightRead;
pub(crate) use transfer::receiver_stream;
pub use transfer::{SKETCHES, TransferCell, TransferModel};
