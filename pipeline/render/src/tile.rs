//! A tile of the image: its camera rays and what they meet, as columns.

use crate::follow::{Carried, Lit};
use crate::view::View;
use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_materials::{BROAD_ROUGHNESS, Bsdf};
use rrf_scene::INVALID;
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

/// Size of a tile in pixels: its rows and what is computed from them stay in a core's cache,
/// and its cells have rows enough to fill blocks.
pub const WIDTH: u32 = 64;
/// Height of a tile.
pub const HEIGHT: u32 = 32;

/// Place of camera rays in pixels from the centre of their square (of a sub-square, if a
/// pixel has several). Not quite through it: symmetric scenes put edges exactly there, and a
/// point on an edge of two walls sees past both of them.
pub const OFF_CENTRE: [f32; 2] = [1.0 / 256.0, 1.0 / 384.0];

/// Points that stand for a view, across its longer side.
const SOME: u32 = 48;

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
}

/// The surface points that a tile's camera rays, or the rays that go on from there, meet; rays that
/// miss have no row.
/// Made once a thread and used for tile after tile.
#[derive(Clone, Debug, Default)]
pub struct VisiblePoints {
    /// Raw columns, the light's left at zero.
    pub rows: Columns,
    /// Surface point of each row.
    pub points: Vec<SurfacePoint>,
    /// Unit shading normal of each row, on the viewer's side.
    pub normals: Vec<Vec3>,
    /// Unit direction to the viewer of each row.
    pub viewers: Vec<Vec3>,
    /// Material of each row, textures looked up.
    pub materials: Vec<Bsdf>,
    /// Pixel of each row, counted over the tile's band of the picture.
    pub pixel: Vec<u32>,
    /// What the ray of each row carries; empty for camera rays where nothing is followed.
    pub carried: Vec<Carried>,
    /// Pixel and direction of each camera ray that met nothing.
    pub missed: Vec<(u32, Vec3)>,
    rays: Rays,
    ray_pixel: Vec<u32>,
    hits: Hits,
}

impl VisiblePoints {
    /// The points that `aa` x `aa` rays a pixel meet along one row of pixels.
    pub fn of_row(tracer: &Tracer, view: &View, y: u32, aa: u32) -> VisiblePoints {
        let tile = Tile {
            x: 0,
            y,
            width: view.width,
            height: 1,
        };
        let mut seen = VisiblePoints::default();
        seen.shoot(tracer, view, tile, aa);
        seen.read_hits(tracer, false);
        seen
    }

    /// Some of the points that a view shows, spread evenly, and unit directions to their viewers.
    pub fn some_of(tracer: &Tracer, view: &View) -> (Vec<SurfacePoint>, Vec<Vec3>) {
        let longer = view.width.max(view.height).max(1);
        let scale = f64::from(longer.min(SOME)) / f64::from(longer);
        let side = |pixels: u32| ((f64::from(pixels) * scale) as u32).max(1);
        let small = View {
            width: side(view.width),
            height: side(view.height),
            ..view.clone()
        };
        let rows = (0..small.height).map(|y| VisiblePoints::of_row(tracer, &small, y, 1));
        let (mut points, mut viewers) = (Vec::new(), Vec::new());
        for row in rows {
            points.extend(row.points);
            viewers.extend(row.viewers);
        }
        (points, viewers)
    }

    /// Shoots `aa` x `aa` rays a pixel, one through each of its sub-squares.
    pub fn shoot(&mut self, tracer: &Tracer, view: &View, tile: Tile, aa: u32) {
        self.aim(view, tile, aa);
        tracer.closest(&self.rays, &mut self.hits);
    }

    /// The camera rays.
    fn aim(&mut self, view: &View, tile: Tile, aa: u32) {
        let lens = view.lens();
        let step = 1.0 / aa as f32;
        self.rays.clear();
        self.ray_pixel.clear();
        for row in 0..tile.height {
            for x in tile.x..tile.x + tile.width {
                let (across, down) = (x as f32, (tile.y + row) as f32);
                for sub in 0..aa * aa {
                    let across = across + ((sub % aa) as f32 + 0.5) * step + OFF_CENTRE[0];
                    let down = down + ((sub / aa) as f32 + 0.5) * step + OFF_CENTRE[1];
                    let direction = lens.direction(across, down);
                    self.rays.push(view.eye, direction, f32::INFINITY);
                    self.ray_pixel.push(row * view.width + x);
                }
            }
        }
    }

    /// The rows of what the camera rays met. Rays `go_on` from them if anything is followed.
    pub fn read_hits(&mut self, tracer: &Tracer, go_on: bool) {
        self.clear();
        let (rays, ray_pixel) = (
            std::mem::take(&mut self.rays),
            std::mem::take(&mut self.ray_pixel),
        );
        let hits = std::mem::take(&mut self.hits);
        let met = hits.triangle.iter().zip(&hits.barycentrics);
        for ((&direction, &pixel), (&triangle, &at)) in
            rays.direction.iter().zip(&ray_pixel).zip(met)
        {
            match triangle {
                INVALID => self.missed.push((pixel, direction)),
                _ => self.push(tracer, (triangle, at), direction, pixel),
            }
        }
        (self.rays, self.ray_pixel, self.hits) = (rays, ray_pixel, hits);
        if go_on {
            let carried = self.pixel.iter().map(|&pixel| Carried::camera(pixel));
            self.carried.extend(carried);
        }
        self.fill_columns();
    }

