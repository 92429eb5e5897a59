//! Metallic-roughness materials.

use super::document::{Document, place};
use super::layers::{layered, opacity};
use super::output::Output;
use super::picture::Pictures;
use super::specular::specular;
use super::uv::{TextureUse, UvSource, common_uv, leaves_repetition};
use crate::texture::Encoding;
use crate::warn::Warnings;
use crate::{INVALID, LoadOptions, Material, SceneError};
use ::gltf::json;
use ::gltf::json::Index;
use ::gltf::json::material::AlphaMode;
use ::gltf::json::validation::Checked;
use glam::Vec3;
use std::collections::HashMap;

/// A material as a primitive uses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaterialUse {
    /// Id in the scene.
    pub(super) id: u32,
    /// Texture coordinates for all its textures; `None` without textures.
    pub(super) uv: Option<UvSource>,
    /// A texture clamps or mirrors beyond [0, 1].
    pub(super) leaves_repetition: bool,
    /// Has a normal map.
    pub(super) bends_normals: bool,
    /// Emitted radiance [W/(sr m^2)], black for none.
    pub(super) radiance: Vec3,
    /// Texture that multiplies it, or [`INVALID`].
    pub(super) emission_texture: u32,
    /// Emits from both sides.
    pub(super) double_sided: bool,
}

/// Materials and textures, read when a primitive first uses them.
pub(super) struct Materials<'a> {
    document: &'a Document<'a>,
    default_albedo: f32,
    known: HashMap<Option<usize>, MaterialUse>,
    materials: Vec<Material>,
    pictures: Pictures<'a>,
    without: usize,
}

impl<'a> Materials<'a> {
    /// None yet.
    pub(super) fn new(document: &'a Document<'a>, options: &LoadOptions) -> Self {
        Self {
            document,
            default_albedo: options.default_albedo,
            known: HashMap::new(),
            materials: Vec::new(),
            pictures: Pictures::new(document),
            without: 0,
        }
    }

    /// The material of a primitive.
    pub(super) fn of_primitive(
        &mut self,
        index: Option<Index<json::Material>>,
        warnings: &mut Warnings,
    ) -> Result<MaterialUse, SceneError> {
        let key = index.map(|index| index.value());
        self.without += usize::from(key.is_none());
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let source = index.and_then(|index| self.document.root.get(index));
        let (material, mut used) = match (key, source) {
            (Some(index), Some(source)) => self.read(index, source, warnings)?,
            _ => self.default_material(),
        };
        used.id = self.materials.len() as u32;
        self.materials.push(material);
        self.known.insert(key, used);
        Ok(used)
    }

    /// A material's name.
    pub(super) fn name(&self, id: u32) -> &str {
        self.materials.get(id as usize).map_or("", |m| &m.name)
    }

    /// Moves everything into the scene.
    pub(super) fn finish(self, output: &mut Output) {
        if self.without > 0 {
            let message = format!(
                "without material: Lambert, reflectance {}",
                self.default_albedo
            );
            let place = format!("{} primitives", self.without);
            output.warnings.add(place, message);
        }
        let lost = &self.pictures.lost;
        if let Some(lost) = lost.warning(self.document.path, self.default_albedo) {
            output.warnings.add(lost.place, lost.message);
        }
        output.scene.materials = self.materials;
        output.scene.textures = self.pictures.into_textures();
    }

    fn default_material(&self) -> (Material, MaterialUse) {
        let material = Material::lambert("default", Vec3::splat(self.default_albedo));
        let used = MaterialUse {
            id: INVALID,
            uv: None,
            leaves_repetition: false,
            bends_normals: false,
            radiance: Vec3::ZERO,
            emission_texture: INVALID,
            double_sided: true,
        };
        (material, used)
    }

    fn read(
        &mut self,
        index: usize,
        source: &json::Material,
        warnings: &mut Warnings,
    ) -> Result<(Material, MaterialUse), SceneError> {
        let place = &place("material", index, source.name.as_deref());
        note_left_out(source, place, warnings);
        let pbr = &source.pbr_metallic_roughness;
        let base = pbr.base_color_texture.as_ref().map(TextureUse::of);
        let mixed = pbr.metallic_roughness_texture.as_ref().map(TextureUse::of);
        let normal = source.normal_texture.as_ref().map(TextureUse::of_normal);
        let normal = normal
            .transpose()
            .map_err(|message| self.document.error(place, message))?;
        let scale = source
            .normal_texture
            .as_ref()
            .map_or(1.0, |normal| normal.scale);
        let [r, g, b, _] = pbr.base_color_factor.0;
        let pictures = &mut self.pictures;
        let specular = specular(self.document, place, source, warnings)?;
        let name = source.name.clone().unwrap_or_else(|| place.clone());
        let (roughness, metallic) = (pbr.roughness_factor.0, pbr.metallic_factor.0);
        let mut material = Material {
            base_texture: pictures.texture(base, Encoding::Srgb, place)?,
            roughness_metallic_texture: pictures.texture(mixed, Encoding::Linear, place)?,
            normal_texture: pictures.texture(normal, Encoding::Normal(scale.to_bits()), place)?,
            ..Material::principled(name, Vec3::new(r, g, b), roughness, metallic, specular)
        };
        if base.is_some() && material.base_texture == INVALID {
            material.base_color *= self.default_albedo;
        }
        if mixed.is_some() && material.roughness_metallic_texture == INVALID {
            // The factor is 1 where a map says which texels are metal: without it, none is.
            material.metallic = 0.0;
        }
        let mut material = layered(self.document, place, source, material, warnings)?;
        let alpha = base.filter(|_| source.alpha_mode != Checked::Valid(AlphaMode::Opaque));
        let alpha = self.pictures.texture(alpha, Encoding::Alpha, place)?;
        let opacity = opacity(source, place, alpha, warnings);
        if opacity.lets_through() {
            material.opacity = opacity;
        }
        let radiance = self.radiance(source, place)?;
        let shining = source.emissive_texture.as_ref().map(TextureUse::of);
        let shining = shining.filter(|_| radiance != Vec3::ZERO);
        let (emission_texture, factor) = self.pictures.light(shining, place)?;
        let uses = [base, mixed, normal, shining].into_iter().flatten();
        let uses: Vec<TextureUse> = uses.collect();
        let used = MaterialUse {
            id: INVALID,
            uv: common_uv(&uses, place, warnings),
            leaves_repetition: uses
                .iter()
                .filter(|used| leaves_repetition(self.document, used.texture, place, warnings))
                .count()
                > 0,
            bends_normals: normal.is_some(),
            radiance: radiance * factor,
            emission_texture,
            double_sided: source.double_sided,
        };
        Ok((material, used))
    }

    /// Radiance [W/(sr m^2)]: emissiveFactor * emissiveStrength.
    fn radiance(&self, source: &json::Material, place: &str) -> Result<Vec3, SceneError> {
        let strength = source
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let radiance = Vec3::from_array(source.emissive_factor.0) * strength;
        if !radiance.is_finite() || radiance.min_element() < 0.0 {
            let message = format!("emission {radiance} must be finite and not negative");
            return Err(self.document.error(place, message));
        }
        Ok(radiance)
    }
}

fn note_left_out(source: &json::Material, place: &str, warnings: &mut Warnings) {
    if source.occlusion_texture.is_some() {
        let message = "occlusion texture left out: occlusion is computed from the geometry";
        warnings.add(place, message);
    }
}
