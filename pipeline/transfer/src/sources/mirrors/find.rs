//! Which surfaces of a scene are flat mirrors.

use super::plane::Mirror;
use super::{FlatMirrors, SURROUNDING};
use crate::sources::numbers::Numbers;
use crate::tracing::{Stream, Tracer};
use rrf_sampling::Stage;
use rrf_scene::{INVALID, Scene};

/// Perceptual roughness up to which a metal is a mirror.
const SMOOTH: f32 = 0.02;
/// Share of the scene's area from which on a flat piece counts; smaller ones are parts of something
/// bent.
const LEAST_AREA: f32 = 1e-3;
/// Mirrors at the most, the largest ones.
const MOST: usize = 8;
/// Distance from the plane, relative to the scene's size, below which a point lies on it.
const CLEAR: f32 = 2e-4;

impl<'a> FlatMirrors<'a> {
    /// Finds them: smooth metals without a normal map whose triangles lie in one plane.
    pub fn new(tracer: &'a Tracer<'a>) -> FlatMirrors<'a> {
        let scene: &Scene = tracer.scene();
        let size = (scene.positions.iter()).fold(0.0f32, |m, p| m.max(p.abs().max_element()));
        let clear = CLEAR * size;
        let mut mirrors: Vec<(u32, Mirror)> = Vec::new();
        for (id, &material) in (0u32..).zip(&scene.triangle_material) {
            let m = &scene.materials[material as usize];
            let even = m.normal_texture == INVALID && m.roughness_metallic_texture == INVALID;
            if !even || m.roughness > SMOOTH || m.metallic < 0.9 {
                continue;
            }
            let point = tracer.point(id, [1.0 / 3.0; 2]);
            let [a, b, c] = scene.triangles[id as usize].map(|v| scene.positions[v as usize]);
            let area = 0.5 * (b - a).cross(c - a).length();
            let bent = tracer.normal_at(&point, point.normal).dot(point.normal) < 0.9999;
            if area <= 0.0 || bent {
                continue;
            }
            let (normal, offset) = (point.normal, point.normal.dot(point.position));
            let same = |m: &(u32, Mirror)| {
                m.0 == material
                    && m.1.normal.dot(normal) > 0.9999
                    && (m.1.offset - offset).abs() < clear
            };
            match mirrors.iter_mut().find(|m| same(m)) {
                Some((_, mirror)) => {
                    mirror.triangles.push(id);
                    mirror.area += area;
                }
                None => mirrors.push((material, Mirror::new(normal, offset, id, area))),
            }
        }
        let mut mirrors: Vec<Mirror> = mirrors.into_iter().map(|m| m.1).collect();
        mirrors.retain(|m| m.area >= LEAST_AREA * tracer.area() as f32);
        mirrors.sort_by(|a, b| b.area.total_cmp(&a.area));
        mirrors.truncate(MOST);
        mirrors.iter_mut().for_each(|m| m.bound(scene));
        FlatMirrors {
            tracer,
            mirrors,
            clear,
            numbers: Numbers::new(Stream::new(1, Stage::Transfer, 3), SURROUNDING),
        }
    }
}
