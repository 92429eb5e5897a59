//! How a picture covers the sphere of directions.

use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// A map from the unit square (s to the right, t down, row 0 of a picture at t = 0) to the
/// sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// Latitude and longitude, +y up: s = atan2(dx, -dz) / 2π mod 1, t = acos(dy) / π.
    /// Looked up with bilinear interpolation, around in s, held at the poles.
    LatLong,
    /// Equal-area octahedron, +z in the square's middle (Clarberg, *Fast Equal-Area Mapping of
    /// the (Hemi)Sphere using SIMD*, JGT 13(3), 2008; pbrt version 4). Looked up texel by texel,
    /// as pbrt does.
    Octahedral,
}

impl Mapping {
    /// Place of a unit direction in the unit square; s and t in [0, 1].
    pub fn place(self, d: Vec3) -> [f64; 2] {
        let d = d.as_dvec3();
        match self {
            Mapping::LatLong => {
                let turn = d.x.atan2(-d.z) / TAU;
                let flat = d.x.hypot(d.z);
                [turn - turn.floor(), flat.atan2(d.y) / PI]
            }
            Mapping::Octahedral => square_of(d),
        }
    }

    /// Unit direction of a place in the unit square: the inverse of [`Mapping::place`].
    pub fn direction(self, [s, t]: [f64; 2]) -> Vec3 {
        match self {
            Mapping::LatLong => {
                let (sine, cosine) = (PI * t).sin_cos();
                let (along, across) = (TAU * s).sin_cos();
                DVec3::new(sine * along, cosine, -sine * across).as_vec3()
            }
            Mapping::Octahedral => direction_of([s, t]).as_vec3(),
        }
    }

    /// Solid angle of a texel in this row \[sr\].
    pub fn texel_solid_angle(self, row: u32, width: u32, height: u32) -> f64 {
        match self {
            Mapping::LatLong => {
                let [top, bottom] = heights(row, height);
                TAU / f64::from(width) * (top - bottom)
            }
            Mapping::Octahedral => 4.0 * PI / (f64::from(width) * f64::from(height)),
        }
    }

    /// A direction uniform over a texel by solid angle, from a place within it.
    pub(crate) fn within(
        self,
        (column, row): (u32, u32),
        place: [f32; 2],
        (width, height): (u32, u32),
    ) -> Vec3 {
        let [x, y] = place.map(f64::from);
        let s = (f64::from(column) + x) / f64::from(width);
        match self {
            Mapping::LatLong => {
                let [top, bottom] = heights(row, height);
                let cosine = top + (bottom - top) * y;
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                let (along, across) = (TAU * s).sin_cos();
                DVec3::new(sine * along, cosine, -sine * across).as_vec3()
            }
            Mapping::Octahedral => self.direction([s, (f64::from(row) + y) / f64::from(height)]),
        }
    }
}

/// Cosines of the polar angles of a lat-long row's upper and lower border.
fn heights(row: u32, height: u32) -> [f64; 2] {
    [row, row + 1].map(|r| (PI * f64::from(r) / f64::from(height)).cos())
}

/// Place of a direction on the octahedron's square.
///
/// On the upper half, a ring of directions at height z lies on the diamond |a| + |b| = r with
/// r² = 1 - z (areas agree: both are 2π (1 - z) up to a factor), a and b from -1 to 1; the azimuth
/// within a quarter goes linearly along the diamond's side. The lower half is folded outwards.
fn square_of(d: DVec3) -> [f64; 2] {
    let r = (1.0 - d.z.abs()).max(0.0).sqrt();
    let quarter = d.y.abs().atan2(d.x.abs()) / (2.0 * FRAC_PI_4);
    let (mut a, mut b) = (r * (1.0 - quarter), r * quarter);
    if d.z < 0.0 {
        (a, b) = (1.0 - b, 1.0 - a);
    }
    [a.copysign(d.x), b.copysign(d.y)].map(|x| (0.5 * (x + 1.0)).clamp(0.0, 1.0))
}

/// Direction of a place on the octahedron's square: the inverse of [`square_of`].
fn direction_of(place: [f64; 2]) -> DVec3 {
    let [a, b] = place.map(|x| 2.0 * x - 1.0);
    let inside = 1.0 - (a.abs() + b.abs());
    let r = 1.0 - inside.abs();
    let along = if r > 0.0 {
        (b.abs() - a.abs()) / r
    } else {
        0.0
    };
    let (sine, cosine) = ((along + 1.0) * FRAC_PI_4).sin_cos();
    let flat = r * (2.0 - r * r).max(0.0).sqrt();
    DVec3::new(
        (cosine * flat).copysign(a),
        (sine * flat).copysign(b),
        (1.0 - r * r).copysign(inside),
    )
}
