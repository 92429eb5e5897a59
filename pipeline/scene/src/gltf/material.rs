//! Metallic-roughness materials.

use super::Output;
use super::buffers::read_uri;
use super::document::{Document, place};
use super::uv::{TextureUse, UvSource, leaves_repetition};
use crate::texture::{Encoding, TextureTable};
use crate::warn::Warnings;
use crate::{INVALID, LoadOptions, Material, MaterialKind, SceneError};
use ::gltf::json;
use ::gltf::json::Index;
use ::gltf::json::material::AlphaMode;
use ::gltf::json::texture::Texture;
use ::gltf::json::validation::Checked;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// What a primitive needs to know of its material.
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
    /// Emits from both sides.
    pub(super) double_sided: bool,
}

/// Materials and textures, read when a primitive first uses them.
pub(super) struct Materials<'a> {
    document: &'a Document<'a>,
    default_albedo: f32,
    known: HashMap<Option<usize>, MaterialUse>,
    materials: Vec<Material>,
    textures: TextureTable<usize>,
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
            textures: TextureTable::new(),
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
        output.scene.materials = self.materials;
        output.scene.textures = self.textures.into_textures();
    }

    fn default_material(&self) -> (Material, MaterialUse) {
        let material = Material {
            name: "default".into(),
            kind: MaterialKind::Lambert,
            base_color: Vec3::splat(self.default_albedo),
            roughness: 1.0,
            metallic: 0.0,
            specular: 0.0,
            base_texture: INVALID,
            roughness_metallic_texture: INVALID,
            normal_texture: INVALID,
        };
        let used = MaterialUse {
            id: INVALID,
            uv: None,
            leaves_repetition: false,
            bends_normals: false,
            radiance: Vec3::ZERO,
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
        let unit = |value, what| unit_interval(self.document, place, value, what);
        let (base_color, roughness, metallic) = (
            unit(Vec3::new(r, g, b), "baseColorFactor")?,
            unit(Vec3::splat(pbr.roughness_factor.0), "roughnessFactor")?.x,
            unit(Vec3::splat(pbr.metallic_factor.0), "metallicFactor")?.x,
        );
        let specular = specular(self.document, place, source, warnings)?;
        let material = Material {
            name: source.name.clone().unwrap_or_else(|| place.clone()),
            kind: MaterialKind::Principled,
            base_color,
            roughness,
            metallic,
            specular,
            base_texture: self.texture(base, Encoding::Srgb, place)?,
            roughness_metallic_texture: self.texture(mixed, Encoding::Linear, place)?,
            normal_texture: self.texture(normal, Encoding::Normal(scale.to_bits()), place)?,
        };
        let uses: Vec<TextureUse> = [base, mixed, normal].into_iter().flatten().collect();
        let used = MaterialUse {
            id: INVALID,
            uv: common_uv(&uses, place, warnings),
            leaves_repetition: uses
                .iter()
                .filter(|used| leaves_repetition(self.document, used.texture, place, warnings))
                .count()
                > 0,
            bends_normals: normal.is_some(),
            radiance: self.radiance(source, place, warnings)?,
            double_sided: source.double_sided,
        };
        Ok((material, used))
    }

    /// Radiance [W/(sr m^2)]: emissiveFactor * emissiveStrength, a texture by its mean.
    fn radiance(
        &self,
        source: &json::Material,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Vec3, SceneError> {
        let strength = source
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let mut radiance = Vec3::from_array(source.emissive_factor.0) * strength;
        if !radiance.is_finite() || radiance.min_element() < 0.0 {
            let message = format!("emission {radiance} must be finite and not negative");
            return Err(self.document.error(place, message));
        }
        if let Some(info) = source
            .emissive_texture
            .as_ref()
            .filter(|_| radiance != Vec3::ZERO)
        {
            let bytes = self.picture(info.index, place)?.1;
            radiance *= self
                .textures
                .mean(Encoding::Srgb, &bytes)
                .map_err(|message| self.document.error(place, message))?;
            let message = "emissive texture is replaced by its mean over the whole picture";
            warnings.add(place, message);
        }
        Ok(radiance)
    }

    fn texture(
        &mut self,
        used: Option<TextureUse>,
        encoding: Encoding,
        place: &str,
    ) -> Result<u32, SceneError> {
        let Some(used) = used else {
            return Ok(INVALID);
        };
        let image = self
            .document
            .root
            .get(used.texture)
            .map(|texture| texture.source);
        let known = image.and_then(|image| self.textures.get(image.value(), encoding));
        if let Some(id) = known {
            return Ok(id);
        }
        let (image, bytes) = self.picture(used.texture, place)?;
        self.textures
            .insert(image, encoding, &bytes)
            .map_err(|message| {
                let place = format!("{place}, image {image}");
                self.document.error(place, message)
            })
    }

    /// A texture's image id and the bytes of its picture file.
    fn picture(
        &self,
        texture: Index<Texture>,
        place: &str,
    ) -> Result<(usize, std::borrow::Cow<'a, [u8]>), SceneError> {
        let root = self.document.root;
        let wrong = |message: String| self.document.error(place, message);
        let texture = root.get(texture);
        let index = texture
            .map(|texture| texture.source)
            .ok_or_else(|| wrong("no such texture".into()))?;
        let image = root
            .get(index)
            .ok_or_else(|| wrong(format!("no image {index}")))?;
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => self
                .document
                .view_bytes(view)
                .map(std::borrow::Cow::Borrowed)
                .map_err(|message| wrong(format!("image {index}: {message}")))?,
            (None, Some(uri)) => {
                let place = || format!("{place}, image {index}");
                read_uri(self.document.path, uri, place)?.into()
            }
            (None, None) => return Err(wrong(format!("image {index} has no data"))),
        };
        Ok((index.value(), bytes))
    }
}

