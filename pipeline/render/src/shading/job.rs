//! A frame to shade, and how each of its tiles is.

use super::indirect::{Answers, Lit};
use super::layers::Band;
use crate::direct::{PointLighting, Rows, SampledLighting, SampledLights, ShadowRays};
use crate::error::RenderError;
use crate::follow::{FollowedPart, Following, Launch, MOST_FOLLOWED, RayQueue};
use crate::options::RenderOptions;
use crate::tile::{Tile, VisiblePoints};
use crate::timings::{FrameStage, Stopwatch};
use crate::view::View;
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_metrics::color::luminance;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, PointLight};
use rrf_trace::{SurfacePoint, Tracer};

/// Columns that a thread works with, tile after tile.
#[derive(Default)]
pub(super) struct Work {
    seen: VisiblePoints,
    /// The part of each row that sends rays on; empty where no surface has one.
    followed: Vec<Option<FollowedPart>>,
    queue: RayQueue,
    point_lighting: PointLighting,
    sampled_lighting: SampledLighting,
    answers: Answers,
    pub(super) watch: Stopwatch,
}

/// A frame to shade: everything that its tiles share.
pub(super) struct Job<'f> {
    pub(super) tracer: &'f Tracer<'f>,
    pub(super) view: &'f View,
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
        tile: Tile,
        band: &mut Band,
    ) -> Result<(), RenderError> {
        work.watch.restart();
        work.seen.shoot(self.tracer, self.view, tile, self.side);
        work.watch.end(FrameStage::PrimaryRays);
        work.seen
            .read_hits(self.tracer, self.following != Following::default());
        work.watch.end(FrameStage::Points);
        band.clear(tile, self.view.width);
        self.add_emission(work, band);
        let part = self.options.part;
        for depth in 0.. {
            self.choose_followed(work, depth);
            let wanted = if depth == 0 {
                part.has_direct()
            } else {
                part.has_indirect()
            };
            if wanted {
                self.add_direct(work, tile, band, depth);
            }
            if part.has_indirect() {
                self.add_indirect(work, tile, band, depth)?;
            }
            if !self.follow(work, tile, band, depth) {
                break;
            }
        }
        band.sum(tile, self.view.width);
        work.watch.end(FrameStage::Resolve);
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
    fn emitted(&self, point: &SurfacePoint, v: Vec3) -> Vec3 {
        let lamp = self.tracer.scene().triangle_light[point.triangle as usize];
        self.tracer.emission(point, v) * self.dim(lamp)
    }

    /// What a lamp is multiplied with.
    fn dim(&self, lamp: u32) -> Vec3 {
        self.dims.get(lamp as usize).copied().unwrap_or(Vec3::ONE)
    }

    /// Chooses the part of each row that sends rays on.
    fn choose_followed(&self, work: &mut Work, depth: u32) {
        let Work { seen, followed, .. } = work;
        followed.clear();
        let following = Following {
            // emission that a first surface shows is direct light
            lamps: self.following.lamps && (depth > 0 || self.options.part.has_direct()),
            ..self.following
        };
        if !following.narrow && !following.lamps {
            return;
        }
        let camera_rays = (depth == 0).then_some(self.side * self.side);
        let surfaces = seen.normals.iter().zip(&seen.viewers).zip(&seen.materials);
        followed.extend(surfaces.zip(&seen.carried).map(
            |(((&normal, &viewer), material), carried)| {
                let throughput = luminance(carried.throughput);
                following.part(material, (normal, viewer), throughput, camera_rays)
            },
        ));
    }

    /// Adds light straight from the lights at the visible points.
    fn add_direct(&self, work: &mut Work, tile: Tile, band: &mut Band, depth: u32) {
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
            let pixels = (self.first_pixel(tile), self.view.width);
            let rows = Rows {
                seen,
                followed: &work.followed,
                depth,
                camera_rays: self.side * self.side,
            };
            let sampled = &mut work.sampled_lighting;
            sampled.shade(self.tracer, rows, &self.sampled, plan, pixels, watch);
            self.add(layer, seen, sampled.radiance.iter().copied());
        }
        watch.end(FrameStage::Resolve);
    }

    /// Number of the first pixel that a tile's pixels are counted from.
    fn first_pixel(&self, tile: Tile) -> u64 {
        u64::from(tile.y) * u64::from(self.view.width)
    }

    /// Adds a radiance a visible point to the layer's pixels.
    fn add(&self, layer: &mut [Vec3], seen: &VisiblePoints, radiance: impl Iterator<Item = Vec3>) {
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

    /// Adds the model's light at the visible points, and which cells gave it.
    fn add_indirect(
        &self,
        work: &mut Work,
        tile: Tile,
        band: &mut Band,
        depth: u32,
    ) -> Result<(), RenderError> {
        let Work {
            seen,
            answers,
            watch,
            ..
        } = work;
        if depth == 0 && self.following.gather > 0 {
            return Ok(());
        }
        let first = self.first_pixel(tile) + u64::from(tile.x) + (u64::from(depth) << 40);
        (self.lit).evaluate(self.tracer, seen, self.options, first, answers, watch)?;
        let [r, g, b] = &answers.radiance;
        let rgb = r.iter().zip(g).zip(b).zip(&seen.materials);
        let answered = |material| self.answers_for(material);
        let radiance = rgb.map(|(((&r, &g), &b), material)| match answered(material) {
            true => Vec3::new(r, g, b),
            false => Vec3::ZERO,
        });
        self.add(band.indirect, seen, radiance);
        // Of the pixel's first row, which comes last here; of mirrors, what they show.
        let cells = seen.pixel.iter().zip(&answers.cells).zip(&seen.materials);
        for ((&pixel, &cell), material) in cells.rev() {
            let known = &mut band.cell[pixel as usize];
            let is_told = match depth {
                0 => !self.following.narrow || material.is_black() || answered(material),
                _ => *known == u32::MAX && answered(material),
            };
            if is_told {
                *known = cell;
            }
        }
        if let Some(trusted) = self.options.trusted {
            let trust = self.lit.trust(trusted, seen, answers);
            for (row, (&pixel, trust)) in seen.pixel.iter().zip(trust).enumerate() {
                let share = seen.carried.get(row).map_or(1.0, |carried| carried.share);
                let share = if trust { share } else { 0.0 };
                band.trust[pixel as usize] += self.weight * share;
            }
        }
        Ok(())
    }

    /// Whether the model answers for a part of a material: no net was trained on what sends no light,
    /// such as a lamp, or on what is traced.
    fn answers_for(&self, material: &rrf_materials::Bsdf) -> bool {
        match self.following.narrow {
            true => material.broad().is_some_and(|broad| !broad.is_black()),
            false => !material.is_black(),
        }
    }

    /// Sends rays on from the visible points and adds the emission that they meet. The surfaces that
    /// they meet are the next visible points; `false` where there are none.
    fn follow(&self, work: &mut Work, tile: Tile, band: &mut Band, depth: u32) -> bool {
        let gather = match depth {
            0 => self.following.gather,
            _ => 0,
        };
        let Some(counted) = work.watch.timings.1.get_mut(depth as usize) else {
            return false;
        };
        if work.followed.iter().all(Option::is_none) && gather == 0 {
            return false;
        }
        let launch = Launch {
            tracer: self.tracer,
            lights: &self.sampled,
            stream: Stream::new(self.seed(), Stage::Followed, depth),
            first: self.first_pixel(tile),
            gather,
        };
        work.queue.clear();
        work.queue.launch(&launch, &mut work.seen, &work.followed);
        *counted += work.queue.carried.len() as u64;
        work.queue.trace(self.tracer);
        self.add_met_emission(&work.queue, band, depth);
        let goes_on = depth + 1 < MOST_FOLLOWED as u32 || gather > 0;
        let queue = &work.queue;
        let rays = (&queue.rays, queue.carried.as_slice());
        work.seen.read_followed(self.tracer, rays, &queue.hits);
        work.watch.end(FrameStage::FollowedRays);
        goes_on && !work.seen.points.is_empty()
    }

    fn seed(&self) -> u64 {
        self.options.shadow_rays.unwrap_or_default().seed
    }

    /// Adds the emission that rays met which had met `depth` surfaces before their last one.
    fn add_met_emission(&self, queue: &RayQueue, band: &mut Band, depth: u32) {
        let part = self.options.part;
        let (layer, wanted) = match depth {
            0 => (&mut *band.direct, part.has_direct()),
            _ => (&mut *band.indirect, part.has_indirect()),
        };
        let met = queue.hits.triangle.iter().zip(&queue.hits.barycentrics);
        let rays = queue.rays.direction.iter().zip(&queue.carried);
        let lights = &self.tracer.scene().triangle_light;
        for ((&direction, carried), (&triangle, &at)) in rays.zip(met) {
            let pixel = carried.pixel as usize;
            if triangle == INVALID {
                if wanted {
                    layer[pixel] += self.weight * carried.throughput * carried.far;
                }
                // no net is asked
                band.trust[pixel] += self.weight * carried.share;
                continue;
            }
            let light = lights[triangle as usize];
            if !wanted || !self.emission || light == INVALID {
                continue;
            }
            let point = self.tracer.point(triangle, at);
            let radiance =
                self.tracer.scene().area_lights[light as usize].radiance * self.dim(light);
            let weight = carried.lamp_weight(luminance(radiance));
            let emitted = self.emitted(&point, -direction);
            layer[pixel] += self.weight * weight * carried.throughput * emitted;
        }
    }
}
