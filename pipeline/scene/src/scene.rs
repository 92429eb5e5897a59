//! The scene's columns.

use glam::{Vec2, Vec3};
use std::path::PathBuf;

/// "No such thing" in a column of ids.
pub const INVALID: u32 = u32::MAX;

/// How a surface scatters light. Both kinds are two-sided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialKind {
    /// Ideal diffuse: f = base_color / pi.
    Lambert,
    /// Mitsuba 3's `principled` with base colour, roughness, metallic and specular only.
    Principled,
}

/// Material parameters; a texture, where present, multiplies the constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the scene file, for messages.
    pub name: String,
    /// Scattering model.
    pub kind: MaterialKind,
    /// Linear sRGB reflectance, each channel in [0, 1].
    pub base_color: Vec3,
    /// Perceptual roughness in [0, 1]; GGX alpha is max(0.001, roughness^2).
    pub roughness: f32,
    /// Metalness in [0, 1].
    pub metallic: f32,
    /// Dielectric specular in [0, 1]; 0.5 means an index of refraction of 1.5.
    pub specular: f32,
    /// Texture of linear base colour (RGB), or [`INVALID`].
    pub base_texture: u32,
    /// Texture of roughness (G) and metallic (B), or [`INVALID`].
    pub roughness_metallic_texture: u32,
    /// Tangent-space normal map, stored as unit vectors scaled into [0, 1], or [`INVALID`].
    /// x points along dp/du, y along dp/dv (v upwards), z along the shading normal.
    pub normal_texture: u32,
}

impl Material {
    /// Ideal diffuse reflection, without textures.
    pub fn lambert(name: impl Into<String>, base_color: Vec3) -> Self {
        Self {
            name: name.into(),
            kind: MaterialKind::Lambert,
            base_color,
            roughness: 1.0,
            metallic: 0.0,
            specular: 0.0,
            base_texture: INVALID,
            roughness_metallic_texture: INVALID,
            normal_texture: INVALID,
        }
    }
}

/// A decoded picture, row-major from the top, three linear f32 channels a texel.
/// Looked up with wrap-around repetition and bilinear interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width * height` linear RGB texels.
    pub texels: Vec<Vec3>,
}

/// An isotropic point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World position.
    pub position: Vec3,
    /// Radiant intensity a channel [W/sr].
    pub intensity: Vec3,
}

/// The emission of a group of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Emitted radiance a channel [W/(sr m^2)].
    pub radiance: Vec3,
    /// Emits from the back of its triangles too. The front is the side that
    /// the triangle's geometric normal (p1-p0) x (p2-p0) points to.
    pub two_sided: bool,
}

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
    /// Full angle of the shorter image side [degrees].
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
    /// What was approximated or ignored, and how.
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
    /// Area light id of each triangle, or [`INVALID`].
    pub triangle_light: Vec<u32>,
    /// Object (shape of the file) id of each triangle.
    pub triangle_object: Vec<u32>,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// The file's own point lights.
    pub point_lights: Vec<PointLight>,
    /// The file's own area lights.
    pub area_lights: Vec<AreaLight>,
    /// Cameras, the first one the default.
    pub cameras: Vec<Camera>,
    /// What was approximated or left out.
    pub warnings: Vec<Warning>,
}
