//! Light subpaths from afar: they come in through openings, or through a disk across the light that
//! is as wide as the scene.

use crate::openings::{Openings, outward};
use glam::Vec3;
use rrf_lights::LightSource;
use std::f32::consts::PI;

/// Share of the light subpaths that come in through openings.
const GUIDED: f32 = 0.9;

/// A sphere about the scene and where light was seen to come in.
#[derive(Clone, Copy)]
pub(super) struct Beams<'a> {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    pub(super) openings: Option<&'a Openings>,
}

/// How light from one direction comes in.
struct Ways {
    /// Density of the direction, where it is chosen at all.
    density: f32,
    /// Cumulative weights of the faces that it comes in through.
    faces: [f32; 6],
    /// Share that comes in there.
    guided: f32,
}

impl Beams<'_> {
    /// The direction to a light that a subpath begins with, by three numbers in [0, 1). That to a
    /// sky is turned, by its mirror image, to the side of an opening.
    pub(super) fn toward(&self, source: &LightSource, u: [f32; 3]) -> Option<Vec3> {
        let mut toward = source.sample(self.center, [u[1], u[2]])?.toward;
        if let Some(openings) = self.openings.filter(|_| source.is_sky() && u[0] < GUIDED) {
            let face = openings.face(u[0] / GUIDED);
            if outward(face, toward) < 0.0 {
                toward[face / 2] = -toward[face / 2];
            }
        }
        Some(toward)
    }

    /// Density of [`Beams::toward`] with respect to angle; 1 for light from one direction.
    pub(super) fn direction_density(&self, source: &LightSource, toward: Vec3) -> f32 {
        self.ways(source, toward).density
    }

    fn ways(&self, source: &LightSource, toward: Vec3) -> Ways {
        let own = density_of(source, self.center, toward);
        let sky = source.is_sky();
        let mut folded = [own; 3];
        if sky && self.openings.is_some() {
            for (axis, folded) in folded.iter_mut().enumerate() {
                let mut image = toward;
                image[axis] = -image[axis];
                *folded += density_of(source, self.center, image);
            }
        }
        let mut sum = 0.0;
        let faces = std::array::from_fn(|face| {
            if let Some(openings) = self.openings.filter(|_| outward(face, toward) > 0.0) {
                sum += openings.chance(face) * folded[face / 2];
            }
            sum
        });
        let comes_in = f32::from(u8::from(sum > 0.0));
        if !sky || self.openings.is_none() {
            return Ways {
                density: own,
                faces,
                guided: GUIDED * comes_in,
            };
        }
        let density = (1.0 - GUIDED) * own + GUIDED * sum;
        Ways {
            density,
            faces,
            guided: GUIDED * sum / density.max(f32::MIN_POSITIVE),
        }
    }

    /// Density with respect to area across it of light from `toward` that arrives at `at`.
    pub(super) fn density(&self, source: &LightSource, at: Vec3, toward: Vec3) -> f32 {
        let ways = self.ways(source, toward);
        let whole = (1.0 - ways.guided) / (PI * self.radius * self.radius);
        let through = self.openings.and_then(|o| o.beam_density(at, toward));
        match through {
            Some((face, density)) if ways.guided > 0.0 => {
                let before = face.checked_sub(1).map_or(0.0, |face| ways.faces[face]);
                let chance = (ways.faces[face] - before) / ways.faces[5];
                whole + ways.guided * chance * density
            }
            _ => whole,
        }
    }

    /// Where light from `toward` begins, by three numbers in [0, 1).
    pub(super) fn leave(&self, source: &LightSource, toward: Vec3, u: [f32; 3]) -> Option<Vec3> {
        let ways = self.ways(source, toward);
        if let Some(openings) = self.openings.filter(|_| u[2] < ways.guided) {
            let target = u[2] / ways.guided * ways.faces[5];
            let last = (0..6).rfind(|&f| f == 0 || ways.faces[f] > ways.faces[f - 1])?;
            let face = ways
                .faces
                .iter()
                .take_while(|&&upto| upto <= target)
                .count();
            return openings.point(face.min(last), [u[0], u[1]]);
        }
        let (x, y) = toward.any_orthonormal_pair();
        let (sine, cosine) = (2.0 * PI * u[1]).sin_cos();
        let across = (x * cosine + y * sine) * (u[0].sqrt() * self.radius);
        Some(self.center + toward * self.radius + across)
    }
}

/// Density of a light's own sampler; 1 where it comes from one direction, which needs no choice.
pub(super) fn density_of(source: &LightSource, at: Vec3, toward: Vec3) -> f32 {
    match source.is_visible() {
        true => source.density(at, toward),
        false => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::openings::tests::openings;
    use glam::Mat3;
    use rrf_lights::{DistantLight, Environment, EnvironmentMap, Mapping};
    use rrf_sampling::{Stage, Stream};

    fn sky() -> LightSource {
        let texels = (0..128u32).map(|k| Vec3::splat(0.1 + (k * 37 % 11) as f32));
        let map = EnvironmentMap::new((16, 8), texels.collect(), Mapping::LatLong, Mat3::IDENTITY);
        Environment::of_map(map.unwrap()).into()
    }

    /// Beams from directions in a cone that pass a disk across them: the mean of 1 / density is the
    /// cone's angle times the disk's area (for one direction: the area), by z at 5.
    #[test]
    fn beams_have_their_density() {
        let openings = openings();
        let beams = Beams {
            center: Vec3::new(0.0, 1.5, 0.0),
            radius: 3.0,
            openings: Some(&openings),
        };
        let axis = Vec3::new(-1.0, 0.3, 0.1).normalize();
        let parallel = DistantLight {
            diameter: 0.0,
            ..DistantLight::sun(axis, Vec3::ONE)
        };
        let spread = 0.3f32;
        let angle = 2.0 * std::f64::consts::PI * f64::from(spread);
        let (middle, radius) = (Vec3::new(0.1, 0.9, 0.0), 0.75f32);
        let area = std::f64::consts::PI * f64::from(radius).powi(2);
        for (source, expected) in [(sky(), angle * area), (parallel.into(), area)] {
            let stream = Stream::new(5, Stage::Test, 0);
            let count = 2_000_000u64;
            let (mut sum, mut squares) = (0.0f64, 0.0f64);
            for i in 0..count {
                let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
                let toward = beams.toward(&source, [u[0], u[1], u[2]]).unwrap();
                let from = beams.leave(&source, toward, [w[0], w[1], w[2]]).unwrap();
                let apart = from - middle;
                let place = from - toward * apart.dot(toward);
                let passes = (place - middle).length() < radius;
                if passes && toward.dot(axis) > 1.0 - spread {
                    let direction = beams.direction_density(&source, toward);
                    let x = 1.0 / f64::from(direction * beams.density(&source, place, toward));
                    sum += x;
                    squares += x * x;
                }
            }
            let mean = sum / count as f64;
            let error = ((squares / count as f64 - mean * mean) / count as f64).sqrt();
            let off = (mean - expected).abs();
            assert!(off < 5.0 * error, "{mean} ± {error}, {expected}");
            assert!(error < 0.03 * expected, "{mean} ± {error}");
        }
    }
}
