//! Which surfaces of a scene are mirrors.

use super::ball::{Ball, MOST_BALLS};
use super::image::Mirror;
use super::shown::{Frames, MOST};
use super::{Mirrors, NO_MIRROR};
use crate::facets::Facet;
use glam::{Vec2, Vec3};
use rrf_materials::{Bsdf, INVALID, Lobe};
use rrf_scene::Scene;
use std::collections::BTreeMap;
use std::f32::consts::PI;

/// Peak of the lobe at normal incidence [1/sr] from which on a surface counts as a mirror:
/// three times that of a white diffuse one.
const STRENGTH: f32 = 1.0;
/// Mirrors are at least this share of the scene's area: smaller ones are parts of something bent.
const LEAST_AREA: f64 = 1e-3;
/// Share of a scene's area that a polished ball has at least.
const LEAST_BALL: f64 = 1e-4;
/// Grid on which planes count as one, relative to the scene's size.
const GRID: f64 = 1e-5;

impl Mirrors {
    /// Finds the mirrors of a checked scene.
    pub(crate) fn new(scene: &Scene, facets: &[Facet], areas: &[f64]) -> Mirrors {
        let mut found: BTreeMap<[i64; 5], Vec<usize>> = BTreeMap::new();
        let largest = scene.positions.iter().map(|p| p.abs().max_element());
        let size = f64::from(largest.fold(f32::MIN_POSITIVE, f32::max));
        for (id, facet) in facets.iter().enumerate() {
            if areas[id] > 0.0 && strength(scene, id, facet).is_some() {
                found.entry(plane_key(facet, size)).or_default().push(id);
            }
        }
        let total: f64 = areas.iter().sum();
        let area = |ids: &[usize]| ids.iter().map(|&id| areas[id]).sum::<f64>();
        let mut groups: Vec<(f64, Vec<usize>)> = (found.into_values())
            .map(|ids| (area(&ids), ids))
            .filter(|(area, _)| *area >= LEAST_AREA * total)
            .collect();
        groups.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        groups.truncate(MOST);
        let mut mirrors = Mirrors::default();
        if !groups.is_empty() {
            mirrors.of_triangle = vec![NO_MIRROR; facets.len()];
        }
        for (number, (_, ids)) in groups.iter().enumerate() {
            mirrors.mirrors.extend(Mirror::over(scene, facets, ids));
            for &id in ids {
                mirrors.of_triangle[id] = number as u8;
            }
        }
        mirrors.frames = Frames::new(&mirrors.mirrors);
        mirrors.find_balls(scene, facets, areas);
        mirrors
    }
}

impl Mirrors {
    /// Finds the polished balls of a checked scene: objects of one material with a narrow lobe, whose
    /// corners and normals are a sphere's.
    fn find_balls(&mut self, scene: &Scene, facets: &[Facet], areas: &[f64]) {
        let mut groups: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for (id, facet) in facets.iter().enumerate() {
            let object = scene.triangle_object.get(id).copied().unwrap_or(0);
            if areas[id] > 0.0 && even_lobe(scene, facet).is_some() {
                groups.entry([object, facet.material]).or_default().push(id);
            }
        }
        let total: f64 = areas.iter().sum();
        let mut found: Vec<(f64, Ball, Vec<usize>)> = Vec::new();
        for ids in groups.into_values() {
            let area: f64 = ids.iter().map(|&id| areas[id]).sum();
            if area >= LEAST_BALL * total {
                let lobe = ids.first().and_then(|&id| even_lobe(scene, &facets[id]));
                let ball = lobe.and_then(|lobe| Ball::over(scene, facets, &ids, lobe));
                found.extend(ball.map(|ball| (area, ball, ids)));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        found.truncate(MOST_BALLS);
        for (_, ball, ids) in found {
            self.of_triangle.resize(facets.len(), NO_MIRROR);
            for id in ids {
                self.of_triangle[id] = (MOST + self.balls.len()) as u8;
            }
            self.balls.push(ball);
        }
    }
}

impl Mirror {
    fn over(scene: &Scene, facets: &[Facet], ids: &[usize]) -> Option<Mirror> {
        let facet = &facets[*ids.first()?];
        let Lobe { alpha, reflectance } = strength(scene, *ids.first()?, facet)?;
        let [e1, e2] = facet.edges;
        let longest = if e1.length_squared() > e2.length_squared() {
            e1
        } else {
            e2
        };
        let first = longest.normalize();
        let mut mirror = Mirror {
            normal: facet.normal,
            offset: facet.normal.dot(facet.corner),
            axes: [first, facet.normal.cross(first)],
            low: Vec2::INFINITY,
            high: Vec2::NEG_INFINITY,
            alpha,
            reflectance,
        };
        for &id in ids {
            let Facet { corner, edges, .. } = facets[id];
            for at in [corner, corner + edges[0], corner + edges[1]] {
                let at = mirror.coordinates(at);
                (mirror.low, mirror.high) = (mirror.low.min(at), mirror.high.max(at));
            }
        }
        Some(mirror)
    }
}

/// Whether the shading normals of a triangle leave it as flat as a lobe is narrow.
fn is_flat(scene: &Scene, id: usize, normal: Vec3, alpha: f32) -> bool {
    let bent = |n: Vec3| n.normalize_or_zero().cross(normal).length() > 0.1 * alpha;
    !scene.triangles[id]
        .iter()
        .any(|&v| bent(scene.normals[v as usize]))
}

/// The lobe of a triangle that may be part of a flat mirror.
fn strength(scene: &Scene, id: usize, facet: &Facet) -> Option<Lobe> {
    let lobe = even_lobe(scene, facet)?;
    is_flat(scene, id, facet.normal, lobe.alpha).then_some(lobe)
}

/// The lobe of a triangle, if it is narrow and the same all over.
fn even_lobe(scene: &Scene, facet: &Facet) -> Option<Lobe> {
    let material = &scene.materials[facet.material as usize];
    let lobe = (material.kind.lobe)(&Bsdf::of(material))?;
    let even = material.roughness_metallic_texture == INVALID && material.normal_texture == INVALID;
    let peak = lobe.reflectance / (4.0 * PI * lobe.alpha * lobe.alpha);
    (even && peak >= STRENGTH).then_some(lobe)
}

/// Material and plane, rounded, the same from both sides.
fn plane_key(facet: &Facet, size: f64) -> [i64; 5] {
    let normal = facet.normal.as_dvec3();
    let largest = [normal.x, normal.y, normal.z]
        .into_iter()
        .fold(0.0f64, |a, b| if b.abs() > a.abs() { b } else { a });
    let normal = normal * largest.signum();
    let offset = normal.dot(facet.corner.as_dvec3()) / size;
    let [x, y, z, w] = [normal.x, normal.y, normal.z, offset].map(|v| (v / GRID).round() as i64);
    [i64::from(facet.material), x, y, z, w]
}
