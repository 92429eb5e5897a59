//! Values of textures and colours.

use glam::{DVec2, DVec3};

/// Texture coordinates are `uv * scale + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    pub scale: DVec2,
    pub offset: DVec2,
}

impl Mapping {
    pub const IDENTITY: Self = Self {
        scale: DVec2::ONE,
        offset: DVec2::ZERO,
    };
}

/// The value of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// One colour everywhere.
    Constant(DVec3),
    /// A picture times a colour.
    Picture { id: u32, scale: DVec3, map: Mapping },
}

impl Value {
    /// One number for all channels.
    pub fn grey(value: f64) -> Self {
        Value::Constant(DVec3::splat(value))
    }
}
