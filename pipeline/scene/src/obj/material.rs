//! MTL materials mapped onto ours.

use super::library;
use super::model::{Model, Obj};
use super::mtl::Mtl;
use crate::file::read;
use crate::lost::LostPictures;
use crate::resolve;
use crate::texture::{Encoding, TextureTable, format_of};
use crate::warn::Warnings;
use crate::{INVALID, LoadOptions, Material, Scene, SceneError};
use glam::Vec3;
use rrf_materials::{Opacity, PRINCIPLED};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// A material as a model uses it.
#[derive(Clone, Copy)]
pub(super) struct MaterialUse {
    /// Id in the scene.
    pub(super) id: u32,
    /// Emitted radiance [W/(sr m^2)], black for none.
    pub(super) radiance: Vec3,
    /// Texture that multiplies it, or [`INVALID`].
    pub(super) emission_texture: u32,
    /// Needs texture coordinates.
    pub(super) is_textured: bool,
}

/// The file's libraries, and the materials that models use.
pub(super) struct Materials {
    library: Vec<Mtl>,
    folder: PathBuf,
    lost: LostPictures,
    default_albedo: f32,
    known: HashMap<Option<usize>, MaterialUse>,
    materials: Vec<Material>,
    textures: TextureTable<PathBuf>,
    without: usize,
}

impl Materials {
    /// Reads the libraries that the OBJ file `path` names. One that cannot be read is a
    /// warning, as is a material that none of them defines.
    pub(super) fn read(
        path: &Path,
        obj: &Obj,
        options: &LoadOptions,
        warnings: &mut Warnings,
    ) -> Result<Self, SceneError> {
        let library = library::read(path, &obj.libraries, warnings)?;
        let defined: HashSet<&str> = library.iter().map(|mtl| mtl.name.as_str()).collect();
        for (line, name) in &obj.materials {
            if !defined.contains(name.as_str()) {
                let message = format!("material {name:?} is not defined: the default serves");
                warnings.add(library::place(path, *line), message);
            }
        }
        Ok(Self {
            library,
            folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
            lost: LostPictures::default(),
            default_albedo: options.default_albedo,
            known: HashMap::new(),
            materials: Vec::new(),
            textures: TextureTable::new(),
            without: 0,
        })
    }

    /// Place in the libraries of a model's material; of equal names the last one counts.
    fn place_of(&self, model: &Model) -> Option<usize> {
        let name = model.material.as_ref()?;
        self.library.iter().rposition(|mtl| mtl.name == *name)
    }

    /// Whether two models have the same material, or both none that is defined.
    pub(super) fn agree(&self, a: &Model, b: &Model) -> bool {
        self.place_of(a) == self.place_of(b)
    }

    /// The material of a model of `triangles` triangles.
    pub(super) fn of_model(
        &mut self,
        model: &Model,
        triangles: usize,
        warnings: &mut Warnings,
    ) -> MaterialUse {
        let key = self.place_of(model);
        if key.is_none() {
            self.without += triangles;
        }
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let (material, (radiance, emission_texture)) =
            match key.and_then(|id| self.library.get(id)).cloned() {
                Some(mtl) => (self.convert(&mtl, warnings), self.radiance(&mtl, warnings)),
                None => (
                    Material::lambert("default", Vec3::splat(self.default_albedo)),
                    (Vec3::ZERO, INVALID),
                ),
            };
        let used = MaterialUse {
            id: self.materials.len() as u32,
            radiance,
            emission_texture,
            is_textured: [
                material.base_texture,
                material.normal_texture,
                material.opacity.texture,
                emission_texture,
            ]
            .iter()
            .any(|&id| id != INVALID),
        };
        self.materials.push(material);
        self.known.insert(key, used);
        used
    }

    /// A material's name.
    pub(super) fn name(&self, id: u32) -> &str {
        self.materials.get(id as usize).map_or("", |m| &m.name)
    }

    /// Moves everything into the scene.
    pub(super) fn finish(self, scene: &mut Scene, warnings: &mut Warnings) {
        if let Some(lost) = self.lost.warning(&scene.source, self.default_albedo) {
            warnings.add(lost.place, lost.message);
        }
        if self.without > 0 {
            let message = format!(
                "without material: Lambert, reflectance {}",
                self.default_albedo
            );
            warnings.add(format!("{} triangles", self.without), message);
        }
        scene.materials = self.materials;
        scene.textures = self.textures.into_textures();
    }

