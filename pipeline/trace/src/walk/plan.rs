//! Which subtrees of the binary tree become the children of which wide node.
//!
//! The cheapest choice by the surface area heuristic, found by dynamic programming over the
//! binary tree (Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs*, HPG 2017, section 4).

use super::WIDTH;
use obvhs::bvh2::Bvh2;

/// Time of a test of eight triangles in units of a test of eight boxes.
const LEAF_COST: f32 = 1.2;

/// Costs of all binary subtrees.
pub(super) struct Plan {
    /// Triangles below each binary node.
    counts: Vec<u32>,
    /// `forest[n][i]`: least cost of subtree n as at most i + 1 wide children.
    forest: Vec<[f32; WIDTH]>,
    /// Whether subtree n is better one leaf than one node.
    leaf: Vec<bool>,
}

impl Plan {
    pub(super) fn new(tree: &Bvh2) -> Plan {
        let nodes = tree.nodes.len();
        let mut plan = Plan {
            counts: vec![0; nodes],
            forest: vec![[0.0; WIDTH]; nodes],
            leaf: vec![false; nodes],
        };
        if nodes > 0 {
            plan.visit(tree, 0);
        }
        plan
    }

    /// Whether a subtree becomes one leaf.
    pub(super) fn is_leaf(&self, n: usize) -> bool {
        self.leaf[n]
    }

    fn visit(&mut self, tree: &Bvh2, n: usize) {
        let node = &tree.nodes[n];
        let area = node.aabb().half_area();
        if node.is_leaf() {
            self.counts[n] = node.prim_count;
            self.leaf[n] = true;
            self.forest[n] = [area * LEAF_COST; WIDTH];
            return;
        }
        let left = node.first_index as usize;
        self.visit(tree, left);
        self.visit(tree, left + 1);
        self.counts[n] = self.counts[left] + self.counts[left + 1];
        let as_node = area + self.shared(left, WIDTH).0;
        let as_leaf = if self.counts[n] as usize <= WIDTH {
            area * LEAF_COST
        } else {
            f32::INFINITY
        };
        self.leaf[n] = as_leaf <= as_node;
        self.forest[n][0] = as_leaf.min(as_node);
        for i in 1..WIDTH {
            self.forest[n][i] = self.forest[n][i - 1].min(self.shared(left, i + 1).0);
        }
    }

    /// Least cost of two sibling subtrees as `among` wide children, and how many of them the
    /// left one has.
    fn shared(&self, left: usize, among: usize) -> (f32, usize) {
        let cost = |k: usize| self.forest[left][k - 1] + self.forest[left + 1][among - k - 1];
        (1..among).fold((f32::INFINITY, 1), |best, k| {
            if cost(k) < best.0 { (cost(k), k) } else { best }
        })
    }

    /// The subtrees that become the children of a node for subtree `n`; itself, where it is
    /// one leaf.
    pub(super) fn open(&self, tree: &Bvh2, n: usize, children: &mut Vec<usize>) {
        if self.leaf[n] {
            children.push(n);
            return;
        }
        let left = tree.nodes[n].first_index as usize;
        let (_, k) = self.shared(left, WIDTH);
        self.spread(tree, left, k, children);
        self.spread(tree, left + 1, WIDTH - k, children);
    }

    /// Subtree `n` as at most `among` children.
    fn spread(&self, tree: &Bvh2, n: usize, among: usize, children: &mut Vec<usize>) {
        if among == 1 || self.forest[n][among - 1] == self.forest[n][0] {
            children.push(n);
            return;
        }
        if self.forest[n][among - 1] == self.forest[n][among - 2] {
            return self.spread(tree, n, among - 1, children);
        }
        let left = tree.nodes[n].first_index as usize;
        let (_, k) = self.shared(left, among);
        self.spread(tree, left, k, children);
        self.spread(tree, left + 1, among - k, children);
    }
}
