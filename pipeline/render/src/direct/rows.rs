//! Surface points as shadow rays see them: what they ask lights for, and how many rays they are worth.

use super::groups::{End, SampledLights};
use crate::follow::{FollowedPart, Lit};
use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_materials::Bsdf;
use rrf_metrics::color::luminance;

/// Shadow rays of a round, at most, of surfaces that are gathered from near by.
const BESIDE: u32 = 8;

/// Rows to be lit.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    pub(crate) seen: &'a VisiblePoints,
    /// The part of each row that sends rays of its own; empty where none does.
    pub(crate) followed: &'a [Option<FollowedPart>],
    /// Surfaces that the rays have met before.
    pub(crate) depth: u32,
    /// Camera rays of each pixel.
    pub(crate) camera_rays: u32,
}

impl Rows<'_> {
    /// The part of a row whose rays bring emission.
    fn followed(&self, row: usize) -> Option<&FollowedPart> {
        let part = self.followed.get(row)?.as_ref();
        part.filter(|part| part.brings_emission())
    }

    /// The part of a row's material that asks for lights.
    pub(super) fn asking(&self, row: usize) -> Bsdf {
        match self.followed(row) {
            Some(part) if part.is_sharp => part.rest.unwrap_or(Bsdf::BLACK),
            _ => self.seen.under_lights(row),
        }
    }

    /// f cos θ of a row toward an end, less what the row's own rays bring.
    pub(super) fn value(&self, row: usize, end: &End, all: &dyn Fn() -> f32) -> Vec3 {
        let (normal, v, l) = (self.seen.normals[row], self.seen.viewers[row], end.toward);
        match (self.followed(row), end.level) {
            (Some(part), Some(level)) => {
                let density = SampledLights::shadow_density(level, all());
                part.value_beside_rays((normal, v, l), density)
            }
            _ => self.seen.under_lights(row).eval(normal, v, l),
        }
    }

    /// Share of a row's light that reaches its camera ray.
    pub(super) fn throughput(&self, row: usize) -> f32 {
        match self.depth {
            0 => 1.0,
            _ => luminance(self.seen.carried[row].throughput).min(1.0),
        }
    }

    /// As many of `rays` as a row's throughput is worth.
    pub(super) fn worth(&self, row: usize, rays: u32) -> u32 {
        let lit = self.seen.carried.get(row).map(|carried| carried.lit);
        match self.depth {
            0 => rays,
            // gathered beside the surface that it lights: few rays would leave grain
            _ if lit == Some(Lit::Widened) => rays.min(BESIDE),
            _ => ((rays as f32 * self.throughput(row)).ceil() as u32).clamp(rays.min(1), rays),
        }
    }

    /// Variance that each row of a pixel may have, where the pixel may have 1. Rows that camera rays met
    /// are averaged; of others, whose throughput makes them parts of a camera ray, variances add up.
    pub(super) fn allowances(&self) -> Vec<f32> {
        let pixels = &self.seen.pixel;
        let mut allowances = Vec::with_capacity(pixels.len());
        for pixel in pixels.chunk_by(|a, b| a == b) {
            let (count, camera) = (pixel.len() as f32, self.camera_rays as f32);
            let allowance = match self.depth {
                0 => count,
                _ => camera * camera / count,
            };
            allowances.resize(allowances.len() + pixel.len(), allowance);
        }
        allowances
    }
}
