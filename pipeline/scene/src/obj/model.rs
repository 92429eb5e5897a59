//! Contents of an OBJ file.

use crate::polygon::triangulate;
use glam::{DVec3, Vec2, Vec3};

/// The content of an OBJ file.
#[derive(Default)]
pub(super) struct Obj {
    pub(super) positions: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    pub(super) models: Vec<Model>,
    /// MTL files named, with their lines.
    pub(super) libraries: Vec<(u32, String)>,
    /// Materials used, with their first lines.
    pub(super) materials: Vec<(u32, String)>,
}

/// Triangles of one object, group and material.
#[derive(Clone, Default)]
pub(super) struct Model {
    pub(super) name: String,
    pub(super) material: Option<String>,
    /// Only a change of material parts it from the model before.
    pub(super) continues: bool,
    pub(super) triangles: Vec<[Corner; 3]>,
    /// Faces of four corners and more: where their fans begin in `triangles`, and how many
    /// triangles they are.
    pub(super) fans: Vec<(usize, usize)>,
}

/// Indices of a corner's position, texture coordinate and normal, in range.
pub(super) type Corner = [Option<u32>; 3];

impl Model {
    /// Adds the fan of one face.
    pub(super) fn add_fan(&mut self, fan: impl Iterator<Item = [Corner; 3]>) {
        let start = self.triangles.len();
        self.triangles.extend(fan);
        let count = self.triangles.len() - start;
        if count > 1 {
            self.fans.push((start, count));
        }
    }

    /// Divides the faces anew that are no fans: what their corners enclose is known at the end.
    pub(super) fn divide_concave(&mut self, positions: &[Vec3]) {
        let mut divided = Vec::new();
        let mut kept = 0;
        for (start, count) in std::mem::take(&mut self.fans) {
            let fan = self.triangles.get(start..start + count).unwrap_or_default();
            let first = fan.first().map(|triangle| [triangle[0], triangle[1]]);
            let corners: Vec<Corner> = (first.into_iter().flatten())
                .chain(fan.iter().map(|triangle| triangle[2]))
                .collect();
            let place = |corner: &Corner| {
                let position = corner[0].and_then(|id| positions.get(id as usize));
                position.copied().unwrap_or_default().as_dvec3()
            };
            let places: Vec<DVec3> = corners.iter().map(place).collect();
            let triangles = triangulate(&places);
            let corner = |id: u32| corners.get(id as usize).copied().unwrap_or_default();
            let triangles = triangles.into_iter().map(|ids| ids.map(corner));
            if triangles.clone().eq(fan.iter().copied()) {
                continue;
            }
            divided.extend_from_slice(self.triangles.get(kept..start).unwrap_or_default());
            divided.extend(triangles);
            kept = start + count;
        }
        if kept > 0 {
            divided.extend_from_slice(self.triangles.get(kept..).unwrap_or_default());
            self.triangles = divided;
        }
    }
}
