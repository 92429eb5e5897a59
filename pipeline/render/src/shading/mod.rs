//! A frame by the nets: what the camera sees, its direct light, its indirect light.
//!
//! [`Renderer::render`] hands out bands of tiles; a tile's pixels are shaded in `Job::shade`.

mod blend;
mod indirect;
mod layers;

use crate::direct::emitter::Emitter;
use crate::direct::{PointLighting, SampledLighting, SampledLights, ShadowRays};
use crate::error::RenderError;
use crate::frame::Frame;
use crate::options::RenderOptions;
use crate::origin;
use crate::tile::{Tile, VisiblePoints};
use crate::timings::{FrameStage, FrameTimings, Stopwatch};
use crate::view::{Lights, View};
use glam::Vec3;
use indirect::{Answers, Baked, Lit};
use layers::{Band, Layers};
use rayon::prelude::*;
use rrf_field::Field;
use rrf_lights::LightSource;
use rrf_scene::PointLight;
use rrf_trace::Tracer;
use rrf_transfer::LightBook;
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

pub use indirect::MOST_RESIDUAL;

/// Makes frame after frame of one scene and model, and keeps what the threads work with.
pub struct Renderer<'a> {
    tracer: &'a Tracer<'a>,
    baked: Baked<'a>,
    idle: Mutex<Vec<Work>>,
}

/// Columns that a thread works with, tile after tile.
#[derive(Default)]
struct Work {
    seen: VisiblePoints,
    point_lighting: PointLighting,
    sampled_lighting: SampledLighting,
    answers: Answers,
    watch: Stopwatch,
}

/// A frame to shade: everything that its tiles share.
struct Job<'f> {
    tracer: &'f Tracer<'f>,
    view: &'f View,
    /// Point lights by exact shadow rays.
    points: &'f [PointLight],
    /// Lights of other kinds that shine from one direction each, exact too.
    sharp: Vec<&'f LightSource>,
    /// Lights to be sampled.
    sampled: SampledLights<'f>,
    /// Whether surfaces may shine themselves.
    emission: bool,
    /// The model under the lights.
    lit: Lit<'f>,
    options: &'f RenderOptions<'f>,
    /// Camera rays a side of a pixel.
    side: u32,
    /// Share of a camera ray in its pixel.
    weight: f32,
}

/// Renders `view` under `lights`. Layers: the parts asked for, and with the indirect part
/// the cell under the first light and, where asked for, trust.
///
/// The same bits on any number of threads.
pub fn render(
    tracer: &Tracer,
    field: &Field,
    view: &View,
    lights: &Lights,
    options: &RenderOptions,
) -> Result<Frame, RenderError> {
    let mut frame = Frame::default();
    Renderer::new(tracer, field).render(view, lights, options, &mut frame)?;
    Ok(frame)
}

impl<'a> Renderer<'a> {
    /// Frames of `tracer`'s scene with the indirect light of `field`.
    pub fn new(tracer: &'a Tracer<'a>, field: &'a Field) -> Renderer<'a> {
        Renderer {
            tracer,
            baked: Baked::Nets(field),
            idle: Mutex::default(),
        }
    }

    /// Frames of `tracer`'s scene with the indirect light of a transfer; lamps that shine are those of
    /// that scene.
    pub fn of_transfer(tracer: &'a Tracer<'a>, book: &'a LightBook<'a>) -> Renderer<'a> {
        Renderer {
            tracer,
            baked: Baked::Transfer(book),
            idle: Mutex::default(),
        }
    }

    /// As [`render()`], into a frame whose memory is used again; and where the time went.
    /// After an error the frame's layers are of no use.
    pub fn render(
        &self,
        view: &View,
        lights: &Lights,
        options: &RenderOptions,
        frame: &mut Frame,
    ) -> Result<FrameTimings, RenderError> {
        view.check()?;
        lights.check()?;
        let (job, coefficients) = self.job(view, lights, options)?;
        let mut layers = Layers::take_from(frame, view);
        let bands = layers.bands(view.width).enumerate();
        let timings = bands
            .map(|(number, mut band)| {
                let mut work = self.idle().pop().unwrap_or_default();
                work.watch = Stopwatch::default();
                let mut tiles = Tile::of_band(view.width, view.height, number as u32);
                let done = tiles.try_for_each(|tile| job.shade(&mut work, tile, &mut band));
                let timings = work.watch.timings;
                self.idle().push(work);
                done.map(|()| timings)
            })
            .collect::<Result<Vec<FrameTimings>, RenderError>>()?;
        layers.give_to(frame, options);
        frame.attributes = origin::of_render(view, lights, options, self.baked.method());
        let mut sum = FrameTimings::default();
        sum.0[FrameStage::Coefficients as usize] = coefficients;
        timings.iter().for_each(|timings| sum.add(timings));
        Ok(sum)
    }

