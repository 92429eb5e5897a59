//! Queries of a model, and the surface point as regression sees it.

use crate::rows::RowPoint;
use crate::tracing::{SurfacePoint, Tracer};
use glam::Vec3;

/// Surfaces whose light is regressed together: those of one object and material, on one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SurfaceKey {
    /// Object id.
    pub object: u32,
    /// Material id.
    pub material: u32,
    /// Whether it is the side that geometric normals point away from.
    pub back: bool,
}

/// A surface point, seen from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferQuery {
    /// Position, world frame, metres.
    pub position: Vec3,
    /// Unit geometric normal on the viewer's side.
    pub geometric: Vec3,
    /// Unit shading normal on the viewer's side.
    pub shading: Vec3,
    /// Unit direction to the viewer.
    pub viewer: Vec3,
    /// Linear base colour, textures looked up.
    pub base_color: Vec3,
    /// The surface.
    pub surface: SurfaceKey,
}

/// How many numbers a net can see of a point.
pub(crate) const INPUTS: usize = 9;
/// Inputs that tell viewers apart begin here.
pub(crate) const VIEW: usize = 6;

impl TransferQuery {
    /// A surface point as the scene has it.
    pub fn new(tracer: &Tracer, point: &SurfacePoint, viewer: Vec3) -> TransferQuery {
        let (shading, bsdf) = tracer.shading_at(point, viewer);
        let back = point.normal.dot(viewer) < 0.0;
        let scene = tracer.scene();
        let triangle = point.triangle as usize;
        TransferQuery {
            position: point.position,
            geometric: if back { -point.normal } else { point.normal },
            shading,
            viewer,
            base_color: bsdf.base_color,
            surface: SurfaceKey {
                object: scene.triangle_object.get(triangle).copied().unwrap_or(0),
                material: scene.triangle_material[triangle],
                back,
            },
        }
    }

    /// The query of a row.
    pub fn of_row(tracer: &Tracer, row: &RowPoint) -> TransferQuery {
        TransferQuery::new(tracer, &row.point, row.viewer)
    }

    /// Cosine between shading normal and viewer.
    #[inline]
    pub fn facing(&self) -> f32 {
        self.shading.dot(self.viewer)
    }

    /// The viewer's direction mirrored about the shading normal.
    #[inline]
    pub fn reflected(&self) -> Vec3 {
        self.shading * (2.0 * self.facing()) - self.viewer
    }

    /// All that a net may see: position, shading normal, mirrored viewer.
    #[inline]
    pub(crate) fn inputs(&self) -> [f32; INPUTS] {
        let (p, n, r) = (self.position, self.shading, self.reflected());
        [p.x, p.y, p.z, n.x, n.y, n.z, r.x, r.y, r.z]
    }
}
