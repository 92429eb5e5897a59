//! From a binary tree to nodes of eight children and leaves of eight triangles.

use super::edges::Edges;
use super::flat::{self, Flat};
use super::plan::Plan;
use super::{ABSENT, LEAF, Leaf, Node, WIDTH, Wide};
use glam::{DVec3, Vec3};
use obvhs::bvh2::Bvh2;
use rrf_scene::INVALID;

/// Rounding units of the scene's extent by which boxes are grown: the edge products place a
/// triangle's border no better than that.
const PAD: f32 = 16.0 * f32::EPSILON;

impl Wide {
    /// Collapses `tree`, whose primitive i is the triangle `corners[i]` with scene id `ids[i]`.
    pub fn new(tree: &Bvh2, corners: &[[Vec3; 3]], ids: &[u32]) -> Wide {
        let low = corners
            .iter()
            .flatten()
            .fold(Vec3::INFINITY, |low, p| low.min(*p));
        let high = corners
            .iter()
            .flatten()
            .fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
        let mut wide = Wide {
            nodes: Vec::new(),
            leaves: Vec::new(),
            // Halved before the sum: huge coordinates must not overflow.
            centre: 0.5 * low + 0.5 * high,
            depth: 0,
            flat: None,
        };
        if corners.len() <= flat::MOST {
            wide.flat = Some(Flat::new(corners, ids, wide.centre));
        }
        let plan = Plan::new(tree);
        let source = Source {
            tree,
            plan: &plan,
            corners,
            ids,
            centre: wide.centre.as_dvec3(),
            pad: PAD * (0.5 * high - 0.5 * low).max_element(),
        };
        if !tree.nodes.is_empty() {
            wide.node(&source, 0, 1);
        }
        wide
    }

    /// Appends a node for the subtree `root`, and everything below it.
    fn node(&mut self, source: &Source, root: usize, depth: usize) -> u32 {
        self.depth = self.depth.max(depth * WIDTH);
        let mut children = Vec::with_capacity(WIDTH);
        source.plan.open(source.tree, root, &mut children);
        let index = self.nodes.len();
        self.nodes.push(Node {
            bounds: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
            child: [ABSENT; WIDTH],
        });
        for (lane, &root) in children.iter().enumerate() {
            let bounds = source.tree.nodes[root].aabb();
            let child = if source.plan.is_leaf(root) {
                self.leaves.push(source.leaf(root));
                LEAF | (self.leaves.len() as u32 - 1)
            } else {
                self.node(source, root, depth + 1)
            };
            let low = Vec3::from(bounds.min) - self.centre - source.pad;
            let high = Vec3::from(bounds.max) - self.centre + source.pad;
            let into = &mut self.nodes[index];
            into.child[lane] = child;
            for axis in 0..3 {
                into.bounds[axis][0][lane] = low[axis];
                into.bounds[axis][1][lane] = high[axis];
            }
        }
        index as u32
    }
}

/// Inputs of a collapse.
struct Source<'a> {
    tree: &'a Bvh2,
    plan: &'a Plan,
    corners: &'a [[Vec3; 3]],
    ids: &'a [u32],
    centre: DVec3,
    /// How much boxes are grown on all sides, metres.
    pad: f32,
}

impl Source<'_> {
    /// The triangles of a subtree as one leaf.
    fn leaf(&self, root: usize) -> Leaf {
        let mut leaf = Leaf {
            plane: [[0.0; WIDTH]; 4],
            edges: [[[0.0; WIDTH]; 6]; 3],
            ids: [INVALID; WIDTH],
        };
        let mut slots = Vec::with_capacity(WIDTH);
        self.gather(root, &mut slots);
        for (lane, &slot) in slots.iter().take(WIDTH).enumerate() {
            leaf.ids[lane] = self.ids[slot];
            let edges = Edges::new(self.corners[slot], self.centre);
            for (row, value) in leaf.plane.iter_mut().zip(edges.plane) {
                row[lane] = value;
            }
            let rows = leaf.edges.iter_mut().flatten();
            for (row, value) in rows.zip(edges.edges.iter().flatten()) {
                row[lane] = *value;
            }
        }
        leaf
    }

    fn gather(&self, root: usize, slots: &mut Vec<usize>) {
        let node = &self.tree.nodes[root];
        if node.is_leaf() {
            let range = node.first_index..node.first_index + node.prim_count;
            slots.extend(range.map(|i| self.tree.primitive_indices[i as usize] as usize));
        } else {
            self.gather(node.first_index as usize, slots);
            self.gather(node.first_index as usize + 1, slots);
        }
    }
}
