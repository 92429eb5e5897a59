//! Picture files as linear texels.

use crate::Texture;
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// How a picture's numbers become linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Srgb,
    Linear,
    Gamma(f64),
}

impl Encoding {
    fn decode(self, value: f32) -> f32 {
        match self {
            Encoding::Linear => value,
            Encoding::Gamma(gamma) => value.powf(gamma as f32),
            Encoding::Srgb if value <= 0.04045 => value / 12.92,
            Encoding::Srgb => ((value + 0.055) / 1.055).powf(2.4),
        }
    }
}

/// Most texels of all pictures together.
const MAX_TEXELS: u64 = 1 << 27;

/// The pictures read so far; the same file read the same way is read once.
#[derive(Default)]
pub(super) struct Pictures {
    textures: Vec<Texture>,
    known: HashMap<(PathBuf, String), u32>,
    texels: u64,
}

impl Pictures {
    /// The scene's textures.
    pub fn finish(self) -> Vec<Texture> {
        self.textures
    }

    /// The mean texel.
    pub fn mean(&self, id: u32) -> DVec3 {
        let Some(texture) = self.textures.get(id as usize) else {
            return DVec3::ZERO;
        };
        let sum: DVec3 = texture.texels.iter().map(|texel| texel.as_dvec3()).sum();
        sum / (texture.texels.len().max(1) as f64)
    }

    /// A copy of a picture with its texels multiplied.
    pub fn scaled(&mut self, id: u32, scale: Vec3) -> Result<u32, String> {
        let Some(mut texture) = self.textures.get(id as usize).cloned() else {
            return Ok(id);
        };
        self.count(texture.texels.len() as u64)?;
        for texel in &mut texture.texels {
            *texel *= scale;
        }
        self.textures.push(texture);
        Ok(self.textures.len() as u32 - 1)
    }

    fn count(&mut self, texels: u64) -> Result<(), String> {
        self.texels = self.texels.saturating_add(texels);
        if self.texels > MAX_TEXELS {
            return Err(format!(
                "all pictures together have more than {MAX_TEXELS} texels"
            ));
        }
        Ok(())
    }

    /// Reads a picture file.
    pub fn read(
        &mut self,
        path: &Path,
        encoding: Option<Encoding>,
        invert: bool,
    ) -> Result<u32, String> {
        let key = (path.to_path_buf(), format!("{encoding:?} {invert}"));
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        if !std::fs::metadata(path)
            .map_err(|e| e.to_string())?
            .is_file()
        {
            return Err("not a regular file".to_owned());
        }
        let mut reader = image::ImageReader::open(path)
            .and_then(image::ImageReader::with_guessed_format)
            .map_err(|e| e.to_string())?;
        let mut limits = image::Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(1 << 15), Some(1 << 15));
        limits.max_alloc = Some(1 << 30);
        reader.limits(limits);
        let picture = reader.decode().map_err(|e| e.to_string())?;
        let (width, height) = (picture.width(), picture.height());
        self.count(u64::from(width) * u64::from(height))?;
        let floats = matches!(
            picture,
            image::DynamicImage::ImageRgb32F(_) | image::DynamicImage::ImageRgba32F(_)
        );
        let encoding = encoding.unwrap_or(if floats {
            Encoding::Linear
        } else {
            Encoding::Srgb
        });
        let texel = |pixel: &image::Rgb<f32>| {
            let linear = Vec3::from_array(pixel.0.map(|value| encoding.decode(value)));
            if invert { Vec3::ONE - linear } else { linear }
        };
        let texels = picture.into_rgb32f().pixels().map(texel).collect();
        self.textures.push(Texture {
            width,
            height,
            texels,
        });
        let id = self.textures.len() as u32 - 1;
        self.known.insert(key, id);
        Ok(id)
    }
}
