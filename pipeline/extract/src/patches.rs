//! Surface that can lie in a cell: sides of triangles, cut to the cell's box.

use glam::Vec3;
use rrf_field::columns;
use rrf_field::tree::Domain;
use rrf_sampling::warp::by_weight;
use rrf_scene::{INVALID, Scene};

/// One side of a triangular piece of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// The triangle.
    pub triangle: u32,
    /// Whether the side is the back: that against the triangle's winding.
    pub back: bool,
    /// The piece's corners: weights of the triangle's second and third corner.
    corners: [[f32; 2]; 3],
}

/// The pieces, by area.
#[derive(Debug)]
pub struct Patches {
    patches: Vec<Patch>,
    /// Running sum of their areas.
    area: Vec<f64>,
}

impl Patches {
    /// Finds the surface within a box of raw columns, by position and normal.
    pub fn new(scene: &Scene, domain: &Domain) -> Patches {
        let mut all = Patches {
            patches: Vec::new(),
            area: Vec::new(),
        };
        let mut sum = 0.0;
        for triangle in 0..scene.triangles.len() as u32 {
            let sides = sides(scene, triangle, domain);
            if sides == [false; 2] {
                continue;
            }
            let polygon = clipped(scene, triangle, domain);
            let whole = scene.triangle_area(triangle as usize);
            for back in [false, true].into_iter().filter(|&b| sides[usize::from(b)]) {
                for i in 2..polygon.len() {
                    let corners = [polygon[0], polygon[i - 1], polygon[i]];
                    sum += whole * share(&corners);
                    all.area.push(sum);
                    all.patches.push(Patch {
                        triangle,
                        back,
                        corners: corners.map(|c| c.map(|w| w as f32)),
                    });
                }
            }
        }
        all
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        !(self.area.last().is_some_and(|&sum| sum > 0.0))
    }

    /// A point uniform over the area of all sides: the patch, and the weights of its triangle's
    /// second and third corner.
    pub fn sample(&self, u: [f32; 3]) -> (&Patch, [f32; 2]) {
        let patch = &self.patches[by_weight(&self.area, u[0])];
        // square to triangle (Heitz 2019): keeps the stratification of the square
        let (a, b) = (u[1], u[2]);
        let (first, second) = if b > a {
            (a * 0.5, b - a * 0.5)
        } else {
            (a - b * 0.5, b * 0.5)
        };
        let rest = 1.0 - first - second;
        let weights = [0, 1].map(|axis| {
            let [p, q, r] = patch.corners.map(|c| c[axis]);
            rest * p + first * q + second * r
        });
        (patch, weights)
    }
}

/// Share of a triangle's area that lies between corners given by weights.
fn share(corners: &[[f64; 2]; 3]) -> f64 {
    let [a, b, c] = corners;
    ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
}

/// The part of a triangle inside the box of positions, as weights of its second and third corner
/// (Sutherland and Hodgman 1974).
fn clipped(scene: &Scene, triangle: u32, domain: &Domain) -> Vec<[f64; 2]> {
    let p = scene.triangles[triangle as usize].map(|v| scene.positions[v as usize].as_dvec3());
    let at = |w: &[f64; 2], axis: usize| {
        p[0][axis] * (1.0 - w[0] - w[1]) + p[1][axis] * w[0] + p[2][axis] * w[1]
    };
    let mut polygon = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    for axis in 0..3 {
        let (low, high) = (
            domain.minimum[columns::P + axis],
            domain.maximum[columns::P + axis],
        );
        for (bound, sign) in [(low, 1.0), (high, -1.0)] {
            if bound.is_infinite() {
                continue;
            }
            let height = |w: &[f64; 2]| sign * (at(w, axis) - f64::from(bound));
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (i, here) in polygon.iter().enumerate() {
                let next = &polygon[(i + 1) % polygon.len()];
                let (a, b) = (height(here), height(next));
                if a >= 0.0 {
                    kept.push(*here);
                }
                if (a >= 0.0) != (b >= 0.0) {
                    let t = a / (a - b);
                    kept.push([0, 1].map(|k| here[k] + t * (next[k] - here[k])));
                }
            }
            polygon = kept;
        }
    }
    polygon
}

