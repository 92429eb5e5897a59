//! A light as the model knows it.

use glam::Vec3;

/// Each cell's outputs under a light: made once a change of light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightCoefficients {
    /// Contracted outputs of all cells.
    pub(crate) outputs: Vec<Vec3>,
    /// First of each cell's two parts in `outputs`, and the number of all.
    pub(crate) starts: Vec<usize>,
}

impl LightCoefficients {
    /// Adds another light of the same model times a factor a channel.
    pub fn add_scaled(&mut self, other: &LightCoefficients, factor: Vec3) {
        let pairs = self.outputs.iter_mut().zip(&other.outputs);
        pairs.for_each(|(own, more)| *own += *more * factor);
    }

    /// What is left of one part of a cell.
    #[inline]
    pub(crate) fn of(&self, cell: u32, part: usize) -> &[Vec3] {
        let at = 2 * cell as usize + part;
        &self.outputs[self.starts[at]..self.starts[at + 1]]
    }
}
