//! Pictures to linear texels.

use crate::Texture;
use crate::pfm::{is_pfm, read_pfm};
use glam::{DVec3, Vec3};
use image::{DynamicImage, ImageFormat, ImageReader};
use std::collections::HashMap;
use std::hash::Hash;
use std::io::Cursor;
use std::path::Path;

/// Most texels of all textures of a scene: 12 bytes each, 1.6 GB. Compressed pictures can
/// claim far more than their own size, so the claim is checked before it is granted.
const MAX_TEXELS: u64 = 1 << 27;

/// Most bytes that decoding one picture may take at once.
const MAX_BYTES: u64 = 1 << 30;

/// Most texels that a byte of a picture file can hold: deflate's greatest ratio, 1032, of
/// texels of one bit. JPEG stays below.
const MAX_TEXELS_A_BYTE: u64 = 8 * 1032;

/// Meaning of the numbers in a picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Encoding {
    /// sRGB for integers, linear for floating-point numbers.
    Natural,
    /// Colours under the sRGB transfer curve (IEC 61966-2-1), decoded to linear.
    Srgb,
    /// Numbers as they are, scaled to [0, 1].
    Linear,
    /// Powers of linear numbers: the exponent's f32 bits.
    Gamma(u32),
    /// The alpha channel in all three.
    Alpha,
    /// Tangent-space normals, their x and y scaled by the number (its f32 bits).
    Normal(u32),
}

/// The scene's textures while it is being read: each picture decoded once a use.
pub(crate) struct TextureTable<K> {
    ids: HashMap<(K, Encoding), u32>,
    /// Pictures that shine, with the factors that they lost.
    lights: HashMap<(K, Encoding), (u32, f32)>,
    textures: Vec<Texture>,
    texels: u64,
}

impl<K: Hash + Eq + Clone> TextureTable<K> {
    /// Empty.
    pub(crate) fn new() -> Self {
        Self {
            ids: HashMap::new(),
            lights: HashMap::new(),
            textures: Vec::new(),
            texels: 0,
        }
    }

    /// The id of picture `key`, if it was decoded before with this encoding.
    pub(crate) fn get(&self, key: K, encoding: Encoding) -> Option<u32> {
        self.ids.get(&(key, encoding)).copied()
    }

    /// Decodes a picture file's bytes as picture `key`, with every texel mapped; `format` is
    /// what the file's name tells, where its bytes do not. The error is a message.
    pub(crate) fn insert(
        &mut self,
        key: K,
        encoding: Encoding,
        bytes: &[u8],
        format: Option<ImageFormat>,
        map: impl Fn(Vec3) -> Vec3,
    ) -> Result<u32, String> {
        let mut texture = decode(bytes, encoding, format, MAX_TEXELS - self.texels)?;
        texture
            .texels
            .iter_mut()
            .for_each(|texel| *texel = map(*texel));
        let id = self.push(texture)?;
        self.ids.insert((key, encoding), id);
        Ok(id)
    }

    /// Decodes a picture that shines as picture `key`, brought to at most 1: its id, and the factor
    /// that it lost. The error is a message.
    pub(crate) fn insert_light(
        &mut self,
        key: K,
        encoding: Encoding,
        bytes: &[u8],
        format: Option<ImageFormat>,
    ) -> Result<(u32, f32), String> {
        if let Some(&known) = self.lights.get(&(key.clone(), encoding)) {
            return Ok(known);
        }
        let mut texture = decode(bytes, encoding, format, MAX_TEXELS - self.texels)?;
        let bad = |texel: &Vec3| !texel.is_finite() || texel.min_element() < 0.0;
        if let Some(at) = texture.texels.iter().position(bad) {
            let (column, row) = (at as u32 % texture.width, at as u32 / texture.width);
            return Err(format!(
                "texel in column {column}, row {row} (from 0, row 0 at the top): light is finite \
                 and not negative"
            ));
        }
        let peak = texture
            .texels
            .iter()
            .fold(1.0, |peak: f32, texel| peak.max(texel.max_element()));
        if peak > 1.0 {
            texture.texels.iter_mut().for_each(|texel| *texel /= peak);
        }
        let id = self.push(texture)?;
        self.lights.insert((key, encoding), (id, peak));
        Ok((id, peak))
    }

    /// A copy of a texture times a colour.
    pub(crate) fn scaled(&mut self, id: u32, scale: Vec3) -> Result<u32, String> {
        let Some(mut texture) = self.textures.get(id as usize).cloned() else {
            return Ok(id);
        };
        texture.texels.iter_mut().for_each(|texel| *texel *= scale);
        self.push(texture)
    }

    fn push(&mut self, texture: Texture) -> Result<u32, String> {
        self.texels += texture.texels.len() as u64;
        if self.texels > MAX_TEXELS {
            return Err(format!(
                "all pictures together have more than {MAX_TEXELS} texels"
            ));
        }
        self.textures.push(texture);
        Ok(self.textures.len() as u32 - 1)
    }

