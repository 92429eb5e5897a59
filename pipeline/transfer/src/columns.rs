//! Columns of the transfer in a tree: near light patch by patch, far light by the cluster.
//!
//! The light that a far cluster of patches sends to a cell depends on its sum alone, or almost;
//! a tree over all columns, as in lightcuts (Walter et al. 2005), lets every cell take each part of
//! the scene as finely as it needs. A node's light is the area-weighted sum of its columns'
//! irradiance: the flux that arrives there.

use crate::patches::Patches;
use glam::Vec3;

/// Metres that a turn of the normal, and of the direction that light comes from, are worth.
const TURN: f32 = 0.6;
/// No child.
const NONE: u32 = u32::MAX;

/// A binary tree over the columns of patches; children stand after their parents.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnTree {
    /// Both children of each node; a leaf has none.
    children: Vec<[u32; 2]>,
    /// First and last-but-one of each node's columns in `order`.
    ranges: Vec<[u32; 2]>,
    /// Columns, those of a node together.
    order: Vec<u32>,
    /// Area of each column's patch, square metres.
    area: Vec<f32>,
}

/// A column: where it lies and which way its light comes from.
struct Place {
    column: u32,
    at: [f32; 9],
}

impl ColumnTree {
    /// The tree over all columns; it follows from the patches.
    pub fn new(patches: &Patches) -> ColumnTree {
        let mut places = Vec::with_capacity(patches.columns());
        let mut area = Vec::with_capacity(patches.columns());
        for patch in 0..patches.len() as u32 {
            let normal = patches.normal[patch as usize];
            for back in [false, true] {
                let first = patches.first_column(patch, back);
                let n = if back { -normal } else { normal };
                let count = patches.directions(patch);
                for cell in 0..count * count {
                    let direction = patches.middle_direction(patch, n, cell);
                    let [p, n, d] = [patches.centre[patch as usize], n * TURN, direction * TURN];
                    places.push(Place {
                        column: first + cell,
                        at: [p.x, p.y, p.z, n.x, n.y, n.z, d.x, d.y, d.z],
                    });
                    area.push(patches.area[patch as usize]);
                }
            }
        }
        let mut tree = ColumnTree {
            area,
            ..ColumnTree::default()
        };
        let count = places.len();
        if count > 0 {
            tree.grow(&mut places, 0, count);
        }
        tree.order = places.iter().map(|place| place.column).collect();
        tree
    }

    fn grow(&mut self, places: &mut [Place], low: usize, high: usize) -> u32 {
        let node = self.children.len();
        self.children.push([NONE; 2]);
        self.ranges.push([low as u32, high as u32]);
        if high - low > 1 {
            let middle = low + split(&mut places[low..high]);
            let left = self.grow(places, low, middle);
            let right = self.grow(places, middle, high);
            self.children[node] = [left, right];
        }
        node as u32
    }

    /// How many nodes.
    pub fn len(&self) -> usize {
        self.children.len()
    }

    /// Whether there is no column.
    pub fn is_empty(&self) -> bool {
        self.children.is_empty()
    }

    /// How many columns.
    pub fn columns(&self) -> usize {
        self.order.len()
    }

    /// Both children of a node, the first right behind it; none of a leaf.
    pub fn children(&self, node: u32) -> Option<[u32; 2]> {
        let children = self.children[node as usize];
        (children[0] != NONE).then_some(children)
    }

    /// Columns of a node.
    pub fn columns_of(&self, node: u32) -> &[u32] {
        let [low, high] = self.ranges[node as usize];
        &self.order[low as usize..high as usize]
    }

    /// Area of a column's patch, square metres.
    pub fn area(&self, column: u32) -> f32 {
        self.area[column as usize]
    }

    /// Returns the power \[W\] that arrives at every node, from the irradiance \[W/m²\] of every column.
    pub fn fluxes(&self, irradiance: &[Vec3]) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; self.children.len()];
        for node in (0..self.children.len()).rev() {
            sums[node] = match self.children(node as u32) {
                Some([left, right]) => sums[left as usize] + sums[right as usize],
                None => {
                    let column = self.order[self.ranges[node][0] as usize] as usize;
                    irradiance[column] * self.area[column]
                }
            };
        }
        sums
    }
}

/// Parts places in two along their widest axis, at the middle of it or, where all lie on one side,
/// by halves; returns where the second part begins.
fn split(places: &mut [Place]) -> usize {
    let (mut low, mut high) = ([f32::INFINITY; 9], [f32::NEG_INFINITY; 9]);
    for place in places.iter() {
        for axis in 0..9 {
            low[axis] = low[axis].min(place.at[axis]);
            high[axis] = high[axis].max(place.at[axis]);
        }
    }
    let wide = |axis: usize| high[axis] - low[axis];
    let axis = (1..9).fold(
        0,
        |best, axis| if wide(axis) > wide(best) { axis } else { best },
    );
    places.sort_by(|a, b| {
        let order = a.at[axis].total_cmp(&b.at[axis]);
        order.then(a.column.cmp(&b.column))
    });
    let middle = 0.5 * (low[axis] + high[axis]);
    let at = places.partition_point(|place| place.at[axis] < middle);
    if at == 0 || at == places.len() {
        places.len() / 2
    } else {
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::PatchConfig;
    use rrf_scene::{LoadOptions, load};

    /// Every column lies in one leaf, and a node's flux is the sum over its columns.
    #[test]
    fn nodes_hold_their_columns() {
        let file = "/../../scenes/cornell-glossy/cornell-glossy.glb";
        let path = format!("{}{file}", env!("CARGO_MANIFEST_DIR"));
        let scene = load(path.as_ref(), &LoadOptions::default()).unwrap();
        let config = PatchConfig {
            count: 200,
            ..PatchConfig::default()
        };
        let patches = Patches::new(&scene, &config, &|_| 1.0).unwrap();
        let tree = ColumnTree::new(&patches);
        assert_eq!(tree.columns(), patches.columns());
        assert_eq!(tree.len(), 2 * tree.columns() - 1);
        let mut all = tree.columns_of(0).to_vec();
        all.sort_unstable();
        assert!(all.iter().enumerate().all(|(i, &c)| i == c as usize));
        let irradiance: Vec<Vec3> = (0..tree.columns())
            .map(|c| Vec3::new(1.0, c as f32 / 100.0, (c % 7) as f32))
            .collect();
        let fluxes = tree.fluxes(&irradiance);
        for node in (0..tree.len() as u32).step_by(37) {
            let columns = tree.columns_of(node).iter();
            let sum: Vec3 = columns
                .map(|&c| irradiance[c as usize] * tree.area(c))
                .sum();
            assert!(fluxes[node as usize].abs_diff_eq(sum, 1e-4 * sum.max_element()));
            if let Some([left, right]) = tree.children(node) {
                let parts = [tree.columns_of(left), tree.columns_of(right)].concat();
                assert_eq!(parts, tree.columns_of(node));
                assert!(left > node && right > node);
            }
        }
    }
}
