//! How much of a surface is there.

use crate::{INVALID, Texture};
use glam::Vec2;

/// Opacity of a surface: the share of it that is there, the rest being a hole. What lets light through
/// by its kind, as glass does, is opaque here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opacity {
    /// Share in [0, 1].
    pub value: f32,
    /// Texture that multiplies it (its red channel), or [`INVALID`].
    pub texture: u32,
    /// From which product on the surface is wholly there, and below which not at all.
    pub cutoff: Option<f32>,
}

impl Opacity {
    /// All of it is there.
    pub const OPAQUE: Opacity = Opacity {
        value: 1.0,
        texture: INVALID,
        cutoff: None,
    };

    /// Whether some of it may not be there.
    pub fn lets_through(&self) -> bool {
        self.texture != INVALID || self.share(1.0) < 1.0
    }

    /// Its value at texture coordinates, which are asked for where there is a texture.
    pub fn at(&self, textures: &[Texture], uv: impl FnOnce() -> Vec2) -> f32 {
        let texture = textures.get(self.texture as usize);
        self.share(texture.map_or(1.0, |texture| texture.sample(uv()).x))
    }

    fn share(&self, texel: f32) -> f32 {
        let product = (self.value * texel).clamp(0.0, 1.0);
        match self.cutoff {
            Some(cutoff) if product >= cutoff => 1.0,
            Some(_) => 0.0,
            None => product,
        }
    }
}
