//! Sixty-four lanes of everything that shading reads, as columns on the stack.

use crate::bsdf::Bsdf;
use crate::surface::Vertex;
use glam::Vec3;
use rrf_scene::MaterialKind;

/// Lanes of a tile. Kernels always run over all of them; lanes past the end hold stale
/// numbers whose results nobody reads.
pub(crate) const TILE: usize = 64;

/// One number a lane.
pub(crate) type Lane = [f32; TILE];

/// One vector a lane.
#[derive(Clone)]
pub(crate) struct Lane3 {
    x: Lane,
    y: Lane,
    z: Lane,
}

impl Lane3 {
    pub(crate) const ZERO: Lane3 = Lane3 {
        x: [0.0; TILE],
        y: [0.0; TILE],
        z: [0.0; TILE],
    };

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, v: Vec3) {
        self.x[i] = v.x;
        self.y[i] = v.y;
        self.z[i] = v.z;
    }
}

/// Surface points seen from somewhere.
#[derive(Clone)]
pub(crate) struct Surfaces {
    pub(crate) position: Lane3,
    /// Geometric normal on the viewer's side.
    pub(crate) geometric: Lane3,
    /// Shading normal on the viewer's side.
    pub(crate) shading: Lane3,
    lift: Lane,
    base_color: Lane3,
    roughness: Lane,
    metallic: Lane,
    specular: Lane,
    lambert: [u32; TILE],
}

impl Surfaces {
    pub(crate) const ZERO: Surfaces = Surfaces {
        position: Lane3::ZERO,
        geometric: Lane3::ZERO,
        shading: Lane3::ZERO,
        lift: [0.0; TILE],
        base_color: Lane3::ZERO,
        roughness: [0.0; TILE],
        metallic: [0.0; TILE],
        specular: [0.0; TILE],
        lambert: [0; TILE],
    };

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, vertex: &Vertex) {
        self.position.set(i, vertex.position);
        self.geometric.set(i, vertex.geometric);
        self.shading.set(i, vertex.shading);
        self.lift[i] = vertex.lift;
        self.base_color.set(i, vertex.bsdf.base_color);
        self.roughness[i] = vertex.bsdf.roughness;
        self.metallic[i] = vertex.bsdf.metallic;
        self.specular[i] = vertex.bsdf.specular;
        self.lambert[i] = u32::from(vertex.bsdf.kind == MaterialKind::Lambert);
    }

    #[inline(always)]
    pub(crate) fn bsdf(&self, i: usize) -> Bsdf {
        Bsdf {
            kind: if self.lambert[i] == 1 {
                MaterialKind::Lambert
            } else {
                MaterialKind::Principled
            },
            base_color: self.base_color.get(i),
            roughness: self.roughness[i],
            metallic: self.metallic[i],
            specular: self.specular[i],
        }
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
    /// To the other point: a shadow ray's t ends at 1.
    pub(crate) direction: Lane3,
}

impl Contributions {
    pub(crate) const ZERO: Contributions = Contributions {
        value: Lane3::ZERO,
        origin: Lane3::ZERO,
        direction: Lane3::ZERO,
    };
}
