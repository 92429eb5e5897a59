//! A material as a scene has it: parameters and the textures that multiply them.

use crate::kind::OWN;
use crate::{Bsdf, INVALID, MaterialKind, Opacity, Parts, Slot, Storage, Texture};
use glam::{Vec2, Vec3};

/// Material parameters; a texture, where present, multiplies the constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the scene file, for messages.
    pub name: String,
    /// Scattering model.
    pub kind: &'static MaterialKind,
    /// Linear sRGB reflectance, each channel in [0, 1].
    pub base_color: Vec3,
    /// Perceptual roughness in [0, 1]; GGX alpha is max(0.001, roughness^2).
    pub roughness: f32,
    /// Metalness in [0, 1].
    pub metallic: f32,
    /// Dielectric specular in [0, 1]; 0.5 means an index of refraction of 1.5.
    pub specular: f32,
    /// Further parameters, one for each of the kind's slots in [`crate::Storage::Own`], in their
    /// order.
    pub own: Vec<Parameter>,
    /// How much of the surface is there.
    pub opacity: Opacity,
    /// Texture of linear base colour (RGB), or [`INVALID`].
    pub base_texture: u32,
    /// Texture of roughness (G) and metallic (B), or [`INVALID`].
    pub roughness_metallic_texture: u32,
    /// Tangent-space normal map, stored as unit vectors scaled into [0, 1], or [`INVALID`].
    /// x points along dp/du, y along dp/dv (v upwards), z along the shading normal.
    pub normal_texture: u32,
}

/// One further parameter of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// A colour, or a number in all three channels.
    pub value: Vec3,
    /// Texture that multiplies it (its red channel, for a number), or [`INVALID`].
    pub texture: u32,
}

impl Parameter {
    /// A number without a texture.
    pub(crate) fn number(value: f32) -> Parameter {
        Parameter {
            value: Vec3::splat(value),
            texture: INVALID,
        }
    }
}

/// A parameter of a material as one of its kind's slots names it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotValue {
    /// The slot.
    pub slot: Slot,
    /// A colour, or a number in all three channels.
    pub value: Vec3,
    /// 3 for a colour, 1 for a number.
    pub width: usize,
    /// Texture that multiplies it, or [`INVALID`]; of a number, `channel` of the texture.
    pub texture: u32,
    /// 0 to 2 for red, green, blue.
    pub channel: usize,
}

impl Material {
    /// Its parameters, in the order of its kind's slots.
    pub fn parameters(&self) -> impl Iterator<Item = SlotValue> {
        let mixed = self.roughness_metallic_texture;
        let mut own = self.own.iter();
        self.kind.slots.iter().filter_map(move |&slot| {
            let (value, width, texture, channel) = match slot.storage {
                Storage::BaseColor => (self.base_color, 3, self.base_texture, 0),
                Storage::Roughness => (Vec3::splat(self.roughness), 1, mixed, 1),
                Storage::Metallic => (Vec3::splat(self.metallic), 1, mixed, 2),
                Storage::Specular => (Vec3::splat(self.specular), 1, INVALID, 0),
                Storage::Own { width, .. } => {
                    let parameter = own.next()?;
                    (parameter.value, width, parameter.texture, 0)
                }
            };
            Some(SlotValue {
                slot,
                value,
                width,
                texture,
                channel,
            })
        })
    }

    /// Texture ids: base colour, roughness and metallic, normals.
    pub fn textures(&self) -> [u32; 3] {
        [
            self.base_texture,
            self.roughness_metallic_texture,
            self.normal_texture,
        ]
    }

    /// Every texture id that it names, [`INVALID`] among them.
    pub fn texture_ids(&self) -> impl Iterator<Item = u32> {
        let own = self.own.iter().map(|parameter| parameter.texture);
        let all = self.textures().into_iter().chain(own);
        all.chain([self.opacity.texture])
    }

    /// Whether a texture multiplies any of its parameters.
    pub fn varies(&self) -> bool {
        self.textures()[..2].iter().any(|&id| id != INVALID)
            || self
                .own
                .iter()
                .any(|parameter| parameter.texture != INVALID)
    }
}

impl Bsdf {
    /// The constants of a material, textures left out.
    pub fn of(material: &Material) -> Bsdf {
        let mut bsdf = Bsdf {
            kind: material.kind,
            base_color: material.base_color,
            roughness: material.roughness,
            metallic: material.metallic,
            specular: material.specular,
            own: [0.0; OWN],
            parts: Parts::ALL,
            eta: 1.0,
            inside: false,
        };
        for (parameter, [first, end]) in own(material) {
            let numbers = parameter.value.to_array();
            bsdf.own[first..end].copy_from_slice(&numbers[..end - first]);
        }
        bsdf.eta = (material.kind.index)(&bsdf);
        bsdf
    }

    /// These constants of a material times its textures at `uv`.
    pub fn textured(self, material: &Material, textures: &[Texture], uv: Vec2) -> Bsdf {
        let texel = |id: u32| Some(textures.get(id as usize)?.sample(uv));
        let mut bsdf = self;
        if let Some(texel) = texel(material.base_texture) {
            bsdf.base_color *= texel;
        }
        if let Some(texel) = texel(material.roughness_metallic_texture) {
            bsdf.roughness *= texel.y;
            bsdf.metallic *= texel.z;
        }
        for (parameter, [first, end]) in own(material) {
            let factors = texel(parameter.texture).map_or([1.0; 3], |texel| texel.to_array());
            let numbers = bsdf.own[first..end].iter_mut();
            numbers.zip(factors).for_each(|(number, f)| *number *= f);
        }
        bsdf
    }
}

/// A material's further parameters, with the first of their numbers in [`Bsdf::own`] and the one
/// after the last.
fn own(material: &Material) -> impl Iterator<Item = (&Parameter, [usize; 2])> {
    let slots = material.kind.slots.iter();
    let places = slots.filter_map(|slot| match slot.storage {
        Storage::Own { first, width } => Some([first, first + width]),
        _ => None,
    });
    material.own.iter().zip(places)
}