fn note_left_out(source: &json::Material, place: &str, warnings: &mut Warnings) {
    match source.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => warnings.add(place, "alpha mask is read as opaque"),
        Checked::Valid(AlphaMode::Blend) => warnings.add(place, "alpha blend is read as opaque"),
        _ => {}
    }
    if source.occlusion_texture.is_some() {
        let message = "occlusion texture left out: occlusion is computed from the geometry";
        warnings.add(place, message);
    }
}

/// The texture coordinates that all textures share, else the first one's.
fn common_uv(uses: &[TextureUse], place: &str, warnings: &mut Warnings) -> Option<UvSource> {
    let first = uses.first()?.uv;
    if uses.iter().any(|used| used.uv != first) {
        let message = "its textures use different texture coordinates; \
                       those of the first one are used for all";
        warnings.add(place, message);
    }
    Some(first)
}

/// Our `specular` from KHR_materials_ior and KHR_materials_specular.
///
/// F0 = ((ior - 1) / (ior + 1))^2 * colour * factor, and F0 = 0.08 specular in Mitsuba's
/// `principled`, whose eta = 2 / (1 - sqrt(0.08 specular)) - 1 has that reflectance.
fn specular(
    document: &Document,
    place: &str,
    source: &json::Material,
    warnings: &mut Warnings,
) -> Result<f32, SceneError> {
    let Some(extensions) = &source.extensions else {
        return Ok(0.5);
    };
    let ior = extensions.ior.as_ref().map_or(1.5, |ior| ior.ior.0);
    // The extension gives 0 the meaning of an infinite index.
    if !(ior >= 1.0 && ior.is_finite()) && ior != 0.0 {
        let message = format!("index of refraction {ior} must be 0 or at least 1");
        return Err(document.error(place, message));
    }
    let ratio = if ior == 0.0 {
        1.0
    } else {
        (ior - 1.0) / (ior + 1.0)
    };
    let mut f0 = ratio * ratio;
    if let Some(specular) = &extensions.specular {
        let colour = Vec3::from_array(specular.specular_color_factor.0);
        let factor = specular.specular_factor.0;
        let is_usable = colour.is_finite() && colour.min_element() >= 0.0;
        if !is_usable || !(0.0..=1.0).contains(&factor) {
            let message = "specularFactor must be in [0, 1], specularColorFactor not negative";
            return Err(document.error(place, message));
        }
        if colour.min_element() != colour.max_element() {
            warnings.add(
                place,
                "coloured specular reflection is read as its luminance",
            );
        }
        if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
            warnings.add(place, "specular textures left out: read as white");
        }
        if factor < 1.0 {
            let message = "specularFactor lowers the reflectance at normal incidence only, \
                           not at grazing angles";
            warnings.add(place, message);
        }
        // Rec. 709 luminance.
        let luminance = colour.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        f0 = (f0 * luminance).min(1.0) * factor;
    }
    if f0 > 0.08 {
        let message = format!("reflectance {f0} at normal incidence is read as 0.08, the most");
        warnings.add(place, message);
    }
    Ok((f0 / 0.08).min(1.0))
}

fn unit_interval(
    document: &Document,
    place: &str,
    value: Vec3,
    what: &str,
) -> Result<Vec3, SceneError> {
    if value.min_element() >= 0.0 && value.max_element() <= 1.0 {
        return Ok(value);
    }
    Err(document.error(place, format!("{what} {value} must be in [0, 1]")))
}

/// Whether all of the coordinates a material sees lie in the picture's first period.
pub(super) fn stays_in_picture(uvs: impl IntoIterator<Item = Vec2>) -> bool {
    // Exporters touch the edges with rounding errors.
    const SLACK: f32 = 1e-4;
    uvs.into_iter()
        .all(|uv| uv.min_element() >= -SLACK && uv.max_element() <= 1.0 + SLACK)
}
