//! How much to sample, and what comes of it.

use crate::TraceError;
use glam::Vec3;

/// How much to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Paths a query, of unlimited depth.
    pub paths: u32,
    /// Independent estimates that the paths are split into: 2 give two halves, 16 or more a
    /// usable standard error. Paths of one replicate are stratified together.
    pub replicates: u32,
}

/// Independent unbiased estimates of radiance [W/(sr m^2)] at every query.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// How many independent estimates a query has.
    pub replicates: usize,
    /// Shape [queries, replicates], row-major: each the mean of paths / replicates paths.
    pub values: Vec<Vec3>,
}

impl Estimates {
    /// How many queries.
    pub fn len(&self) -> usize {
        self.values.len() / self.replicates.max(1)
    }

    /// Whether there is no query.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Two independent estimates of a query: the mean of the even replicates and of the odd.
    pub fn halves(&self, query: usize) -> [Vec3; 2] {
        let row = self.row(query);
        let mean = |first: usize| {
            let picked = row.iter().skip(first).step_by(2);
            let count = picked.clone().count().max(1);
            picked.copied().sum::<Vec3>() / count as f32
        };
        [mean(0), mean(1)]
    }

    /// Mean of all paths of a query.
    pub fn mean(&self, query: usize) -> Vec3 {
        let row = self.row(query);
        row.iter().copied().sum::<Vec3>() / row.len().max(1) as f32
    }

    /// Standard error of [`Estimates::mean`] a channel, from the spread of the replicates.
    pub fn standard_error(&self, query: usize) -> Vec3 {
        let row = self.row(query);
        let mean = self.mean(query);
        let count = row.len().max(2) as f32;
        let squares: Vec3 = row.iter().map(|&v| (v - mean) * (v - mean)).sum();
        let variance = squares / (count - 1.0) / count;
        Vec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt())
    }

    fn row(&self, query: usize) -> &[Vec3] {
        let first = query * self.replicates;
        self.values
            .get(first..first + self.replicates)
            .unwrap_or(&[])
    }
}

impl Sampling {
    /// Paths a replicate.
    pub(crate) fn each(&self) -> Result<usize, TraceError> {
        let (paths, replicates) = (self.paths, self.replicates);
        if replicates == 0 || paths == 0 || !paths.is_multiple_of(replicates) {
            return Err(TraceError::Paths { paths, replicates });
        }
        Ok((paths / replicates) as usize)
    }
}

/// Whether a query column is as long as the points.
pub(crate) fn same_length(
    column: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), TraceError> {
    if found == expected {
        return Ok(());
    }
    Err(TraceError::Queries {
        column,
        found,
        reference: "points",
        expected,
    })
}