    /// The rows of the surfaces that followed rays met and that are to be shaded.
    pub fn read_followed(
        &mut self,
        tracer: &Tracer,
        (rays, carried): (&Rays, &[Carried]),
        hits: &Hits,
    ) {
        self.clear();
        let met = hits.triangle.iter().zip(&hits.barycentrics);
        let rays = rays.direction.iter().zip(carried).zip(&hits.t);
        for (((&direction, &carried), &distance), (&triangle, &at)) in rays.zip(met) {
            if triangle != INVALID && carried.surface && carried.is_meant_for(distance) {
                self.push(tracer, (triangle, at), direction, carried.pixel);
                self.carried.push(Carried {
                    throughput: carried.throughput * self.left_after(distance),
                    guide: carried.guide * distance * distance,
                    length: distance,
                    ..carried
                });
            }
        }
        self.fill_columns();
    }

    /// Rows of given points, seen from given directions; each counts as a pixel.
    pub fn read_points(&mut self, tracer: &Tracer, points: &[SurfacePoint], viewers: &[Vec3]) {
        self.clear();
        for ((pixel, point), &viewer) in (0..).zip(points).zip(viewers) {
            let at = (point.triangle, point.barycentrics);
            self.push(tracer, at, -viewer, pixel);
            self.carried.push(Carried::camera(pixel));
        }
        self.fill_columns();
    }

    fn clear(&mut self) {
        self.points.clear();
        self.normals.clear();
        self.viewers.clear();
        self.materials.clear();
        self.pixel.clear();
        self.carried.clear();
        self.missed.clear();
    }

    fn push(
        &mut self,
        tracer: &Tracer,
        (triangle, barycentrics): (u32, [f32; 2]),
        direction: Vec3,
        pixel: u32,
    ) {
        let point = tracer.point(triangle, barycentrics);
        let (normal, material) = tracer.shading_at(&point, -direction);
        self.points.push(point);
        self.normals.push(normal);
        self.viewers.push(-direction);
        self.materials.push(material);
        self.pixel.push(pixel);
    }

    /// Material of a row as lights that shine on it find it.
    pub fn under_lights(&self, row: usize) -> Bsdf {
        let material = self.materials[row];
        match self.lit(row) {
            Lit::Whole => material,
            Lit::Widened => Bsdf {
                roughness: material.roughness.max(BROAD_ROUGHNESS),
                ..material
            },
            Lit::Even | Lit::Not => Bsdf::BLACK,
        }
    }

    /// Whether lights are asked for at a row.
    pub fn is_asked(&self, row: usize) -> bool {
        matches!(self.lit(row), Lit::Whole | Lit::Widened)
    }

    /// Whether a row was met by a ray that gathers light, one of many.
    pub fn is_gathered(&self, row: usize) -> bool {
        self.lit(row) != Lit::Whole
    }

    fn lit(&self, row: usize) -> Lit {
        let carried = self.carried.get(row);
        carried.map_or(Lit::Whole, |carried| carried.lit)
    }

    /// Share of light that is left after a distance up to the last row's surface, if that encloses
    /// glass which absorbs.
    fn left_after(&self, distance: f32) -> Vec3 {
        let material = self.materials.last().filter(|material| material.inside);
        match material.and_then(Bsdf::interior) {
            Some(absorption) if absorption != Vec3::ZERO => (absorption * -distance).exp(),
            _ => Vec3::ONE,
        }
    }

    /// Unit geometric normal of a row on the viewer's side.
    pub fn side(&self, row: usize) -> Vec3 {
        let normal = self.points[row].normal;
        match normal.dot(self.viewers[row]) < 0.0 {
            true => -normal,
            false => normal,
        }
    }

    /// The raw columns, from the rows.
    fn fill_columns(&mut self) {
        let columns = &mut self.rows.columns;
        for axis in 0..3 {
            let of = |v: Vec3| v.to_array()[axis];
            let points = self.points.iter().map(|p| of(p.position));
            refill(&mut columns[columns::P + axis], points);
            let normals = self.normals.iter().map(|&n| of(n));
            refill(&mut columns[columns::N + axis], normals);
            let viewers = self.viewers.iter().map(|&v| of(v));
            refill(&mut columns[columns::V + axis], viewers);
            let bases = self.materials.iter().map(|m| of(m.base_color));
            refill(&mut columns[columns::BASE + axis], bases);
            let dark = std::iter::repeat_n(0.0, self.points.len());
            refill(&mut columns[columns::L + axis], dark);
        }
        let materials = self.materials.iter();
        refill(
            &mut columns[columns::ROUGHNESS],
            materials.map(|m| m.roughness),
        );
        let materials = self.materials.iter();
        refill(
            &mut columns[columns::METALLIC],
            materials.map(|m| m.metallic),
        );
        let materials = self.materials.iter();
        refill(
            &mut columns[columns::SPECULAR],
            materials.map(|m| m.specular),
        );
    }
}

/// Replaces what a column holds.
fn refill(column: &mut Vec<f32>, values: impl Iterator<Item = f32>) {
    column.clear();
    column.extend(values);
}

/// The raw columns at a surface point seen from direction `v`, as extraction stores them:
/// the shading normal on the viewer's side, the material with its textures looked up.
pub fn raw(tracer: &Tracer, point: &SurfacePoint, v: Vec3) -> [f32; columns::COUNT] {
    let mut raw = [0.0; columns::COUNT];
    let (normal, material) = tracer.shading_at(point, v);
    let mut put = |first: usize, value: Vec3| {
        raw[first..first + 3].copy_from_slice(&value.to_array());
    };
    put(columns::P, point.position);
    put(columns::N, normal);
    put(columns::V, v);
    raw[columns::BASE..=columns::SPECULAR].copy_from_slice(&material.columns());
    raw
}
