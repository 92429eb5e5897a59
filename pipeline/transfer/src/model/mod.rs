//! A model that answers any light: patches, basis, cells.

mod basis;
mod cells;
mod evaluate;
mod light;
mod net;
mod nodes;

use crate::TransferError;
use crate::basis::CellBasis;
use crate::irradiance::Receivers;
use crate::patches::Patches;
use crate::reflectance::Reflectances;
use crate::tracing::{Stream, Tracer};
use glam::Vec3;
use rrf_sampling::Stage;

pub use basis::LightBasis;
pub(crate) use cells::{AXES, coordinate};
pub use cells::{CellNode, LEAF_AXIS, SurfaceCells};
pub use evaluate::TransferAnswer;
pub use light::LightCoefficients;
pub use net::TransferNet;
pub use nodes::TransferNodes;

/// How one part of a cell's rows is answered.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PartFit {
    /// The material has no such part.
    #[default]
    Nothing,
    /// A net.
    Net(TransferNet),
    /// Local fits at nodes.
    Nodes(TransferNodes),
}

/// A cell.
#[derive(Clone, Debug)]
pub struct TransferCell {
    /// The directions of the basis that its rows need.
    pub basis: CellBasis,
    /// Base part and constant part.
    pub parts: [PartFit; 2],
    /// Relative error on rows that it was not fitted to, noise taken out.
    pub error: f32,
    /// Whether that error is good enough to be shown.
    pub trusted: bool,
}

/// A model that answers any light.
#[derive(Clone, Debug)]
pub struct TransferModel {
    /// Where light is asked for.
    pub patches: Patches,
    /// Points that each patch is asked at.
    pub receiver_points: u32,
    /// Seed of the bake, which those points follow from.
    pub seed: u64,
    /// Coefficients of a light.
    pub basis: LightBasis,
    /// What the rows' parts are relative to.
    pub reflectances: Reflectances,
    /// Which cell a point belongs to.
    pub tree: SurfaceCells,
    /// The cells.
    pub cells: Vec<TransferCell>,
}

/// The stream that receivers' points follow from.
pub(crate) fn receiver_stream(seed: u64) -> Stream {
    Stream::new(seed, Stage::Transfer, 0).part(1)
}

impl TransferModel {
    /// The fixed points that a light's irradiance is asked at.
    pub fn receivers<'a>(&'a self, tracer: &'a Tracer<'a>) -> Receivers<'a> {
        let used = self.basis.used();
        let stream = receiver_stream(self.seed);
        Receivers::new(
            tracer,
            &self.patches,
            self.receiver_points,
            Some(&used),
            stream,
        )
    }

    /// A light by its irradiance of all columns, as [`Receivers::irradiance`] gives it.
    pub fn coefficients(&self, irradiance: &[Vec3]) -> Result<LightCoefficients, TransferError> {
        let basis = self.basis.coefficients(irradiance)?;
        let mut light = LightCoefficients {
            starts: vec![0],
            outputs: Vec::new(),
            basis,
        };
        for cell in &self.cells {
            let own = cell.basis.coefficients(&light.basis);
            for part in &cell.parts {
                match part {
                    PartFit::Nothing => {}
                    PartFit::Net(net) => light.outputs.extend(net.contract(&own)),
                    PartFit::Nodes(nodes) => light.outputs.extend(nodes.contract(&own)),
                }
                light.starts.push(light.outputs.len());
            }
        }
        Ok(light)
    }

    /// The share of a light that the basis leaves out: see [`LightBasis::residual`].
    pub fn residual(&self, irradiance: &[Vec3]) -> Result<f32, TransferError> {
        self.basis.residual(irradiance)
    }

    /// How many numbers the model consists of, patches left out: they follow from the scene.
    pub fn numbers(&self) -> usize {
        let part = |part: &PartFit| match part {
            PartFit::Nothing => 0,
            PartFit::Net(net) => net.numbers(),
            PartFit::Nodes(nodes) => nodes.numbers(),
        };
        let cells = self
            .cells
            .iter()
            .map(|cell| cell.basis.read.len() + cell.parts.iter().map(part).sum::<usize>());
        self.basis.numbers() + 4 * self.tree.nodes.len() + cells.sum::<usize>()
    }
}
