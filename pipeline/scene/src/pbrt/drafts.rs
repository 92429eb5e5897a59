//! The kinds of pbrt's materials, and the nearest of ours to each.

use super::fault::{Place, Read, fault};
use super::gloss::f0_of;
use super::material::Draft;
use super::metal::copper;
use super::params::Params;
use super::reader::Reader;
use super::value::Value;
use crate::Material;
use glam::Vec3;
use rrf_materials::Metal;

impl Reader {
    /// The draft of a material and what about it is approximated; `None` for an unknown one.
    pub fn draft(
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
                self.metal(params, "", default)?
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
                let (draft, _) = self.metal(params, "conductor.", 0.0)?;
                near(draft, "coated metal without its coat")
            }
            "mirror" => {
                let base = self.value_or(params, "Kr", 0.9)?;
                let mirror = Material::conductor("", Metal::PERFECT, Vec3::ONE, 0.0);
                exact(Draft::of(&mirror, base))
            }
            "glass" | "dielectric" | "thindielectric" => self.glass(kind, params)?,
            "disney" => self.disney(params)?,
            "mix" => self.mix(params, at)?,
            "diffusetransmission" => {
                let scale = Value::grey(params.float("scale")?.unwrap_or(1.0));
                let base = self.value_or(params, "reflectance", 0.25)?;
                let through = self.value_or(params, "transmittance", 0.25)?;
                self.leaf(self.times(base, scale), self.times(through, scale))
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
        for name in ["Kr", "Kt"] {
            if self.grey(params, name, 0.0)? != 0.0 {
                note.push_str(&format!("; {name} is left out"));
            }
        }
        let opacity = self.grey(params, "opacity", 1.0)?;
        if !(0.0..=1.0).contains(&opacity) {
            return fault(
                params.place,
                format!("an opacity of {opacity} is outside 0 to 1"),
            );
        }
        let mut draft = Draft::dielectric(base, roughness, f0);
        draft.opacity = opacity;
        Ok((draft, Some(note)))
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
        let transmit = self.value_or(params, "transmit", 0.5)?;
        params.ignore(&["Ks", "roughness", "remaproughness"]);
        let (draft, note) = self.leaf(self.times(base, reflect), self.times(base, transmit));
        let note = note.map_or(String::new(), |note| format!("; {note}"));
        let gloss = format!("translucent without its gloss (Ks){note}");
        Ok((draft, Some(gloss)))
    }

    /// Diffuse reflection and transmission; of a picture that is transmitted, the mean.
    fn leaf(&self, base: Value, through: Value) -> (Draft, Option<String>) {
        let mean = self.mean(through).as_vec3();
        let leaf = Material::diffuse_transmission("", Vec3::ONE, mean);
        let note = matches!(through, Value::Picture { .. })
            .then(|| "the transmittance's picture by its mean".to_owned());
        (Draft::of(&leaf, base), note)
    }

    /// A diffuse body under a rough coat, as Mitsuba's nonlinear `roughplastic`.
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
        let eta = self.eta(params, &["eta"])?;
        let roughness = self.roughness(params, "", 0.0)?;
        let mut note = "coated diffuser by Mitsuba's nonlinear rough plastic".to_owned();
        let index = eta.clamp(1.0, 2.5);
        if index != eta {
            note.push_str(&format!(
                "; its index of refraction {eta} is read as {index}: 1 to 2.5 is tabulated"
            ));
        }
        let plastic = Material::nonlinear_plastic("", Vec3::ONE, roughness as f32, index as f32);
        Ok((Draft::of(&plastic, base), Some(note)))
    }

    /// Glass, solid or a thin pane.
    fn glass(&mut self, kind: &str, params: &Params) -> Read<(Draft, Option<String>)> {
        let eta = self.eta(params, &["eta", "index"])? as f32;
        let reflected = self.value_or(params, "Kr", 1.0)?;
        let through = self.value_or(params, "Kt", 1.0)?;
        let (reflected, tint) = (self.mean(reflected).as_vec3(), self.mean(through).as_vec3());
        let roughness = self.roughness(params, "", 0.0)? as f32;
        // version 3 maps a roughness of 0 to an alpha of 0.047, but has clear glass for it
        let names = ["roughness", "uroughness", "vroughness"];
        let is_rough = names.iter().any(|name| params.has(name)) && roughness > 0.032;
        let mut note = None;
        let mut glass = if kind == "thindielectric" {
            if is_rough {
                note = Some("a rough thin pane by a clear one".to_owned());
            }
            Material::thin_dielectric("", eta, tint)
        } else if is_rough {
            Material::rough_dielectric("", eta, tint, Vec3::ZERO, roughness)
        } else {
            Material::dielectric("", eta, tint, Vec3::ZERO)
        };
        if let Some(factor) = glass.own.last_mut() {
            factor.value = reflected;
        }
        Ok((Draft::of(&glass, Value::Constant(tint.as_dvec3())), note))
    }

    /// Metal by its index of refraction, or by its reflectance at normal incidence.
    fn metal(
        &mut self,
        params: &Params,
        prefix: &str,
        default_roughness: f64,
    ) -> Read<(Draft, Option<String>)> {
        let name = |stem: &str| format!("{prefix}{stem}");
        let roughness = self.roughness(params, prefix, default_roughness)?;
        let of = |metal, base| {
            let metal = Material::conductor("", metal, Vec3::ONE, roughness as f32);
            Draft::of(&metal, base)
        };
        match self.value(params, "reflectance")? {
            Some(Value::Constant(colour)) => {
                let metal = Metal::of_reflectance(colour.as_vec3());
                Ok((of(metal, Value::grey(1.0)), None))
            }
            Some(picture) => {
                let note = "metal with a picture of its reflectance, at all angles alike";
                Ok((of(Metal::PERFECT, picture), Some(note.to_owned())))
            }
            None => {
                let (copper_eta, copper_k) = copper();
                let eta = self.index(params, &name("eta"))?.unwrap_or(copper_eta);
                let k = self.index(params, &name("k"))?.unwrap_or(copper_k);
                let [eta, k] = [eta, k].map(|index| index.rgb().as_vec3());
                Ok((of(Metal { eta, k }, Value::grey(1.0)), None))
            }
        }
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
}
