//! A frame: what the camera sees, its direct light, its indirect light by the nets.

use crate::blend::blended;
use crate::direct::Direct;
use crate::emitter::Emitter;
use crate::error::RenderError;
use crate::facts;
use crate::frame::Frame;
use crate::layers::{Band, Layers, parts};
use crate::sampled::{Sampled, ShadowRays};
use crate::stages::{Lap, Stages};
use crate::stand_in::Lamps;
use crate::tile::{Tile, Visible};
use crate::view::{Lights, View};
use glam::Vec3;
use rayon::prelude::*;
use rrf_field::columns::{self, Columns};
use rrf_field::{Borders, Field, Light, LitField, Workspace};
use rrf_scene::PointLight;
use rrf_trace::Tracer;
use std::sync::Mutex;

/// Which part of the light a frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// Direct and indirect.
    #[default]
    Full,
    /// Light that arrives straight from the lights.
    Direct,
    /// Light that arrives from other surfaces.
    Indirect,
}

/// What becomes of negative radiance, which a net may give where there is next to none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Negative {
    /// It stays: the frame is what the nets say, errors average out.
    #[default]
    Keep,
    /// It becomes zero.
    Zero,
}

/// Whether the nets were trained for each of the rows.
pub type Trusted<'a> = dyn Fn(&Columns) -> Vec<bool> + Sync + 'a;

/// How a frame is made.
#[derive(Clone, Copy, Default)]
pub struct RenderOptions<'a> {
    /// Part of the light.
    pub part: Part,
    /// Camera rays a pixel are `aa` x `aa`; 0 means 1.
    pub aa: u32,
    /// Negative radiance of the indirect part, pixel by pixel and channel by channel.
    pub negative: Negative,
    /// The scene's area lights: needed where they shine, with the scene that has them traced.
    pub lamps: Option<&'a Lamps>,
    /// How lights are sampled. Point lights are otherwise exact, one shadow ray each; area
    /// lights are always sampled, by [`ShadowRays::default`] if need be.
    pub shadow_rays: Option<ShadowRays>,
    /// Tells which rows, light included, the nets were trained for; with it the frame has a
    /// trust layer.
    pub trusted: Option<&'a Trusted<'a>>,
    /// Where cells meet, if their nets are to be blended there. Takes the lights one by one.
    pub borders: Option<&'a Borders>,
}

impl RenderOptions<'_> {
    fn side(&self) -> u32 {
        self.aa.max(1)
    }
}

/// What a thread works with, tile after tile.
#[derive(Default)]
struct Work {
    seen: Visible,
    direct: Direct,
    sampled: Sampled,
    nets: Workspace,
    radiance: [Vec<f32>; 3],
    cells: Vec<u32>,
    stages: Stages,
}

/// What every tile of a frame shares.
struct Job<'f> {
    tracer: &'f Tracer<'f>,
    view: &'f View,
    /// Point lights by exact shadow rays.
    points: &'f [PointLight],
    /// Lights to be sampled.
    emitters: Vec<Emitter>,
    /// Whether surfaces may shine themselves.
    emission: bool,
    /// The nets under their point lights.
    lit: LitField<'f>,
    options: &'f RenderOptions<'f>,
}

/// Makes frame after frame of one scene and field, and keeps what the threads work with.
pub struct Renderer<'a> {
    tracer: &'a Tracer<'a>,
    field: &'a Field,
    idle: Mutex<Vec<Work>>,
}

/// Renders `view` under point lights. Layers: the parts asked for, and with the indirect part
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
            field,
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
    ) -> Result<Stages, RenderError> {
        view.check()?;
        lights.check()?;
        let job = self.job(view, lights, options)?;
        let mut layers = Layers::of(frame, view);
        let bands = layers.bands(view.width).enumerate();
        let stages = bands
            .map(|(band, mut layers)| {
                let mut work = self.take();
                let mut tiles = Tile::of_band(view.width, view.height, band as u32);
                let done = tiles.try_for_each(|tile| job.tile(&mut work, tile, &mut layers));
                let stages = std::mem::take(&mut work.stages);
                self.give_back(work);
                done.map(|()| stages)
            })
            .collect::<Result<Vec<Stages>, RenderError>>()?;
        layers.into_frame(frame, options);
        frame.attributes = facts::of_render(view, lights, options);
        let mut sum = Stages::default();
        stages.iter().for_each(|stages| sum.add(stages));
        Ok(sum)
    }

    /// Which lights are exact, which are sampled, which the nets see.
    fn job<'f>(
        &'f self,
        view: &'f View,
        lights: &'f Lights,
        options: &'f RenderOptions<'f>,
    ) -> Result<Job<'f>, RenderError> {
        let lamps = match options.lamps {
            Some(lamps) if lights.area => Some(lamps),
            None if lights.area && !self.tracer.scene().area_lights.is_empty() => {
                return Err(RenderError::AreaLights);
            }
            _ => None,
        };
        let light = |light: &PointLight| Light {
            position: light.position.to_array(),
            intensity: light.intensity.to_array(),
        };
        let stand_ins = lamps.into_iter().flat_map(Lamps::points);
        let cells = lamps.map_or(&[][..], |lamps| &lamps.cells);
        let points = lights.points.iter().map(Emitter::from);
        let sampled = points.filter(|_| options.shadow_rays.is_some());
        let of_nets: Vec<Light> = lights.points.iter().map(light).chain(stand_ins).collect();
        Ok(Job {
            tracer: self.tracer,
            view,
            points: match options.shadow_rays {
                None => &lights.points,
                Some(_) => &[],
            },
            emitters: sampled.chain(cells.iter().copied()).collect(),
            emission: lamps.is_some(),
            lit: self.field.under(&of_nets),
            options,
        })
    }

    /// A thread that panicked may leave the list behind poisoned, but never half changed.
    fn take(&self) -> Work {
        let mut idle = self
            .idle
            .lock()
            .unwrap_or_else(|poison| poison.into_inner());
        idle.pop().unwrap_or_default()
    }

    fn give_back(&self, work: Work) {
        let mut idle = self
            .idle
            .lock()
            .unwrap_or_else(|poison| poison.into_inner());
        idle.push(work);
    }
}

