//! Where light from afar comes in: windows, doors and holes in the roof.
//!
//! A box about the scene is divided into cells. Those through which light was seen to come in are
//! aimed at, by shadow rays to the sky and by the lights' own rays. All of it is weighed against samplers that aim at the
//! whole sky, so that a cell that was not seen costs noise and nothing else.

mod aim;
mod pilot;

pub(crate) use aim::{aim, aim_density};
pub(crate) use pilot::Walks;

use glam::Vec3;
use rrf_sampling::warp::{by_weight, by_weight_probability};

/// Cells along each side of a face.
const SIDE: usize = 12;
const FACE: usize = SIDE * SIDE;

/// Where light from afar comes in: cells of a box, and how much each of them is aimed at.
#[derive(Clone, Debug)]
pub struct Openings {
    low: Vec3,
    size: Vec3,
    /// Cumulative weights of the cells of each face: faces are low and high of x, y, z.
    faces: [Vec<f64>; 6],
    /// Cumulative weights of the faces.
    all: Vec<f64>,
    /// Share of the directions to a sky that go through them.
    share: f32,
}

/// The largest share of the directions to a sky that go through openings.
const MOST: f64 = 0.8;

impl Openings {
    /// Share of the directions to a sky that go through openings: the more, the less of what the sky's own
    /// sampler draws arrives.
    pub(crate) fn share(&self) -> f32 {
        self.share
    }

    /// Share of a sky's light that arrives where it was looked for, by its own directions.
    pub fn arriving(&self) -> f32 {
        1.0 - self.share / MOST as f32
    }

    /// A point of the box that the weights choose.
    pub(crate) fn sample(&self, u: [f32; 3]) -> Option<Vec3> {
        self.point(by_weight(&self.all, u[0]), [u[1], u[2]])
    }

    /// A face by its weight, by a number in [0, 1).
    pub(crate) fn face(&self, u: f32) -> usize {
        by_weight(&self.all, u)
    }

    /// Probability of [`Openings::face`] to choose a face.
    pub(crate) fn chance(&self, face: usize) -> f32 {
        by_weight_probability(&self.all, face) as f32
    }

    /// A point of a face that the weights of its cells choose.
    pub(crate) fn point(&self, face: usize, u: [f32; 2]) -> Option<Vec3> {
        let cells = self.faces.get(face)?;
        if cells.last().is_none_or(|&total| total <= 0.0) {
            return None;
        }
        // the number serves for the cell and the place in it
        let cell = by_weight(cells, u[0]);
        let chance = by_weight_probability(cells, cell) as f32;
        let before = cell.checked_sub(1).and_then(|c| cells.get(c));
        let total = cells.last().copied().unwrap_or(1.0);
        let before = (before.copied().unwrap_or(0.0) / total) as f32;
        let within = (u[0] - before) / chance.max(f32::MIN_POSITIVE);
        let axis = face / 2;
        let [a, b] = across(axis);
        let mut at = self.low;
        at[axis] += if face % 2 == 1 { self.size[axis] } else { 0.0 };
        at[a] += ((cell % SIDE) as f32 + within.clamp(0.0, 1.0)) / SIDE as f32 * self.size[a];
        at[b] += ((cell / SIDE) as f32 + u[1]) / SIDE as f32 * self.size[b];
        Some(at)
    }

    /// Density of [`Openings::sample`] with respect to angle from `at`.
    pub(crate) fn angle_density(&self, at: Vec3, toward: Vec3) -> f32 {
        let Some((face, cell, t)) = leaves(self.low, self.size, at, toward) else {
            return 0.0;
        };
        let cosine = outward(face, toward);
        self.chance(face) * self.area_density(face, cell) * t * t / cosine
    }

    /// The face that light from `toward` comes in through on its way to `at`, and the density of
    /// [`Openings::point`] there with respect to area across the light.
    pub(crate) fn beam_density(&self, at: Vec3, toward: Vec3) -> Option<(usize, f32)> {
        let (face, cell, _) = leaves(self.low, self.size, at, toward)?;
        Some((face, self.area_density(face, cell) / outward(face, toward)))
    }

    /// Density of a cell among those of its face, with respect to area.
    fn area_density(&self, face: usize, cell: usize) -> f32 {
        let cells = &self.faces[face];
        if cells.last().is_none_or(|&total| total <= 0.0) {
            return 0.0;
        }
        let [a, b] = across(face / 2);
        let area = self.size[a] * self.size[b] / FACE as f32;
        by_weight_probability(cells, cell) as f32 / area
    }
}

/// Counts of light seen through each cell of a box's faces.
pub(crate) struct Seen {
    low: Vec3,
    size: Vec3,
    /// By walks' own directions and by lights'.
    sums: [Vec<f64>; 2],
    /// Weight of the lights' own directions that were drawn, and of those that light came by.
    drawn: f64,
    arrived: f64,
}

impl Seen {
    /// Nothing, of a box about these corners.
    pub(crate) fn new([low, high]: [Vec3; 2]) -> Seen {
        let margin = Vec3::splat(1e-4 * (high - low).length());
        Seen {
            low: low - margin,
            size: high - low + 2.0 * margin,
            sums: [vec![0.0; 6 * FACE], vec![0.0; 6 * FACE]],
            drawn: 0.0,
            arrived: 0.0,
        }
    }

    /// A walk's ray that leaves the scene.
    pub(crate) fn leave(&mut self, origin: Vec3, direction: Vec3, weight: f64) {
        self.add(0, origin, direction, weight);
    }

