//! A cell's read of a light.

use glam::Vec3;

/// A few combinations of the light on nodes of the column tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightRead {
    /// How many combinations.
    pub rank: usize,
    /// Nodes of the column tree; none lies within another.
    pub nodes: Vec<u32>,
    /// Shape [nodes, rank] row-major: what 1 W on a node adds to each combination.
    pub weights: Vec<f32>,
}

impl LightRead {
    /// The combinations for a light, a channel each, from what arrives at every node.
    pub fn coefficients(&self, fluxes: &[Vec3]) -> Vec<Vec3> {
        super::sums::combine(self.rank, &self.nodes, &self.weights, fluxes)
    }

    /// How many numbers it consists of.
    pub fn numbers(&self) -> usize {
        self.nodes.len() + self.weights.len()
    }
}
