//! A tile of the image: its camera rays and what they meet, as columns.

use crate::view::View;
use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_scene::INVALID;
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

/// Pixels a side of a tile: its rows and what is computed from them stay in a core's cache.
pub const SIDE: u32 = 32;

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
    /// The tiles of a picture, row by row.
    pub fn all(width: u32, height: u32) -> Vec<Tile> {
        let starts = |size: u32| (0..size).step_by(SIDE as usize);
        let tile = |x: u32, y: u32| Tile {
            x,
            y,
            width: SIDE.min(width - x),
            height: SIDE.min(height - y),
        };
        starts(height)
            .flat_map(|y| starts(width).map(move |x| tile(x, y)))
            .collect()
    }

    /// How many pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The tile's pixel ids in the picture `width` pixels wide, row by row.
    pub fn ids(self, width: u32) -> impl Iterator<Item = usize> {
        let row = move |y: u32| (self.x..self.x + self.width).map(move |x| (x, y));
        (self.y..self.y + self.height)
            .flat_map(row)
            .map(move |(x, y)| y as usize * width as usize + x as usize)
    }
}

/// The surface points that a tile's camera rays meet; rays that miss have no row.
#[derive(Clone, Debug, Default)]
pub struct Visible {
    /// Raw columns, the light's left at zero.
    pub rows: Columns,
    /// Surface point of each row.
    pub points: Vec<SurfacePoint>,
    /// Pixel of each row, counted within the tile.
    pub pixel: Vec<u32>,
}

impl Visible {
    /// Shoots `aa` x `aa` rays a pixel through the centres of its sub-squares.
    pub fn shoot(tracer: &Tracer, view: &View, tile: Tile, aa: u32) -> Visible {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        for pixel in 0..tile.pixels() as u32 {
            let (x, y) = (tile.x + pixel % tile.width, tile.y + pixel / tile.width);
            for sub in 0..aa * aa {
                let offset = |i: u32| (i as f32 + 0.5) / aa as f32;
                let (x, y) = (x as f32 + offset(sub % aa), y as f32 + offset(sub / aa));
                rays.push(view.eye, view.direction(x, y), f32::INFINITY);
            }
        }
        tracer.closest(&rays, &mut hits);
        let mut seen = Visible::default();
        for (ray, &triangle) in hits.triangle.iter().enumerate() {
            if triangle == INVALID {
                continue;
            }
            let point = tracer.point(triangle, hits.barycentrics[ray]);
            seen.rows.push(raw(tracer, &point, -rays.direction[ray]));
            seen.points.push(point);
            seen.pixel.push(ray as u32 / (aa * aa));
        }
        seen
    }

    /// Unit direction to the viewer of a row.
    pub fn viewer(&self, row: usize) -> Vec3 {
        self.rows.vec3(columns::V, row).into()
    }

    /// Adds each row's value, times `weight`, to its pixel.
    pub fn gather(&self, values: impl Iterator<Item = Vec3>, weight: f32, pixels: &mut [Vec3]) {
        for (&pixel, value) in self.pixel.iter().zip(values) {
            pixels[pixel as usize] += weight * value;
        }
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
