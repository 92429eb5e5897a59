//! Emission of the surface: triangles that shine, and the choice of a point on them.

use glam::Vec3;
use rrf_sampling::warp::uniform_triangle;

/// The emission of a group of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Emitted radiance a channel [W/(sr m^2)].
    pub radiance: Vec3,
    /// Emits from the back of its triangles too. The front is the side that
    /// the triangle's geometric normal (p1-p0) x (p2-p0) points to.
    pub two_sided: bool,
}

impl AreaLight {
    /// Radiance [W/(sr m²)] toward `v` of a triangle with this unit geometric normal.
    #[inline(always)]
    pub fn emitted(&self, outward: Vec3, v: Vec3) -> Vec3 {
        if self.two_sided || outward.dot(v) > 0.0 {
            self.radiance
        } else {
            Vec3::ZERO
        }
    }

    /// Sides that shine.
    pub fn sides(&self) -> f64 {
        if self.two_sided { 2.0 } else { 1.0 }
    }

    /// Radiant power \[W\] of a surface of this area \[m²\]: π times area times radiance a side.
    pub fn power(&self, area: f64) -> [f64; 3] {
        let power = self.radiance.as_dvec3() * (std::f64::consts::PI * area * self.sides());
        power.to_array()
    }
}

/// The triangles that emit, chosen by their power, uniform by area on each.
#[derive(Clone, Debug, Default)]
pub struct EmittingTriangles {
    triangles: Vec<u32>,
    /// Cumulative power of `triangles`, up to a common factor.
    cdf: Vec<f64>,
    /// Density of [`EmittingTriangles::sample`] on each triangle of the scene, with respect to
    /// area [1/m²]; zero where nothing is emitted.
    density: Vec<f32>,
}

/// A point on an emitting triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittingPoint {
    /// Id of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f32; 2],
}

impl EmittingTriangles {
    /// From each triangle's area \[m²\] and exitance, up to a common factor: power an area, all
    /// sides and channels together, 0 where it does not emit.
    pub fn new(triangles: impl ExactSizeIterator<Item = (f64, f64)>) -> EmittingTriangles {
        let mut emitting = EmittingTriangles {
            density: vec![0.0; triangles.len()],
            ..EmittingTriangles::default()
        };
        let (mut total, mut exitances) = (0.0, Vec::new());
        for (id, (area, exitance)) in triangles.enumerate() {
            if exitance * area > 0.0 {
                total += exitance * area;
                emitting.triangles.push(id as u32);
                emitting.cdf.push(total);
                exitances.push(exitance);
            }
        }
        for (&triangle, exitance) in emitting.triangles.iter().zip(exitances) {
            if let Some(density) = emitting.density.get_mut(triangle as usize) {
                *density = (exitance / total) as f32;
            }
        }
        emitting
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A point by emitted power, uniform by area on each triangle, from three numbers in
    /// [0, 1); `None` if nothing emits.
    pub fn sample(&self, u: [f32; 3]) -> Option<EmittingPoint> {
        let target = f64::from(u[0]) * self.cdf.last()?;
        let at = self.cdf.partition_point(|&c| c <= target);
        let triangle = *self.triangles.get(at.min(self.triangles.len() - 1))?;
        Some(EmittingPoint {
            triangle,
            barycentrics: uniform_triangle([u[1], u[2]]),
        })
    }

    /// Density of [`EmittingTriangles::sample`] on a triangle with respect to area [1/m²].
    #[inline(always)]
    pub fn density(&self, triangle: u32) -> f32 {
        self.density[triangle as usize]
    }
}
