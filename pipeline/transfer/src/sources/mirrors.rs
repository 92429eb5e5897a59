//! What flat mirrors throw straight on a surface: the image of a light of any kind.
//!
//! A point x behind a mirror's plane at its own image x' sees the light as x sees it in the mirror.
//! So a light's arrivals at x', folded back, are those by way of the mirror: exact for every kind
//! of light, and paths need not find a lobe that is narrower than any patch's directions.

use crate::lights::{DirectLight, IncidentLight, Leg, Receiver, ReceiverId};
use crate::rows::RowPoint;
use crate::tracing::{Rays, Tracer};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
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

/// The flat mirrors of a scene.
pub struct FlatMirrors<'a> {
    tracer: &'a Tracer<'a>,
    mirrors: Vec<Mirror>,
    /// Metres.
    clear: f32,
}

/// Triangles of one plane and material.
struct Mirror {
    normal: Vec3,
    offset: f32,
    triangles: Vec<u32>,
    area: f32,
}

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
                None => mirrors.push((
                    material,
                    Mirror {
                        normal,
                        offset,
                        triangles: vec![id],
                        area,
                    },
                )),
            }
        }
        let mut mirrors: Vec<Mirror> = mirrors.into_iter().map(|m| m.1).collect();
        mirrors.retain(|m| m.area >= LEAST_AREA * tracer.area() as f32);
        mirrors.sort_by(|a, b| b.area.total_cmp(&a.area));
        mirrors.truncate(MOST);
        FlatMirrors {
            tracer,
            mirrors,
            clear,
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.mirrors.is_empty()
    }

    /// A light, and its images in the mirrors. Mirrors themselves receive nothing: what they show
    /// is the image.
    pub fn of<'m, L: DirectLight>(&'m self, light: L) -> Mirrored<'m, L> {
        Mirrored {
            mirrors: self,
            light,
        }
    }

    fn is_on_mirror(&self, at: &Receiver) -> bool {
        self.mirrors.iter().any(|m| {
            m.height(at.position).abs() < 0.5 * self.clear
                && m.normal.dot(at.geometric).abs() > 0.9999
        })
    }

    /// Arrivals by way of the mirrors alone.
    pub fn images(
        &self,
        light: &dyn DirectLight,
        at: &Receiver,
        id: ReceiverId,
        arrive: &mut dyn FnMut(IncidentLight),
    ) {
        for mirror in &self.mirrors {
            let height = mirror.height(at.position);
            if height.abs() < self.clear {
                continue;
            }
            let fold = |v: Vec3| v - 2.0 * mirror.normal.dot(v) * mirror.normal;
            let image = Receiver {
                position: at.position - 2.0 * height * mirror.normal,
                geometric: fold(at.geometric),
                shading: fold(at.shading),
            };
            light.arrivals(&image, id, &mut |incident| {
                let direction = fold(incident.direction);
                let way = -height / mirror.normal.dot(direction);
                // from the front, and the light farther than the mirror
                let rest = incident.distance - way;
                let valid = way > 0.0 && way.is_finite() && rest > 0.0;
                if !valid || at.geometric.dot(direction) <= 0.0 {
                    return;
                }
                let place = at.position + direction * way;
                let Some(reflectance) = self.reflectance(mirror, place, direction) else {
                    return;
                };
                let off = mirror.normal * (0.25 * self.clear * height.signum());
                arrive(IncidentLight {
                    direction,
                    distance: way - 0.25 * self.clear,
                    normal_irradiance: incident.normal_irradiance * reflectance,
                    beyond: Some(Leg {
                        origin: place + off,
                        direction: incident.direction,
                        distance: rest,
                    }),
                });
            });
        }
    }

    /// What the mirror leaves of light at a place of its plane (Schlick 1994); `None` beside it.
    fn reflectance(&self, mirror: &Mirror, place: Vec3, direction: Vec3) -> Option<Vec3> {
        let scene = self.tracer.scene();
        let (triangle, at) = mirror.triangles.iter().find_map(|&id| {
            let corners = scene.triangles[id as usize].map(|v| scene.positions[v as usize]);
            Some((id, barycentrics(corners, mirror.normal, place)?))
        })?;
        let colour = (self.tracer)
            .material_at(&self.tracer.point(triangle, at.to_array()))
            .base_color;
        let cosine = direction.dot(mirror.normal).abs().min(1.0);
        Some(colour + (Vec3::ONE - colour) * (1.0 - cosine).powi(5))
    }

    /// Radiance [W/(sr m²)] that rows send to their viewers by way of a mirror and their own
    /// surface: two reflections, of which none is a patch's. Row i has the name `first + i`.
    pub fn at_rows(&self, light: &dyn DirectLight, rows: &[RowPoint], first: u64) -> Vec<Vec3> {
        if self.is_empty() {
            return vec![Vec3::ZERO; rows.len()];
        }
        let indices = (0..rows.len()).into_par_iter();
        let one = |i: usize| self.at_row(light, &rows[i], first + i as u64);
        indices.map(one).collect()
    }

    fn at_row(&self, light: &dyn DirectLight, row: &RowPoint, owner: u64) -> Vec3 {
        let point = &row.point;
        let back = point.normal.dot(row.viewer) < 0.0;
        let (shading, bsdf) = self.tracer.shading_at(point, row.viewer);
        let at = Receiver {
            position: point.position,
            geometric: if back { -point.normal } else { point.normal },
            shading,
        };
        if self.is_on_mirror(&at) {
            return Vec3::ZERO;
        }
        let (mut near, mut far, mut values) = (Rays::default(), Rays::default(), Vec::new());
        self.images(
            light,
            &at,
            ReceiverId { owner, point: 0 },
            &mut |incident| {
                let Some(leg) = incident.beyond else { return };
                let value = bsdf.eval(shading, row.viewer, incident.direction);
                if value != Vec3::ZERO {
                    let origin =
                        (self.tracer).lift(point.triangle, point.position, incident.direction);
                    near.push(origin, incident.direction, incident.distance);
                    far.push(leg.origin, leg.direction, leg.distance);
                    values.push(value * incident.normal_irradiance);
                }
            },
        );
        let mut blocked = [Vec::new(), Vec::new()];
        self.tracer.occluded(&near, &mut blocked[0]);
        self.tracer.occluded(&far, &mut blocked[1]);
        let free = |i: &usize| !blocked[0][*i] && !blocked[1][*i];
        (0..values.len()).filter(free).map(|i| values[i]).sum()
    }
}

impl Mirror {
    fn height(&self, x: Vec3) -> f32 {
        self.normal.dot(x) - self.offset
    }
}

/// Weights of a triangle's second and third corner at a place in its plane, inside only.
fn barycentrics([a, b, c]: [Vec3; 3], normal: Vec3, place: Vec3) -> Option<Vec2> {
    let (e, f, d) = (b - a, c - a, place - a);
    let doubled = e.cross(f).dot(normal);
    let at = Vec2::new(d.cross(f).dot(normal), e.cross(d).dot(normal)) / doubled;
    (at.min_element() >= 0.0 && at.element_sum() <= 1.0).then_some(at)
}

/// A light with its images in flat mirrors.
pub struct Mirrored<'a, L> {
    mirrors: &'a FlatMirrors<'a>,
    light: L,
}

impl<L: DirectLight> DirectLight for Mirrored<'_, L> {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        if self.mirrors.is_on_mirror(at) {
            return;
        }
        self.light.arrivals(at, id, arrive);
        self.mirrors.images(&self.light, at, id, arrive);
    }
}
