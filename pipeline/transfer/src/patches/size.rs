//! How fine patches are, place by place.

use glam::Vec3;
use std::collections::BTreeMap;

/// Quarterings of a patch at most.
const MOST: u8 = 4;

/// Patch sizes in the cells of a grid: smaller where surroundings are near and light varies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchSizes {
    /// Edge of a cell, metres.
    pub edge: f32,
    /// Quarterings of a patch, where there are any; keys are floor(position / edge).
    pub levels: BTreeMap<[i32; 3], u8>,
}

impl PatchSizes {
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
    fn places_are_as_fine_as_asked_for() {
        let mut sizes = PatchSizes::even(0.2);
        sizes.demand(Vec3::splat(0.01), 1);
        sizes.demand(Vec3::splat(0.03), 2);
        sizes.demand(Vec3::splat(0.05), 1);
        sizes.demand(Vec3::ONE, 200);
        let size: SizeField = &sizes.field();
        assert_eq!(size(Vec3::splat(0.02)), 0.25);
        assert_eq!(size(Vec3::splat(1.05)), 1.0 / f32::from(1u16 << MOST));
        assert_eq!(size(Vec3::splat(9.0)), 1.0);
    }
}
