//! A point light and its image in a flat mirror: what a mirror throws straight on a surface.

use glam::Vec3;
use rrf_scene::Scene;
use rrf_trace::{Hits, Rays, Tracer};
use rrf_transfer::{DirectLight, IncidentLight, Receiver, RowPoint};

/// A point light of 1 W/sr, seen straight and by way of every flat perfect mirror.
pub struct Mirrored<'a> {
    tracer: &'a Tracer<'a>,
    light: Vec3,
    mirrors: Vec<Plane>,
}

/// Triangles of one plane that are perfect mirrors.
struct Plane {
    material: u32,
    normal: Vec3,
    offset: f32,
    colour: Vec3,
}

impl<'a> Mirrored<'a> {
    pub fn new(tracer: &'a Tracer<'a>, light: Vec3) -> Mirrored<'a> {
        let scene: &Scene = tracer.scene();
        let mut mirrors: Vec<Plane> = Vec::new();
        for (id, &material) in scene.triangle_material.iter().enumerate() {
            let m = &scene.materials[material as usize];
            if m.roughness > 0.02 || m.metallic < 0.9 {
                continue;
            }
            let point = tracer.point(id as u32, [0.3, 0.3]);
            let (normal, offset) = (point.normal, point.normal.dot(point.position));
            let same =
                |p: &Plane| p.normal.dot(normal) > 0.9999 && (p.offset - offset).abs() < 1e-3;
            if !mirrors.iter().any(same) {
                let colour = m.base_color;
                mirrors.push(Plane {
                    material,
                    normal,
                    offset,
                    colour,
                });
            }
        }
        Mirrored {
            tracer,
            light,
            mirrors,
        }
    }

    /// What the mirrors send by way of a row's own point: two reflections, but no patch's.
    pub fn at_row(&self, row: &RowPoint) -> Vec3 {
        if self.mirrors.is_empty() {
            return Vec3::ZERO;
        }
        let point = &row.point;
        let back = point.normal.dot(row.viewer) < 0.0;
        let (shading, bsdf) = self.tracer.shading_at(point, row.viewer);
        let at = Receiver {
            position: point.position,
            geometric: if back { -point.normal } else { point.normal },
            shading,
        };
        let mut sum = Vec3::ZERO;
        self.images(&at, &mut |arrival| {
            let l = arrival.direction;
            let origin = self.tracer.lift(point.triangle, point.position, l);
            if at.geometric.dot(l) > 0.0 && !self.blocked(origin, l * arrival.distance) {
                sum += bsdf.eval(shading, row.viewer, l) * arrival.normal_irradiance;
            }
        });
        sum
    }

    fn blocked(&self, origin: Vec3, way: Vec3) -> bool {
        let mut rays = Rays::default();
        rays.push(origin, way, 1.0);
        let mut blocked = Vec::new();
        self.tracer.occluded(&rays, &mut blocked);
        blocked[0]
    }

    fn images(&self, at: &Receiver, arrive: &mut dyn FnMut(IncidentLight)) {
        for mirror in &self.mirrors {
            let height = mirror.normal.dot(self.light) - mirror.offset;
            let own = mirror.normal.dot(at.position) - mirror.offset;
            // far enough not to be the mirror itself
            if height * own <= 0.0 || own.abs() < 1e-3 {
                continue;
            }
            let image = self.light - 2.0 * height * mirror.normal;
            let way = image - at.position;
            let share = own / (own + height);
            let on_mirror = at.position + way * share;
            let side = mirror.normal * height.signum();
            let mut rays = Rays::default();
            rays.push(on_mirror + side * 1e-3, -side, 2e-3);
            let mut hits = Hits::default();
            self.tracer.closest(&rays, &mut hits);
            let triangle = hits.triangle[0];
            let scene = self.tracer.scene();
            let is_mirror = triangle != rrf_scene::INVALID
                && scene.triangle_material[triangle as usize] == mirror.material;
            if !is_mirror || self.blocked(on_mirror + side * 1e-4, self.light - on_mirror) {
                continue;
            }
            let distance = way.length();
            let direction = way / distance;
            let cosine = (1.0 - direction.dot(mirror.normal).abs()).clamp(0.0, 1.0);
            let fresnel = mirror.colour + (Vec3::ONE - mirror.colour) * cosine.powi(5);
            arrive(IncidentLight {
                direction,
                distance: distance * share - 1e-3,
                normal_irradiance: fresnel / (distance * distance),
            });
        }
    }

    fn on_mirror(&self, at: &Receiver) -> bool {
        let on = |m: &Plane| (m.normal.dot(at.position) - m.offset).abs() < 1e-4;
        self.mirrors
            .iter()
            .any(|m| on(m) && m.normal.dot(at.geometric).abs() > 0.9999)
    }
}

impl DirectLight for Mirrored<'_> {
    fn arrivals(&self, at: &Receiver, _: u64, arrive: &mut dyn FnMut(IncidentLight)) {
        // what a mirror shows is the image; its own patches take no part
        if self.on_mirror(at) {
            return;
        }
        let to = self.light - at.position;
        let distance = to.length();
        arrive(IncidentLight {
            direction: to / distance,
            distance,
            normal_irradiance: Vec3::splat(1.0 / (distance * distance)),
        });
        self.images(at, arrive);
    }
}
