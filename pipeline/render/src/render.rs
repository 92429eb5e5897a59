//! A frame: what the camera sees, its direct light, its indirect light by the nets.

use crate::direct::point_lights;
use crate::error::RenderError;
use crate::facts;
use crate::frame::Frame;
use crate::tile::{Tile, Visible};
use crate::view::{Lights, View};
use glam::Vec3;
use rayon::prelude::*;
use rrf_field::columns::{self, Columns};
use rrf_field::{Field, Light};
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

/// The layers of one tile, by pixel.
struct Layers {
    direct: Vec<Vec3>,
    indirect: Vec<Vec3>,
    cell: Vec<u32>,
    trust: Vec<f32>,
}

/// Renders `view` under point lights. Layers: the parts asked for, and with the indirect part
/// the cell under the first light and, where domains are given, trust.
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
    let tiles = Tile::all(view.width, view.height);
    let layers: Vec<Result<Layers, RenderError>> = tiles
        .par_iter()
        .map(|&tile| render_tile(tracer, field, view, lights, options, tile))
        .collect();
    let count = view.width as usize * view.height as usize;
    let (mut direct, mut indirect) = (vec![Vec3::ZERO; count], vec![Vec3::ZERO; count]);
    let (mut cell, mut trust) = (vec![u32::MAX; count], vec![0.0; count]);
    for (tile, layers) in tiles.iter().zip(layers) {
        let layers = layers?;
        for (i, id) in tile.ids(view.width).enumerate() {
            direct[id] = layers.direct[i];
            indirect[id] = layers.indirect[i];
            cell[id] = layers.cell[i];
            trust[id] = layers.trust[i];
        }
    }
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

fn render_tile(
    tracer: &Tracer,
    field: &Field,
    view: &View,
    lights: &Lights,
    options: &RenderOptions,
    tile: Tile,
) -> Result<Layers, RenderError> {
    let side = options.side();
    let seen = Visible::shoot(tracer, view, tile, side);
    let weight = 1.0 / (side * side) as f32;
    let (with_direct, with_indirect) = parts(options.part);
    let mut layers = Layers {
        direct: vec![Vec3::ZERO; tile.pixels()],
        indirect: vec![Vec3::ZERO; tile.pixels()],
        cell: vec![u32::MAX; tile.pixels()],
        trust: vec![0.0; tile.pixels()],
    };
    if with_direct {
        let values = point_lights(tracer, &seen, &lights.points);
        seen.gather(values.into_iter(), weight, &mut layers.direct);
    }
    if with_indirect {
        indirect(field, &seen, lights, options, weight, &mut layers)?;
    }
    Ok(layers)
}

/// The nets' light at the visible points, and which nets gave it.
fn indirect(
    field: &Field,
    seen: &Visible,
    lights: &Lights,
    options: &RenderOptions,
    weight: f32,
    layers: &mut Layers,
) -> Result<(), RenderError> {
    let points: Vec<Light> = lights
        .points
        .iter()
        .map(|light| Light {
            position: light.position.to_array(),
            intensity: light.intensity.to_array(),
        })
        .collect();
    let (mut radiance, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
    field.evaluate_lights(&seen.rows, &points, &mut radiance, &mut cells)?;
    let [r, g, b] = &radiance;
    let rgb = r.iter().zip(g).zip(b);
    let rgb = rgb.map(|((&r, &g), &b)| Vec3::new(r, g, b));
    seen.gather(rgb, weight, &mut layers.indirect);
    if options.negative == Negative::Zero {
        for pixel in &mut layers.indirect {
            *pixel = pixel.max(Vec3::ZERO);
        }
    }
    for (&pixel, &cell) in seen.pixel.iter().zip(&cells).rev() {
        layers.cell[pixel as usize] = cell; // of the pixel's first ray that hit
    }
    if let Some(trusted) = options.trusted {
        let trust = trusted_under_all(trusted, &seen.rows, &points);
        for (&pixel, trust) in seen.pixel.iter().zip(trust) {
            layers.trust[pixel as usize] += if trust { weight } else { 0.0 };
        }
    }
    Ok(())
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
