//! The part of a basis that a light is measured by.

use crate::TransferError;
use crate::basis::{Basis, SKETCHES};
use glam::Vec3;
use rayon::prelude::*;

/// Reads coefficients and the residual off a light's irradiance, from the columns that rows use.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBasis {
    /// Dimensions.
    pub rank: usize,
    /// Columns that the patches have.
    pub width: usize,
    /// Columns that rows use; growing.
    pub columns: Vec<u32>,
    /// Shape [rank, columns] row-major.
    pub read: Vec<f32>,
    /// Random combinations of weighted rows, shape [sketches, columns].
    pub sketch: Vec<f32>,
    /// Their projections, shape [sketches, rank].
    pub sketch_made: Vec<f32>,
}

impl LightBasis {
    /// The columns of a basis that some row uses.
    pub(crate) fn new(basis: &Basis, used: &[bool]) -> LightBasis {
        let columns: Vec<u32> = (0..basis.columns as u32)
            .filter(|&c| used.get(c as usize).copied().unwrap_or(false))
            .collect();
        let pick = |matrix: &[f32]| -> Vec<f32> {
            (matrix.chunks_exact(basis.columns.max(1)))
                .flat_map(|row| columns.iter().map(|&c| row[c as usize]))
                .collect()
        };
        LightBasis {
            rank: basis.rank,
            width: basis.columns,
            read: pick(&basis.read),
            sketch: pick(&basis.sketch),
            sketch_made: basis.sketch_made.clone(),
            columns,
        }
    }

    /// Which columns matter.
    pub fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.width];
        for &column in &self.columns {
            if let Some(used) = used.get_mut(column as usize) {
                *used = true;
            }
        }
        used
    }

    fn pick(&self, irradiance: &[Vec3]) -> Result<Vec<Vec3>, TransferError> {
        if irradiance.len() != self.width {
            return Err(TransferError::Columns {
                found: irradiance.len(),
                expected: self.width,
            });
        }
        Ok((self.columns.iter())
            .map(|&c| irradiance[c as usize])
            .collect())
    }

    /// Coefficients of a light, `rank` numbers a channel, from its irradiance of all columns.
    pub fn coefficients(&self, irradiance: &[Vec3]) -> Result<Vec<Vec3>, TransferError> {
        Ok(times(&self.read, &self.pick(irradiance)?))
    }

    /// What share of a light the basis leaves out, as [`Basis::residual`].
    pub fn residual(&self, irradiance: &[Vec3]) -> Result<f32, TransferError> {
        let light = self.pick(irradiance)?;
        let whole = times(&self.sketch, &light);
        let made = times(&self.sketch_made, &times(&self.read, &light));
        let (mut rest, mut all) = (0.0f64, 0.0f64);
        for (whole, made) in whole.iter().zip(&made) {
            rest += f64::from((*whole - *made).length_squared());
            all += f64::from(whole.length_squared());
        }
        Ok(if all > 0.0 {
            (rest / all).sqrt() as f32
        } else {
            0.0
        })
    }

    /// How many numbers it consists of.
    pub fn numbers(&self) -> usize {
        self.columns.len() + self.read.len() + self.sketch.len() + SKETCHES * self.rank
    }
}

/// A row-major matrix times a vector a channel.
fn times(matrix: &[f32], vector: &[Vec3]) -> Vec<Vec3> {
    (matrix.par_chunks_exact(vector.len().max(1)))
        .map(|row| {
            let mut sum = Vec3::ZERO;
            row.iter().zip(vector).for_each(|(m, v)| sum += *m * *v);
            sum
        })
        .collect()
}
