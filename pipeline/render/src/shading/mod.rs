//! A frame by the nets: what the camera sees, its direct light, its indirect light.
//!
//! [`Renderer::render`] hands out bands of tiles; a tile's pixels are shaded in `Job::shade`, which
//! goes on to what mirrors and glass show.

mod blend;
mod crowded;
mod indirect;
mod job;
mod layers;
mod onward;
mod passes;
mod points;
mod probes;

use crate::direct::SampledLights;
use crate::direct::emitter::Emitter;
use crate::error::RenderError;
use crate::follow::{Following, RAYS};
use crate::frame::Frame;
use crate::options::{Part, RenderOptions};
use crate::origin;
use crate::tile::{Tile, VisiblePoints};
use crate::timings::{FrameStage, FrameTimings, Stopwatch};
use crate::view::{Lights, View};
use indirect::{Baked, Lit};
use job::{Job, Work};
use layers::Layers;
use rayon::prelude::*;
use rrf_field::Field;
use rrf_trace::{TraceError, Tracer};
use rrf_transfer::LightBook;
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

pub use passes::Passes;
pub use points::PointAnswers;
pub use rrf_transfer::MOST_RESIDUAL;

/// Makes frame after frame of one scene and model, and keeps what the threads work with.
pub struct Renderer<'a> {
    tracer: &'a Tracer<'a>,
    baked: Baked<'a>,
    /// Whether narrow parts are traced: the model does not answer for them.
    traces_narrow: bool,
    idle: Mutex<Vec<Work>>,
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
            traces_narrow: false,
            idle: Mutex::default(),
        }
    }

    /// Frames of `tracer`'s scene with the indirect light of a transfer; lamps that shine are those of
    /// that scene. Narrow lobes are traced where the transfer leaves them out.
    pub fn of_transfer(tracer: &'a Tracer<'a>, book: &'a LightBook<'a>) -> Renderer<'a> {
        Renderer {
            tracer,
            baked: Baked::Transfer(book),
            traces_narrow: book.model().broad,
            idle: Mutex::default(),
        }
    }

    /// Traces mirrors, glass and other narrow lobes, if so told: for nets that were baked without
    /// their light. Otherwise they answer for the whole of every surface.
    pub fn tracing_narrow(self, traces_narrow: bool) -> Renderer<'a> {
        Renderer {
            traces_narrow,
            ..self
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
        let (mut job, coefficients) = self.job(lights, options)?;
        if job.asks_sky() {
            let (points, viewers) = VisiblePoints::some_of(self.tracer, view);
            let seen = (points.as_slice(), viewers.as_slice());
            (job.sampled).aim_at_openings(self.tracer, seen, options.seed);
        }
        let mut layers = Layers::take_from(frame, view);
        let bands = layers.bands(view.width).enumerate();
        let timings = bands
            .map(|(number, mut band)| {
                let mut work = self.idle().pop().unwrap_or_default();
                work.watch = Stopwatch::default();
                let mut tiles = Tile::of_band(view.width, view.height, number as u32);
                let done =
                    tiles.try_for_each(|tile| match options.halt.is_some_and(|halt| halt()) {
                        true => Err(TraceError::Halted.into()),
                        false => job.shade(&mut work, (view, tile), &mut band),
                    });
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
        let dimmed = area_lights.and_then(|area| area.scene.as_deref());
        let lamps = dimmed.unwrap_or(self.tracer.scene());
        let lit = self.baked.under(lights, proxies, lamps)?;
        let coefficients = match lit {
            Lit::Nets(_) => Duration::ZERO,
            Lit::Transfer(_) => start.elapsed() * rayon::current_num_threads() as u32,
        };
        let patches = lit.patches(self.tracer.scene());
        let side = options.aa.max(1);
        let emitters = sampled.iter().map(Emitter::from).chain(pieces);
        let sources = lights.sources.iter().map(|light| &light.source);
        let (visible, sharp): (Vec<_>, Vec<_>) = sources.partition(|s| s.is_visible());
        let sampled = SampledLights::new(emitters.collect(), visible);
        let shines = area_lights.is_some() || !sampled.far.is_empty();
        let has_lobes = crate::follow::has_lobes(self.tracer.scene());
        let following = Following {
            narrow: self.traces_narrow && has_lobes && options.part != Part::Direct,
            lamps: shines && has_lobes,
            rays: match options.narrow_rays {
                0 => RAYS,
                rays => rays,
            },
        };
        let job = Job {
            tracer: self.tracer,
            points: exact,
            sharp,
            sampled,
            emission: area_lights.is_some(),
            dims: &lights.dims,
            following,
            lit,
            patches,
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
