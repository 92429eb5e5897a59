//! Pictures in memory.

use crate::error::MetricsError;
use glam::Vec3;

/// A linear RGB picture (Rec. 709 primaries, D65), row-major from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<Vec3>,
}

impl Picture {
    /// Names the first pixel that is not finite in an error about `picture`.
    pub(crate) fn check_finite(&self, picture: &'static str) -> Result<(), MetricsError> {
        let bad = self.pixels.iter().position(|p| !p.is_finite());
        match bad {
            None => Ok(()),
            Some(at) => {
                let pixel = self.pixels[at].to_array();
                Err(MetricsError::NotFinite {
                    picture,
                    x: at as u32 % self.width,
                    y: at as u32 / self.width,
                    value: pixel.into_iter().find(|x| !x.is_finite()).unwrap_or(0.0),
                })
            }
        }
    }
}