impl Job<'_> {
    fn tile(&self, work: &mut Work, tile: Tile, band: &mut Band) -> Result<(), RenderError> {
        let mut lap = Lap::start();
        let side = self.options.side();
        let weight = 1.0 / (side * side) as f32;
        work.seen.shoot(self.tracer, self.view, tile, side);
        lap.end(&mut work.stages.primary_rays);
        work.seen.read_hits(self.tracer);
        lap.end(&mut work.stages.points);
        band.clear(tile, self.view.width);
        lap.end(&mut work.stages.resolve);
        let (with_direct, with_indirect) = parts(self.options.part);
        if with_direct {
            self.direct(work, tile, weight, band);
            lap = Lap::start();
        }
        if with_indirect {
            self.indirect(work, weight, band)?;
            lap = Lap::start();
        }
        band.sum(tile, self.view.width, self.options.negative);
        lap.end(&mut work.stages.resolve);
        Ok(())
    }

    /// Light straight from the lights, and what the surface sends out itself.
    fn direct(&self, work: &mut Work, tile: Tile, weight: f32, band: &mut Band) {
        let Work {
            seen,
            direct,
            sampled,
            stages,
            ..
        } = work;
        direct.point_lights(self.tracer, seen, self.points, stages);
        let mut lap = Lap::start();
        for (&pixel, &radiance) in seen.pixel.iter().zip(&direct.radiance) {
            band.direct[pixel as usize] += weight * radiance;
        }
        if !self.emitters.is_empty() {
            let first = u64::from(tile.y) * u64::from(self.view.width);
            let plan = self.options.shadow_rays.unwrap_or_default();
            let place = (first, self.view.width);
            sampled.estimate(self.tracer, seen, &self.emitters, plan, place, stages);
            lap = Lap::start();
            for (&pixel, &radiance) in seen.pixel.iter().zip(&sampled.radiance) {
                band.direct[pixel as usize] += weight * radiance;
            }
        }
        if self.emission {
            let shining = seen.points.iter().zip(&seen.viewers);
            for (&pixel, (point, &v)) in seen.pixel.iter().zip(shining) {
                band.direct[pixel as usize] += weight * self.tracer.emission(point, v);
            }
        }
        lap.end(&mut stages.resolve);
    }

    /// The nets' light at the visible points, and which nets gave it.
    fn indirect(&self, work: &mut Work, weight: f32, band: &mut Band) -> Result<(), RenderError> {
        let Work {
            seen,
            nets,
            radiance,
            cells,
            stages,
            ..
        } = work;
        match self.options.borders {
            Some(borders) => blended(borders, &self.lit, &seen.rows, radiance, cells)?,
            None => {
                let timings = Some(&mut stages.nets);
                self.lit
                    .evaluate(&seen.rows, nets, radiance, cells, timings)?;
            }
        }
        let mut lap = Lap::start();
        let [r, g, b] = &*radiance;
        let rgb = r.iter().zip(g).zip(b).zip(&seen.materials);
        for (&pixel, (((&r, &g), &b), material)) in seen.pixel.iter().zip(rgb) {
            // no net was trained on what sends no light, such as a lamp
            if !material.is_black() {
                band.indirect[pixel as usize] += weight * Vec3::new(r, g, b);
            }
        }
        // Of the pixel's first ray that hit, which comes last here.
        for (&pixel, &cell) in seen.pixel.iter().zip(&*cells).rev() {
            band.cell[pixel as usize] = cell;
        }
        if let Some(trusted) = self.options.trusted {
            let trust = trusted_under_all(trusted, &seen.rows, self.lit.lights());
            for (&pixel, trust) in seen.pixel.iter().zip(trust) {
                band.trust[pixel as usize] += if trust { weight } else { 0.0 };
            }
        }
        lap.end(&mut stages.resolve);
        Ok(())
    }
}

/// Whether each row is trusted under every one of the lights.
fn trusted_under_all(trusted: &Trusted, rows: &Columns, lights: &[Light]) -> Vec<bool> {
    let mut rows = rows.clone();
    let mut all = vec![true; rows.len()];
    for light in lights {
        for (i, x) in light.position.into_iter().enumerate() {
            rows.columns[columns::L + i].fill(x);
        }
        for (all, one) in all.iter_mut().zip(trusted(&rows)) {
            *all &= one;
        }
    }
    all
}
