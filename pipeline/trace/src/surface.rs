//! Where rays end: points, frames and materials on the scene's surface.

use crate::tracer::Tracer;
use glam::Vec3;
use rrf_materials::Bsdf;
use rrf_sampling::warp::{by_weight, uniform_triangle};

/// A point on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Scene id of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f32; 2],
    /// World position, metres.
    pub position: Vec3,
    /// Unit geometric normal (p1-p0) x (p2-p0), world frame.
    pub normal: Vec3,
}

/// A surface point as shading sees it: both normals on the viewer's side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub(crate) position: Vec3,
    pub(crate) geometric: Vec3,
    pub(crate) shading: Vec3,
    /// How far rays start off the triangle, metres.
    pub(crate) lift: f32,
    pub(crate) bsdf: Bsdf,
}

/// A surface point before it is known where it is seen from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Site {
    pub(crate) position: Vec3,
    /// Geometric normal, on the outer side.
    pub(crate) outward: Vec3,
    /// Shading normal on the outer side; zero where it is the geometric one.
    bent: Vec3,
    pub(crate) lift: f32,
    /// Whether it encloses a solid that light travels in, on the side of the outward normal if inverted.
    pub(crate) encloses: bool,
    inverted: bool,
    /// As seen from outside.
    pub(crate) bsdf: Bsdf,
}

impl Site {
    /// Whether light between these directions crosses a surface that encloses a solid.
    #[inline]
    pub(crate) fn enters(&self, v: Vec3, l: Vec3) -> bool {
        self.encloses && (self.outward.dot(v) < 0.0) != (self.outward.dot(l) < 0.0)
    }

    /// Both normals turned to the side of `v`.
    #[inline(always)]
    pub(crate) fn seen_from(&self, v: Vec3) -> Vertex {
        let back = self.outward.dot(v) < 0.0;
        let geometric = if back { -self.outward } else { self.outward };
        let mut shading = geometric;
        if self.bent != Vec3::ZERO {
            let turned = if self.bent.dot(geometric) < 0.0 {
                -self.bent
            } else {
                self.bent
            };
            if turned.dot(v) > 0.0 {
                shading = turned;
            }
        }
        Vertex {
            position: self.position,
            geometric,
            shading,
            lift: self.lift,
            bsdf: if self.encloses && back != self.inverted {
                self.bsdf.from_within()
            } else {
                self.bsdf
            },
        }
    }

    /// Where rays start that leave to the side of `v`.
    #[inline]
    pub(crate) fn origin(&self, v: Vec3) -> Vec3 {
        let back = self.outward.dot(v) < 0.0;
        self.position + self.outward * if back { -self.lift } else { self.lift }
    }
}

impl Vertex {
    /// Whether light from `l` is on one side of both normals: light through a surface by one of
    /// them alone does not count.
    #[inline]
    pub(crate) fn agrees(&self, l: Vec3) -> bool {
        (self.geometric.dot(l) > 0.0) == (self.shading.dot(l) > 0.0)
    }

    /// Black, nowhere.
    pub(crate) const NONE: Vertex = Vertex {
        position: Vec3::ZERO,
        geometric: Vec3::Z,
        shading: Vec3::Z,
        lift: 0.0,
        bsdf: Bsdf::BLACK,
    };
}

impl Tracer<'_> {
    /// Total area of the surface, square metres, each triangle counted once.
    pub fn area(&self) -> f64 {
        self.area_cdf.last().copied().unwrap_or(0.0)
    }

    /// The point of a triangle with these barycentrics.
    #[inline]
    pub fn point(&self, triangle: u32, barycentrics: [f32; 2]) -> SurfacePoint {
        let facet = &self.facets[triangle as usize];
        SurfacePoint {
            triangle,
            barycentrics,
            position: facet.position(barycentrics),
            normal: facet.normal,
        }
    }

    /// A point uniform over the surface by area, from three numbers in [0, 1).
    /// Density 1 / [`Tracer::area`] with respect to area.
    pub fn sample_area(&self, u: [f32; 3]) -> SurfacePoint {
        let triangle = by_weight(&self.area_cdf, u[0]);
        self.point(triangle as u32, uniform_triangle([u[1], u[2]]))
    }

    /// Unit shading normal at a point for a viewer in direction `v`: the interpolated normal on
    /// the viewer's geometric side; where that turns away from the viewer, the geometric one.
    pub fn normal_at(&self, point: &SurfacePoint, v: Vec3) -> Vec3 {
        self.vertex(point.triangle, point.barycentrics, v).shading
    }

    /// Material parameters at a point, textures looked up, as seen from outside.
    pub fn material_at(&self, point: &SurfacePoint) -> Bsdf {
        let facet = &self.facets[point.triangle as usize];
        let inside = facet.encloses && facet.is_inside(point.normal);
        let outer = if inside { -point.normal } else { point.normal };
        self.vertex(point.triangle, point.barycentrics, outer).bsdf
    }

    /// [`Tracer::normal_at`] and [`Tracer::material_at`] in one look-up.
    #[inline]
    pub fn shading_at(&self, point: &SurfacePoint, v: Vec3) -> (Vec3, Bsdf) {
        let vertex = self.vertex(point.triangle, point.barycentrics, v);
        (vertex.shading, vertex.bsdf)
    }

    /// All that shading needs of a point seen from `v`.
    #[inline(always)]
    pub(crate) fn vertex(&self, triangle: u32, barycentrics: [f32; 2], v: Vec3) -> Vertex {
        self.site(triangle, barycentrics).seen_from(v)
    }

    /// All that shading needs of a point, wherever it is seen from.
    #[inline(always)]
    pub(crate) fn site(&self, triangle: u32, barycentrics: [f32; 2]) -> Site {
        let facet = &self.facets[triangle as usize];
        let constants = self.materials[facet.material as usize];
        Site {
            position: facet.position(barycentrics),
            outward: facet.normal,
            bent: if facet.smooth {
                self.bent_normal(triangle, barycentrics)
            } else {
                Vec3::ZERO
            },
            lift: facet.lift,
            encloses: facet.encloses,
            inverted: facet.inverted,
            bsdf: if facet.textured {
                self.textured(triangle, barycentrics, constants)
            } else {
                constants
            },
        }
    }

    /// Radiance that the surface emits at a point toward `v` [W/(sr m^2)].
    pub fn emission(&self, point: &SurfacePoint, v: Vec3) -> Vec3 {
        self.emission_of(&self.lamps, point, v)
    }
}
