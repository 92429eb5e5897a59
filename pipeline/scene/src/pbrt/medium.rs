//! Media that only absorb, as what solids of glass are filled with.

use super::fault::{Place, Read, fault};
use super::params::Params;
use super::reader::Reader;
use super::state::Medium;
use super::token::{Kind, Token, Tokens};
use super::value::Mapping;
use glam::{DVec3, Vec3};
use rrf_materials::Storage;

impl Reader {
    /// `MakeNamedMedium "name" "string type" "..."`. A homogeneous medium that does not scatter is kept.
    pub fn make_named_medium(&mut self, name: String, params: &Params) -> Read<()> {
        let kind = params.string("type")?.unwrap_or_default().to_owned();
        let medium = self.medium(&kind, params)?;
        if medium == Medium::LeftOut {
            let what = match kind.as_str() {
                "homogeneous" => "scatters light".to_owned(),
                _ => format!("is of the type \"{kind}\""),
            };
            let message =
                format!("medium \"{name}\" {what}; it is left out, and light passes it unchanged");
            self.warn(params.place, message);
        }
        self.media.insert(name, medium);
        Ok(())
    }

    fn medium(&mut self, kind: &str, params: &Params) -> Read<Medium> {
        // without sigma_a or sigma_s pbrt has those of a medium that scatters
        if kind != "homogeneous" || params.has("preset") {
            return Ok(Medium::LeftOut);
        }
        let absorbed = self.index(params, "sigma_a")?.map(|index| index.rgb());
        let scattered = self.index(params, "sigma_s")?.map(|index| index.rgb());
        let scale = params.float("scale")?.unwrap_or(1.0);
        let (Some(absorbed), Some(DVec3::ZERO)) = (absorbed, scattered) else {
            return Ok(Medium::LeftOut);
        };
        let absorption = (absorbed * scale).as_vec3();
        if !absorption.is_finite() || absorption.min_element() < 0.0 {
            return fault(
                params.place,
                format!("sigma_a times scale is {absorption}; it must not be negative"),
            );
        }
        if self
            .emitted(params, "Le")?
            .is_some_and(|le| le != DVec3::ZERO)
        {
            let message = "Le is left out: media do not shine";
            self.warn(params.place, message);
        }
        Ok(Medium::Absorbs(absorption))
    }

    /// `MediumInterface "inside" "outside"`: with what the next shapes are filled.
    pub fn medium_interface(&mut self, tokens: &mut Tokens<'_>) -> Read<()> {
        let (inside, at) = tokens.string("a medium's name")?;
        self.state.filled_with = self.absorption(&inside, at)?;
        let outside = tokens.peek()?;
        if let Some(Token {
            kind: Kind::Quoted(_),
            ..
        }) = outside
        {
            let (outside, at) = tokens.string("a medium's name")?;
            if self.absorption(&outside, at)? != Vec3::ZERO {
                let message = format!(
                    "medium \"{outside}\" outside of shapes is left out: glass alone is filled"
                );
                self.warn(at, message);
            }
        }
        Ok(())
    }

    fn absorption(&mut self, name: &str, at: Place) -> Read<Vec3> {
        match self.media.get(name) {
            Some(Medium::Absorbs(absorption)) => Ok(*absorption),
            Some(Medium::LeftOut) => Ok(Vec3::ZERO),
            None if name.is_empty() => Ok(Vec3::ZERO),
            None => {
                let message = format!("no medium \"{name}\" is known: there is none, light passes");
                self.warn(at, message);
                Ok(Vec3::ZERO)
            }
        }
    }

    /// The material `id` filled with the medium in force, if light travels in what it encloses.
    pub fn filled(&mut self, id: u32) -> u32 {
        let absorption = self.state.filled_with;
        let Some(material) = self.scene.materials.get(id as usize) else {
            return id;
        };
        let own = material.kind.slots.iter();
        let mut own = own.filter(|slot| matches!(slot.storage, Storage::Own { .. }));
        let place = own.position(|slot| slot.name == "absorption");
        let (Some(place), true) = (place, absorption != Vec3::ZERO) else {
            return id;
        };
        let mut filled = material.clone();
        if let Some(parameter) = filled.own.get_mut(place) {
            parameter.value = absorption;
        }
        let map = self.material_maps.get(id as usize).copied();
        self.store_material(filled, map.unwrap_or(Mapping::IDENTITY))
    }
}
