//! A cell's read of a light.

use super::packed::PackedRows;
use glam::Vec3;

/// A few combinations of the light on nodes of the column tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightRead {
    /// Nodes of the column tree; none lies within another.
    pub nodes: Vec<u32>,
    /// One row a node: what 1 W on it adds to each combination.
    pub weights: PackedRows,
}

impl LightRead {
    /// How many combinations.
    pub fn rank(&self) -> usize {
        self.weights.width
    }

    /// The combinations for a light, a channel each, from what arrives at every node.
    pub fn coefficients(&self, fluxes: &[Vec3]) -> Vec<Vec3> {
        super::sums::combine(&self.nodes, &self.weights, fluxes)
    }

    /// Bytes of its numbers.
    pub fn bytes(&self) -> usize {
        4 * self.nodes.len() + self.weights.bytes()
    }
}
