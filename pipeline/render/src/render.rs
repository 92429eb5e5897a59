//! A frame: what the camera sees, its direct light, its indirect light by the nets.

use crate::direct::Direct;
use crate::error::RenderError;
use crate::facts;
use crate::frame::Frame;
use crate::tile::{self, Tile, Visible};
use crate::view::{Lights, View};
use glam::Vec3;
use rayon::prelude::*;
use rrf_field::columns::{self, Columns};
use rrf_field::{Field, Light};
use rrf_scene::PointLight;
use rrf_trace::Tracer;

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
    /// Tells which rows, light included, the nets were trained for; with it the frame has a
    /// trust layer.
    pub trusted: Option<&'a Trusted<'a>>,
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
    radiance: [Vec<f32>; 3],
    cells: Vec<u32>,
}

/// A band of the frame's layers.
struct Band<'f> {
    direct: &'f mut [Vec3],
    indirect: &'f mut [Vec3],
    cell: &'f mut [u32],
    trust: &'f mut [f32],
}

/// What every tile of a frame shares.
struct Job<'f> {
    tracer: &'f Tracer<'f>,
    field: &'f Field,
    view: &'f View,
    points: &'f [PointLight],
    lights: Vec<Light>,
    options: &'f RenderOptions<'f>,
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
    view.check()?;
    lights.check()?;
    if lights.area && !tracer.scene().area_lights.is_empty() {
        return Err(RenderError::AreaLights);
    }
    let light = |light: &PointLight| Light {
        position: light.position.to_array(),
        intensity: light.intensity.to_array(),
    };
    let job = Job {
        tracer,
        field,
        view,
        points: &lights.points,
        lights: lights.points.iter().map(light).collect(),
        options,
    };
    let count = view.width as usize * view.height as usize;
    let (mut direct, mut indirect) = (vec![Vec3::ZERO; count], vec![Vec3::ZERO; count]);
    let (mut cell, mut trust) = (vec![u32::MAX; count], vec![0.0; count]);
    let size = (tile::HEIGHT * view.width) as usize;
    direct
        .par_chunks_mut(size)
        .zip(indirect.par_chunks_mut(size))
        .zip(cell.par_chunks_mut(size).zip(trust.par_chunks_mut(size)))
        .enumerate()
        .try_for_each_init(Work::default, |work, (band, layers)| {
            let ((direct, indirect), (cell, trust)) = layers;
            let mut layers = Band {
                direct,
                indirect,
                cell,
                trust,
            };
            let mut tiles = Tile::of_band(view.width, view.height, band as u32);
            tiles.try_for_each(|tile| job.tile(work, tile, &mut layers))
        })?;
    let (with_direct, with_indirect) = parts(options.part);
    Ok(Frame {
        width: view.width,
        height: view.height,
        full: direct.iter().zip(&indirect).map(|(a, b)| a + b).collect(),
        direct: with_direct.then_some(direct),
        indirect: with_indirect.then_some(indirect),
        cell: with_indirect.then_some(cell),
        trust: (with_indirect && options.trusted.is_some()).then_some(trust),
        attributes: facts::of_render(view, lights, options),
    })
}

fn parts(part: Part) -> (bool, bool) {
    (part != Part::Indirect, part != Part::Direct)
}

impl Job<'_> {
    fn tile(&self, work: &mut Work, tile: Tile, band: &mut Band) -> Result<(), RenderError> {
        let side = self.options.side();
        let weight = 1.0 / (side * side) as f32;
        work.seen.shoot(self.tracer, self.view, tile, side);
        let (with_direct, with_indirect) = parts(self.options.part);
        if with_direct {
            work.direct
                .point_lights(self.tracer, &work.seen, self.points);
            for (&pixel, &radiance) in work.seen.pixel.iter().zip(&work.direct.radiance) {
                band.direct[tile.in_band(pixel, self.view.width)] += weight * radiance;
            }
        }
        if with_indirect {
            self.indirect(work, tile, weight, band)?;
        }
        Ok(())
    }

    /// The nets' light at the visible points, and which nets gave it.
    fn indirect(
        &self,
        work: &mut Work,
        tile: Tile,
        weight: f32,
        band: &mut Band,
    ) -> Result<(), RenderError> {
        let Work {
            seen,
            radiance,
            cells,
            ..
        } = work;
        self.field
            .evaluate_lights(&seen.rows, &self.lights, radiance, cells)?;
        let at = |pixel: u32| tile.in_band(pixel, self.view.width);
        let [r, g, b] = &*radiance;
        let rgb = r.iter().zip(g).zip(b);
        for (&pixel, ((&r, &g), &b)) in seen.pixel.iter().zip(rgb) {
            band.indirect[at(pixel)] += weight * Vec3::new(r, g, b);
        }
        // Of the pixel's first ray that hit, which comes last here.
        for (&pixel, &cell) in seen.pixel.iter().zip(&*cells).rev() {
            band.cell[at(pixel)] = cell;
        }
        if self.options.negative == Negative::Zero {
            for pixel in 0..tile.pixels() as u32 {
                let value = &mut band.indirect[at(pixel)];
                *value = value.max(Vec3::ZERO);
            }
        }
        if let Some(trusted) = self.options.trusted {
            let trust = trusted_under_all(trusted, &seen.rows, &self.lights);
            for (&pixel, trust) in seen.pixel.iter().zip(trust) {
                band.trust[at(pixel)] += if trust { weight } else { 0.0 };
            }
        }
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