    /// Glass or a mirror where illum says so, Principled where Pr or Pm stand, else Lambert.
    fn convert(&mut self, mtl: &Mtl, warnings: &mut Warnings) -> Material {
        if let Some(glass) = glass(mtl, warnings) {
            return glass;
        }
        note_left_out(mtl, warnings);
        // A map without Kd stands alone.
        let none = if mtl.diffuse_map.is_some() {
            1.0
        } else {
            self.default_albedo
        };
        if mtl.diffuse.is_none() && mtl.diffuse_map.is_none() {
            warnings.add(&mtl.place, format!("no Kd: read as {none}"));
        }
        let mut colour = mtl.diffuse.unwrap_or(Vec3::splat(none));
        if colour == Vec3::ZERO && mtl.diffuse_map.is_some() {
            // Maya writes black beside a map, and means the map.
            warnings.add(
                &mtl.place,
                "Kd is black beside map_Kd: the map alone counts",
            );
            colour = Vec3::ONE;
        }
        let mut material = Material::lambert(&mtl.name, colour);
        if mtl.roughness.is_some() || mtl.metallic.is_some() {
            let index = index_of_refraction(mtl, warnings);
            let ratio = (index - 1.0) / (index + 1.0);
            material.kind = &PRINCIPLED;
            material.roughness = mtl.roughness.unwrap_or(0.5);
            material.metallic = mtl.metallic.unwrap_or(0.0);
            // F0 = ((n - 1) / (n + 1))^2 = 0.08 specular.
            material.specular = ratio * ratio / 0.08;
        }
        if is_mirror(mtl) {
            make_mirror(mtl, &mut material);
        }
        material.base_texture = self.texture(mtl, &mtl.diffuse_map, Encoding::Srgb, warnings);
        if mtl.diffuse_map.is_some() && material.base_texture == INVALID {
            material.base_color *= self.default_albedo;
        }
        material.opacity = Opacity {
            value: mtl.opacity.unwrap_or(1.0).clamp(0.0, 1.0),
            texture: self.texture(mtl, &mtl.opacity_map, Encoding::Linear, warnings),
            cutoff: None,
        };
        let normal = Encoding::Normal(1.0_f32.to_bits());
        material.normal_texture = self.texture(mtl, &mtl.normal_map, normal, warnings);
        material
    }

    /// Ke, and the texture of map_Ke. A map without Ke stands alone.
    fn radiance(&mut self, mtl: &Mtl, warnings: &mut Warnings) -> (Vec3, u32) {
        let none = if mtl.emission_map.is_some() {
            Vec3::ONE
        } else {
            Vec3::ZERO
        };
        let mut radiance = mtl.emission.unwrap_or(none);
        if radiance.min_element() < 0.0 {
            warnings.add(&mtl.place, "negative Ke is read as black");
            radiance = radiance.max(Vec3::ZERO);
        }
        if radiance == Vec3::ZERO {
            return (radiance, INVALID);
        }
        let message = "Ke is read as radiance from the front (counter-clockwise) side";
        warnings.add(&mtl.place, message);
        let Some(name) = &mtl.emission_map else {
            return (radiance, INVALID);
        };
        let file = self.picture(mtl, name, warnings);
        let picture = read(&file)
            .map_err(|error| error.to_string())
            .and_then(|bytes| {
                let (key, format) = (file.clone(), format_of(&file));
                self.textures
                    .insert_light(key, Encoding::Srgb, &bytes, format)
            });
        match picture {
            Ok((id, factor)) => (radiance * factor, id),
            Err(reason) => {
                self.lost.add(name, reason);
                (radiance, INVALID)
            }
        }
    }

    /// The file that a material's map means.
    fn picture(&self, mtl: &Mtl, name: &str, warnings: &mut Warnings) -> PathBuf {
        let found = resolve::find(&[&mtl.folder, &self.folder], name);
        if found.is_guess {
            let message = format!("{name} is read from {}", found.path.display());
            warnings.add(&mtl.place, message);
        }
        found.path
    }

