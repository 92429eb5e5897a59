//! pbrt's materials as the nearest of ours. Those that have no exact counterpart come with a warning
//! that names what was approximated.

use super::fault::{Place, Read, fault};
use super::params::Params;
use super::reader::Reader;
use super::state::{Surface, Version};
use super::value::{Mapping, Value};
use crate::{INVALID, Material, MaterialKind};
use glam::Vec3;
use rrf_materials::{LAMBERT, Opacity, PRINCIPLED, Parameter};

/// A material on its way.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub kind: &'static MaterialKind,
    pub base: Value,
    pub roughness: f64,
    pub metallic: f64,
    pub specular: f64,
    /// Further parameters in the order of the kind's slots.
    pub own: Vec<Vec3>,
    /// Share of the surface that is there.
    pub opacity: f64,
    pub normal_texture: u32,
}

impl Draft {
    pub fn lambert(base: Value) -> Self {
        let kind = &LAMBERT;
        Self {
            kind,
            base,
            roughness: 1.0,
            metallic: 0.0,
            specular: 0.0,
            own: Vec::new(),
            opacity: 1.0,
            normal_texture: INVALID,
        }
    }

    pub fn dielectric(base: Value, roughness: f64, f0: f64) -> Self {
        let kind = &PRINCIPLED;
        let specular = f0 / 0.08;
        Self {
            kind,
            base,
            roughness,
            metallic: 0.0,
            specular,
            own: Vec::new(),
            opacity: 1.0,
            normal_texture: INVALID,
        }
    }

    /// One of our materials, with a texture in place of its base colour.
    pub fn of(material: &Material, base: Value) -> Self {
        Self {
            kind: material.kind,
            base,
            roughness: f64::from(material.roughness),
            metallic: f64::from(material.metallic),
            specular: f64::from(material.specular),
            own: material.own.iter().map(|p| p.value).collect(),
            opacity: f64::from(material.opacity.value),
            normal_texture: INVALID,
        }
    }
}

impl Reader {
    /// `Material "type"`.
    pub fn material_directive(&mut self, kind: &str, at: Place, params: &Params) -> Read<()> {
        self.state.surface = self.surface(kind, None, at, params)?;
        Ok(())
    }

    /// `MakeNamedMaterial "name" "string type" "..."`.
    pub fn make_named_material(&mut self, name: String, at: Place, params: &Params) -> Read<()> {
        let Some(kind) = params.string("type")? else {
            return fault(
                at,
                format!("MakeNamedMaterial \"{name}\" needs \"string type\""),
            );
        };
        let surface = self.surface(kind, Some(&name), at, params)?;
        self.materials.insert(name, surface);
        Ok(())
    }

    /// The material of the next shapes, filled with the medium in force; where a file gives none,
    /// pbrt's: Lambert 0.5.
    pub fn material_of(&mut self, surface: Surface) -> Option<u32> {
        let id = match surface {
            Surface::Interface => None,
            Surface::Material(id) => Some(id),
            Surface::Default => {
                if self.default_surface.is_none() {
                    let draft = Draft::lambert(Value::grey(0.5));
                    self.default_surface = self.add_material("default".to_owned(), &draft).ok();
                }
                self.default_surface
            }
        };
        id.map(|id| self.filled(id))
    }

    fn surface(
        &mut self,
        kind: &str,
        name: Option<&str>,
        at: Place,
        params: &Params,
    ) -> Read<Surface> {
        const V3: [&str; 10] = [
            "matte",
            "plastic",
            "metal",
            "glass",
            "mirror",
            "uber",
            "substrate",
            "translucent",
            "disney",
            "kdsubsurface",
        ];
        const V4: [&str; 8] = [
            "diffuse",
            "coateddiffuse",
            "coatedconductor",
            "conductor",
            "dielectric",
            "thindielectric",
            "diffusetransmission",
            "measured",
        ];
        if V3.contains(&kind) {
            self.sees(Version::V3);
        } else if V4.contains(&kind) {
            self.sees(Version::V4);
        }
        if matches!(kind, "" | "none" | "interface") {
            return Ok(Surface::Interface);
        }
        let Some((mut draft, note)) = self.draft(kind, params, at)? else {
            return fault(at, format!("unknown material \"{kind}\""));
        };
        let label = match name {
            Some(name) => format!("material \"{name}\" ({kind})"),
            None => format!("material {kind}"),
        };
        if let Some(note) = note {
            self.warn(params.place, format!("{label} is approximated: {note}"));
        }
        if draft.specular > 1.0 {
            self.warn(
                params.place,
                format!(
                    "{label}: reflectance {:.3} at normal incidence is lowered to 0.08",
                    0.08 * draft.specular
                ),
            );
            draft.specular = 1.0;
        }
        self.bumps(&mut draft, params, &label)?;
        self.check_unused(params)?;
        let name = name.map_or_else(|| kind.to_owned(), str::to_owned);
        match self.add_material(name, &draft) {
            Ok(id) => Ok(Surface::Material(id)),
            Err(message) => fault(params.place, message),
        }
    }

    /// Normal maps are kept; bump and displacement maps are left out.
    fn bumps(&mut self, draft: &mut Draft, params: &Params, label: &str) -> Read<()> {
        for name in ["bumpmap", "displacement"] {
            if let Some(place) = params.place_of(name) {
                self.warn(place, format!("{label}: \"{name}\" is left out"));
            }
        }
        if let Some(file) = params.string("normalmap")? {
            let place = super::colour::place_of(params, "normalmap");
            draft.normal_texture = self.linear_picture(file, place)?.unwrap_or(INVALID);
        }
        Ok(())
    }

    /// Adds a material, or finds the same one made before.
    fn add_material(&mut self, name: String, draft: &Draft) -> Result<u32, String> {
        let (mut base_color, mut base_texture, map) = match draft.base {
            Value::Constant(colour) => (colour.as_vec3(), INVALID, Mapping::IDENTITY),
            Value::Picture { id, scale, map } => (scale.as_vec3(), id, map),
        };
        if base_texture != INVALID && base_color.max_element() > 1.0 {
            base_texture = self.pictures.scaled(base_texture, base_color)?;
            base_color = Vec3::ONE;
        }
        let material = Material {
            kind: draft.kind,
            roughness: draft.roughness as f32,
            metallic: draft.metallic as f32,
            specular: draft.specular as f32,
            own: draft.own.iter().map(|&value| own(value)).collect(),
            opacity: Opacity {
                value: draft.opacity as f32,
                ..Opacity::OPAQUE
            },
            base_texture,
            normal_texture: draft.normal_texture,
            ..Material::lambert(name, base_color)
        };
        Ok(self.store_material(material, map))
    }

    /// The id of a material, new or made before.
    pub fn store_material(&mut self, material: Material, map: Mapping) -> u32 {
        let next = self.scene.materials.len() as u32;
        let key = format!("{material:?} {map:?}");
        let id = *self.known_materials.entry(key).or_insert(next);
        if id == next {
            self.scene.materials.push(material);
            self.material_maps.push(map);
        }
        id
    }
}

/// A further parameter without a texture.
fn own(value: Vec3) -> Parameter {
    Parameter {
        value,
        texture: INVALID,
    }
}
