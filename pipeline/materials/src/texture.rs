//! Pictures that multiply parameters, and their lookup.

use glam::{DVec3, Vec2, Vec3};

/// "No such thing" in a column of ids.
pub const INVALID: u32 = u32::MAX;

/// A decoded picture, row-major from the top, three linear f32 channels a texel.
/// Looked up with wrap-around repetition and bilinear interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width * height` linear RGB texels.
    pub texels: Vec<Vec3>,
}

impl Texture {
    /// Bilinear lookup with wrap-around repetition, linear RGB.
    ///
    /// `uv` spans the picture once from (0, 0) at its lower left to (1, 1) at its upper
    /// right, so that v = 1 is the upper edge of row 0; texel (x, row) is centred at
    /// u = (x + 0.5) / width, v = 1 - (row + 0.5) / height. A texture whose `texels` are
    /// fewer than `width * height` is black where they are missing.
    #[inline]
    pub fn sample(&self, uv: Vec2) -> Vec3 {
        let (x0, x1, fx) = neighbours(uv.x, self.width);
        let (y0, y1, fy) = neighbours(1.0 - uv.y, self.height);
        let texel = |x: usize, y: usize| {
            let index = y * self.width as usize + x;
            self.texels.get(index).copied().unwrap_or(Vec3::ZERO)
        };
        let upper = texel(x0, y0).lerp(texel(x1, y0), fx);
        let lower = texel(x0, y1).lerp(texel(x1, y1), fx);
        upper.lerp(lower, fy)
    }

    /// Mean over all texels, linear RGB; black for an empty texture.
    pub fn mean(&self) -> DVec3 {
        let sum: DVec3 = self.texels.iter().map(|texel| texel.as_dvec3()).sum();
        sum / self.texels.len().max(1) as f64
    }
}

/// The two texels around coordinate `t` (one period is [0, 1)) on a ring of `size` texels,
/// and the weight of the second.
#[inline]
fn neighbours(t: f32, size: u32) -> (usize, usize, f32) {
    // Half a texel back to the centre and a whole one forward, so that truncation is floor.
    // t - floor(t) may round to 1: then `second` is `size`, and wraps.
    let position = (t - t.floor()) * size as f32 + 0.5;
    let second = position as u32;
    let weight = position - second as f32;
    let first = second.checked_sub(1).unwrap_or(size.saturating_sub(1));
    let second = if second >= size { 0 } else { second };
    (first as usize, second as usize, weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream};

    /// Texel (x, row) has a red of its own.
    fn numbered(width: u32, height: u32) -> Texture {
        let texels = (0..width * height)
            .map(|i| Vec3::new(i as f32, 1.0, 0.0))
            .collect();
        Texture {
            width,
            height,
            texels,
        }
    }

    /// Bilinear interpolation written the slow way, in f64.
    fn reference(texture: &Texture, uv: Vec2) -> f64 {
        let (w, h) = (i64::from(texture.width), i64::from(texture.height));
        let x = f64::from(uv.x) * w as f64 - 0.5;
        let y = (1.0 - f64::from(uv.y)) * h as f64 - 0.5;
        let mut sum = 0.0;
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (i, j) = (x.floor() as i64 + dx, y.floor() as i64 + dy);
            let weight = (1.0 - (x - i as f64).abs()) * (1.0 - (y - j as f64).abs());
            let index = j.rem_euclid(h) * w + i.rem_euclid(w);
            sum += weight * f64::from(texture.texels[index as usize].x);
        }
        sum
    }

    #[test]
    fn texel_centres_give_the_texels() {
        for (w, h) in [(1, 1), (1, 4), (3, 2), (8, 8)] {
            let texture = numbered(w, h);
            for row in 0..h {
                for x in 0..w {
                    let uv = Vec2::new(
                        (x as f32 + 0.5) / w as f32,
                        1.0 - (row as f32 + 0.5) / h as f32,
                    );
                    let got = texture.sample(uv).x;
                    let want = (row * w + x) as f32;
                    assert!((got - want).abs() < 1e-4, "{w}x{h} ({x}, {row}): {got}");
                }
            }
        }
    }

    #[test]
    fn v_one_is_row_zero() {
        let texture = numbered(1, 2);
        assert_eq!(texture.sample(Vec2::new(0.5, 0.75)).x, 0.0);
        assert_eq!(texture.sample(Vec2::new(0.5, 0.25)).x, 1.0);
    }

    #[test]
    fn agrees_with_slow_interpolation_and_repeats() {
        let texture = numbered(5, 3);
        let random = Stream::new(1, Stage::Test, 0);
        for i in 0..10_000 {
            let uv = Vec2::new(random.f32(i, 0), random.f32(i, 1)) * 8.0 - 4.0;
            // uv near 4 is rounded to 2^-22; the slope is below 14 a texel of 1/5.
            let bound = 14.0 * 5.0 * f64::from(f32::EPSILON) * 8.0;
            let got = f64::from(texture.sample(uv).x);
            assert!((got - reference(&texture, uv)).abs() < bound, "{uv}: {got}");
        }
    }

    #[test]
    fn edges_and_unusable_coordinates_stay_inside() {
        let texture = numbered(4, 4);
        let edges = [0.0, 1.0, -1.0, -1e-20, 1e-20, 0.999_999_94, -1e9, 3e38];
        for u in edges {
            for v in edges {
                let got = texture.sample(Vec2::new(u, v));
                assert_eq!(got.y, 1.0, "outside the picture at {u}, {v}");
            }
        }
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(texture.sample(Vec2::splat(bad)).is_nan());
        }
        let empty = Texture {
            width: 0,
            height: 0,
            texels: Vec::new(),
        };
        assert_eq!(empty.sample(Vec2::splat(0.3)), Vec3::ZERO);
        assert_eq!(empty.mean(), DVec3::ZERO);
    }

    #[test]
    fn mean_is_the_mean() {
        assert_eq!(numbered(4, 4).mean().x, 7.5);
    }
}
