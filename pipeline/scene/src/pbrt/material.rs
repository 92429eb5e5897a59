//! pbrt's materials as the nearest of ours: Lambert, or Principled with base colour,
//! roughness, metallic and specular. All but `matte` and `diffuse` come with a warning that
//! names what was approximated.
//!
//! **Roughness.** Ours has GGX alpha = roughness^2. pbrt's `roughness` is alpha itself where
//! `remaproughness` is false; where it is true (the default) version 3 has the polynomial
//! alpha = 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 of
//! x = ln(max(roughness, 0.001)), and version 4 has alpha = sqrt(roughness). Ours is then
//! sqrt(alpha), at most 1. `disney` has our own convention already.
//!
//! **Specular.** Ours has the normal-incidence reflectance F0 = 0.08 specular; an index eta
//! has F0 = ((eta-1)/(eta+1))^2.

use super::fault::{Place, Read, fault};
use super::metal::{copper, normal_reflectance};
use super::params::Params;
use super::reader::Reader;
use super::state::{Surface, Version};
use super::texture::{Mapping, Value};
use crate::{INVALID, Material, MaterialKind};
use glam::{DVec3, Vec3};

/// A material on its way.
#[derive(Clone, Debug)]
struct Draft {
    kind: MaterialKind,
    base: Value,
    roughness: f64,
    metallic: f64,
    specular: f64,
    normal_texture: u32,
}

impl Draft {
    fn lambert(base: Value) -> Self {
        let kind = MaterialKind::Lambert;
        Self {
            kind,
            base,
            roughness: 1.0,
            metallic: 0.0,
            specular: 0.0,
            normal_texture: INVALID,
        }
    }

    fn dielectric(base: Value, roughness: f64, f0: f64) -> Self {
        let kind = MaterialKind::Principled;
        let specular = f0 / 0.08;
        Self {
            kind,
            base,
            roughness,
            metallic: 0.0,
            specular,
            normal_texture: INVALID,
        }
    }

    fn metal(base: Value, roughness: f64) -> Self {
        let kind = MaterialKind::Principled;
        Self {
            kind,
            base,
            roughness,
            metallic: 1.0,
            specular: 0.5,
            normal_texture: INVALID,
        }
    }
}

