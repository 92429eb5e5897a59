//! Flat glossy surfaces and polished balls, and where each of them shows a light to a point.
//!
//! A narrow lobe on the way from a point light to a rough surface (a caustic) is found neither by
//! the rough surface's own directions nor by the light's: each hits it once in thousands of paths
//! and then brings thousands of times its share. A flat surface shows the light at its mirror
//! image. For a point x and a light l at heights a and b over the plane, the slope of the half
//! vector at y is, to first order about the mirror point y0,
//!
//! s = k (cos²θ (y - y0)·t, (y - y0)·u),    k = (a + b) / (2 a b),
//!
//! t and u along and across the plane of incidence and θ the angle there. Light from afar is the
//! limit b → ∞ of it. Drawing s from the GGX
//! slopes of the surface's own alpha and taking y from it covers the lobe; the balance heuristic
//! takes care of all else, so that no approximation here makes an estimate wrong. On a ball of radius r, the
//! normal turns the other way and adds 1 / r to both slopes.

mod ball;
mod find;
mod image;
mod shown;

use ball::{Ball, BallImage};
use glam::Vec3;
use image::Mirror;
pub(crate) use image::Shown;
use shown::{Each, Frames, MOST, sum, weights};

/// In place of a mirror's number: none.
pub(crate) const NO_MIRROR: u8 = u8::MAX;

/// All of a scene's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mirrors {
    mirrors: Vec<Mirror>,
    frames: Frames,
    /// Polished balls, numbered from [`MOST`] on.
    balls: Vec<Ball>,
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
    /// Whether there is no flat one.
    pub(crate) fn is_empty(&self) -> bool {
        self.mirrors.is_empty()
    }

    /// Whether there is a flat one or a ball.
    pub(crate) fn has_any(&self) -> bool {
        !(self.mirrors.is_empty() && self.balls.is_empty())
    }

    /// The flat mirror that a triangle belongs to.
    #[inline]
    pub(crate) fn flat_of(&self, triangle: u32) -> u8 {
        let found = self.of(triangle);
        if usize::from(found) < MOST {
            found
        } else {
            NO_MIRROR
        }
    }

    /// The mirror or ball that a triangle belongs to.
    #[inline]
    pub(crate) fn of(&self, triangle: u32) -> u8 {
        let found = self.of_triangle.get(triangle as usize);
        found.copied().unwrap_or(NO_MIRROR)
    }

    /// A point on a mirror by which the light `l` is seen from `x`, from three numbers in
    /// [0, 1): which mirror, and where.
    pub(crate) fn propose(&self, x: Vec3, l: Shown, u: [f32; 3]) -> Option<Proposal> {
        self.propose_flat(x, l, &weights(&self.frames, x, l), u)
    }

    fn propose_flat(&self, x: Vec3, l: Shown, weights: &Each, u: [f32; 3]) -> Option<Proposal> {
        let total = sum(weights);
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
    pub(crate) fn density(&self, mirror: u8, x: Vec3, l: Shown, y: Vec3) -> f32 {
        let weights = weights(&self.frames, x, l);
        match weights.get(usize::from(mirror)) {
            Some(&own) if own > 0.0 => self.density_in(mirror, own / sum(&weights), x, l, y),
            _ => 0.0,
        }
    }

    /// [`Mirrors::density`] where the share of this mirror is known. Rays from x go on from the plane to where
    /// the surface is, a rounding away: a cone's area there is that in the plane over t².
    pub(crate) fn density_in(&self, mirror: u8, share: f32, x: Vec3, l: Shown, y: Vec3) -> f32 {
        self.mirrors.get(usize::from(mirror)).map_or(0.0, |own| {
            let t = own.height(x) / (own.height(x) - own.height(y));
            let in_plane = own.coordinates(x + (y - x) * t);
            share * own.image(x, l).density(own.alpha, in_plane) * t * t
        })
    }
}

/// Share of the proposals that go to balls which show a light, at the least: their images are weaker
/// than those of flat mirrors, which may be hidden.
const LEAST_BALLS: f32 = 0.3;

/// Images of a light in the balls.
struct InBalls {
    images: [Option<BallImage>; ball::MOST_BALLS],
    /// Sum of their weights.
    total: f32,
    /// Share of the proposals that go to any of them.
    share: f32,
}

impl Mirrors {
    fn in_balls(&self, x: Vec3, l: Shown, flat: f32) -> InBalls {
        let image = |k: usize| self.balls.get(k).and_then(|ball| ball.image(x, l));
        let images: [Option<BallImage>; ball::MOST_BALLS] = std::array::from_fn(image);
        let total: f32 = images.iter().flatten().map(|image| image.weight).sum();
        let share = match (total > 0.0, flat > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (total / (total + flat)).max(LEAST_BALLS),
        };
        InBalls {
            images,
            total,
            share,
        }
    }

    /// [`Mirrors::propose`] among flat mirrors and balls.
    pub(crate) fn propose_any(&self, x: Vec3, l: Shown, u: [f32; 3]) -> Option<Proposal> {
        let flat = weights(&self.frames, x, l);
        let InBalls {
            images,
            total,
            share,
        } = self.in_balls(x, l, sum(&flat));
        if u[0] >= share {
            let rest = (u[0] - share) / (1.0 - share);
            return self.propose_flat(x, l, &flat, [rest, u[1], u[2]]);
        }
        let (mut left, mut chosen) = (u[0] / share * total, None);
        for (number, image) in images.iter().enumerate() {
            if let Some(image) = image.as_ref().filter(|_| left >= 0.0) {
                left -= image.weight;
                chosen = Some((number, image));
            }
        }
        let (number, image) = chosen?;
        Some(Proposal {
            mirror: (MOST + number) as u8,
            position: image.sample(self.balls.get(number)?, [u[1], u[2]]),
            share: share * image.weight / total,
        })
    }

    /// Density of [`Mirrors::propose_any`] at `y`, a point of `mirror` with this unit normal, with respect
    /// to area.
    pub(crate) fn density_any(
        &self,
        mirror: u8,
        x: Vec3,
        l: Shown,
        (y, outward): (Vec3, Vec3),
    ) -> f32 {
        let flat = weights(&self.frames, x, l);
        let in_balls = self.in_balls(x, l, sum(&flat));
        let Some(number) = usize::from(mirror).checked_sub(MOST) else {
            let own = flat.get(usize::from(mirror)).copied().unwrap_or(0.0);
            if own <= 0.0 {
                return 0.0;
            }
            let share = (1.0 - in_balls.share) * own / sum(&flat);
            return self.density_in(mirror, share, x, l, y);
        };
        let image = in_balls.images.get(number).and_then(Option::as_ref);
        match (image, self.balls.get(number)) {
            (Some(image), Some(ball)) => {
                let share = in_balls.share * image.weight / in_balls.total;
                share * image.density(ball, x, (y, outward))
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
