//! Flat glossy surfaces, and where each of them shows a point light to a point.
//!
//! A narrow lobe on the way from a point light to a rough surface (a caustic) is found neither by
//! the rough surface's own directions nor by the light's: each hits it once in thousands of paths
//! and then brings thousands of times its share. A flat surface shows the light at its mirror
//! image. For a point x and a light l at heights a and b over the plane, the slope of the half
//! vector at y is, to first order about the mirror point y0,
//!
//! s = k (cos²θ (y - y0)·t, (y - y0)·u),    k = (a + b) / (2 a b),
//!
//! t and u along and across the plane of incidence and θ the angle there. Drawing s from the GGX
//! slopes of the surface's own alpha and taking y from it covers the lobe; the balance heuristic
//! takes care of all else, so that no approximation here makes an estimate wrong.

use crate::facets::Facet;
use glam::{Vec2, Vec3};
use multiversion::multiversion;
use rrf_scene::{INVALID, MaterialKind, Scene};
use std::collections::BTreeMap;
use std::f32::consts::PI;

/// Peak of the lobe at normal incidence [1/sr] from which on a surface counts as a mirror:
/// three times that of a white diffuse one.
const STRENGTH: f32 = 1.0;
/// Mirrors are at least this share of the scene's area: smaller ones are parts of something bent.
const LEAST_AREA: f64 = 1e-3;
/// Mirrors at the most: each is asked at every vertex.
const MOST: usize = 16;
/// Of a mirror whose image lies beside it: the lobe's share below which it is left out.
const LEAST_SHARE: f32 = 0.01;
/// Grid on which planes count as one, relative to the scene's size.
const GRID: f64 = 1e-4;
/// Height over a plane, relative to the distance to the image, below which a point lies on it.
const CLEAR: f32 = 1e-4;

/// In place of a mirror's number: none.
pub(crate) const NO_MIRROR: u8 = u8::MAX;

/// A flat glossy surface.
#[derive(Clone, Debug)]
struct Mirror {
    /// Its plane: normal · y = offset.
    normal: Vec3,
    offset: f32,
    /// Axes in the plane, and the bounds along them.
    axes: [Vec3; 2],
    low: Vec2,
    high: Vec2,
    /// GGX alpha.
    alpha: f32,
    /// Reflectance at normal incidence.
    reflectance: f32,
}

/// One number a mirror.
type Each = [f32; MOST];

/// What tells how much of a light's image each mirror shows, side by side.
#[derive(Clone, Debug, Default)]
struct Frames {
    normal: [Each; 3],
    offset: Each,
    axes: [[Each; 3]; 2],
    low: [Each; 2],
    high: [Each; 2],
    /// 1 / alpha².
    sharpness: Each,
    /// Zero past the last mirror.
    reflectance: Each,
}

/// All of a scene's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mirrors {
    mirrors: Vec<Mirror>,
    frames: Frames,
    /// Of each triangle, or [`NO_MIRROR`]; empty where there is none at all.
    of_triangle: Vec<u8>,
}

/// A point to go to.
pub(crate) struct Proposal {
    /// Which mirror it is on.
    pub(crate) mirror: u8,
    pub(crate) position: Vec3,
    /// How often this mirror is taken from there.
    pub(crate) share: f32,
}

