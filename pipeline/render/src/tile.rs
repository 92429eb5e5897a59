//! A tile of the image: its camera rays and what they meet, as columns.

use crate::view::View;
use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_scene::INVALID;
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

/// Size of a tile in pixels: its rows and what is computed from them stay in a core's cache,
/// and its cells have rows enough to fill blocks.
pub const WIDTH: u32 = 64;
/// Height of a tile.
pub const HEIGHT: u32 = 16;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Tile {
    /// The tiles of band `band`, [`HEIGHT`] rows of a picture, from left to right.
    pub fn of_band(width: u32, height: u32, band: u32) -> impl Iterator<Item = Tile> {
        let y = band * HEIGHT;
        (0..width).step_by(WIDTH as usize).map(move |x| Tile {
            x,
            y,
            width: WIDTH.min(width - x),
            height: HEIGHT.min(height - y),
        })
    }

    /// How many pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Place of pixel `pixel` of the tile in its band of a picture `width` pixels wide.
    #[inline(always)]
    pub fn in_band(self, pixel: u32, width: u32) -> usize {
        let (row, column) = (pixel / self.width, pixel % self.width);
        row as usize * width as usize + (self.x + column) as usize
    }
}

/// The surface points that a tile's camera rays meet; rays that miss have no row.
/// Made once a thread and used for tile after tile.
#[derive(Clone, Debug, Default)]
pub struct Visible {
    /// Raw columns, the light's left at zero.
    pub rows: Columns,
    /// Surface point of each row.
    pub points: Vec<SurfacePoint>,
    /// Pixel of each row, counted within the tile.
    pub pixel: Vec<u32>,
    rays: Rays,
    hits: Hits,
}

impl Visible {
    /// Shoots `aa` x `aa` rays a pixel through the centres of its sub-squares.
    pub fn shoot(&mut self, tracer: &Tracer, view: &View, tile: Tile, aa: u32) {
        let lens = view.lens();
        let step = 1.0 / aa as f32;
        self.rays.clear();
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                for sub in 0..aa * aa {
                    let offset = |i: u32| (i as f32 + 0.5) * step;
                    let (x, y) = (x as f32 + offset(sub % aa), y as f32 + offset(sub / aa));
                    let direction = lens.direction(x, y);
                    self.rays.push(view.eye, direction, f32::INFINITY);
                }
            }
        }
        tracer.closest(&self.rays, &mut self.hits);
        self.read_hits(tracer, aa);
    }

    /// The rows of the hits.
    fn read_hits(&mut self, tracer: &Tracer, aa: u32) {
        let found = self.hits.triangle.iter().filter(|&&t| t != INVALID);
        let count = found.count();
        for column in &mut self.rows.columns {
            column.clear();
            column.resize(count, 0.0);
        }
        self.points.clear();
        self.pixel.clear();
        let directions = self.rays.direction.iter();
        let hits = self.hits.triangle.iter().zip(&self.hits.barycentrics);
        for (ray, ((&triangle, &barycentrics), &direction)) in (0u32..).zip(hits.zip(directions)) {
            if triangle == INVALID {
                continue;
            }
            let row = self.points.len();
            let point = tracer.point(triangle, barycentrics);
            let raw = raw(tracer, &point, -direction);
            for (column, x) in self.rows.columns.iter_mut().zip(raw) {
                column[row] = x;
            }
            self.points.push(point);
            self.pixel.push(ray / (aa * aa));
        }
    }

    /// Unit direction to the viewer of a row.
    pub fn viewer(&self, row: usize) -> Vec3 {
        self.rows.vec3(columns::V, row).into()
    }
}

/// The raw columns at a surface point seen from direction `v`, as extraction stores them:
/// the shading normal on the viewer's side, the material with its textures looked up.
pub fn raw(tracer: &Tracer, point: &SurfacePoint, v: Vec3) -> [f32; columns::COUNT] {
    let mut raw = [0.0; columns::COUNT];
    let material = tracer.material_at(point);
    let mut put = |first: usize, value: Vec3| {
        raw[first..first + 3].copy_from_slice(&value.to_array());
    };
    put(columns::P, point.position);
    put(columns::N, tracer.normal_at(point, v));
    put(columns::V, v);
    put(columns::BASE, material.base_color);
    raw[columns::ROUGHNESS] = material.roughness;
    raw[columns::METALLIC] = material.metallic;
    raw[columns::SPECULAR] = material.specular;
    raw
}
