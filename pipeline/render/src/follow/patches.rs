//! Patches of a transfer in a frame's scene, which may have more triangles than the bake's: how wide they
//! are, and where rays that gather light look for it.

use glam::Vec3;
use rrf_scene::{INVALID, Scene};
use rrf_trace::{SurfacePoint, Tracer};
use rrf_transfer::{BrightPatches, Patches};

/// Patches, the light that reaches them, and the triangles that they lie on.
pub(crate) struct MetPatches<'a> {
    patches: &'a Patches,
    /// None where all is dark.
    bright: Option<BrightPatches<'a>>,
    /// Triangle of the bake's scene for each one that rays meet; [`INVALID`] for lamps.
    baked: Vec<u32>,
    /// The other way.
    met: Vec<u32>,
    /// Width of the largest patch, metres.
    pub(crate) widest: f32,
}

/// A place to look at.
pub(crate) struct BrightTarget {
    /// Unit direction to it.
    pub(crate) toward: Vec3,
    /// Distance to it, metres.
    pub(crate) distance: f32,
    /// Density of the direction [1/sr].
    pub(crate) density: f32,
}

impl<'a> MetPatches<'a> {
    /// In a scene that is the bake's but for its lamps.
    pub(crate) fn new(
        patches: &'a Patches,
        bright: Option<BrightPatches<'a>>,
        scene: &Scene,
    ) -> MetPatches<'a> {
        let (all, baked) = (scene.triangles.len(), patches.triangles());
        // a scene without its lamps names its triangles as the bake does
        let left_out = |t: usize| all != baked && scene.is_lamp(t);
        let met: Vec<u32> = (0..all as u32).filter(|&t| !left_out(t as usize)).collect();
        let mut of_baked = vec![INVALID; all];
        for (own, &t) in (0..).zip(&met) {
            of_baked[t as usize] = own;
        }
        MetPatches {
            patches,
            bright,
            baked: of_baked,
            met,
            widest: patches
                .area
                .iter()
                .fold(0.0f32, |m, &area| m.max(area))
                .sqrt(),
        }
    }

    /// A place that faces a point, as often as light reaches it, by three numbers in [0, 1).
    pub(crate) fn sample(&self, tracer: &Tracer, from: Vec3, u: [f32; 3]) -> Option<BrightTarget> {
        let place = self.bright.as_ref()?.sample(u)?;
        let &triangle = self.met.get(place.point.triangle as usize)?;
        let point = tracer.point(triangle, place.point.barycentrics);
        let to = point.position - from;
        let distance = to.length();
        let toward = to / distance.max(f32::MIN_POSITIVE);
        let side = if place.back {
            -point.normal
        } else {
            point.normal
        };
        let cosine = -side.dot(toward);
        (cosine > 0.0 && distance > 0.0).then(|| BrightTarget {
            toward,
            distance,
            density: place.density * distance * distance / cosine,
        })
    }

    /// Density with respect to area of a point that a ray from `viewer` met, over its cosine to the ray.
    pub(crate) fn density(&self, point: &SurfacePoint, viewer: Vec3) -> f32 {
        let cosine = point.normal.dot(viewer);
        match (&self.bright, self.baked(point)) {
            (Some(bright), Some(own)) if cosine != 0.0 => {
                bright.density(&own, cosine < 0.0) / cosine.abs()
            }
            _ => 0.0,
        }
    }

    /// Width of the patch that a point lies on, metres; 0 for lamps.
    pub(crate) fn width(&self, point: &SurfacePoint) -> f32 {
        let patch = self.baked(point).and_then(|own| self.patches.patch(&own));
        patch.map_or(0.0, |patch| self.patches.area[patch as usize].sqrt())
    }

    /// The point as the bake's scene names it.
    pub(crate) fn baked(&self, point: &SurfacePoint) -> Option<SurfacePoint> {
        let triangle = self.baked[point.triangle as usize];
        (triangle != INVALID).then_some(SurfacePoint { triangle, ..*point })
    }
}