/// The image of a light in one mirror.
struct Image {
    /// Where in the plane.
    center: Vec2,
    /// Unit vector along the plane of incidence.
    along: Vec2,
    /// Slopes a metre, along and across.
    slopes: Vec2,
}

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
        mirrors
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.mirrors.is_empty()
    }

    /// The mirror that a triangle belongs to.
    #[inline]
    pub(crate) fn of(&self, triangle: u32) -> u8 {
        let found = self.of_triangle.get(triangle as usize);
        found.copied().unwrap_or(NO_MIRROR)
    }

    /// A point on a mirror by which the light at `l` is seen from `x`, from three numbers in
    /// [0, 1): which mirror, and where.
    pub(crate) fn propose(&self, x: Vec3, l: Vec3, u: [f32; 3]) -> Option<Proposal> {
        let weights = weights(&self.frames, x, l);
        let total = sum(&weights);
        if total == 0.0 {
            return None;
        }
        // the first whose share of the sum so far goes beyond the number; without a branch each
        let (mut so_far, mut chosen, mut last) = (0.0, 0, 0);
        for (number, weight) in weights.iter().enumerate().take(self.mirrors.len()) {
            so_far += weight;
            chosen += usize::from(so_far <= u[0] * total);
            last = if *weight > 0.0 { number } else { last };
        }
        let chosen = chosen.min(last);
        let mirror = self.mirrors.get(chosen)?;
        let image = mirror.image(x, l);
        Some(Proposal {
            mirror: chosen as u8,
            position: mirror.at(image.sample(mirror.alpha, [u[1], u[2]])),
            share: weights[chosen] / total,
        })
    }

    /// Density of [`Mirrors::propose`] at `y` on `mirror`, with respect to area.
    pub(crate) fn density(&self, mirror: u8, x: Vec3, l: Vec3, y: Vec3) -> f32 {
        let weights = weights(&self.frames, x, l);
        match weights.get(usize::from(mirror)) {
            Some(&own) if own > 0.0 => self.density_in(mirror, own / sum(&weights), x, l, y),
            _ => 0.0,
        }
    }

    /// The same where the share of this mirror is known.
    pub(crate) fn density_in(&self, mirror: u8, share: f32, x: Vec3, l: Vec3, y: Vec3) -> f32 {
        self.mirrors.get(usize::from(mirror)).map_or(0.0, |own| {
            share * own.image(x, l).density(own.alpha, own.coordinates(y))
        })
    }
}

/// How much of the image of `l` each mirror shows `x`, in proportion: the mirror's reflectance
/// over the squared distance, times what the lobe leaves where the image lies beside the mirror;
/// zero where that is too little or the two are not on one side, clear of the plane.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
fn weights(frames: &Frames, x: Vec3, l: Vec3) -> Each {
    let mut weights = [0.0; MOST];
    for (i, weight) in weights.iter_mut().enumerate() {
        let along =
            |axis: &[Each; 3], p: Vec3| axis[0][i] * p.x + axis[1][i] * p.y + axis[2][i] * p.z;
        let a = along(&frames.normal, x) - frames.offset[i];
        let b = along(&frames.normal, l) - frames.offset[i];
        let height = a + b;
        let (mut to_rectangle, mut apart) = ([0.0; 2], [0.0; 2]);
        for axis in 0..2 {
            let from = along(&frames.axes[axis], x);
            apart[axis] = along(&frames.axes[axis], l) - from;
            let center = from + apart[axis] * (a / height);
            let nearest = center.max(frames.low[axis][i]).min(frames.high[axis][i]);
            to_rectangle[axis] = nearest - center;
        }
        let apart2 = apart[0] * apart[0] + apart[1] * apart[1];
        let distance2 = apart2 + height * height;
        let dot = to_rectangle[0] * apart[0] + to_rectangle[1] * apart[1];
        let cross = to_rectangle[0] * apart[1] - to_rectangle[1] * apart[0];
        let cos2 = height * height / distance2;
        let k = height / (2.0 * a * b);
        let tiny = f32::MIN_POSITIVE;
        let slope2 = k * k * (cos2 * cos2 * dot * dot + cross * cross) / (apart2 + tiny);
        // straight above, the plane of incidence may be any
        let beside2 = to_rectangle[0] * to_rectangle[0] + to_rectangle[1] * to_rectangle[1];
        let slope2 = if apart2 > tiny {
            slope2
        } else {
            k * k * beside2
        };
        let spread = 1.0 + slope2 * frames.sharpness[i];
        let share = 1.0 / (spread * spread);
        let clear = CLEAR * CLEAR * distance2;
        let shown = (a * b > 0.0) & (a * a > clear) & (b * b > clear) & (share >= LEAST_SHARE);
        let full = share * frames.reflectance[i] / distance2;
        *weight = if shown { full } else { 0.0 };
    }
    weights
}

/// In halves, so that no addition waits for all before it.
fn sum(weights: &Each) -> f32 {
    let mut sums = *weights;
    let mut half = MOST / 2;
    while half > 0 {
        let (low, high) = sums.split_at_mut(half);
        low.iter_mut().zip(high).for_each(|(a, b)| *a += *b);
        half /= 2;
    }
    sums[0]
}

