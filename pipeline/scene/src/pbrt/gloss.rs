//! Roughness and specular reflectance in our convention.
//!
//! **Roughness.** Ours has GGX alpha = roughness^2. pbrt's `roughness` is alpha itself where
//! `remaproughness` is false; where it is true (the default) version 3 has the polynomial
//! alpha = 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 of
//! x = ln(max(roughness, 0.001)), and version 4 has alpha = sqrt(roughness). Ours is then
//! sqrt(alpha), at most 1. `disney` has our own convention already.
//!
//! **Specular.** Ours has the normal-incidence reflectance F0 = 0.08 specular; an index eta
//! has F0 = ((eta-1)/(eta+1))^2.

use super::fault::{Read, fault};
use super::params::Params;
use super::reader::Reader;
use super::state::Version;
use super::value::Value;

/// Reflectance at normal incidence between vacuum and a dielectric.
pub(super) fn f0_of(eta: f64) -> f64 {
    ((eta - 1.0) / (eta + 1.0)).powi(2)
}

impl Reader {
    /// Our roughness from pbrt's.
    pub fn roughness(&mut self, params: &Params, prefix: &str, default: f64) -> Read<f64> {
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
    pub fn eta(&mut self, params: &Params, names: &[&str]) -> Read<f64> {
        for name in names {
            if let Some(eta) = self.dielectric_index(params, name)? {
                return Ok(eta);
            }
        }
        Ok(1.5)
    }

    /// The mean of a colour or texture over its channels.
    pub fn grey(&mut self, params: &Params, name: &str, default: f64) -> Read<f64> {
        let value = self.value_or(params, name, default)?;
        Ok(self.mean(value).element_sum() / 3.0)
    }

    /// A texture times a constant (a texture's mean).
    pub fn times(&self, a: Value, b: Value) -> Value {
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
}

/// pbrt version 3's remapped roughness.
fn alpha_of_version_3(roughness: f64) -> f64 {
    let x = roughness.max(1e-3).ln();
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}