/// Reflectance at normal incidence between vacuum and a dielectric.
fn f0_of(eta: f64) -> f64 {
    ((eta - 1.0) / (eta + 1.0)).powi(2)
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

    /// pbrt's material where a file gives none: Lambert 0.5.
    pub fn material_of(&mut self, surface: Surface) -> Option<u32> {
        match surface {
            Surface::Interface => None,
            Surface::Material(id) => Some(id),
            Surface::Default => {
                if self.default_surface.is_none() {
                    let draft = Draft::lambert(Value::grey(0.5));
                    self.default_surface = self.add_material("default".to_owned(), &draft).ok();
                }
                self.default_surface
            }
        }
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

    /// The draft of a material and what about it is approximated; `None` for an unknown one.
    fn draft(
        &mut self,
        kind: &str,
        params: &Params,
        at: Place,
    ) -> Read<Option<(Draft, Option<String>)>> {
        params.ignore(&["type"]);
        let exact = |draft| (draft, None);
        let near = |draft, note: &str| (draft, Some(note.to_owned()));
        Ok(Some(match kind {
            "matte" => {
                let base = self.value_or(params, "Kd", 0.5)?;
                match self.float_texture(params, "sigma")?.unwrap_or(0.0) {
                    0.0 => exact(Draft::lambert(base)),
                    sigma => near(
                        Draft::lambert(base),
                        &format!("Oren-Nayar with sigma {sigma} by Lambert"),
                    ),
                }
            }
            "diffuse" => exact(Draft::lambert(self.value_or(params, "reflectance", 0.5)?)),
            "plastic" => self.plastic(params)?,
            "uber" => self.uber(params)?,
            "substrate" => self.substrate(params)?,
            "translucent" => self.translucent(params)?,
            "coateddiffuse" => self.coated_diffuse(params)?,
            "metal" | "conductor" => {
                let default = if kind == "metal" { 0.01 } else { 0.0 };
                near(
                    self.metal(params, "", default)?,
                    "metal by Principled, metallic 1, with Schlick's Fresnel term",
                )
            }
            "coatedconductor" => {
                params.ignore(&[
                    "thickness",
                    "maxdepth",
                    "nsamples",
                    "g",
                    "albedo",
                    "interface.eta",
                    "interface.roughness",
                    "interface.uroughness",
                    "interface.vroughness",
                ]);
                near(
                    self.metal(params, "conductor.", 0.0)?,
                    "coated metal by Principled, metallic 1, without its coat",
                )
            }
            "mirror" => {
                let base = self.value_or(params, "Kr", 0.9)?;
                near(
                    Draft::metal(base, 0.0),
                    "mirror by Principled, metallic 1, GGX alpha 0.001, with Schlick's Fresnel term",
                )
            }
            "glass" | "dielectric" | "thindielectric" => self.glass(params)?,
            "disney" => self.disney(params)?,
            "mix" => self.mix(params, at)?,
            "diffusetransmission" => {
                params.ignore(&["transmittance"]);
                let base = self.value_or(params, "reflectance", 0.25)?;
                let scale = Value::grey(params.float("scale")?.unwrap_or(1.0));
                near(
                    Draft::lambert(self.times(base, scale)),
                    "transmitting diffuser by Lambert; what it transmits is lost",
                )
            }
            "subsurface" | "kdsubsurface" | "hair" | "measured" | "fourier" => {
                self.by_albedo(kind, params)?
            }
            _ => return Ok(None),
        }))
    }

    fn plastic(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        let base = self.value_or(params, "Kd", 0.25)?;
        let f0 = self.grey(params, "Ks", 0.25)? * f0_of(1.5);
        let roughness = self.roughness(params, "", 0.1)?;
        let note = "plastic by Principled; a coloured Ks by its mean";
        Ok((
            Draft::dielectric(base, roughness, f0),
            Some(note.to_owned()),
        ))
    }

    fn uber(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        let base = self.value_or(params, "Kd", 0.25)?;
        let eta = self.eta(params, &["eta", "index"])?;
        let f0 = self.grey(params, "Ks", 0.25)? * f0_of(eta);
        let roughness = self.roughness(params, "", 0.1)?;
        let mut note = "uber by Principled; a coloured Ks by its mean".to_owned();
        for (name, full) in [("Kr", 0.0), ("Kt", 0.0), ("opacity", 1.0)] {
            if self.grey(params, name, full)? != full {
                note.push_str(&format!("; {name} is left out"));
            }
        }
        Ok((Draft::dielectric(base, roughness, f0), Some(note)))
    }

    fn substrate(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        let base = self.value_or(params, "Kd", 0.5)?;
        let f0 = self.grey(params, "Ks", 0.5)?;
        let roughness = self.roughness(params, "", 0.1)?;
        let note = "Ashikhmin-Shirley substrate by Principled; a coloured Ks by its mean";
        Ok((
            Draft::dielectric(base, roughness, f0),
            Some(note.to_owned()),
        ))
    }

    fn translucent(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        let base = self.value_or(params, "Kd", 0.25)?;
        let reflect = self.value_or(params, "reflect", 0.5)?;
        let reflected = self.mean(reflect).element_sum() / 3.0;
        let f0 = self.grey(params, "Ks", 0.25)? * reflected * f0_of(1.5);
        let roughness = self.roughness(params, "", 0.1)?;
        params.ignore(&["transmit"]);
        let note = "translucent by Principled; what it transmits is lost";
        Ok((
            Draft::dielectric(self.times(base, reflect), roughness, f0),
            Some(note.to_owned()),
        ))
    }

    fn coated_diffuse(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        params.ignore(&[
            "thickness",
            "maxdepth",
            "nsamples",
            "twosided",
            "g",
            "albedo",
        ]);
        let base = self.value_or(params, "reflectance", 0.5)?;
        let f0 = f0_of(self.eta(params, &["eta"])?);
        let roughness = self.roughness(params, "", 0.0)?;
        let note = "coated diffuser by Principled; light is not scattered between its layers";
        Ok((
            Draft::dielectric(base, roughness, f0),
            Some(note.to_owned()),
        ))
    }

    /// Clear materials reflect as they do in pbrt and absorb the rest.
    fn glass(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        params.ignore(&["Kt"]);
        let f0 = f0_of(self.eta(params, &["eta", "index"])?) * self.grey(params, "Kr", 1.0)?;
        let roughness = self.roughness(params, "", 0.0)?;
        let note = "glass by a black Principled: its reflection alone; what it transmits is lost";
        Ok((
            Draft::dielectric(Value::grey(0.0), roughness, f0),
            Some(note.to_owned()),
        ))
    }

    fn metal(&mut self, params: &Params, prefix: &str, default_roughness: f64) -> Read<Draft> {
        let name = |stem: &str| format!("{prefix}{stem}");
        let base = if let Some(reflectance) = self.value(params, "reflectance")? {
            reflectance
        } else {
            let (copper_eta, copper_k) = copper();
            let eta = self.index(params, &name("eta"))?.unwrap_or(copper_eta);
            let k = self.index(params, &name("k"))?.unwrap_or(copper_k);
            Value::Constant(normal_reflectance(&eta, &k).clamp(DVec3::ZERO, DVec3::ONE))
        };
        Ok(Draft::metal(
            base,
            self.roughness(params, prefix, default_roughness)?,
        ))
    }

    fn disney(&mut self, params: &Params) -> Read<(Draft, Option<String>)> {
        let base = self.value_or(params, "color", 0.5)?;
        let mut draft = Draft::dielectric(base, 0.0, f0_of(self.eta(params, &["eta"])?));
        draft.roughness = self.float_texture(params, "roughness")?.unwrap_or(0.5);
        draft.metallic = self.float_texture(params, "metallic")?.unwrap_or(0.0);
        let mut note = "disney by Principled".to_owned();
        for name in [
            "anisotropic",
            "clearcoat",
            "difftrans",
            "flatness",
            "sheen",
            "spectrans",
            "speculartint",
        ] {
            if self.float_texture(params, name)?.unwrap_or(0.0) != 0.0 {
                note.push_str(&format!("; {name} is left out"));
            }
        }
        params.ignore(&["clearcoatgloss", "sheentint", "scatterdistance", "thin"]);
        Ok((draft, Some(note)))
    }

    /// Materials without a counterpart: Lambert with the reflectance that they state.
    fn by_albedo(&mut self, kind: &str, params: &Params) -> Read<(Draft, Option<String>)> {
        params.ignore(&[
            "name",
            "sigma_a",
            "sigma_s",
            "sigma_prime_s",
            "mfp",
            "scale",
            "eta",
            "g",
            "Kr",
            "Kt",
            "roughness",
            "uroughness",
            "vroughness",
            "remaproughness",
            "eumelanin",
            "pheomelanin",
            "beta_m",
            "beta_n",
            "alpha",
            "filename",
            "bsdffile",
        ]);
        let mut base = None;
        for name in ["reflectance", "color", "Kd"] {
            base = base.or(self.value(params, name)?);
        }
        let by = if base.is_some() {
            "Lambert of its colour"
        } else {
            "Lambert 0.5"
        };
        let base = base.unwrap_or(Value::grey(0.5));
        Ok((Draft::lambert(base), Some(format!("{kind} by {by}"))))
    }

    /// `mix`: version 3's `amount` weighs the first material, version 4's the second.
    fn mix(&mut self, params: &Params, at: Place) -> Read<(Draft, Option<String>)> {
        let amount = match self.value(params, "amount")? {
            Some(amount) => self.mean(amount).element_sum() / 3.0,
            None => 0.5,
        };
        let (names, second) = match params.strings("materials")? {
            Some(names) => (names.to_vec(), amount),
            None => {
                let name = |which: &str| Ok(params.string(which)?.unwrap_or_default().to_owned());
                (
                    vec![name("namedmaterial1")?, name("namedmaterial2")?],
                    1.0 - amount,
                )
            }
        };
        let [a, b] = names.as_slice() else {
            return fault(at, "mix needs two materials");
        };
        let (a, b) = (self.known_draft(a, at)?, self.known_draft(b, at)?);
        let t = second.clamp(0.0, 1.0);
        let lerp = |a: f64, b: f64| a + (b - a) * t;
        let kind = if a.kind == b.kind {
            a.kind
        } else {
            MaterialKind::Principled
        };
        let base = self.mean(a.base).lerp(self.mean(b.base), t);
        let draft = Draft {
            kind,
            base: Value::Constant(base),
            roughness: lerp(a.roughness, b.roughness),
            metallic: lerp(a.metallic, b.metallic),
            specular: lerp(a.specular, b.specular),
            normal_texture: INVALID,
        };
        let exact = kind == MaterialKind::Lambert;
        let note = "mix by one material with mixed parameters; pictures by their means";
        Ok((draft, (!exact).then(|| note.to_owned())))
    }

    /// A named material once more as a draft.
    fn known_draft(&self, name: &str, at: Place) -> Read<Draft> {
        let id = match self.materials.get(name) {
            Some(Surface::Material(id)) => *id,
            Some(_) => {
                return fault(
                    at,
                    format!("mix cannot take \"{name}\", which has no surface"),
                );
            }
            None => return fault(at, format!("no material \"{name}\" is known")),
        };
        let Some(material) = self.scene.materials.get(id as usize) else {
            return fault(at, format!("no material \"{name}\" is known"));
        };
        let scale = material.base_color.as_dvec3();
        Ok(Draft {
            kind: material.kind,
            base: match material.base_texture {
                INVALID => Value::Constant(scale),
                id => Value::Picture {
                    id,
                    scale,
                    map: Mapping::IDENTITY,
                },
            },
            roughness: f64::from(material.roughness),
            metallic: f64::from(material.metallic),
            specular: f64::from(material.specular),
            normal_texture: INVALID,
        })
    }

    /// Our roughness from pbrt's.
    fn roughness(&mut self, params: &Params, prefix: &str, default: f64) -> Read<f64> {
        let name = |stem: &str| format!("{prefix}{stem}");
        let both = self
            .float_texture(params, &name("roughness"))?
            .unwrap_or(default);
        let u = self
            .float_texture(params, &name("uroughness"))?
            .unwrap_or(both);
        let v = self
            .float_texture(params, &name("vroughness"))?
            .unwrap_or(both);
        let remap = params.bool("remaproughness")?.unwrap_or(true);
        if u < 0.0 || v < 0.0 {
            return fault(
                params.place,
                format!("{} has a negative roughness", params.owner),
            );
        }
        if u != v {
            self.warn(
                params.place,
                "anisotropic roughness is approximated by its geometric mean",
            );
        }
        let version = self.version();
        let alpha = |roughness: f64| match (remap, version) {
            (false, _) => roughness,
            (true, Version::V4) => roughness.sqrt(),
            (true, Version::V3) => alpha_of_version_3(roughness),
        };
        let alpha = (alpha(u) * alpha(v)).sqrt();
        if alpha > 1.0 {
            self.warn(
                params.place,
                format!("{}: GGX alpha {alpha:.3} is lowered to 1", params.owner),
            );
        }
        Ok(alpha.min(1.0).sqrt())
    }

    /// The index of refraction under the first of some names, 1.5 by default.
    fn eta(&mut self, params: &Params, names: &[&str]) -> Read<f64> {
        for name in names {
            if let Some(eta) = self.dielectric_index(params, name)? {
                return Ok(eta);
            }
        }
        Ok(1.5)
    }

    /// The mean of a colour or texture over its channels.
    fn grey(&mut self, params: &Params, name: &str, default: f64) -> Read<f64> {
        let value = self.value_or(params, name, default)?;
        Ok(self.mean(value).element_sum() / 3.0)
    }

    /// A texture times a constant (a texture's mean).
    fn times(&self, a: Value, b: Value) -> Value {
        let b = self.mean(b);
        match a {
            Value::Constant(a) => Value::Constant(a * b),
            Value::Picture { id, scale, map } => Value::Picture {
                id,
                scale: scale * b,
                map,
            },
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
            draft.normal_texture =
                self.linear_picture(file, super::colour::place_of(params, "normalmap"))?;
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
            name,
            kind: draft.kind,
            base_color,
            roughness: draft.roughness as f32,
            metallic: draft.metallic as f32,
            specular: draft.specular as f32,
            base_texture,
            roughness_metallic_texture: INVALID,
            normal_texture: draft.normal_texture,
        };
        let key = format!("{material:?} {map:?}");
        if let Some(&known) = self.known_materials.get(&key) {
            return Ok(known);
        }
        self.known_materials
            .insert(key, self.scene.materials.len() as u32);
        self.scene.materials.push(material);
        self.material_maps.push(map);
        Ok(self.scene.materials.len() as u32 - 1)
    }
}

/// pbrt version 3's remapped roughness.
fn alpha_of_version_3(roughness: f64) -> f64 {
    let x = roughness.max(1e-3).ln();
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}
