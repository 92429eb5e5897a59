//! The broad and the narrow part of a material.
//!
//! Nets answer for lobes that are broad. What is narrower is followed along the ray: mirrors,
//! glass, and metals and coats that are nearly smooth. [`Bsdf::broad`] and [`Bsdf::narrow`] are
//! materials of their own with value, density and sampler, and the two values sum to the whole.

use crate::{Bsdf, INVALID, Material, Parameter, Parts};

impl Bsdf {
    /// The part that nets can answer for, as a material of its own; `None` if there is none.
    pub fn broad(&self) -> Option<Bsdf> {
        self.only(Parts::BROAD, Parts::BROAD)
    }

    /// The part that has to be followed along the ray, as a material of its own; `None` if there
    /// is none.
    pub fn narrow(&self) -> Option<Bsdf> {
        self.only(Parts::NARROW, Parts::NARROW | Parts::STRAIGHT)
    }

    /// Whether it has nothing but a narrow part.
    pub fn is_narrow(&self) -> bool {
        let has = self.has();
        has.has(Parts::NARROW) && !has.has(Parts::BROAD)
    }

    /// The parts that it has.
    fn has(&self) -> Parts {
        (self.kind.parts)(self).and(self.parts)
    }

    /// It without light that goes straight through.
    pub fn without_straight(self) -> Bsdf {
        Bsdf {
            parts: self.parts.without(Parts::STRAIGHT),
            ..self
        }
    }

    fn only(&self, part: Parts, kept: Parts) -> Option<Bsdf> {
        self.has().has(part).then_some(Bsdf {
            parts: self.parts.and(kept),
            ..*self
        })
    }
}

impl Material {
    /// Whether it has a narrow part somewhere, whatever its textures hold there.
    pub fn may_be_narrow(&self) -> bool {
        let constants = Bsdf::of(self);
        let textured = |parameter: &Parameter| parameter.texture != INVALID;
        let varies = self.roughness_metallic_texture != INVALID || self.own.iter().any(textured);
        constants.narrow().is_some() || varies && (self.kind.lobe)(&constants).is_some()
    }
}