impl Frames {
    fn new(mirrors: &[Mirror]) -> Frames {
        let mut frames = Frames::default();
        for (i, mirror) in mirrors.iter().enumerate().take(MOST) {
            for axis in 0..3 {
                frames.normal[axis][i] = mirror.normal[axis];
                frames.axes[0][axis][i] = mirror.axes[0][axis];
                frames.axes[1][axis][i] = mirror.axes[1][axis];
            }
            for axis in 0..2 {
                frames.low[axis][i] = mirror.low[axis];
                frames.high[axis][i] = mirror.high[axis];
            }
            frames.offset[i] = mirror.offset;
            frames.sharpness[i] = 1.0 / (mirror.alpha * mirror.alpha);
            frames.reflectance[i] = mirror.reflectance;
        }
        frames
    }
}

impl Mirror {
    fn over(scene: &Scene, facets: &[Facet], ids: &[usize]) -> Option<Mirror> {
        let facet = &facets[*ids.first()?];
        let (alpha, reflectance) = strength(scene, *ids.first()?, facet)?;
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

    fn coordinates(&self, y: Vec3) -> Vec2 {
        Vec2::new(self.axes[0].dot(y), self.axes[1].dot(y))
    }

    fn at(&self, y: Vec2) -> Vec3 {
        self.axes[0] * y.x + self.axes[1] * y.y + self.normal * self.offset
    }

    /// The image of `l` as `x` sees it, both on one side of the plane.
    fn image(&self, x: Vec3, l: Vec3) -> Image {
        let (a, b) = (
            self.normal.dot(x) - self.offset,
            self.normal.dot(l) - self.offset,
        );
        let (from, to) = (self.coordinates(x), self.coordinates(l));
        let (apart, height) = (to - from, a + b);
        let distance2 = apart.length_squared() + height * height;
        let k = (height / (2.0 * a * b)).abs();
        Image {
            center: from + apart * (a / height),
            along: apart.try_normalize().unwrap_or(Vec2::X),
            slopes: Vec2::new(k * height * height / distance2, k),
        }
    }
}

impl Image {
    /// Slope of the half vector at `y`, along and across, to first order.
    fn slope(&self, y: Vec2) -> Vec2 {
        let d = y - self.center;
        Vec2::new(d.dot(self.along), d.dot(self.along.perp())) * self.slopes
    }

    /// GGX slopes: density 1 / (π α² (1 + s²/α²)²).
    fn sample(&self, alpha: f32, u: [f32; 2]) -> Vec2 {
        let radius = alpha * (u[0] / (1.0 - u[0])).sqrt();
        let (sine, cosine) = crate::math::sin_cos_turn(u[1]);
        let d = Vec2::new(radius * cosine, radius * sine) / self.slopes;
        self.center + self.along * d.x + self.along.perp() * d.y
    }

