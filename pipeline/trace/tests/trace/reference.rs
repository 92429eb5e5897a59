//! A path tracer made as plainly as possible: all triangles one by one in f64, directions
//! uniform over the hemisphere, survival by a fixed chance. It shares the scattering values
//! with the library and nothing else.

use glam::{DVec3, Vec3};
use rrf_lights::LightSource;
use rrf_materials::Bsdf;
use rrf_sampling::hash::hash;
use rrf_scene::{INVALID, Scene};

/// Chance of a path to go on after each reflection.
const SURVIVAL: f64 = 0.7;

/// Numbers by a hash that the library's paths do not use.
pub struct Random {
    seed: u64,
    drawn: u64,
}

impl Random {
    pub fn new(seed: u64) -> Random {
        Random { seed, drawn: 0 }
    }

    pub fn next(&mut self) -> f64 {
        self.drawn += 1;
        (hash(self.seed, self.drawn) >> 11) as f64 / (1u64 << 53) as f64
    }
}

pub struct Plain<'a> {
    pub scene: &'a Scene,
}

/// A surface point on the viewer's side.
#[derive(Clone, Copy)]
pub struct Place {
    pub triangle: usize,
    pub position: DVec3,
    pub normal: DVec3,
    pub viewer: DVec3,
}

impl Plain<'_> {
    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.scene.triangles[triangle].map(|v| self.scene.positions[v as usize].as_dvec3())
    }

    fn normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).normalize()
    }

    pub fn place(&self, triangle: usize, position: DVec3, viewer: DVec3) -> Place {
        let normal = self.normal(triangle);
        let normal = if normal.dot(viewer) < 0.0 {
            -normal
        } else {
            normal
        };
        Place {
            triangle,
            position,
            normal,
            viewer,
        }
    }

    fn closest(&self, origin: DVec3, direction: DVec3) -> Option<(usize, f64)> {
        let mut found: Option<(usize, f64)> = None;
        for id in 0..self.scene.triangles.len() {
            let [a, b, c] = self.corners(id);
            let (e1, e2, to) = (b - a, c - a, origin - a);
            let p = direction.cross(e2);
            let det = e1.dot(p);
            if det.abs() < 1e-14 {
                continue;
            }
            let (u, q) = (to.dot(p) / det, to.cross(e1));
            let (v, t) = (direction.dot(q) / det, e2.dot(q) / det);
            let nearest = found.is_none_or(|(_, best)| t < best);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-9 && nearest {
                found = Some((id, t));
            }
        }
        found
    }

    fn follow(&self, place: &Place, l: DVec3) -> Option<Place> {
        let origin = place.position + place.normal * 1e-6;
        let (triangle, t) = self.closest(origin, l)?;
        Some(self.place(triangle, origin + l * t, -l))
    }

    fn scatters(&self, place: &Place, l: DVec3) -> DVec3 {
        let material = self.scene.triangle_material[place.triangle] as usize;
        let bsdf = Bsdf::of(&self.scene.materials[material]);
        let value = bsdf.eval(place.normal.as_vec3(), place.viewer.as_vec3(), l.as_vec3());
        value.as_dvec3()
    }

    fn emission(&self, place: &Place) -> DVec3 {
        let light = self.scene.triangle_light[place.triangle];
        if light == INVALID {
            return DVec3::ZERO;
        }
        let light = &self.scene.area_lights[light as usize];
        let front = self.normal(place.triangle).dot(place.viewer) > 0.0;
        if front || light.two_sided {
            light.radiance.as_dvec3()
        } else {
            DVec3::ZERO
        }
    }

    /// A uniform direction above a place; its density is 1 / (2 pi).
    fn direction(place: &Place, random: &mut Random) -> DVec3 {
        let z = 2.0 * random.next() - 1.0;
        let (s, c) = (std::f64::consts::TAU * random.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let l = DVec3::new(r * c, r * s, z);
        if l.dot(place.normal) < 0.0 { -l } else { l }
    }

    /// One path's indirect light of a point light of 1 W/sr.
    pub fn indirect(&self, start: Place, light: DVec3, random: &mut Random) -> DVec3 {
        let (mut place, mut throughput, mut sum) = (start, DVec3::ONE, DVec3::ZERO);
        loop {
            let l = Self::direction(&place, random);
            throughput *= self.scatters(&place, l) * std::f64::consts::TAU;
            let Some(next) = self.follow(&place, l) else {
                return sum;
            };
            place = next;
            let to = light - place.position;
            let toward = to.normalize();
            if place.normal.dot(toward) > 0.0 {
                let blocker = self.closest(place.position + place.normal * 1e-6, toward);
                if blocker.is_none_or(|(_, t)| t > to.length()) {
                    sum += throughput * self.scatters(&place, toward) / to.length_squared();
                }
            }
            if random.next() > SURVIVAL {
                return sum;
            }
            throughput /= SURVIVAL;
        }
    }

    /// One path's full light of the scene's lamps, found by running into them.
    pub fn lamps(&self, start: Place, random: &mut Random) -> DVec3 {
        let (mut place, mut throughput, mut sum) = (start, DVec3::ONE, self.emission(&start));
        loop {
            let l = Self::direction(&place, random);
            throughput *= self.scatters(&place, l) * std::f64::consts::TAU;
            let Some(next) = self.follow(&place, l) else {
                return sum;
            };
            place = next;
            sum += throughput * self.emission(&place);
            if random.next() > SURVIVAL {
                return sum;
            }
            throughput /= SURVIVAL;
        }
    }
}

impl Plain<'_> {
    /// One path's full light of the scene's lamps and other lights: points by a ray to each of
    /// them, all else by running into it.
    pub fn own(&self, start: Place, sources: &[LightSource], random: &mut Random) -> DVec3 {
        let (mut place, mut throughput, mut sum) = (start, DVec3::ONE, self.emission(&start));
        loop {
            for source in sources {
                sum += throughput * self.straight(&place, source);
            }
            let l = Self::direction(&place, random);
            throughput *= self.scatters(&place, l) * std::f64::consts::TAU;
            let Some(next) = self.follow(&place, l) else {
                let met: Vec3 = sources.iter().map(|s| s.radiance(l.as_vec3())).sum();
                return sum + throughput * met.as_dvec3();
            };
            place = next;
            sum += throughput * self.emission(&place);
            if random.next() > SURVIVAL {
                return sum;
            }
            throughput /= SURVIVAL;
        }
    }

    /// Light straight from a point.
    fn straight(&self, place: &Place, source: &LightSource) -> DVec3 {
        let Some(light) = source.position() else {
            return DVec3::ZERO;
        };
        let to = light.as_dvec3() - place.position;
        let toward = to.normalize();
        let blocker = self.closest(place.position + place.normal * 1e-6, toward);
        if place.normal.dot(toward) <= 0.0 || blocker.is_some_and(|(_, t)| t < to.length()) {
            return DVec3::ZERO;
        }
        let intensity = source.intensity_toward(-toward.as_vec3()).as_dvec3();
        intensity * self.scatters(place, toward) / to.length_squared()
    }
}

/// Mean and standard error of many values.
pub fn mean_of(count: u32, mut value: impl FnMut() -> DVec3) -> (Vec3, Vec3) {
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..count {
        let v = value();
        sum += v;
        squares += v * v;
    }
    let n = f64::from(count);
    let mean = sum / n;
    let variance = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0);
    let error = variance.to_array().map(f64::sqrt);
    (mean.as_vec3(), DVec3::from(error).as_vec3())
}
