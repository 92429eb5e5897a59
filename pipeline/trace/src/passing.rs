//! Light that goes straight through surfaces: thin panes, and holes and veils of alpha masks.
//!
//! Rays of paths pass such a surface, or stop there, by chance, so that what is beyond is as if seen
//! without it, darker. A pane that stops a ray only reflects it. Shadow rays take the product of all
//! transmittances on their way. Camera rays and public queries pass where more than half of the light
//! passes an alpha mask, which is exact for masks of holes, and stop at panes.

use crate::rays;
use crate::tracer::Tracer;
use crate::walk::{Found, Ray, Stack};
use glam::Vec3;
use rrf_scene::INVALID;

/// Surfaces that one ray passes at most; then it counts as stopped.
const MOST: u32 = 256;

impl Tracer<'_> {
    /// Whether rays may pass some surface.
    pub(crate) fn lets_rays_pass(&self) -> bool {
        self.passes
    }

    /// Opacity of the surface that a ray met, and the share of light that goes straight through it.
    fn passing(&self, found: &Found, direction: Vec3) -> (f32, Vec3) {
        let vertex = self.vertex(found.triangle, found.barycentrics, -direction);
        let opacity = self.opacity(found.triangle, found.barycentrics);
        let straight = vertex.bsdf.straight(vertex.shading.dot(direction).abs());
        (opacity, Vec3::splat(1.0 - opacity) + straight * opacity)
    }

    /// The rest of a ray beyond what it met: where it starts, and by how much that is farther.
    fn beyond(&self, ray: &Ray, found: &Found) -> (Ray, f32) {
        let facet = &self.facets[found.triangle as usize];
        let cosine = facet.normal.dot(ray.direction).abs().max(f32::MIN_POSITIVE);
        // past the plane by the lift, as rays that leave it start
        let t = found.t + facet.lift / cosine.max(1e-3 * ray.direction.length());
        let rest = Ray {
            origin: ray.origin + ray.direction * t,
            direction: ray.direction,
            t_max: ray.t_max - t,
        };
        (rest, t)
    }

    /// Follows a unit ray that met `found` through what it passes by chance, by a number in [0, 1)
    /// for each surface: what it meets in the end, its distance from the first origin, and the
    /// factor of the light from there.
    pub(crate) fn pass_by_chance(
        &self,
        ray: &Ray,
        found: &mut Found,
        stack: &mut Stack,
        hits: &mut Vec<Found>,
        mut number: impl FnMut(u32) -> f32,
    ) -> Vec3 {
        let (mut factor, mut rest, mut gone) = (Vec3::ONE, *ray, 0.0);
        for k in 0..MOST {
            if found.triangle == INVALID || !self.facets[found.triangle as usize].passes {
                break;
            }
            let met = Found {
                t: found.t - gone,
                ..*found
            };
            let (opacity, through) = self.passing(&met, rest.direction);
            let probability = (through.element_sum() / 3.0).min(1.0);
            if number(k) >= probability {
                return factor * (opacity / (1.0 - probability));
            }
            factor *= through / probability;
            let (onward, step) = self.beyond(&rest, &met);
            (rest, gone) = (onward, gone + step);
            rays::closest(&self.wide, &[rest], stack, hits);
            if let Some(next) = hits.first() {
                *found = Found {
                    t: next.t + gone,
                    ..*next
                };
            }
        }
        factor
    }

    /// Share of light that passes along a ray which something may block.
    pub(crate) fn transmittance(
        &self,
        ray: &Ray,
        stack: &mut Stack,
        hits: &mut Vec<Found>,
    ) -> Vec3 {
        let (mut share, mut rest) = (Vec3::ONE, *ray);
        for _ in 0..MOST {
            rays::closest(&self.wide, &[rest], stack, hits);
            let Some(found) = hits.first().filter(|found| found.triangle != INVALID) else {
                return share;
            };
            if !self.facets[found.triangle as usize].passes {
                return Vec3::ZERO;
            }
            share *= self.passing(found, rest.direction.normalize()).1;
            if share == Vec3::ZERO {
                return share;
            }
            rest = self.beyond(&rest, found).0;
        }
        Vec3::ZERO
    }

    /// Moves on what public rays met to the first surface that does not let most light pass by an alpha
    /// mask.
    pub(crate) fn skip_holes(&self, ray: &Ray, found: &mut Found, stack: &mut Stack) {
        let (mut hits, mut rest, mut gone) = (Vec::new(), *ray, 0.0);
        for _ in 0..MOST {
            if found.triangle == INVALID
                || !self.facets[found.triangle as usize].passes
                || self.opacity(found.triangle, found.barycentrics) >= 0.5
            {
                return;
            }
            let met = Found {
                t: found.t - gone,
                ..*found
            };
            let (onward, step) = self.beyond(&rest, &met);
            (rest, gone) = (onward, gone + step);
            rays::closest(&self.wide, &[rest], stack, &mut hits);
            if let Some(next) = hits.first() {
                *found = Found {
                    t: next.t + gone,
                    ..*next
                };
            }
        }
    }
}