    /// A light's own direction, of which a share of the light arrives.
    pub(crate) fn draw(&mut self, origin: Vec3, direction: Vec3, weight: f64, share: f64) {
        self.drawn += weight;
        self.arrived += weight * share;
        if share > 0.0 {
            self.add(1, origin, direction, weight * share);
        }
    }

    /// A ray that leaves: its cell counts, and those about it a little.
    fn add(&mut self, by: usize, origin: Vec3, direction: Vec3, weight: f64) {
        let Some((face, cell, _)) = leaves(self.low, self.size, origin, direction) else {
            return;
        };
        let (column, row) = ((cell % SIDE) as isize, (cell / SIDE) as isize);
        for (dc, dr) in (-1..=1).flat_map(|dr| (-1..=1).map(move |dc| (dc, dr))) {
            let (c, r) = (column + dc, row + dr);
            if (0..SIDE as isize).contains(&c) && (0..SIDE as isize).contains(&r) {
                let share = if dc == 0 && dr == 0 { 1.0 } else { 0.15 };
                let index = face * FACE + r as usize * SIDE + c as usize;
                self.sums[by][index] += weight * share;
            }
        }
    }

    /// Both kinds of rays count alike.
    pub(crate) fn openings(self) -> Option<Openings> {
        let mut weights = vec![0.0; 6 * FACE];
        for sums in &self.sums {
            let total: f64 = sums.iter().sum();
            if total > 0.0 {
                let scaled = weights.iter_mut().zip(sums);
                scaled.for_each(|(weight, sum)| *weight += sum / total);
            }
        }
        let mut faces: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(FACE));
        let (mut all, mut total) = (Vec::with_capacity(6), 0.0);
        for (face, cells) in faces.iter_mut().zip(weights.chunks(FACE)) {
            let mut sum = 0.0;
            face.extend(cells.iter().map(|weight| {
                sum += weight;
                sum
            }));
            total += sum;
            all.push(total);
        }
        let hidden = 1.0 - self.arrived / self.drawn.max(f64::MIN_POSITIVE);
        let Seen { low, size, .. } = self;
        (total > 0.0).then_some(Openings {
            low,
            size,
            faces,
            all,
            share: (MOST * hidden) as f32,
        })
    }
}

/// The two axes along a face across `axis`.
fn across(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// How much a direction goes out through a face.
pub(crate) fn outward(face: usize, toward: Vec3) -> f32 {
    let along = toward[face / 2];
    if face % 2 == 1 { along } else { -along }
}

/// Face, cell and distance where a ray from inside leaves the box.
fn leaves(low: Vec3, size: Vec3, at: Vec3, toward: Vec3) -> Option<(usize, usize, f32)> {
    let (mut nearest, mut face) = (f32::INFINITY, None);
    for axis in 0..3 {
        let goes_up = toward[axis] > 0.0;
        let bound = low[axis] + if goes_up { size[axis] } else { 0.0 };
        let t = (bound - at[axis]) / toward[axis];
        if toward[axis] != 0.0 && t >= 0.0 && t < nearest {
            (nearest, face) = (t, Some(2 * axis + usize::from(goes_up)));
        }
    }
    let face = face?;
    let place = at + toward * nearest;
    let cell = |axis: usize| {
        let along = (place[axis] - low[axis]) / size[axis] * SIDE as f32;
        (along.max(0.0) as usize).min(SIDE - 1)
    };
    let [a, b] = across(face / 2);
    Some((face, cell(b) * SIDE + cell(a), nearest))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use rrf_sampling::Stream;

    pub(crate) fn openings() -> Openings {
        let mut seen = Seen {
            low: Vec3::new(-2.0, 0.0, -1.0),
            size: Vec3::new(4.0, 3.0, 2.0),
            sums: [vec![0.0; 6 * FACE], vec![0.0; 6 * FACE]],
            drawn: 1.0,
            arrived: 0.0,
        };
        for k in 0..40 {
            let along = k as f32 / 40.0;
            seen.add(0, Vec3::Y, Vec3::new(-1.0, 0.4 * along, 0.1), 1.0);
            seen.add(
                1,
                Vec3::Y,
                Vec3::new(0.1, 1.0, 0.3 - along).normalize(),
                0.7,
            );
        }
        seen.openings().unwrap()
    }

    /// Directions to sampled points have their density: the mean of 1 / density over those in a cone
    /// is the cone's solid angle, if every direction in it can be drawn; by z at 5.
    #[test]
    fn directions_have_their_density() {
        let openings = openings();
        let stream = Stream::new(4, rrf_sampling::Stage::Test, 0);
        let from = Vec3::new(0.2, 1.1, 0.1);
        let axis = Vec3::new(-1.0, 0.1, 0.05).normalize();
        let (cosine, count) = (0.995f32, 400_000u64);
        let (mut sum, mut squares) = (0.0f64, 0.0f64);
        for i in 0..count {
            let [a, b, c, _] = stream.units(i, 0, 0);
            let toward = (openings.sample([a, b, c]).unwrap() - from).normalize();
            if toward.dot(axis) > cosine {
                let x = 1.0 / f64::from(openings.angle_density(from, toward));
                sum += x;
                squares += x * x;
            }
        }
        let mean = sum / count as f64;
        let error = ((squares / count as f64 - mean * mean) / count as f64).sqrt();
        let expected = 2.0 * std::f64::consts::PI * (1.0 - f64::from(cosine));
        assert!(
            (mean - expected).abs() < 5.0 * error,
            "{mean} ± {error}, {expected}"
        );
        assert!(error < 0.01 * expected);
    }
}