    /// The texture's id; one that cannot be read is lost.
    fn texture(
        &mut self,
        mtl: &Mtl,
        name: &Option<String>,
        encoding: Encoding,
        warnings: &mut Warnings,
    ) -> u32 {
        let Some(name) = name else {
            return INVALID;
        };
        let file = self.picture(mtl, name, warnings);
        if let Some(id) = self.textures.get(file.clone(), encoding) {
            return id;
        }
        let texture = read(&file)
            .map_err(|error| error.to_string())
            .and_then(|bytes| {
                let key = file.clone();
                self.textures
                    .insert(key, encoding, &bytes, format_of(&file), |texel| texel)
            });
        texture.unwrap_or_else(|reason| {
            self.lost.add(name, reason);
            INVALID
        })
    }
}

/// Whether a material without Pr and Pm only reflects: black by Kd, with a mirror's model.
fn is_mirror(mtl: &Mtl) -> bool {
    let is_black = mtl.diffuse == Some(Vec3::ZERO) && mtl.diffuse_map.is_none();
    let plain = mtl.roughness.is_none() && mtl.metallic.is_none();
    is_black && plain && matches!(mtl.model, Some(3.0 | 5.0 | 8.0))
}

/// A mirror of reflectance Ks. Lobes of equal width: Phong's exponent n is a Beckmann roughness of
/// (2 / (n + 2))^½ (Walter et al. 2007), and that is the square of ours.
fn make_mirror(mtl: &Mtl, material: &mut Material) {
    let alpha = |n: f32| (2.0 / (n.max(0.0) + 2.0)).sqrt();
    material.kind = &PRINCIPLED;
    material.roughness = mtl.exponent.map_or(0.0, |n| alpha(n).sqrt());
    material.base_color = mtl.phong.unwrap_or(Vec3::ONE).clamp(Vec3::ZERO, Vec3::ONE);
    material.metallic = 1.0;
    material.specular = 0.5;
}

/// Ni, or 1.5 where it is none.
fn index_of_refraction(mtl: &Mtl, warnings: &mut Warnings) -> f32 {
    let index = mtl.index.unwrap_or(1.5);
    if index > 0.0 {
        return index;
    }
    let message = format!("Ni {index} is no index of refraction: read as 1.5");
    warnings.add(&mtl.place, message);
    1.5
}

/// Glass (illum 4, 6, 7, 9) by Ni and Tf.
fn glass(mtl: &Mtl, warnings: &mut Warnings) -> Option<Material> {
    let plain = mtl.roughness.is_none() && mtl.metallic.is_none();
    if !plain || !matches!(mtl.model, Some(4.0 | 6.0 | 7.0 | 9.0)) {
        return None;
    }
    let index = index_of_refraction(mtl, warnings);
    let tint = mtl.filter.unwrap_or(Vec3::ONE);
    Some(Material::dielectric(&mtl.name, index, tint, Vec3::ZERO))
}

fn note_left_out(mtl: &Mtl, warnings: &mut Warnings) {
    let is_principled = mtl.roughness.is_some() || mtl.metallic.is_some();
    if is_mirror(mtl) {
        return;
    }
    // Models 0 and 1 have no reflection, whatever Ks says.
    let reflects = mtl.model.is_none_or(|model| model >= 2.0);
    let phong = mtl.phong.is_some_and(|phong| phong != Vec3::ZERO);
    if phong && reflects && !is_principled {
        warnings.add(
            &mtl.place,
            "Phong reflection (Ks, Ns) left out: Lambert of Kd",
        );
    }
    if mtl.model == Some(0.0) {
        warnings.add(
            &mtl.place,
            "illum 0 (constant colour) is read as Lambert of Kd",
        );
    }
    if mtl.model.is_some_and(|model| model >= 3.0) && !is_principled {
        let message = "a mirror (illum 3, 5, 8) with Kd is read as Lambert of Kd";
        warnings.add(&mtl.place, message);
    }
    if mtl.opacity.is_some_and(|opacity| opacity < 1.0) {
        let message = "d below 1 is read as a veil: light passes it straight";
        warnings.add(&mtl.place, message);
    }
}
