//! Places of the surface at which a lamp's indirect light is compared with the nets'.

use crate::error::RenderError;
use crate::tile::raw;
use glam::Vec3;
use rrf_field::Field;
use rrf_field::columns::{self, Columns};
use rrf_materials::{ShadingFrame, cosine_hemisphere};
use rrf_sampling::{Stage, Stream};
use rrf_scene::INVALID;
use rrf_trace::{Reflections, Sampling, SurfacePoint, Tracer, lamp_light};

/// Probes of the surface.
const PROBES: usize = 768;
/// Paths of a probe, in two independent halves.
const PATHS: u32 = 128;

/// Points of the surface, uniform by area, seen from directions by their cosine.
pub struct Probes {
    points: Vec<SurfacePoint>,
    viewers: Vec<Vec3>,
    rows: Columns,
}

impl Probes {
    /// On the sides that face the middle of the light box; lamps themselves are left out.
    pub fn new(tracer: &Tracer, [low, high]: [Vec3; 2]) -> Probes {
        let mut probes = Probes {
            points: Vec::new(),
            viewers: Vec::new(),
            rows: Columns::default(),
        };
        let middle = 0.5 * (low + high);
        for k in 0..PROBES {
            let point = tracer.sample_area(halton3(k).to_array());
            let emits = tracer.scene().triangle_light.get(point.triangle as usize);
            if emits.is_none_or(|&light| light != INVALID) {
                continue;
            }
            let side = point.normal.dot(middle - point.position);
            let normal = if side < 0.0 {
                -point.normal
            } else {
                point.normal
            };
            let [u, v] = [7, 11].map(|base| radical_inverse(k + 1, base));
            let local = cosine_hemisphere([u, v]);
            let viewer = ShadingFrame::new(normal).to_world(local);
            probes.rows.push(raw(tracer, &point, viewer));
            probes.points.push(point);
            probes.viewers.push(viewer);
        }
        probes
    }

    /// The lamp's indirect light at the probes, two independent halves, channel by channel
    /// within each probe.
    pub fn trace(&self, tracer: &Tracer, light: u32) -> Result<[Vec<f64>; 2], RenderError> {
        let sampling = Sampling {
            paths: PATHS,
            replicates: 2,
        };
        let estimates = lamp_light(
            tracer,
            &self.points,
            &self.viewers,
            Reflections::More,
            sampling,
            Stream::new(1, Stage::LightProxy, light),
            0,
        )?;
        Ok([0, 1].map(|half| {
            let values = (0..estimates.len()).map(|probe| estimates.halves(probe)[half]);
            values.flat_map(|v| v.as_dvec3().to_array()).collect()
        }))
    }

    /// The nets' light at the probes under a point light of 1 W/sr at `place`.
    pub fn nets(&self, field: &Field, place: Vec3) -> Result<Vec<f64>, RenderError> {
        let mut rows = self.rows.clone();
        for (axis, x) in place.to_array().into_iter().enumerate() {
            rows.columns[columns::L + axis].fill(x);
        }
        let (mut radiance, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
        field.evaluate(&rows, &mut radiance, &mut cells)?;
        let [r, g, b] = &radiance;
        let rgb = r.iter().zip(g).zip(b);
        Ok(rgb
            .flat_map(|((&r, &g), &b)| [r, g, b].map(f64::from))
            .collect())
    }
}

/// Point `index` of the Halton sequence in bases 2, 3 and 5.
pub fn halton3(index: usize) -> Vec3 {
    Vec3::from_array([2, 3, 5].map(|base| radical_inverse(index + 1, base)))
}

/// The digits of `index` in a base, mirrored behind the point.
fn radical_inverse(index: usize, base: usize) -> f32 {
    let (mut left, mut digit, mut sum) = (index, 1.0, 0.0);
    while left > 0 {
        digit /= base as f64;
        sum += digit * (left % base) as f64;
        left /= base;
    }
    sum as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_points_are_radical_inverses() {
        assert_eq!(halton3(0), Vec3::new(0.5, 1.0 / 3.0, 0.2));
        assert_eq!(halton3(5), Vec3::new(0.375, 2.0 / 9.0, 0.24));
    }
}
