//! The kinds of pbrt's materials, and the nearest of ours to each.

use super::fault::{Place, Read};
use super::gloss::f0_of;
use super::material::Draft;
use super::metal::{copper, normal_reflectance};
use super::params::Params;
use super::reader::Reader;
use super::value::Value;
use glam::DVec3;

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
}
