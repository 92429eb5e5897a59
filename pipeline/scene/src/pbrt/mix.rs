//! Mixtures of named materials.

use super::fault::{Place, Read, fault};
use super::material::Draft;
use super::params::Params;
use super::reader::Reader;
use super::state::Surface;
use super::value::{Mapping, Value};
use crate::INVALID;
use rrf_materials::{LAMBERT, PRINCIPLED};

impl Reader {
    /// `mix`: version 3's `amount` weighs the first material, version 4's the second.
    pub fn mix(&mut self, params: &Params, at: Place) -> Read<(Draft, Option<String>)> {
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
            &PRINCIPLED
        };
        let base = self.mean(a.base).lerp(self.mean(b.base), t);
        let draft = Draft {
            kind,
            base: Value::Constant(base),
            roughness: lerp(a.roughness, b.roughness),
            metallic: lerp(a.metallic, b.metallic),
            specular: lerp(a.specular, b.specular),
            own: match kind == a.kind {
                true => (a.own.iter().zip(&b.own))
                    .map(|(a, b)| a.lerp(*b, t as f32))
                    .collect(),
                false => Vec::new(),
            },
            opacity: lerp(a.opacity, b.opacity),
            normal_texture: INVALID,
        };
        let exact = kind == &LAMBERT;
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
        let base = match material.base_texture {
            INVALID => Value::Constant(scale),
            id => Value::Picture {
                id,
                scale,
                map: Mapping::IDENTITY,
            },
        };
        Ok(Draft::of(material, base))
    }
}
