//! The scene's columns.

use glam::{Vec2, Vec3};
use rrf_lights::{AreaLight, OwnLight};
use rrf_materials::{Material, Texture};
use std::path::PathBuf;

/// A pinhole camera. `right`, `up` and `forward` are unit and orthogonal, and may be
/// left-handed (pbrt scenes often mirror).
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the scene file, for messages.
    pub name: String,
    /// World position of the eye.
    pub eye: Vec3,
    /// World direction of the image's +x (to the right).
    pub right: Vec3,
    /// World direction of the image's up.
    pub up: Vec3,
    /// World viewing direction.
    pub forward: Vec3,
    /// Full angle of the shorter image side \[degrees\].
    pub fov: f32,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
}

/// Something that was read but approximated or left out.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// `file:line:column`, or the node or material concerned.
    pub place: String,
    /// The approximation or omission, and how it was made.
    pub message: String,
}

/// A static scene in world space, metres (scene units), as parallel columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The file it was read from.
    pub source: PathBuf,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals a vertex, or the zero vector where the geometric normal serves.
    /// As long as `positions`.
    pub normals: Vec<Vec3>,
    /// Texture coordinates a vertex, v growing upwards as in pbrt (row 0 of a texture at v = 1).
    /// As long as `positions`.
    pub uvs: Vec<Vec2>,
    /// Vertex ids of each triangle. The geometric normal is (p1-p0) x (p2-p0).
    pub triangles: Vec<[u32; 3]>,
    /// Material id of each triangle.
    pub triangle_material: Vec<u32>,
    /// Area light id of each triangle, or `INVALID`.
    pub triangle_light: Vec<u32>,
    /// Object (shape of the file) id of each triangle.
    pub triangle_object: Vec<u32>,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// The file's own lights that are no surface, with names that none shares.
    pub lights: Vec<OwnLight>,
    /// The file's own area lights.
    pub area_lights: Vec<AreaLight>,
    /// Own light that each area light is part of: lamps of one material, or pieces of one shape,
    /// share a name. As long as `area_lights`.
    pub area_light_names: Vec<String>,
    /// Texture that each area light's radiance is multiplied with, or `INVALID`; area lights
    /// beyond its end have none.
    pub area_light_textures: Vec<u32>,
    /// Cameras, the first one the default.
    pub cameras: Vec<Camera>,
    /// Approximations and omissions.
    pub warnings: Vec<Warning>,
}

impl Scene {
    /// Adds a warning about the scene as a whole.
    pub(crate) fn warn(&mut self, message: impl Into<String>) {
        self.warnings.push(Warning {
            place: self.source.display().to_string(),
            message: message.into(),
        });
    }
}
