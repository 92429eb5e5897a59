//! What other programs need to check a bake or to use it, in their own formats.
//!
//! [`mitsuba::write_mitsuba`] puts a scene into a folder that Mitsuba 3 loads: `scene.xml`, a PLY file a
//! mesh, an EXR file a texture. [`tensors::write_safetensors`] puts the nets and their kd-tree into one
//! safetensors file, from which ten lines of numpy give what `rrf query` gives; [`onnx::write_onnx`] the
//! same as a graph that any ONNX runtime evaluates. `notebooks/02_nets` does both.
//! [`transfer::write_transfer_tensors`] puts a transfer and lights into a safetensors file; `docs/guide/relight.py` relights from it.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod error;
mod light;
mod material;
pub mod mitsuba;
pub mod onnx;
mod ply;
mod tensor_file;
pub mod tensors;
pub mod transfer;

pub use error::ExportError;
use rrf_field::model::CellModel;

/// Other formats know nets alone.
fn nets_only(cells: &[CellModel]) -> Result<(), ExportError> {
    match cells.iter().find(|cell| !cell.kind.is_net()) {
        None => Ok(()),
        Some(cell) => Err(ExportError::NoNet {
            cell: cell.cell,
            kind: cell.kind.name(),
        }),
    }
}
