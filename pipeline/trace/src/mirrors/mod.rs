//! Flat glossy surfaces, and where each of them shows a point light to a point.
//!
//! A narrow lobe on the way from a point light to a rough surface (a caustic) is found neither by
//! the rough surface's own directions nor by the light's: each hits it once in thousands of paths
//! and then brings thousands of times its share. A flat surface shows the light at its mirror
//! image. For a point x and a light l at heights a and b over the plane, the slope of the half
//! vector at y is, to first order about the mirror point y0,
//!
//! s = k (cos²θ (y - y0)·t, (y - y0)·u),    k = (a + b) / (2 a b),
//!
//! t and u along and across the plane of incidence and θ the angle there. Drawing s from the GGX
//! slopes of the surface's own alpha and taking y from it covers the lobe; the balance heuristic
//! takes care of all else, so that no approximation here makes an estimate wrong.

mod find;
mod image;
mod shown;

use glam::Vec3;
use image::Mirror;
use shown::{Frames, sum, weights};

/// In place of a mirror's number: none.
pub(crate) const NO_MIRROR: u8 = u8::MAX;

/// All of a scene's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mirrors {
    mirrors: Vec<Mirror>,
    frames: Frames,
    /// Of each triangle, or [`NO_MIRROR`]; empty where there is none at all.
    of_triangle: Vec<u8>,
}

/// A point to go to.
pub(crate) struct Proposal {
    /// Which mirror it is on.
    pub(crate) mirror: u8,
    pub(crate) position: Vec3,
    /// How often this mirror is taken from there.
    pub(crate) share: f32,
}

impl Mirrors {
    pub(crate) fn is_empty(&self) -> bool {
        self.mirrors.is_empty()
    }

    /// The mirror that a triangle belongs to.
    #[inline]
    pub(crate) fn of(&self, triangle: u32) -> u8 {
        let found = self.of_triangle.get(triangle as usize);
        found.copied().unwrap_or(NO_MIRROR)
    }

    /// A point on a mirror by which the light at `l` is seen from `x`, from three numbers in
    /// [0, 1): which mirror, and where.
    pub(crate) fn propose(&self, x: Vec3, l: Vec3, u: [f32; 3]) -> Option<Proposal> {
        let weights = weights(&self.frames, x, l);
        let total = sum(&weights);
        if total == 0.0 {
            return None;
        }
        // the first whose share of the sum so far goes beyond the number; without a branch each
        let (mut so_far, mut chosen, mut last) = (0.0, 0, 0);
        for (number, weight) in weights.iter().enumerate().take(self.mirrors.len()) {
            so_far += weight;
            chosen += usize::from(so_far <= u[0] * total);
            last = if *weight > 0.0 { number } else { last };
        }
        let chosen = chosen.min(last);
        let mirror = self.mirrors.get(chosen)?;
        let image = mirror.image(x, l);
        Some(Proposal {
            mirror: chosen as u8,
            position: mirror.at(image.sample(mirror.alpha, [u[1], u[2]])),
            share: weights[chosen] / total,
        })
    }

    /// Density of [`Mirrors::propose`] at `y` on `mirror`, with respect to area.
    pub(crate) fn density(&self, mirror: u8, x: Vec3, l: Vec3, y: Vec3) -> f32 {
        let weights = weights(&self.frames, x, l);
        match weights.get(usize::from(mirror)) {
            Some(&own) if own > 0.0 => self.density_in(mirror, own / sum(&weights), x, l, y),
            _ => 0.0,
        }
    }

    /// [`Mirrors::density`] where the share of this mirror is known. Rays from x go on from the plane to where
    /// the surface is, a rounding away: a cone's area there is that in the plane over t².
    pub(crate) fn density_in(&self, mirror: u8, share: f32, x: Vec3, l: Vec3, y: Vec3) -> f32 {
        self.mirrors.get(usize::from(mirror)).map_or(0.0, |own| {
            let t = own.height(x) / (own.height(x) - own.height(y));
            let in_plane = own.coordinates(x + (y - x) * t);
            share * own.image(x, l).density(own.alpha, in_plane) * t * t
        })
    }
}

#[cfg(test)]
mod tests;