    /// Density of [`Image::sample`] with respect to area.
    fn density(&self, alpha: f32, y: Vec2) -> f32 {
        let spread = 1.0 + self.slope(y).length_squared() / (alpha * alpha);
        self.slopes.x * self.slopes.y / (PI * alpha * alpha * spread * spread)
    }
}

/// Whether the shading normals of a triangle leave it as flat as a lobe is narrow.
fn is_flat(scene: &Scene, id: usize, normal: Vec3, alpha: f32) -> bool {
    let bent = |n: Vec3| n.normalize_or_zero().cross(normal).length() > 0.1 * alpha;
    !scene.triangles[id]
        .iter()
        .any(|&v| bent(scene.normals[v as usize]))
}

/// GGX alpha and reflectance at normal incidence of a triangle that may be part of a mirror.
fn strength(scene: &Scene, id: usize, facet: &Facet) -> Option<(f32, f32)> {
    let material = &scene.materials[facet.material as usize];
    let constant = material.roughness_metallic_texture == INVALID;
    let alpha = (material.roughness * material.roughness).max(1e-3);
    let flat = material.normal_texture == INVALID && is_flat(scene, id, facet.normal, alpha);
    if material.kind != MaterialKind::Principled || !flat || !constant {
        return None;
    }
    let metal = material.base_color.max_element() * material.metallic;
    let reflectance = metal + 0.08 * material.specular * (1.0 - material.metallic);
    let peak = reflectance / (4.0 * PI * alpha * alpha);
    (peak >= STRENGTH).then_some((alpha, reflectance))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn mirror() -> Mirror {
        Mirror {
            normal: Vec3::Y,
            offset: 0.5,
            axes: [Vec3::X, Vec3::NEG_Z],
            low: Vec2::splat(-1.0),
            high: Vec2::splat(1.0),
            alpha: 0.04,
            reflectance: 0.9,
        }
    }

    /// The image is where angles of incidence and reflection agree, and the slope's derivative is
    /// that of the half vector, by central differences.
    #[test]
    fn images_are_mirror_points_with_the_half_vectors_slope() {
        let mirror = mirror();
        for (x, l) in [
            (Vec3::new(0.3, 1.5, -0.2), Vec3::new(-0.5, 0.9, 0.4)),
            (Vec3::new(0.1, -0.2, 0.3), Vec3::new(0.2, 0.3, -0.4)),
            (Vec3::new(0.1, 1.2, 0.3), Vec3::new(0.1, 0.8, 0.3)),
        ] {
            let image = mirror.image(x, l);
            let slope = |y: Vec2| {
                let y = mirror.at(y).as_dvec3();
                let (dx, dl) = (x.as_dvec3() - y, l.as_dvec3() - y);
                let h = dx / dx.length() + dl / dl.length();
                let h = h / h.y.abs();
                glam::DVec2::new(
                    mirror.axes[0].as_dvec3().dot(h),
                    mirror.axes[1].as_dvec3().dot(h),
                )
            };
            assert!(slope(image.center).length() < 1e-5);
            for (axis, expected) in [
                (image.along, image.slopes.x),
                (image.along.perp(), image.slopes.y),
            ] {
                let step = 1e-3 * axis;
                let change = slope(image.center + step) - slope(image.center - step);
                let found = -change.dot(axis.as_dvec2()) / 2e-3;
                let error = found / f64::from(expected) - 1.0;
                assert!(error.abs() < 1e-3, "{found} for {expected}");
            }
        }
        let frames = Frames::new(&[mirror]);
        let shown = |x, l| sum(&weights(&frames, x, l));
        let above = Vec3::new(0.2, 1.0, 0.0);
        assert_eq!(shown(above, Vec3::ZERO), 0.0, "on different sides");
        assert_eq!(
            shown(above, Vec3::new(2.5, 0.9, 0.0)),
            0.0,
            "image beside the mirror"
        );
        assert!(shown(above, Vec3::new(-0.3, 0.8, 0.1)) > 0.0);
    }

    /// Points are as dense as `density` says: chi-square over a grid of 6 x 6 and the outside; the
    /// 99.9999 % point for 36 degrees of freedom is 92.9.
    #[test]
    fn points_have_their_density() {
        let mirrors = Mirrors {
            frames: Frames::new(&[mirror()]),
            mirrors: vec![mirror()],
            of_triangle: vec![0],
        };
        let (x, l) = (Vec3::new(0.3, 1.5, -0.2), Vec3::new(-0.5, 0.9, 0.4));
        let image = mirrors.mirrors[0].image(x, l);
        let (count, cells, half) = (200_000u64, 6, 0.09f32);
        let width = 2.0 * half / cells as f32;
        let cell = |y: Vec2| {
            let at = (y - image.center + half) / width;
            let inside = at.min_element() >= 0.0 && at.max_element() < cells as f32;
            inside.then(|| at.y as usize * cells + at.x as usize)
        };
        let mut found = vec![0.0; cells * cells + 1];
        for i in 0..count {
            let u = crate::rng::Stream::new(5, 0, 0).units(i, 0, 0);
            let proposal = mirrors.propose(x, l, [u[0], u[1], u[2]]).unwrap();
            assert!((proposal.position.y - 0.5).abs() < 1e-6);
            let y = mirrors.mirrors[0].coordinates(proposal.position);
            found[cell(y).unwrap_or(cells * cells)] += 1.0;
        }
        let fine = 40;
        let mut expected = vec![0.0; cells * cells + 1];
        for iy in 0..cells * fine {
            for ix in 0..cells * fine {
                let offset = Vec2::new(ix as f32 + 0.5, iy as f32 + 0.5) * (width / fine as f32);
                let y = image.center - half + offset;
                let density = mirrors.density(0, x, l, mirrors.mirrors[0].at(y));
                let area = f64::from(width / fine as f32).powi(2);
                expected[(iy / fine) * cells + ix / fine] +=
                    f64::from(density) * area * count as f64;
            }
        }
        expected[cells * cells] = count as f64 - expected.iter().sum::<f64>();
        let square = |(f, e): (&f64, &f64)| (f - e).powi(2) / e;
        let chi2: f64 = found.iter().zip(&expected).map(square).sum();
        assert!(chi2 < 92.9, "{chi2}");
    }
}