    /// Decides which lights are exact, which are sampled, what the model makes of them; and the
    /// threads' time that the latter took.
    fn job<'f>(
        &'f self,
        view: &'f View,
        lights: &'f Lights,
        options: &'f RenderOptions<'f>,
    ) -> Result<(Job<'f>, Duration), RenderError> {
        let area_lights = options.area_lights.filter(|_| lights.area);
        let has_any = !self.tracer.scene().area_lights.is_empty();
        if lights.area && has_any && area_lights.is_none() {
            return Err(RenderError::AreaLights);
        }
        let (exact, sampled) = match options.shadow_rays {
            None => (lights.points.as_slice(), [].as_slice()),
            Some(_) => ([].as_slice(), lights.points.as_slice()),
        };
        let pieces = area_lights.iter().flat_map(|area| &area.pieces).copied();
        let start = Instant::now();
        let proxies = area_lights.iter().flat_map(|area| area.points());
        let lit = self.baked.under(lights, proxies, self.tracer.scene())?;
        let coefficients = match lit {
            Lit::Nets(_) => Duration::ZERO,
            Lit::Transfer(_) => start.elapsed() * rayon::current_num_threads() as u32,
        };
        let side = options.aa.max(1);
        let emitters = sampled.iter().map(Emitter::from).chain(pieces);
        let sources = lights.sources.iter().map(|light| &light.source);
        let (visible, sharp): (Vec<_>, Vec<_>) = sources.partition(|s| s.is_visible());
        let job = Job {
            tracer: self.tracer,
            view,
            points: exact,
            sharp,
            sampled: SampledLights::new(emitters.collect(), visible),
            emission: area_lights.is_some(),
            lit,
            options,
            side,
            weight: 1.0 / (side * side) as f32,
        };
        Ok((job, coefficients))
    }

    /// Columns that no thread works with at the moment. A thread that panicked may leave the list
    /// poisoned, but never half changed.
    fn idle(&self) -> MutexGuard<'_, Vec<Work>> {
        self.idle.lock().unwrap_or_else(|p| p.into_inner())
    }
}

impl Job<'_> {
    /// Shades a tile: camera rays, rows of what they meet, direct light, nets, layers.
    fn shade(&self, work: &mut Work, tile: Tile, band: &mut Band) -> Result<(), RenderError> {
        work.watch.restart();
        work.seen.shoot(self.tracer, self.view, tile, self.side);
        work.watch.end(FrameStage::PrimaryRays);
        work.seen.read_hits(self.tracer);
        work.watch.end(FrameStage::Points);
        band.clear(tile, self.view.width);
        if self.options.part.has_direct() {
            self.add_direct(work, tile, band);
        }
        if self.options.part.has_indirect() {
            self.add_indirect(work, tile, band)?;
        }
        band.sum(tile, self.view.width);
        work.watch.end(FrameStage::Resolve);
        Ok(())
    }

    /// Adds light straight from the lights, and what the surface sends out itself.
    fn add_direct(&self, work: &mut Work, tile: Tile, band: &mut Band) {
        let (seen, watch) = (&work.seen, &mut work.watch);
        watch.end(FrameStage::Resolve);
        let exact = &mut work.point_lighting;
        exact.shade(self.tracer, seen, (self.points, &self.sharp), watch);
        self.add(band.direct, seen, exact.radiance.iter().copied());
        if !self.sampled.is_empty() {
            watch.end(FrameStage::Resolve);
            let options = self.options;
            let plan = options
                .shadow_rays
                .unwrap_or_else(|| ShadowRays::down_to(options.noise));
            let first = u64::from(tile.y) * u64::from(self.view.width);
            let (sampled, pixels) = (&mut work.sampled_lighting, (first, self.view.width));
            sampled.shade(self.tracer, seen, &self.sampled, plan, pixels, watch);
            self.add(band.direct, seen, sampled.radiance.iter().copied());
        }
        if self.emission {
            let shining = seen.points.iter().zip(&seen.viewers);
            let emitted = shining.map(|(point, &v)| self.tracer.emission(point, v));
            self.add(band.direct, seen, emitted);
        }
        for &(pixel, direction) in &seen.missed {
            let from_afar: Vec3 = self.sampled.far.iter().map(|s| s.radiance(direction)).sum();
            band.direct[pixel as usize] += self.weight * from_afar;
        }
        watch.end(FrameStage::Resolve);
    }

    /// Adds a radiance a visible point to the layer's pixels.
    fn add(&self, layer: &mut [Vec3], seen: &VisiblePoints, radiance: impl Iterator<Item = Vec3>) {
        for (&pixel, radiance) in seen.pixel.iter().zip(radiance) {
            layer[pixel as usize] += self.weight * radiance;
        }
    }

    /// Adds the model's light at the visible points, and which cells gave it.
    fn add_indirect(
        &self,
        work: &mut Work,
        tile: Tile,
        band: &mut Band,
    ) -> Result<(), RenderError> {
        let Work {
            seen,
            answers,
            watch,
            ..
        } = work;
        let first = u64::from(tile.y) * u64::from(self.view.width) + u64::from(tile.x);
        (self.lit).evaluate(self.tracer, seen, self.options, first, answers, watch)?;
        let [r, g, b] = &answers.radiance;
        let rgb = r.iter().zip(g).zip(b).zip(&seen.materials);
        for (&pixel, (((&r, &g), &b), material)) in seen.pixel.iter().zip(rgb) {
            // no net was trained on what sends no light, such as a lamp
            if !material.is_black() {
                band.indirect[pixel as usize] += self.weight * Vec3::new(r, g, b);
            }
        }
        // Of the pixel's first ray that hit, which comes last here.
        for (&pixel, &cell) in seen.pixel.iter().zip(&answers.cells).rev() {
            band.cell[pixel as usize] = cell;
        }
        if let Some(trusted) = self.options.trusted {
            let trust = self.lit.trust(trusted, seen, answers);
            for (&pixel, trust) in seen.pixel.iter().zip(trust) {
                band.trust[pixel as usize] += if trust { self.weight } else { 0.0 };
            }
        }
        Ok(())
    }
}
