//! How one part of a cell's rows is answered.

use super::net::TransferNet;
use super::nodes::TransferNodes;
use super::packed::PackedRows;
use crate::query::TransferQuery;
use glam::Vec3;

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

impl PartFit {
    /// What is left of the outputs under a light, by its coefficients in the cell.
    pub fn contract(&self, coefficients: &[Vec3]) -> Vec<Vec3> {
        match self {
            PartFit::Nothing => Vec::new(),
            PartFit::Net(net) => net.contract(coefficients),
            PartFit::Nodes(nodes) => nodes.contract(coefficients),
        }
    }

    /// The part at a point, over its directional albedo, under a contracted light.
    #[inline]
    pub fn evaluate(&self, query: &TransferQuery, contracted: &[Vec3]) -> Vec3 {
        match self {
            PartFit::Nothing => Vec3::ZERO,
            PartFit::Net(net) => net.evaluate(&query.inputs(), contracted),
            PartFit::Nodes(nodes) => nodes.evaluate(query, contracted),
        }
    }

    /// Whether a point lies within what the part was fitted to, by `margin` deviations.
    #[inline]
    pub fn is_inside(&self, query: &TransferQuery, margin: f32) -> bool {
        match self {
            PartFit::Net(net) => net.beyond(&query.inputs()) <= margin,
            _ => true,
        }
    }

    /// Packs what it makes of each of a light's coefficients, rows of `width` numbers.
    pub(crate) fn pack(&mut self, exact: &[f32], width: usize) {
        match self {
            PartFit::Nothing => {}
            PartFit::Net(net) => net.output = PackedRows::pack(exact, width),
            PartFit::Nodes(nodes) => nodes.values = PackedRows::pack(exact, width),
        }
    }

    /// Bytes of its numbers.
    pub fn bytes(&self) -> usize {
        match self {
            PartFit::Nothing => 0,
            PartFit::Net(net) => net.bytes(),
            PartFit::Nodes(nodes) => nodes.bytes(),
        }
    }
}
