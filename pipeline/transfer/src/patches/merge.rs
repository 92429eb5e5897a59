//! Elements joined to patches: those too small for one of their own, with neighbours that
//! face alike.

use super::element::Element;
use glam::DVec3;
use std::collections::BTreeMap;

/// An element of at least this share of its cell's square is a patch of its own.
const OWN: f64 = 0.5;
/// Steps of the octahedral map that normals are sorted by, along each axis.
const TURNS: f64 = 6.0;
/// Where the grid of places begins, in cells: away from the planes that scenes like to use.
const SHIFT: f64 = 0.311_7;

/// Object, material, emission; cell size, direction and cell of the place.
type Key = ([i64; 3], i64, [i64; 2], [i64; 3]);

/// Patch of every element; patches are numbered in the order of their first elements.
pub(super) fn patches_of(elements: &[Element], kinds: &[[i64; 3]]) -> Vec<u32> {
    let mut known: BTreeMap<Key, u32> = BTreeMap::new();
    let mut next = 0;
    let mut new = || {
        next += 1;
        next - 1
    };
    (elements.iter().zip(kinds))
        .map(|(element, &kind)| {
            if element.area >= OWN * element.edge * element.edge {
                return new();
            }
            let cell = element.centre / element.edge + DVec3::splat(SHIFT);
            let place = cell.floor().to_array().map(|x| x as i64);
            let size = (element.edge.log2() * 16.0).round() as i64;
            let key = (kind, size, direction(element.normal.as_dvec3()), place);
            *known.entry(key).or_insert_with(&mut new)
        })
        .collect()
}

/// Cell of a unit normal on the octahedron unfolded to a square (Meyer et al. 2010).
fn direction(n: DVec3) -> [i64; 2] {
    let sum = n.x.abs() + n.y.abs() + n.z.abs();
    let (x, y) = (n.x / sum, n.y / sum);
    let (x, y) = if n.z >= 0.0 {
        (x, y)
    } else {
        let turn = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
        (turn(x, y), turn(y, x))
    };
    // the shift keeps the axes, along which scenes are built, away from a border
    [x, y].map(|c| ((c + 1.0) * 0.5 * TURNS + 0.5 + 1e-3).floor() as i64)
}