    /// Mean of a texture, linear RGB.
    pub(crate) fn mean_of(&self, id: u32) -> DVec3 {
        self.textures
            .get(id as usize)
            .map_or(DVec3::ZERO, Texture::mean)
    }

    /// The textures, ids as positions.
    pub(crate) fn into_textures(self) -> Vec<Texture> {
        self.textures
    }
}

/// A picture file that no surface looks up, floats as they are and integers by the sRGB curve;
/// the error is a message.
pub(crate) fn linear_picture(path: &Path) -> Result<Texture, String> {
    let bytes = crate::file::read(path).map_err(|error| error.to_string())?;
    let format = ImageFormat::from_path(path).ok();
    decode(&bytes, Encoding::Natural, format, MAX_TEXELS)
}

/// The format that a file's name tells: the bytes of a TGA do not.
pub(crate) fn format_of(path: &Path) -> Option<ImageFormat> {
    ImageFormat::from_path(path).ok()
}

fn decode(
    bytes: &[u8],
    encoding: Encoding,
    format: Option<ImageFormat>,
    max_texels: u64,
) -> Result<Texture, String> {
    if is_pfm(bytes) {
        return read_pfm(bytes, max_texels);
    }
    let open = || {
        let mut reader = ImageReader::new(Cursor::new(bytes));
        format.inspect(|&format| reader.set_format(format));
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(MAX_BYTES);
        reader.limits(limits);
        reader
            .with_guessed_format()
            .map_err(|error| error.to_string())
    };
    let unreadable = |error| {
        format!(
            "picture cannot be decoded: {error} (read here: PNG, JPEG, TGA, BMP, WebP, OpenEXR, \
             HDR, PFM)"
        )
    };
    let (width, height) = open()?.into_dimensions().map_err(unreadable)?;
    let texels = u64::from(width) * u64::from(height);
    if texels > max_texels {
        return Err(format!(
            "picture of {width} x {height} texels: the scene's textures together may have \
             {MAX_TEXELS} texels; use a smaller picture"
        ));
    }
    if texels > MAX_TEXELS_A_BYTE * bytes.len() as u64 {
        return Err(format!(
            "picture of {width} x {height} texels in {} bytes: truncated or damaged",
            bytes.len()
        ));
    }
    let image = open()?.decode().map_err(unreadable)?;
    let mut texture = Texture {
        width: image.width(),
        height: image.height(),
        texels: linear_texels(&image, encoding),
    };
    if let Encoding::Normal(bits) = encoding {
        scale_normals(&mut texture.texels, f32::from_bits(bits));
    }
    Ok(texture)
}

/// Grey is repeated over the channels, alpha is dropped unless it is what is wanted.
fn linear_texels(image: &DynamicImage, encoding: Encoding) -> Vec<Vec3> {
    if encoding == Encoding::Alpha {
        let texel = |pixel: &image::Rgba<f32>| Vec3::splat(pixel.0[3]);
        return image.to_rgba32f().pixels().map(texel).collect();
    }
    let linear = |value: f32, floats: bool| match encoding {
        Encoding::Natural if floats => value,
        Encoding::Srgb | Encoding::Natural => srgb_to_linear(value),
        Encoding::Linear | Encoding::Normal(_) | Encoding::Alpha => value,
        Encoding::Gamma(exponent) => value.powf(f32::from_bits(exponent)),
    };
    let curve = |levels: u32| -> Vec<f32> {
        let level = |i| linear(i as f32 / (levels - 1) as f32, false);
        (0..levels).map(level).collect()
    };
    match image.color().bytes_per_pixel() / image.color().channel_count() {
        1 => {
            let curve = curve(1 << 8);
            let texel = |pixel: &image::Rgb<u8>| pixel.0.map(|c| curve[usize::from(c)]).into();
            image.to_rgb8().pixels().map(texel).collect()
        }
        2 => {
            let curve = curve(1 << 16);
            let texel = |pixel: &image::Rgb<u16>| pixel.0.map(|c| curve[usize::from(c)]).into();
            image.to_rgb16().pixels().map(texel).collect()
        }
        _ => {
            let texel = |pixel: &image::Rgb<f32>| pixel.0.map(|c| linear(c, true)).into();
            image.to_rgb32f().pixels().map(texel).collect()
        }
    }
}

