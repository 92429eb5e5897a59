//! A light as the model knows it.

use glam::Vec3;

/// Once a change of light: its coefficients in the basis, and what is left of each cell's outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightCoefficients {
    /// Coefficients in the basis, a channel each.
    pub(crate) basis: Vec<Vec3>,
    /// Contracted outputs of all cells.
    pub(crate) outputs: Vec<Vec3>,
    /// First of each cell's two parts in `outputs`, and the number of all.
    pub(crate) starts: Vec<usize>,
}

impl LightCoefficients {
    /// Coefficients in the model's basis.
    pub fn basis(&self) -> &[Vec3] {
        &self.basis
    }

    /// Adds another light of the same model times a factor a channel.
    pub fn add_scaled(&mut self, other: &LightCoefficients, factor: Vec3) {
        let add = |own: &mut [Vec3], more: &[Vec3]| {
            own.iter_mut()
                .zip(more)
                .for_each(|(o, m)| *o += *m * factor);
        };
        add(&mut self.basis, &other.basis);
        add(&mut self.outputs, &other.outputs);
    }

    /// What is left of one part of a cell.
    #[inline]
    pub(crate) fn of(&self, cell: u32, part: usize) -> &[Vec3] {
        let at = 2 * cell as usize + part;
        &self.outputs[self.starts[at]..self.starts[at + 1]]
    }
}