/// Whether the front and the back of a triangle may have rows in the box: by its bounds, and by its
/// normal where that is one and the same all over.
fn sides(scene: &Scene, triangle: u32, domain: &Domain) -> [bool; 2] {
    let ids = scene.triangles[triangle as usize];
    let p = ids.map(|v| scene.positions[v as usize]);
    let (low, high) = (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]));
    let overlaps = (0..3).all(|i| {
        high[i] >= domain.minimum[columns::P + i] && low[i] < domain.maximum[columns::P + i]
    });
    let material = &scene.materials[scene.triangle_material[triangle as usize] as usize];
    let own = scene.normals[ids[0] as usize];
    let bent =
        material.normal_texture != INVALID || ids.iter().any(|&v| scene.normals[v as usize] != own);
    if !overlaps || bent {
        return [overlaps; 2];
    }
    let flat = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
    let own = own.normalize_or_zero();
    let normal = if own == Vec3::ZERO { flat } else { own };
    // a rounding of the normal must not lose a triangle
    let within = |n: Vec3| {
        (0..3).all(|i| {
            n[i] + 1e-5 >= domain.minimum[columns::N + i]
                && n[i] - 1e-5 < domain.maximum[columns::N + i]
        })
    };
    // rows have the normal on the viewer's side; one at right angles to the face may be on either
    let facing = normal.dot(flat);
    let either = within(normal) || within(-normal);
    match facing.abs() > 1e-3 {
        true => [
            within(normal * facing.signum()),
            within(-normal * facing.signum()),
        ],
        false => [either; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cornell;
    use rrf_sampling::{Stage, Stream};
    use rrf_trace::Tracer;

    fn domain(low: Vec3, high: Vec3) -> Domain {
        let mut domain = Domain::ALL;
        domain.minimum[columns::P..columns::N].copy_from_slice(&low.to_array());
        domain.maximum[columns::P..columns::N].copy_from_slice(&high.to_array());
        domain
    }

    /// Points drawn from the pieces of a box are as those of the whole surface that lie in it: as many on
    /// each triangle, and as many in each eighth of the box; and their whole area is that share's.
    #[test]
    fn pieces_are_the_surface_within_the_box() {
        let scene = cornell();
        let tracer = Tracer::new(&scene).unwrap();
        let (low, high) = (Vec3::new(-1.0, -0.1, -0.7), Vec3::new(0.35, 0.8, 0.5));
        let (domain, middle) = (domain(low, high), (low + high) / 2.0);
        let all = Patches::new(&scene, &Domain::ALL);
        let pieces = Patches::new(&scene, &domain);
        let key = |triangle: u32, back: bool, p: Vec3| {
            let eighth = (0..3).fold(0, |k, i| 2 * k + usize::from(p[i] > middle[i]));
            (usize::try_from(triangle).unwrap() * 2 + usize::from(back)) * 8 + eighth
        };
        let n = 400_000;
        let mut counts = vec![[0.0f64; 2]; scene.triangles.len() * 16];
        let mut inside = 0.0;
        for k in 0..n {
            for (which, from) in [&pieces, &all].into_iter().enumerate() {
                let u = Stream::new(5, Stage::Test, which as u32).units(k, 0, 0);
                let (patch, weights) = from.sample([u[0], u[1], u[2]]);
                let p = tracer.point(patch.triangle, weights).position;
                let within = p.cmpge(low - 1e-5).all() && p.cmple(high + 1e-5).all();
                assert!(which == 1 || within, "{p} is outside the box");
                if within {
                    inside += which as f64;
                    counts[key(patch.triangle, patch.back, p)][which] += 1.0;
                }
            }
        }
        let share = pieces.area.last().unwrap() / all.area.last().unwrap();
        let se = (share * (1.0 - share) / n as f64).sqrt();
        let z = (inside / n as f64 - share) / se;
        assert!(z.abs() < 4.5, "share of the area: z {z}");
        // two samples of different sizes, one distribution: chi-square at 1e-5
        let (a, b) = (n as f64, inside);
        let (mut chi2, mut bins) = (0.0, 0);
        for [x, y] in counts.into_iter().filter(|[x, y]| x + y >= 20.0) {
            chi2 += (x * (b / a).sqrt() - y * (a / b).sqrt()).powi(2) / (x + y);
            bins += 1;
        }
        let freedom = f64::from(bins - 1);
        let limit =
            freedom * (1.0 - 2.0 / (9.0 * freedom) + 4.27 * (2.0 / (9.0 * freedom)).sqrt()).powi(3);
        assert!(
            bins > 20 && chi2 < limit,
            "chi-square {chi2}, limit {limit}, {bins} bins"
        );
    }

    /// A side whose normal is not the cell's has no piece; every triangle has two otherwise.
    #[test]
    fn sides_go_with_the_normal() {
        let scene = cornell();
        let mut up = Domain::ALL;
        up.minimum[columns::N + 1] = 0.5;
        let tracer = Tracer::new(&scene).unwrap();
        for patch in &Patches::new(&scene, &up).patches {
            let normal = tracer.point(patch.triangle, [0.3, 0.3]).normal;
            let facing = if patch.back { -normal } else { normal };
            assert!(facing.y > 0.5, "{patch:?}");
        }
        let all = Patches::new(&scene, &Domain::ALL);
        assert_eq!(all.patches.len(), 2 * scene.triangles.len());
        assert!(Patches::new(&scene, &domain(Vec3::splat(7.0), Vec3::splat(8.0))).is_empty());
    }
}
