//! Paths from the query's point.

use super::light::sent_to;
use crate::media::Media;
use crate::surface::Site;
use glam::Vec3;

/// A vertex x_j of a path from the query's point.
#[derive(Clone, Copy)]
pub(super) struct EyeVertex {
    /// Of the batch's paths.
    pub(super) path: u32,
    pub(super) triangle: u32,
    pub(super) site: Site,
    /// Unit direction to x_{j-1}, of x_0 to the viewer.
    pub(super) viewer: Vec3,
    /// Product of f cos / pdf.
    pub(super) throughput: Vec3,
    /// Solids of glass that the path is in.
    pub(super) media: Media,
    /// Largest channel of the throughput after the first scattering.
    pub(super) first: f32,
    /// Which vertex this is.
    pub(super) number: u32,
    /// Density of this vertex with respect to area.
    pub(super) density: f32,
    /// The cosine at x_{j-1} over the squared distance.
    pub(super) back: f32,
    /// Density of x_{j-1}, and where it is.
    pub(super) before: f32,
    pub(super) from: Vec3,
    /// The way in which x_{j-2} belongs to the light's end and x_{j-3} does not, relative to its
    /// density here. Light subpaths are too short for more.
    pub(super) others: f32,
}

impl EyeVertex {
    /// The sum over the ways in which x_{j-1} and up to `most` vertices in all belong to the light's
    /// end, if light comes from `l`.
    pub(super) fn earlier(&self, l: Vec3, most: usize) -> f32 {
        if self.number < 2 || most == 0 {
            return 0.0;
        }
        let own = sent_to(&self.site, self.viewer, l) * self.back / self.before;
        let others = if most > 1 { self.others } else { 0.0 };
        own * (1.0 + others)
    }

    /// The sum over the ways in which x_j and up to `most` vertices in all belong to the light's end, that
    /// would lead to x_j with density `by_light` with respect to area; light comes from `l`.
    pub(super) fn lighter(&self, l: Vec3, by_light: f32, most: usize) -> f32 {
        if self.number == 0 || most == 0 {
            return 0.0;
        }
        by_light / self.density * (1.0 + self.earlier(l, most - 1))
    }
}
