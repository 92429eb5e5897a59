//! Lights as cells: point lights, and pieces of emitting triangles, each chosen as a whole.

use glam::Vec3;
use rrf_scene::{PointLight, Scene};

/// Cells that lamps are cut into, together, at the most; a triangle that is cut becomes four.
const MOST_CELLS: usize = 256;
/// Cuts of a triangle at the most: 4² pieces.
const MOST_CUTS: u32 = 2;

/// A light, or a piece of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Position, or a triangle's first corner.
    corner: Vec3,
    /// To the triangle's other corners; zero for a point.
    edges: [Vec3; 2],
    /// Unit normal of the emitting side; zero for a point.
    normal: Vec3,
    two_sided: bool,
    /// Radiant intensity [W/sr] of a point; radiance times area of a triangle, its intensity
    /// along the normal.
    pub intensity: Vec3,
}

impl From<&PointLight> for Emitter {
    fn from(light: &PointLight) -> Emitter {
        Emitter {
            corner: light.position,
            edges: [Vec3::ZERO; 2],
            normal: Vec3::ZERO,
            two_sided: false,
            intensity: light.intensity,
        }
    }
}

impl Emitter {
    fn triangle([a, b, c]: [Vec3; 3], radiance: Vec3, two_sided: bool) -> Option<Emitter> {
        let edges = [b - a, c - a];
        let doubled = edges[0].cross(edges[1]);
        let emitter = Emitter {
            corner: a,
            edges,
            normal: doubled.try_normalize()?,
            two_sided,
            intensity: 0.5 * doubled.length() * radiance,
        };
        (radiance != Vec3::ZERO).then_some(emitter)
    }

    /// The four triangles between the corners and the edges' middles.
    fn cut(&self) -> [Emitter; 4] {
        let [e, f] = self.edges.map(|edge| 0.5 * edge);
        let quarter = |corner: Vec3, edges: [Vec3; 2]| Emitter {
            corner,
            edges,
            intensity: 0.25 * self.intensity,
            ..*self
        };
        let a = self.corner;
        [
            quarter(a, [e, f]),
            quarter(a + e, [e, f]),
            quarter(a + f, [e, f]),
            quarter(a + e + f, [-e, -f]),
        ]
    }

    /// The three corners; a point, three times.
    pub(crate) fn corners(&self) -> [Vec3; 3] {
        let [e, f] = self.edges;
        [self.corner, self.corner + e, self.corner + f]
    }

    /// The middle.
    pub(crate) fn middle(&self) -> Vec3 {
        self.corner + (self.edges[0] + self.edges[1]) / 3.0
    }

    /// Unit normal, where light leaves on one side only.
    pub(crate) fn normal(&self) -> Option<Vec3> {
        (self.normal != Vec3::ZERO && !self.two_sided).then_some(self.normal)
    }

    /// The place by two numbers in [0, 1): uniform over a triangle's area (Turk, *Graphics
    /// Gems*, 1990).
    pub fn place(&self, u: [f32; 2]) -> Vec3 {
        let root = u[0].sqrt();
        self.corner + root * ((1.0 - u[1]) * self.edges[0] + u[1] * self.edges[1])
    }

    /// Unoccluded irradiance [W/m²] on a surface square to it at `x` of a light that stands at
    /// `place` alone with the emitter's whole power: intensity toward x over the squared
    /// distance. Its mean over places is the emitter's own.
    pub fn arriving(&self, place: Vec3, x: Vec3) -> Vec3 {
        let to = x - place;
        let squared = to.length_squared();
        if squared < f32::MIN_POSITIVE {
            return Vec3::ZERO;
        }
        if self.normal == Vec3::ZERO {
            return self.intensity / squared;
        }
        let cosine = self.normal.dot(to) / squared.sqrt();
        let cosine = if self.two_sided {
            cosine.abs()
        } else {
            cosine.max(0.0)
        };
        self.intensity * (cosine / squared)
    }

    /// End of a shadow ray to `place`, off the emitter on the side of `x`: the lamp itself
    /// must not shade it.
    pub fn before(&self, place: Vec3, x: Vec3) -> Vec3 {
        let largest = place.abs().max_element().max(x.abs().max_element());
        let side = self.normal.dot(x - place).signum();
        place + self.normal * (side * LIFT * largest)
    }
}

/// Distance of a shadow ray's end from the lamp, as a share of the largest coordinate.
const LIFT: f32 = 4e-6;

/// The emitting triangles of each of a scene's area lights, uncut.
pub fn of_area_lights(scene: &Scene) -> Vec<Vec<Emitter>> {
    let mut emitters = vec![Vec::new(); scene.area_lights.len()];
    let columns = scene.triangles.iter().zip(&scene.triangle_light);
    for (id, (triangle, &light)) in (0..).zip(columns) {
        let Some(area_light) = scene.area_lights.get(light as usize) else {
            continue;
        };
        let corners = triangle.map(|v| scene.positions[v as usize]);
        // a picture by its mean over the triangle
        let radiance = area_light.radiance * scene.mean_share(id);
        let two_sided = area_light.two_sided;
        emitters[light as usize].extend(Emitter::triangle(corners, radiance, two_sided));
    }
    emitters
}

/// Cuts emitters into smaller ones of the same light: where part of a lamp is hidden, shadow rays
/// can learn which.
pub fn cut_all(emitters: impl Iterator<Item = Emitter>) -> Vec<Emitter> {
    let mut cells: Vec<Emitter> = emitters.collect();
    for _ in 0..MOST_CUTS {
        if 4 * cells.len() > MOST_CELLS {
            break;
        }
        cells = cells.iter().flat_map(Emitter::cut).collect();
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Emitter {
        let corners = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 2.0];
        Emitter::triangle(corners, Vec3::new(1.0, 2.0, 3.0), false).unwrap()
    }

    /// Pieces have the whole's power, and every place of a piece lies in the whole.
    #[test]
    fn pieces_make_up_the_whole() {
        let cells = cut_all([triangle()].into_iter());
        assert_eq!(cells.len(), 16);
        let power: Vec3 = cells.iter().map(|c| c.intensity).sum();
        assert!((power - Vec3::new(3.0, 6.0, 9.0)).length() < 1e-5);
        for cell in &cells {
            assert_eq!(cell.normal, Vec3::Z);
            for u in [[0.0, 0.0], [0.99, 0.0], [0.99, 0.99], [0.5, 0.3]] {
                let p = cell.place(u);
                let inside = p.x > -1e-5 && p.y > -1e-5 && p.x / 3.0 + p.y / 2.0 < 1.0 + 1e-5;
                assert!(inside && p.z == 0.0, "{p}");
            }
        }
    }

    #[test]
    fn a_one_sided_lamp_has_a_dark_side() {
        let lamp = triangle();
        let place = lamp.place([0.3, 0.3]);
        let at = |z: f32| lamp.arriving(place, place + Vec3::Z * z).x;
        assert!((at(2.0) - 3.0 / 4.0).abs() < 1e-5);
        assert_eq!(at(-2.0), 0.0);
        assert_eq!(at(0.0), 0.0);
    }
}
