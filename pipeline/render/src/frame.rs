//! Frames in memory.

use glam::Vec3;
use rrf_metrics::Picture;

/// A rendered frame: radiance [W·sr⁻¹·m⁻²] by parts, and where it came from.
/// Every layer present has `width * height` entries, row-major from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The frame's picture: the sum of the parts that were asked for.
    pub full: Vec<Vec3>,
    /// Light from the lamps to the eye by at most one bounce, lamps seen directly included.
    pub direct: Option<Vec<Vec3>>,
    /// Light by two bounces or more.
    pub indirect: Option<Vec<Vec3>>,
    /// Cell of the net that lit the pixel under the first light, `u32::MAX` where none did.
    pub cell: Option<Vec<u32>>,
    /// Share of the pixel's samples within what the nets were trained for, 0 to 1.
    pub trust: Option<Vec<f32>>,
    /// Reflectance of what the camera sees.
    pub albedo: Option<Vec<Vec3>>,
    /// Its shading normal, world frame.
    pub normal: Option<Vec<Vec3>>,
    /// Its distance along the viewing direction \[m\].
    pub depth: Option<Vec<f32>>,
    /// Named facts about the frame: program version, view, lights, options.
    pub attributes: Vec<(String, String)>,
}

impl Frame {
    /// The frame's picture.
    pub fn picture(&self) -> Picture {
        self.layer(&self.full)
    }

    /// One of the frame's layers as a picture.
    pub fn layer(&self, layer: &[Vec3]) -> Picture {
        Picture {
            width: self.width,
            height: self.height,
            pixels: layer.to_vec(),
        }
    }
}
