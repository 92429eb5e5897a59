//! Scenes, and the points and lights that errors are measured at.

use glam::Vec3;
use rayon::prelude::*;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, LoadOptions, Scene, SkyOption, SkySource, load};
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};
use rrf_transfer::{PointSource, RowPoint};

/// What is measured on.
pub struct Setup {
    pub scene: Scene,
    /// Where lights are, and where eyes are.
    pub lights: [Vec3; 2],
    pub eyes: [Vec3; 2],
    /// Lights are at least this far from surfaces, metres.
    pub clearance: f32,
    /// Points are what eyes see; else uniform by area.
    pub seen: bool,
}

impl Setup {
    /// `salon PATH`, `overhead`, `free` or `free15` (at least 0.15 m from surfaces).
    pub fn new(name: &str, path: Option<&str>) -> Setup {
        let scene = load_whole(path, None).unlit();
        let b = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        let (lights, eyes, clearance, seen) = match name {
            "salon" => {
                let eyes = [b(-2.3, 0.3, -1.8), b(2.3, 2.3, 1.9)];
                ([b(-2.4, 0.2, -1.9), b(2.4, 2.5, 1.9)], eyes, 0.15, true)
            }
            "overhead" => {
                let eyes = [b(-0.95, 0.05, -0.95), b(0.95, 1.95, 0.95)];
                ([b(-0.6, 1.3, -0.6), b(0.6, 1.8, 0.6)], eyes, 0.0, false)
            }
            free => {
                let eyes = [b(-0.95, 0.05, -0.95), b(0.95, 1.95, 0.95)];
                let clearance = if free == "free15" { 0.15 } else { 0.0 };
                (
                    [b(-0.8, 0.2, -0.8), b(0.8, 1.8, 0.8)],
                    eyes,
                    clearance,
                    false,
                )
            }
        };
        Setup {
            scene,
            lights,
            eyes,
            clearance,
            seen,
        }
    }
}

/// The scene with its own lights, under a sky if one is given.
pub fn load_whole(path: Option<&str>, sky: Option<&str>) -> Scene {
    let cornell = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    );
    let options = LoadOptions {
        sky: sky.map(|file| SkyOption {
            source: SkySource::Picture(file.into()),
            rotate: 0.0,
        }),
        ..LoadOptions::default()
    };
    load(path.unwrap_or(cornell).as_ref(), &options).expect("a scene file")
}

/// Draws points and lights.
pub struct Places<'a> {
    setup: &'a Setup,
    tracer: &'a Tracer<'a>,
    /// Free places in the box of eyes.
    free: Vec<Vec3>,
}

impl<'a> Places<'a> {
    pub fn new(setup: &'a Setup, tracer: &'a Tracer<'a>) -> Places<'a> {
        let first = setup.scene.cameras.first().map_or(Vec3::Y, |c| c.eye);
        let middle = (setup.eyes[0] + setup.eyes[1]) * 0.5;
        let start = if setup.seen {
            first
        } else {
            middle + 0.4 * Vec3::Z + 0.5 * Vec3::Y
        };
        let mut places = Places {
            setup,
            tracer,
            free: vec![start],
        };
        let stream = Stream::new(17, Stage::Test, 900);
        for i in 0..20_000 {
            let at = within(setup.eyes, stream, i);
            if places.is_free(at) && places.free.len() < 96 {
                places.free.push(at);
            }
        }
        places
    }

    /// Whether a place is seen from one that is free.
    pub fn is_free(&self, place: Vec3) -> bool {
        let mut rays = Rays::default();
        for &from in &self.free {
            rays.push(from, place - from, 1.0);
        }
        let mut blocked = Vec::new();
        self.tracer.occluded(&rays, &mut blocked);
        blocked.contains(&false)
    }

    /// Lights in free space.
    pub fn lights(&self, count: usize, seed: u64) -> Vec<Vec3> {
        let stream = Stream::new(seed, Stage::Test, 901);
        let near = |at: Vec3| self.tracer.distance(at, self.setup.clearance).is_some();
        (0u64..)
            .map(|i| within(self.setup.lights, stream, i))
            .filter(|&at| self.is_free(at) && !(self.setup.clearance > 0.0 && near(at)))
            .take(count)
            .collect()
    }

    /// Surface points and viewers.
    pub fn points(&self, count: usize, seed: u64) -> Vec<RowPoint> {
        let stream = Stream::new(seed, Stage::Test, 902);
        (0u64..)
            .filter_map(|i| self.point(stream, i))
            .take(count)
            .collect()
    }

    /// Those of `count` candidates that are surface points, found by all threads.
    pub fn candidates(&self, count: usize, seed: u64) -> Vec<RowPoint> {
        let stream = Stream::new(seed, Stage::Test, 902);
        (0..count as u64)
            .into_par_iter()
            .filter_map(|i| self.point(stream, i))
            .collect()
    }

    fn point(&self, stream: Stream, i: u64) -> Option<RowPoint> {
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let row = if self.setup.seen {
            let eye = self.free[(u[0] * self.free.len() as f32) as usize];
            let direction = sphere(u[1], u[2]);
            let mut rays = Rays::default();
            rays.push(eye, direction, f32::INFINITY);
            let mut hits = Hits::default();
            self.tracer.closest(&rays, &mut hits);
            (hits.triangle[0] != INVALID).then(|| RowPoint {
                point: self.tracer.point(hits.triangle[0], hits.barycentrics[0]),
                viewer: -direction,
            })?
        } else {
            let point = self.tracer.sample_area([u[0], u[1], u[2]]);
            let side = if w[0] < 0.5 {
                point.normal
            } else {
                -point.normal
            };
            let out = sphere(w[1], w[2]);
            let viewer = if out.dot(side) < 0.0 { -out } else { out };
            self.looks_inside(&point, side)
                .then_some(RowPoint { point, viewer })?
        };
        let material = self.tracer.material_at(&row.point);
        let dull = material.roughness >= 0.15 && material.base_color.max_element() > 1e-3;
        (dull && row.point.normal.dot(row.viewer).abs() > 0.02).then_some(row)
    }

    /// Whether a side of a point sees a free place.
    fn looks_inside(&self, point: &SurfacePoint, side: Vec3) -> bool {
        let mut rays = Rays::default();
        for &place in &self.free {
            if (place - point.position).dot(side) > 0.0 {
                let origin = self.tracer.lift(point.triangle, point.position, side);
                rays.push(origin, place - origin, 1.0);
            }
        }
        let mut blocked = Vec::new();
        self.tracer.occluded(&rays, &mut blocked);
        blocked.contains(&false)
    }
}

/// A point light of 1 W/sr a channel.
pub fn one_watt(position: Vec3) -> PointSource {
    PointSource {
        position,
        intensity: Vec3::ONE,
    }
}

fn within([low, high]: [Vec3; 2], stream: Stream, i: u64) -> Vec3 {
    let u = stream.units(i, 0, 0);
    low + (high - low) * Vec3::new(u[0], u[1], u[2])
}

fn sphere(a: f32, b: f32) -> Vec3 {
    let z = 1.0 - 2.0 * a;
    let (s, c) = (std::f32::consts::TAU * b).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * c, r * s, z)
}
