//! From linear radiance to what a screen shows: exposure, clip, sRGB.

use crate::color::luminance;
use crate::picture::Picture;
use glam::Vec3;

/// Exposure in stops: radiance is multiplied by 2^`ev`, then clipped to [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Exposure {
    /// Stops.
    pub ev: f32,
}

/// The share of lit pixels that [`Exposure::automatic`] keeps below [`AUTOMATIC_LEVEL`].
pub const AUTOMATIC_SHARE: f64 = 0.95;
/// The linear level on which it puts them.
pub const AUTOMATIC_LEVEL: f32 = 0.8;

impl Exposure {
    /// The exposure that puts the [`AUTOMATIC_SHARE`] quantile of the luminances above zero
    /// at [`AUTOMATIC_LEVEL`]; 0 stops for a black picture.
    pub fn automatic(picture: &Picture) -> Exposure {
        let mut lit: Vec<f32> = picture.pixels.iter().map(|&p| luminance(p)).collect();
        lit.retain(|&y| y > 0.0 && y.is_finite());
        if lit.is_empty() {
            return Exposure::default();
        }
        let place = (lit.len() - 1) as f64 * AUTOMATIC_SHARE;
        let (_, &mut level, _) = lit.select_nth_unstable_by(place as usize, f32::total_cmp);
        Exposure {
            ev: (AUTOMATIC_LEVEL / level).log2(),
        }
    }

    /// Exposed and clipped linear RGB in [0, 1]; NaN becomes 0.
    pub fn apply(self, rgb: Vec3) -> Vec3 {
        let exposed = rgb * self.ev.exp2();
        let clip = |x: f32| if x > 0.0 { x.min(1.0) } else { 0.0 };
        Vec3::from_array(exposed.to_array().map(clip))
    }
}

/// sRGB encoding of one linear value in [0, 1] (IEC 61966-2-1).
pub fn srgb_encode(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// Linear value of an sRGB one in [0, 1] (IEC 61966-2-1).
pub fn srgb_decode(x: f32) -> f32 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

/// The 8-bit sRGB pixel that shows `rgb`.
pub fn srgb8(rgb: Vec3, exposure: Exposure) -> [u8; 3] {
    let shown = exposure.apply(rgb).to_array();
    shown.map(|x| (srgb_encode(x) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_byte_survives() {
        for byte in 0..=255u8 {
            let linear = srgb_decode(f32::from(byte) / 255.0);
            assert_eq!(srgb8(Vec3::splat(linear), Exposure::default()), [byte; 3]);
        }
    }

    #[test]
    fn automatic_exposure_puts_the_quantile_at_its_level() {
        // 50 black pixels, then luminances 1 to 101: the 95 % quantile of the lit ones is 96.
        let lit = (1..=101).map(|y| Vec3::splat(y as f32));
        let picture = Picture {
            width: 151,
            height: 1,
            pixels: std::iter::repeat_n(Vec3::ZERO, 50).chain(lit).collect(),
        };
        let ev = Exposure::automatic(&picture).ev;
        assert!((96.0 * ev.exp2() - AUTOMATIC_LEVEL).abs() < 1e-5);
        let black = Picture {
            width: 1,
            height: 1,
            pixels: vec![Vec3::ZERO],
        };
        assert_eq!(Exposure::automatic(&black).ev, 0.0);
    }

    #[test]
    fn what_cannot_be_shown_is_clipped() {
        let rgb = Vec3::new(f32::NAN, -1.0, 7.0);
        assert_eq!(srgb8(rgb, Exposure::default()), [0, 0, 255]);
    }
}
