//! Summary of a scene file, for people and for programs.

use crate::measure::areas_by;
use crate::{Bounds, INVALID, Material, OwnLight, Scene, Warning};
use glam::DVec3;
use rrf_materials::Storage;
use serde::Serialize;
use std::collections::BTreeMap;

/// Output of `rrf scene`. Lengths are in scene units, areas in their square.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The file.
    pub file: String,
    /// [`Scene::hash_hex`].
    pub hash: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Area of all triangles, one side.
    pub area: f64,
    /// Box around all triangles.
    pub bounds: Option<Bounds>,
    /// Materials by id.
    pub materials: Vec<MaterialSummary>,
    /// Textures by id.
    pub textures: Vec<TextureSummary>,
    /// Objects by id.
    pub objects: Vec<ObjectSummary>,
    /// The file's own lights that are no surface.
    pub lights: Vec<LightSummary>,
    /// The file's area lights.
    pub area_lights: Vec<AreaLightSummary>,
    /// Cameras, the first the default.
    pub cameras: Vec<CameraSummary>,
    /// Approximations and omissions.
    pub warnings: Vec<Warning>,
}

/// A material and how much of it there is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialSummary {
    /// Name in the file.
    pub name: String,
    /// Its kind's name.
    pub kind: &'static str,
    /// Linear sRGB.
    pub base_color: [f32; 3],
    /// Perceptual roughness; `None` where its kind has none, as the next two.
    pub roughness: Option<f32>,
    /// Metalness.
    pub metallic: Option<f32>,
    /// Dielectric specular.
    pub specular: Option<f32>,
    /// Further parameters by name: one number, or three of a colour.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub own: BTreeMap<&'static str, Vec<f32>>,
    /// Texture ids: base colour, roughness and metallic, normal.
    pub textures: [Option<u32>; 3],
    /// Number of triangles.
    pub triangles: u64,
    /// Their area.
    pub area: f64,
}

/// A texture's size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureSummary {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
}

/// An object and its size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectSummary {
    /// Name.
    pub name: String,
    /// Number of triangles.
    pub triangles: u64,
    /// Their area.
    pub area: f64,
}

/// A light that is no surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightSummary {
    /// Name, unique in the scene.
    pub name: String,
    /// Its kind's name.
    pub kind: &'static str,
    /// Its numbers with units.
    pub summary: String,
    /// Radiant power \[W\]; of a light from afar, all that it sends through the sphere around the
    /// scene's bounds.
    pub power: [f32; 3],
}

/// An area light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AreaLightSummary {
    /// Name of the own light that it is part of.
    pub name: String,
    /// Radiance [W/(sr m^2)].
    pub radiance: [f32; 3],
    /// Emits from both sides.
    pub two_sided: bool,
    /// Number of triangles.
    pub triangles: u64,
    /// Their area, one side.
    pub area: f64,
    /// Radiant power pi * area * radiance, twice for two sides \[W\].
    pub power: [f64; 3],
    /// Texture that multiplies the radiance.
    pub texture: Option<u32>,
}

/// A camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraSummary {
    /// Name.
    pub name: String,
    /// World position of the eye.
    pub eye: [f32; 3],
    /// Unit viewing direction.
    pub forward: [f32; 3],
    /// Unit up direction.
    pub up: [f32; 3],
    /// The picture is a mirror image of the world: its right is against forward x up.
    pub mirrored: bool,
    /// Full angle of the shorter side \[degrees\].
    pub fov: f32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Scene {
    /// Summarises what was understood of the file.
    pub fn summary(&self) -> Summary {
        let objects = areas_by(self, &self.triangle_object, self.objects.len());
        Summary {
            file: self.source.display().to_string(),
            hash: self.hash_hex(),
            triangles: self.triangles.len(),
            vertices: self.positions.len(),
            area: (0..self.triangles.len())
                .map(|i| self.triangle_area(i))
                .sum(),
            bounds: self.bounds(),
            materials: self.material_summaries(),
            textures: self
                .textures
                .iter()
                .map(|t| TextureSummary {
                    width: t.width,
                    height: t.height,
                })
                .collect(),
            objects: self
                .objects
                .iter()
                .zip(objects)
                .map(|(name, (triangles, area))| ObjectSummary {
                    name: name.clone(),
                    triangles,
                    area,
                })
                .collect(),
            lights: self.light_summaries(),
            area_lights: self.area_light_summaries(),
            cameras: self.camera_summaries(),
            warnings: self.warnings.clone(),
        }
    }

    fn material_summaries(&self) -> Vec<MaterialSummary> {
        let areas = areas_by(self, &self.triangle_material, self.materials.len());
        let materials = self.materials.iter().zip(areas);
        materials.map(|(m, of)| material_summary(m, of)).collect()
    }

    fn light_summaries(&self) -> Vec<LightSummary> {
        let radius = self.bounds().map_or(0.0, |b| 0.5 * b.diagonal());
        let summary = |light: &OwnLight| LightSummary {
            name: light.name.clone(),
            kind: light.source.kind(),
            summary: light.source.summary(),
            power: light.source.power(radius).to_array(),
        };
        self.lights.iter().map(summary).collect()
    }

    fn area_light_summaries(&self) -> Vec<AreaLightSummary> {
        let areas = areas_by(self, &self.triangle_light, self.area_lights.len());
        let shining = self.shining_areas();
        self.area_lights
            .iter()
            .zip(&self.area_light_names)
            .zip(areas)
            .zip(shining)
            .zip(0..)
            .map(
                |((((light, name), (triangles, area)), (_, shining)), id)| AreaLightSummary {
                    name: name.clone(),
                    radiance: light.radiance.to_array(),
                    two_sided: light.two_sided,
                    triangles,
                    area,
                    power: (DVec3::from(light.power(1.0)) * shining).to_array(),
                    texture: self
                        .area_light_textures
                        .get(id)
                        .copied()
                        .filter(|&id| id != INVALID),
                },
            )
            .collect()
    }

    fn camera_summaries(&self) -> Vec<CameraSummary> {
        self.cameras
            .iter()
            .map(|camera| CameraSummary {
                name: camera.name.clone(),
                eye: camera.eye.to_array(),
                forward: camera.forward.to_array(),
                up: camera.up.to_array(),
                mirrored: camera.forward.cross(camera.up).dot(camera.right) < 0.0,
                fov: camera.fov,
                width: camera.width,
                height: camera.height,
            })
            .collect()
    }
}

fn material_summary(material: &Material, (triangles, area): (u64, f64)) -> MaterialSummary {
    let entry = material.kind;
    let own = material.parameters().filter_map(|p| {
        let numbers = p.value.to_array()[..p.width].to_vec();
        matches!(p.slot.storage, Storage::Own { .. }).then_some((p.slot.name, numbers))
    });
    MaterialSummary {
        name: material.name.clone(),
        kind: entry.name,
        base_color: material.base_color.to_array(),
        roughness: entry.has(Storage::Roughness).then_some(material.roughness),
        metallic: entry.has(Storage::Metallic).then_some(material.metallic),
        specular: entry.has(Storage::Specular).then_some(material.specular),
        own: own.collect(),
        textures: material.textures().map(|id| (id != INVALID).then_some(id)),
        triangles,
        area,
    }
}
