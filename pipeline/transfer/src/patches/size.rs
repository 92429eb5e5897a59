//! How fine patches are, place by place.

use glam::Vec3;
use std::collections::BTreeMap;

/// Quarterings of a patch at most.
const MOST: u8 = 4;

/// Patch sizes in the cells of a grid: as small as surroundings are near, so that a patch in a gap
/// is about as wide as the gap (Ward, Rubinstein, Clear 1988 space their samples alike).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchSizes {
    /// Edge of a cell, metres.
    pub edge: f32,
    /// Quarterings of a patch, where there are any; keys are floor(position / edge).
    pub levels: BTreeMap<[i32; 3], u8>,
}

impl PatchSizes {
    /// From places and the harmonic mean distance of what is around each, for patches of an edge;
    /// a patch is to be at most `width` times that distance wide.
    pub fn new(around: &[(Vec3, f32)], patch_edge: f32, width: f32) -> PatchSizes {
        let edge = 0.5 * patch_edge;
        let mut sums: BTreeMap<[i32; 3], (f64, u32)> = BTreeMap::new();
        for (place, distance) in around {
            let sum = sums.entry(cell(*place, edge)).or_default();
            sum.0 += f64::from(1.0 / distance.max(1e-3));
            sum.1 += 1;
        }
        let level = |(sum, count): (f64, u32)| {
            let distance = f64::from(count) / sum;
            let wanted = (f64::from(patch_edge) / (f64::from(width) * distance)).log2();
            wanted.ceil().clamp(0.0, f64::from(MOST)) as u8
        };
        let levels = sums.into_iter().map(|(key, sum)| (key, level(sum)));
        PatchSizes {
            edge,
            levels: levels.filter(|l| l.1 > 0).collect(),
        }
    }

    /// Quarterings of a patch at most.
    pub(crate) const MOST: u8 = MOST;

    /// Patches of one size, whose edge this is.
    pub(crate) fn even(patch_edge: f32) -> PatchSizes {
        PatchSizes {
            edge: 0.5 * patch_edge,
            levels: BTreeMap::new(),
        }
    }

    /// Asks for patches that are quartered so often around a place.
    pub(crate) fn demand(&mut self, place: Vec3, level: u8) {
        let own = self.levels.entry(cell(place, self.edge)).or_default();
        *own = (*own).max(level.min(MOST));
    }

    /// Asks for all that other sizes for the same patches ask for.
    pub(crate) fn join(&mut self, other: &PatchSizes) {
        for (&key, &level) in &other.levels {
            let own = self.levels.entry(key).or_default();
            *own = (*own).max(level);
        }
    }

    /// Size of a patch at a place, as a share of the largest.
    pub fn at(&self, place: Vec3) -> f32 {
        let level = self.levels.get(&cell(place, self.edge));
        level.map_or(1.0, |&level| 1.0 / f32::from(1u16 << level))
    }

    /// The sizes as a field.
    pub fn field(&self) -> impl Fn(Vec3) -> f32 + Sync + '_ {
        |place| self.at(place)
    }
}

fn cell(place: Vec3, edge: f32) -> [i32; 3] {
    (place / edge.max(1e-6))
        .floor()
        .to_array()
        .map(|x| x as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::SizeField;

    #[test]
    fn gaps_are_fine_and_open_places_are_not() {
        let near = [(Vec3::ZERO, 0.06), (Vec3::splat(0.01), 0.06)];
        let far = [(Vec3::ONE, 2.0)];
        let sizes = PatchSizes::new(&[near.as_slice(), &far].concat(), 0.2, 1.0);
        let size: SizeField = &sizes.field();
        assert_eq!(size(Vec3::splat(0.02)), 0.25);
        assert_eq!(size(Vec3::ONE), 1.0);
        assert_eq!(size(Vec3::splat(9.0)), 1.0);
    }
}
