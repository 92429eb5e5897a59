//! Which texture coordinates a material uses, and how it moves them.

use super::document::Document;
use crate::warn::Warnings;
use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::texture::{MagFilter, Texture, WrappingMode};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, material, texture};
use glam::{Affine2, Mat2, Vec2};
use serde::Deserialize;

/// A set of texture coordinates with a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvSource {
    /// The n of TEXCOORD_n.
    pub(super) set: u32,
    /// KHR_texture_transform, in glTF's coordinates (v grows downwards).
    pub(super) transform: Affine2,
}

impl UvSource {
    /// TEXCOORD_0 as it is.
    pub(super) const PLAIN: Self = Self {
        set: 0,
        transform: Affine2::IDENTITY,
    };

    /// A texture coordinate of the file in our frame, where v grows upwards.
    pub(super) fn apply(&self, uv: [f32; 2]) -> Vec2 {
        let uv = self.transform.transform_point2(Vec2::from_array(uv));
        Vec2::new(uv.x, 1.0 - uv.y)
    }
}

/// A reference to a texture, whatever it is for.
#[derive(Clone, Copy)]
pub(super) struct TextureUse {
    /// The texture.
    pub(super) texture: Index<Texture>,
    /// Where it is looked up.
    pub(super) uv: UvSource,
}

impl TextureUse {
    /// Base colour, metallic-roughness or emissive texture.
    pub(super) fn of(info: &texture::Info) -> Self {
        let transform = info
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.texture_transform.as_ref());
        Self {
            texture: info.index,
            uv: source(info.tex_coord, transform),
        }
    }

    /// Normal texture; the crate leaves its KHR_texture_transform as JSON. Or a message.
    pub(super) fn of_normal(normal: &material::NormalTexture) -> Result<Self, String> {
        let transform = normal
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.others.get("KHR_texture_transform"))
            .map(TextureTransform::deserialize)
            .transpose()
            .map_err(|error| format!("normalTexture's KHR_texture_transform: {error}"))?;
        Ok(Self {
            texture: normal.index,
            uv: source(normal.tex_coord, transform.as_ref()),
        })
    }
}

/// KHR_texture_transform: translation * rotation * scale; a positive angle turns u towards
/// -v, which is counter-clockwise where v grows downwards.
fn source(set: u32, transform: Option<&TextureTransform>) -> UvSource {
    let Some(transform) = transform else {
        return UvSource {
            set,
            ..UvSource::PLAIN
        };
    };
    let (sin, cos) = transform.rotation.0.sin_cos();
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let scale = Mat2::from_diagonal(Vec2::from_array(transform.scale.0));
    UvSource {
        set: transform.tex_coord.unwrap_or(set),
        transform: Affine2::from_mat2_translation(
            rotation * scale,
            Vec2::from_array(transform.offset.0),
        ),
    }
}

/// The texture coordinates that all textures share, else the first one's.
pub(super) fn common_uv(
    uses: &[TextureUse],
    place: &str,
    warnings: &mut Warnings,
) -> Option<UvSource> {
    let first = uses.first()?.uv;
    if uses.iter().any(|used| used.uv != first) {
        let message = "its textures use different texture coordinates; \
                       those of the first one are used for all";
        warnings.add(place, message);
    }
    Some(first)
}

/// Whether all of the coordinates a material sees lie in the picture's first period.
pub(super) fn stays_in_picture(uvs: impl IntoIterator<Item = Vec2>) -> bool {
    // Exporters touch the edges with rounding errors.
    const SLACK: f32 = 1e-4;
    uvs.into_iter()
        .all(|uv| uv.min_element() >= -SLACK && uv.max_element() <= 1.0 + SLACK)
}

/// Whether the texture does not simply repeat; warns of filters that are not bilinear.
pub(super) fn leaves_repetition(
    document: &Document,
    texture: Index<Texture>,
    place: &str,
    warnings: &mut Warnings,
) -> bool {
    let sampler = document
        .root
        .get(texture)
        .and_then(|texture| document.root.get(texture.sampler?));
    let Some(sampler) = sampler else {
        return false;
    };
    if matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest))) {
        warnings.add(place, "nearest-texel lookup is read as bilinear");
    }
    let repeats = Checked::Valid(WrappingMode::Repeat);
    sampler.wrap_s != repeats || sampler.wrap_t != repeats
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::gltf::json::extensions::texture::{
        TextureTransformOffset, TextureTransformRotation, TextureTransformScale,
    };

    fn transform(offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> UvSource {
        let transform = TextureTransform {
            offset: TextureTransformOffset(offset),
            rotation: TextureTransformRotation(rotation),
            scale: TextureTransformScale(scale),
            tex_coord: Some(1),
            ..TextureTransform::default()
        };
        source(0, Some(&transform))
    }

    #[test]
    fn plain_coordinates_are_turned_upwards() {
        assert_eq!(UvSource::PLAIN.apply([0.25, 0.0]), Vec2::new(0.25, 1.0));
    }

    #[test]
    fn the_extensions_examples_come_out() {
        // "utilizes only the lower left quadrant of the source image, rotated clockwise 90°"
        let quadrant = transform([0.0, 1.0], std::f32::consts::FRAC_PI_2, [0.5, 0.5]);
        assert_eq!(quadrant.set, 1);
        for (uv, want) in [
            ([0.0, 0.0], [0.0, 0.0]), // upper left corner from the picture's lower left
            ([1.0, 0.0], [0.0, 0.5]), // upper right corner from the left edge's middle
            ([0.0, 1.0], [0.5, 0.0]), // lower left corner from the lower edge's middle
        ] {
            let got = quadrant.apply(uv);
            assert!(
                (got - Vec2::from_array(want)).length() < 1e-6,
                "{uv:?}: {got}"
            );
        }
        // "inverts the T axis"
        let inverted = transform([0.0, 1.0], 0.0, [1.0, -1.0]);
        assert!((inverted.apply([0.3, 0.2]) - Vec2::new(0.3, 0.2)).length() < 1e-6);
    }
}
