//! Sixty-four lanes of the points that shading reads, as columns.

use crate::surface::Vertex;
use glam::Vec3;
use rrf_materials::{Lane, Lane3, MaterialLanes, TILE};

/// Surface points seen from somewhere.
#[derive(Clone)]
pub(crate) struct Surfaces {
    pub(crate) position: Lane3,
    /// Geometric normal on the viewer's side.
    pub(crate) geometric: Lane3,
    /// Shading normal on the viewer's side.
    pub(crate) shading: Lane3,
    lift: Lane,
    pub(crate) materials: MaterialLanes,
}

impl Surfaces {
    pub(crate) const ZERO: Surfaces = Surfaces {
        position: Lane3::ZERO,
        geometric: Lane3::ZERO,
        shading: Lane3::ZERO,
        lift: [0.0; TILE],
        materials: MaterialLanes::ZERO,
    };

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, vertex: &Vertex) {
        self.position.set(i, vertex.position);
        self.geometric.set(i, vertex.geometric);
        self.shading.set(i, vertex.shading);
        self.lift[i] = vertex.lift;
        self.materials.set(i, &vertex.bsdf);
    }

    /// Where rays start that leave to the viewer's side, or to the other one.
    #[inline(always)]
    pub(crate) fn origin_on(&self, i: usize, above: bool) -> Vec3 {
        let lift = if above { self.lift[i] } else { -self.lift[i] };
        self.position.get(i) + self.geometric.get(i) * lift
    }

    /// Where rays start that leave to the viewer's side.
    #[inline(always)]
    pub(crate) fn origin(&self, i: usize) -> Vec3 {
        self.position.get(i) + self.geometric.get(i) * self.lift[i]
    }
}

/// Contributions that hold if nothing lies between two points.
pub(crate) struct Contributions {
    pub(crate) value: Lane3,
    pub(crate) origin: Lane3,
    /// To the other point, a shadow ray's t ending at 1; a unit vector to light from afar.
    pub(crate) direction: Lane3,
}

impl Contributions {
    pub(crate) const ZERO: Contributions = Contributions {
        value: Lane3::ZERO,
        origin: Lane3::ZERO,
        direction: Lane3::ZERO,
    };
}
