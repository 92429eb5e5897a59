//! Lights as cells: point lights, and pieces of emitting triangles, each chosen as a whole.

use glam::{Vec2, Vec3};
use rrf_metrics::color::luminance;
use rrf_scene::{AreaLight, PointLight, Scene};

/// Cells that lamps are cut into, together, at the most; a triangle that is cut becomes four.
const MOST_CELLS: usize = 256;
/// Cuts of a triangle at the most: 4² pieces.
const MOST_CUTS: u32 = 2;
/// Cuts of a triangle that shines by a picture: 4³ pieces, each of one colour.
const PICTURE_CUTS: u32 = 3;

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
    /// Luminance of the radiance of the lamp that it is a piece of, pictures left out; zero for a
    /// point, which no ray meets.
    pub level: f32,
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
            level: 0.0,
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
            level: luminance(radiance),
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

/// The emitting triangles of each of a scene's area lights, uncut but where they shine by a
/// picture.
pub fn of_area_lights(scene: &Scene) -> Vec<Vec<Emitter>> {
    let mut emitters = vec![Vec::new(); scene.area_lights.len()];
    for (id, &light) in (0..).zip(&scene.triangle_light) {
        if let Some(area_light) = scene.area_lights.get(light as usize) {
            let has_picture = scene.emission_texture(light).is_some();
            let cuts = if has_picture { PICTURE_CUTS } else { 0 };
            emitters[light as usize].extend(pieces(scene, id, area_light, cuts));
        }
    }
    emitters
}

/// A triangle that shines, cut so many times into four, each piece by the mean over it.
fn pieces<'s>(
    scene: &'s Scene,
    triangle: u32,
    light: &'s AreaLight,
    cuts: u32,
) -> impl Iterator<Item = Emitter> + 's {
    let [a, b, c] = scene.triangles[triangle as usize].map(|v| scene.positions[v as usize]);
    let mut parts = vec![[Vec2::ZERO, Vec2::X, Vec2::Y]];
    for _ in 0..cuts {
        let quarters = parts.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
        });
        parts = quarters.collect();
    }
    parts.into_iter().filter_map(move |part| {
        let corners = match cuts {
            0 => [a, b, c],
            _ => part.map(|at| a + (b - a) * at.x + (c - a) * at.y),
        };
        let share = scene.mean_share_of(triangle, part);
        let piece = Emitter::triangle(corners, light.radiance * share, light.two_sided)?;
        Some(Emitter {
            level: luminance(light.radiance),
            ..piece
        })
    })
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
    use rrf_scene::Texture;

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

    /// A lamp whose picture is red on its left half and green on the right.
    #[test]
    fn pieces_of_a_picture_have_its_colours() {
        let uvs = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let scene = Scene {
            positions: uvs.map(|uv| (3.0 * uv).extend(0.0)).to_vec(),
            // within the picture, whose opposite borders meet
            uvs: uvs.map(|uv| 0.25 + 0.5 * uv).to_vec(),
            triangles: vec![[0, 1, 2]],
            triangle_light: vec![0],
            textures: vec![Texture {
                width: 32,
                height: 1,
                texels: [Vec3::X, Vec3::Y].map(|colour| [colour; 16]).concat(),
            }],
            area_lights: vec![AreaLight {
                radiance: Vec3::splat(2.0),
                two_sided: false,
            }],
            area_light_textures: vec![0],
            ..Scene::default()
        };
        let [pieces] = of_area_lights(&scene).try_into().unwrap();
        assert_eq!(pieces.len(), 64);
        let power: Vec3 = pieces.iter().map(|piece| piece.intensity).sum();
        // Of the area 4.5, 3/4 lie on the left; midpoints err along the border.
        assert!(
            (power - Vec3::new(6.75, 2.25, 0.0)).abs().max_element() < 0.05,
            "{power}"
        );
        for piece in &pieces {
            assert_eq!(piece.normal, Vec3::Z);
            let middle = piece.middle().x;
            if (middle - 1.5).abs() > 0.4 && middle > 0.4 && middle < 2.6 {
                let wanted = if middle < 1.5 { Vec3::X } else { Vec3::Y };
                let colour = piece.intensity / piece.intensity.element_sum();
                assert!((colour - wanted).length() < 1e-4, "{piece:?}");
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
