//! Patches by the light that reaches them: where rays that gather light should look first.

use crate::patches::{PatchPoint, Patches};
use crate::tracing::SurfacePoint;
use glam::Vec3;
use rrf_sampling::warp::{by_weight, by_weight_probability};

/// Sides of patches, chosen in proportion to the power that reaches each straight from the lights.
pub struct BrightPatches<'a> {
    patches: &'a Patches,
    /// Cumulative power: front of patch 0, its back, front of patch 1 and so on.
    cumulative: Vec<f64>,
}

/// A place on a bright patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrightPlace {
    /// The place.
    pub point: PatchPoint,
    /// Whether it is the side that geometric normals point away from.
    pub back: bool,
    /// Density with respect to area [1/m²].
    pub density: f32,
}

/// The power \[W\], channels averaged, that reaches both sides of each patch.
pub(crate) fn powers(patches: &Patches, irradiance: &[Vec3]) -> Vec<f32> {
    let mut powers = Vec::with_capacity(2 * patches.len());
    for patch in 0..patches.len() as u32 {
        let area = patches.area[patch as usize];
        for back in [false, true] {
            let first = patches.first_column(patch, back) as usize;
            let columns = &irradiance[first..first + patches.directions(patch).pow(2) as usize];
            let sum: f32 = columns.iter().map(|e| e.element_sum() / 3.0).sum();
            powers.push(sum.max(0.0) * area);
        }
    }
    powers
}

impl<'a> BrightPatches<'a> {
    /// Of the powers of all sides; none where all is dark.
    pub(crate) fn new(patches: &'a Patches, powers: &[f32]) -> Option<BrightPatches<'a>> {
        let mut sum = 0.0;
        let upto = powers.iter().map(|&power| {
            sum += f64::from(power);
            sum
        });
        let cumulative = upto.collect();
        (sum > 0.0).then_some(BrightPatches {
            patches,
            cumulative,
        })
    }

    /// A place by three numbers in [0, 1).
    pub fn sample(&self, [u, v, w]: [f32; 3]) -> Option<BrightPlace> {
        let side = by_weight(&self.cumulative, u);
        let before = side.checked_sub(1).map_or(0.0, |k| self.cumulative[k]);
        let all = self.cumulative.last().copied().unwrap_or(1.0);
        let power = self.cumulative[side] - before;
        let within = ((f64::from(u) * all - before) / power).clamp(0.0, 1.0) as f32;
        let patch = (side / 2) as u32;
        Some(BrightPlace {
            point: self.patches.place(patch, [within, v, w])?,
            back: side % 2 == 1,
            density: self.side_density(side),
        })
    }

    /// Density of [`BrightPatches::sample`] at a point of the bake's scene with respect to area [1/m²].
    pub fn density(&self, point: &SurfacePoint, back: bool) -> f32 {
        let side = |patch: u32| 2 * patch as usize + usize::from(back);
        let patch = self.patches.patch(point);
        patch.map_or(0.0, |patch| self.side_density(side(patch)))
    }

    fn side_density(&self, side: usize) -> f32 {
        let chance = by_weight_probability(&self.cumulative, side);
        chance as f32 / self.patches.area[side / 2]
    }
}
