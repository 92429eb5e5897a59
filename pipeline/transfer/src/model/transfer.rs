//! The model, and a light in it.

use super::cells::SurfaceCells;
use super::light::LightCoefficients;
use super::packed::PackedRows;
use super::part::PartFit;
use super::read::LightRead;
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::irradiance::Receivers;
use crate::patches::{PatchConfig, PatchSizes, Patches};
use crate::reflectance::Reflectances;
use crate::tracing::{Stream, Tracer};
use glam::Vec3;
use rayon::prelude::*;
use rrf_sampling::Stage;

/// Random combinations of rows by which a light's residual is measured.
pub const SKETCHES: usize = 32;

/// A cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferCell {
    /// What it reads of a light.
    pub read: LightRead,
    /// Base part and constant part of its rows.
    pub parts: [PartFit; 2],
    /// Relative error on rows that it was not fitted to, noise taken out, and one standard error of
    /// its square; infinite where that is not known.
    pub error: f32,
    /// Rows that it was fitted to.
    pub rows: u32,
    /// Rows that the error is taken over.
    pub judged: u32,
    /// Shape [sketches, rank]: its rows' part of the random combinations.
    pub sketch: PackedRows,
}

/// A model that answers any light.
#[derive(Clone, Debug)]
pub struct TransferModel {
    /// Where light is asked for.
    pub patches: Patches,
    /// How they were asked for.
    pub patch_config: PatchConfig,
    /// How fine they are where.
    pub sizes: PatchSizes,
    /// Columns of the patches by the cluster.
    pub columns: ColumnTree,
    /// Which columns rows use.
    pub used: Vec<bool>,
    /// Points that each patch is asked at.
    pub receiver_points: u32,
    /// Seed of the bake, which those points follow from.
    pub seed: u64,
    /// Whether it answers for the broad part of surfaces alone.
    pub broad: bool,
    /// What the rows' parts are relative to.
    pub reflectances: Reflectances,
    /// Which cell a point belongs to.
    pub tree: SurfaceCells,
    /// The cells.
    pub cells: Vec<TransferCell>,
    /// Random combinations of weighted rows.
    pub sketch: LightRead,
    /// Cells with a larger error are not trusted.
    pub trust: f32,
}

/// The stream that receivers' points follow from.
pub(crate) fn receiver_stream(seed: u64) -> Stream {
    Stream::new(seed, Stage::Transfer, 0).part(1)
}

impl TransferModel {
    /// The fixed points that a light's irradiance is asked at.
    pub fn receivers<'a>(&'a self, tracer: &'a Tracer<'a>) -> Receivers<'a> {
        let stream = receiver_stream(self.seed);
        let (patches, points) = (&self.patches, self.receiver_points);
        Receivers::new(tracer, patches, points, Some(&self.used), stream)
    }

    fn fluxes(&self, irradiance: &[Vec3]) -> Result<Vec<Vec3>, TransferError> {
        if irradiance.len() != self.columns.columns() {
            return Err(TransferError::Columns {
                found: irradiance.len(),
                expected: self.columns.columns(),
            });
        }
        Ok(self.columns.fluxes(irradiance))
    }

    /// A light by its irradiance of all columns, as [`Receivers::irradiance`] gives it.
    pub fn coefficients(&self, irradiance: &[Vec3]) -> Result<LightCoefficients, TransferError> {
        Ok(self.known(irradiance)?.0)
    }

    /// What share of the light that an irradiance sends into the rows the cells do not read: the
    /// norm of the weighted rows' error over the norm of the weighted rows, estimated from random
    /// combinations of them (Johnson and Lindenstrauss 1984). 0 for a light of 0.
    pub fn residual(&self, irradiance: &[Vec3]) -> Result<f32, TransferError> {
        Ok(self.known(irradiance)?.1)
    }

    /// [`TransferModel::coefficients`] and [`TransferModel::residual`].
    pub(crate) fn known(
        &self,
        irradiance: &[Vec3],
    ) -> Result<(LightCoefficients, f32), TransferError> {
        let fluxes = self.fluxes(irradiance)?;
        let known: Vec<([Vec<Vec3>; 2], Vec<Vec3>)> = (self.cells.par_iter())
            .map(|cell| {
                let own = cell.read.coefficients(&fluxes);
                let parts = [0, 1].map(|part: usize| cell.parts[part].contract(&own));
                (parts, cell.sketch.combine(&own))
            })
            .collect();
        let mut light = LightCoefficients {
            starts: vec![0],
            outputs: Vec::new(),
        };
        let whole = self.sketch.coefficients(&fluxes);
        let mut made = vec![Vec3::ZERO; whole.len()];
        for (parts, sketch) in &known {
            for part in parts {
                light.outputs.extend_from_slice(part);
                light.starts.push(light.outputs.len());
            }
            made.iter_mut().zip(sketch).for_each(|(m, s)| *m += *s);
        }
        let (mut rest, mut all) = (0.0f64, 0.0f64);
        for (whole, made) in whole.iter().zip(&made) {
            rest += f64::from((*whole - *made).length_squared());
            all += f64::from(whole.length_squared());
        }
        let residual = if all > 0.0 { (rest / all).sqrt() } else { 0.0 };
        Ok((light, residual as f32))
    }

    /// Bytes of the model's numbers, patches left out: they follow from the scene.
    pub fn bytes(&self) -> usize {
        let cells = self.cells.iter().map(|cell| {
            let parts: usize = cell.parts.iter().map(PartFit::bytes).sum();
            cell.read.bytes() + cell.sketch.bytes() + parts
        });
        self.sketch.bytes() + 16 * self.tree.nodes.len() + cells.sum::<usize>()
    }
}
