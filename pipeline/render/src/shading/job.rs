//! A frame to shade, and how each of its tiles is.

use super::indirect::{Answers, Lit};
use super::layers::Band;
use super::probes::Probes;
use crate::direct::{PointLighting, Rows, SampledLighting, SampledLights, ShadowRays};
use crate::error::RenderError;
use crate::follow::{FollowedPart, Following, MetPatches, RayQueue};
use crate::options::RenderOptions;
use crate::tile::{Tile, VisiblePoints};
use crate::timings::{FrameStage, Stopwatch};
use crate::view::View;
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_scene::PointLight;
use rrf_trace::{SurfacePoint, Tracer};

/// Columns that a thread works with, tile after tile.
#[derive(Default)]
pub(super) struct Work {
    pub(super) seen: VisiblePoints,
    /// The part of each row that sends rays on; empty where no surface has one.
    pub(super) followed: Vec<Option<FollowedPart>>,
    /// Rays of each row's broad part, where the model does not answer for it; empty where it always does.
    pub(super) gathered: Vec<u32>,
    /// Whether each row's answer is believed, where that is asked.
    pub(super) trust: Vec<bool>,
    pub(super) queue: RayQueue,
    pub(super) probes: Probes,
    point_lighting: PointLighting,
    sampled_lighting: SampledLighting,
    pub(super) answers: Answers,
    pub(super) watch: Stopwatch,
}

/// Names of a tile's pixels, which their random numbers follow from.
#[derive(Clone, Copy)]
pub(super) struct PixelNames {
    /// Number of the pixel that the tile's are counted from.
    pub(super) first: u64,
    /// Number of the tile's first pixel.
    pub(super) corner: u64,
    /// Pixels of a row of the picture.
    pub(super) width: u32,
}

/// A frame to shade: everything that its tiles share.
pub(super) struct Job<'f> {
    pub(super) tracer: &'f Tracer<'f>,
    /// Point lights by exact shadow rays.
    pub(super) points: &'f [PointLight],
    /// Lights of other kinds that shine from one direction each, exact too.
    pub(super) sharp: Vec<&'f LightSource>,
    /// Lights to be sampled.
    pub(super) sampled: SampledLights<'f>,
    /// Whether surfaces may shine themselves.
    pub(super) emission: bool,
    /// What each lamp's emission is multiplied with, if anything.
    pub(super) dims: &'f [Vec3],
    /// What is followed along the ray.
    pub(super) following: Following,
    /// The model under the lights.
    pub(super) lit: Lit<'f>,
    /// The patches that the model reads light from, if it does.
    pub(super) patches: Option<MetPatches<'f>>,
    pub(super) options: &'f RenderOptions<'f>,
    /// Camera rays a side of a pixel.
    pub(super) side: u32,
    /// Share of a camera ray in its pixel.
    pub(super) weight: f32,
}

