//! TransferRows elsewhere in the scene, and what regression sees of them.

use glam::Vec3;
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::RowPoint;

/// What regression sees of a row.
#[derive(Clone, Copy)]
pub struct Row {
    pub position: Vec3,
    /// Shading normal on the viewer's side.
    pub normal: Vec3,
    pub geometric: Vec3,
    pub viewer: Vec3,
    pub reflected: Vec3,
    pub object: u32,
    pub metal: bool,
    pub roughness: f32,
    pub colour: Vec3,
    /// 1 / max(what it gets, 5 % of the mean).
    pub weight: f32,
}

/// TransferRows elsewhere, and the points that are judged.
pub struct Table {
    pub rows: Vec<Row>,
    pub judged: Vec<Row>,
}

impl Row {
    pub fn new(scene: &Scene, tracer: &Tracer, at: &RowPoint) -> Row {
        let (normal, bsdf) = tracer.shading_at(&at.point, at.viewer);
        let facing = at.point.normal.dot(at.viewer).signum();
        Row {
            position: at.point.position,
            normal,
            geometric: at.point.normal * facing,
            viewer: at.viewer,
            reflected: normal * (2.0 * normal.dot(at.viewer)) - at.viewer,
            object: scene.triangle_object[at.point.triangle as usize],
            metal: bsdf.metallic > 0.5,
            roughness: bsdf.roughness,
            colour: bsdf.base_color,
            weight: 1.0,
        }
    }

    /// Whether a row elsewhere can say anything about this one.
    pub fn alike(&self, other: &Row) -> bool {
        self.object == other.object
            && self.metal == other.metal
            && self.geometric.dot(other.geometric) > 0.5
    }

    /// Metres; turned normals and other viewers count too, the latter for metals above all.
    pub fn distance(&self, other: &Row) -> f32 {
        let view = if self.metal { 0.3 } else { 0.02 };
        self.position.distance(other.position)
            + 0.2 * self.normal.distance(other.normal)
            + view * self.reflected.distance(other.reflected)
    }

    /// Terms of a polynomial about `own`, in units of `reach`.
    pub fn polynomial(&self, own: &Row, reach: f32, order: usize) -> Vec<f64> {
        let (x, y) = own.geometric.any_orthonormal_pair();
        let d = (self.position - own.position) / reach;
        let (a, b) = (f64::from(d.dot(x)), f64::from(d.dot(y)));
        let mut terms = vec![1.0];
        if order >= 1 {
            terms.extend([a, b]);
            let n = (self.normal - own.normal) * 0.5;
            terms.extend([f64::from(n.dot(x)), f64::from(n.dot(y))]);
        }
        if order >= 2 {
            terms.extend([a * a, a * b, b * b]);
        }
        terms
    }
}