/// The sRGB transfer curve's inverse (IEC 61966-2-1).
fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// glTF 2.0, section 3.9.3: normalize((2 texel - 1) * (scale, scale, 1)), encoded again.
/// A texel without direction becomes the unbent normal.
fn scale_normals(texels: &mut [Vec3], scale: f32) {
    for texel in texels {
        let bent = (*texel * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0);
        *texel = (bent.try_normalize().unwrap_or(Vec3::Z) + 1.0) * 0.5;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageFormat, Luma, Rgb, Rgba};

    fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let image: DynamicImage = image.into();
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn first_texel(bytes: &[u8], encoding: Encoding) -> Vec3 {
        decode(bytes, encoding, None, MAX_TEXELS).unwrap().texels[0]
    }

    #[test]
    fn srgb_curve_is_the_standard_one() {
        // Tabulated values of IEC 61966-2-1.
        for (encoded, linear) in [(0.0, 0.0), (0.5, 0.214_041_14), (1.0, 1.0)] {
            assert!((srgb_to_linear(encoded) - linear).abs() < 1e-6);
        }
        // The two branches meet: the standard's rounding leaves a step of 2e-8.
        assert!((srgb_to_linear(0.040_45) - srgb_to_linear(0.040_450_1)).abs() < 1e-7);
    }

    #[test]
    fn every_pixel_layout_becomes_linear_rgb() {
        let half = srgb_to_linear(128.0 / 255.0);
        let rgb = png(image::RgbImage::from_pixel(2, 1, Rgb([255, 128, 0])));
        let want = Vec3::new(1.0, half, 0.0);
        assert_eq!(first_texel(&rgb, Encoding::Srgb), want);
        let rgba = png(image::RgbaImage::from_pixel(2, 1, Rgba([255, 128, 0, 3])));
        assert_eq!(first_texel(&rgba, Encoding::Srgb), want);
        let grey = png(image::GrayImage::from_pixel(2, 1, Luma([128])));
        assert_eq!(first_texel(&grey, Encoding::Srgb), Vec3::splat(half));
        let deep = image::ImageBuffer::from_pixel(2, 1, Rgb([65_535_u16, 257 * 128, 1]));
        let got = first_texel(&png(deep), Encoding::Linear);
        let want = Vec3::new(1.0, 128.0 / 255.0, 1.0 / 65_535.0);
        assert!((got - want).abs().max_element() < 1e-7, "{got}");
    }

    #[test]
    fn jpeg_is_read_too() {
        let mut bytes = Cursor::new(Vec::new());
        DynamicImage::from(image::RgbImage::from_pixel(16, 8, Rgb([200, 100, 50])))
            .write_to(&mut bytes, ImageFormat::Jpeg)
            .unwrap();
        let texture = decode(bytes.get_ref(), Encoding::Linear, None, MAX_TEXELS).unwrap();
        assert_eq!((texture.width, texture.height), (16, 8));
        // A constant block keeps its colour up to rounding in YCbCr.
        let want = Vec3::new(200.0, 100.0, 50.0) / 255.0;
        let error = (texture.texels[0] - want).abs().max_element();
        assert!(error <= 3.0 / 255.0, "{}", texture.texels[0]);
    }

    #[test]
    fn normals_are_scaled_and_stay_unit() {
        let encode = |n: Vec3| (n.normalize() + 1.0) * 0.5;
        let mut texels = [encode(Vec3::new(1.0, 2.0, 4.0)), Vec3::splat(0.5)];
        scale_normals(&mut texels, 0.5);
        let want = encode(Vec3::new(0.5, 1.0, 4.0));
        assert!((texels[0] - want).abs().max_element() < 1e-6);
        assert_eq!(texels[1], Vec3::new(0.5, 0.5, 1.0));
    }

    #[test]
    fn pictures_beyond_the_limit_are_refused_before_decoding() {
        let bytes = png(image::GrayImage::new(64, 64));
        let error = decode(&bytes, Encoding::Srgb, None, 64 * 64 - 1).unwrap_err();
        assert!(error.contains("64 x 64"), "{error}");
        assert!(decode(&bytes, Encoding::Srgb, None, 64 * 64).is_ok());
    }

    #[test]
    fn broken_pictures_are_messages() {
        let bytes = png(image::RgbImage::from_fn(9, 7, |x, y| {
            Rgb([x as u8 * 20, y as u8 * 30, 77])
        }));
        assert!(decode(b"not a picture", Encoding::Srgb, None, MAX_TEXELS).is_err());
        for cut in 0..bytes.len() - 12 {
            assert!(
                decode(&bytes[..cut], Encoding::Srgb, None, MAX_TEXELS).is_err(),
                "{cut}"
            );
        }
    }

    #[test]
    fn a_picture_is_decoded_once_a_use() {
        let bytes = png(image::GrayImage::new(2, 2));
        let mut table = TextureTable::new();
        let colour = table
            .insert(0, Encoding::Srgb, &bytes, None, |t| t)
            .unwrap();
        let number = table
            .insert(0, Encoding::Linear, &bytes, None, |t| t)
            .unwrap();
        assert_ne!(colour, number);
        assert_eq!(table.get(0, Encoding::Srgb), Some(colour));
        assert_eq!(table.get(0, Encoding::Normal(0)), None);
        assert_eq!(table.into_textures().len(), 2);
    }
}