impl Job<'_> {
    /// Shades a tile: camera rays, rows of what they meet, direct light, nets; then the same for what
    /// mirrors and glass show, and so on.
    pub(super) fn shade(
        &self,
        work: &mut Work,
        (view, tile): (&View, Tile),
        band: &mut Band,
    ) -> Result<(), RenderError> {
        work.watch.restart();
        work.seen.shoot(self.tracer, view, tile, self.side);
        work.watch.end(FrameStage::PrimaryRays);
        work.seen.read_hits(self.tracer, self.goes_on());
        work.watch.end(FrameStage::Points);
        band.clear(tile, view.width);
        self.add_emission(work, band);
        let first = u64::from(tile.y) * u64::from(view.width);
        let names = PixelNames {
            first,
            corner: first + u64::from(tile.x),
            width: view.width,
        };
        self.shade_seen(work, names, band)?;
        band.sum(tile, view.width);
        work.watch.end(FrameStage::Resolve);
        Ok(())
    }

    /// Whether shadow rays choose where to look, and there may be a sky to find.
    pub(super) fn asks_sky(&self) -> bool {
        let asks = self.options.part.has_direct() || self.goes_on();
        let adaptive = self.options.shadow_rays.is_none_or(|rays| rays.adaptive);
        asks && adaptive && !self.sampled.far.is_empty()
    }

    /// Whether rays may go on from what the camera sees.
    fn goes_on(&self) -> bool {
        let Following { narrow, lamps, .. } = self.following;
        narrow || lamps || self.options.gather > 0 || self.options.fallback > 0
    }

    /// Light of the visible points, and of what they show.
    pub(super) fn shade_seen(
        &self,
        work: &mut Work,
        names: PixelNames,
        band: &mut Band,
    ) -> Result<(), RenderError> {
        let part = self.options.part;
        for depth in 0.. {
            work.trust.clear();
            work.gathered.clear();
            self.choose_followed(work, depth);
            let wanted = if depth == 0 {
                part.has_direct()
            } else {
                part.has_indirect()
            };
            if wanted {
                self.add_direct(work, names, band, depth);
            }
            if part.has_indirect() {
                self.add_indirect(work, names, band, depth)?;
            }
            if !self.follow(work, names, band, depth) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Adds what the camera sees of lamps and sky.
    fn add_emission(&self, work: &Work, band: &mut Band) {
        if !self.options.part.has_direct() {
            return;
        }
        let seen = &work.seen;
        if self.emission {
            let shining = seen.points.iter().zip(&seen.viewers);
            let emitted = shining.map(|(point, &v)| self.emitted(point, v));
            self.add(band.direct, seen, emitted);
        }
        for &(pixel, direction) in &seen.missed {
            let from_afar: Vec3 = self.sampled.far.iter().map(|s| s.radiance(direction)).sum();
            band.direct[pixel as usize] += self.weight * from_afar;
        }
    }

    /// Radiance that a lamp emits at a point toward `v`.
    pub(super) fn emitted(&self, point: &SurfacePoint, v: Vec3) -> Vec3 {
        let lamp = self.tracer.scene().triangle_light[point.triangle as usize];
        self.tracer.emission(point, v) * self.dim(lamp)
    }

    /// What a lamp is multiplied with.
    pub(super) fn dim(&self, lamp: u32) -> Vec3 {
        self.dims.get(lamp as usize).copied().unwrap_or(Vec3::ONE)
    }

    /// Adds light straight from the lights at the visible points.
    fn add_direct(&self, work: &mut Work, names: PixelNames, band: &mut Band, depth: u32) {
        let (seen, watch) = (&work.seen, &mut work.watch);
        let layer = match depth {
            0 => &mut *band.direct,
            _ => &mut *band.indirect,
        };
        watch.end(FrameStage::Resolve);
        let exact = &mut work.point_lighting;
        exact.shade(self.tracer, seen, (self.points, &self.sharp), watch);
        self.add(layer, seen, exact.radiance.iter().copied());
        if !self.sampled.is_empty() {
            watch.end(FrameStage::Resolve);
            let options = self.options;
            let plan = options
                .shadow_rays
                .unwrap_or_else(|| ShadowRays::down_to(options.noise));
            let rows = Rows {
                seen,
                followed: &work.followed,
                depth,
                camera_rays: self.side * self.side,
            };
            let sampled = &mut work.sampled_lighting;
            let pixels = (names.first, names.width);
            let plan = (plan, options.seed);
            sampled.shade(self.tracer, rows, &self.sampled, plan, pixels, watch);
            self.add(layer, seen, sampled.radiance.iter().copied());
        }
        watch.end(FrameStage::Resolve);
    }

    /// Adds a radiance a visible point to the layer's pixels.
    pub(super) fn add(
        &self,
        layer: &mut [Vec3],
        seen: &VisiblePoints,
        radiance: impl Iterator<Item = Vec3>,
    ) {
        if seen.carried.is_empty() {
            for (&pixel, radiance) in seen.pixel.iter().zip(radiance) {
                layer[pixel as usize] += self.weight * radiance;
            }
            return;
        }
        for (carried, radiance) in seen.carried.iter().zip(radiance) {
            layer[carried.pixel as usize] += self.weight * carried.throughput * radiance;
        }
    }
}
