//! The hierarchy that rays walk: obvhs' binary tree, collapsed to eight children a node and
//! eight triangles a leaf, so that one ray meets eight boxes or eight triangles at once.
//!
//! Eight-wide collapse: Wald, Benthin, Boulos, *Getting Rid of Packets*, IRT 2008.
//! Edges are tested by the sign of Pluecker products that two neighbours compute from the
//! same numbers with opposite signs (Davidovic et al. 2012), so no ray slips between them.
//! All arithmetic is plain IEEE without fused operations: every instruction set gives the
//! same bits.

mod collapse;
mod edges;
mod flat;
mod plan;
mod ray;

use edges::{Edges, Line, barycentrics, max, min};
use flat::Flat;
use glam::Vec3;
pub use ray::{Found, Ray};
use rrf_scene::INVALID;

/// Children of a node and triangles of a leaf.
pub const WIDTH: usize = 8;
type Lanes = [f32; WIDTH];

/// Top bit of a child reference: the rest is a leaf.
const LEAF: u32 = 1 << 31;
/// No child: a leaf that does not exist.
const ABSENT: u32 = u32::MAX;
/// The slab test's rounding, three operations a bound (Ize, JCGT 2013).
const FAR_SLACK: f32 = 1.0 + 3.0 * f32::EPSILON;
/// Stands in for zero direction components: keeps 0 times infinity out of the slab test.
const TINY: f32 = 1e-20;

/// Boxes of eight children.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Node {
    /// `bounds[axis][0]` are the lower bounds, `bounds[axis][1]` the upper ones.
    bounds: [[Lanes; 2]; 3],
    child: [u32; WIDTH],
}

/// Eight triangles; unused lanes have a zero normal and are never hit.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Leaf {
    /// Unit geometric normal and its product with a corner: the plane n.x = c.
    plane: [Lanes; 4],
    /// For the edges opposite to corners 0, 1, 2: direction b - a, then moment a x b.
    edges: [[Lanes; 6]; 3],
    /// Scene ids.
    ids: [u32; WIDTH],
}

/// The collapsed tree.
#[derive(Clone, Debug)]
pub struct Wide {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    /// Middle of the scene: all else is stored relative to it, so that a scene far from the
    /// origin loses no digits.
    centre: Vec3,
    /// Child references that can wait at once.
    depth: usize,
    /// A small scene's faster way.
    flat: Option<Flat>,
}

/// A ray with what the box tests share.
#[derive(Clone, Copy)]
struct Prepared {
    line: Line,
    inverse: [f32; 3],
    /// Which bound of an axis the ray meets first: 1 when it runs downwards.
    near: [usize; 3],
}

/// Children that wait, kept from ray to ray to save the allocation.
pub type Stack = Vec<(u32, f32)>;

impl Prepared {
    #[inline(always)]
    fn new(o: Vec3, d: Vec3) -> Prepared {
        let mut inverse = d.to_array();
        let mut near = [0; 3];
        for (c, near) in inverse.iter_mut().zip(&mut near) {
            *c = 1.0
                / if c.abs() < TINY {
                    TINY.copysign(*c)
                } else {
                    *c
                };
            *near = usize::from(*c < 0.0);
        }
        Prepared {
            line: Line::new(o, d),
            inverse,
            near,
        }
    }
}

impl Wide {
    /// The closest triangle with 0 < t < t_max of every ray, appended to `hits`.
    #[inline(always)]
    pub fn closest_of(&self, rays: &[Ray], stack: &mut Stack, hits: &mut Vec<Found>) {
        match &self.flat {
            Some(flat) => flat.closest(rays, hits),
            // A loop, not an iterator chain: a chain's closure is a function of its own, which
            // the compiler may build for the oldest processor.
            None => {
                for ray in rays {
                    hits.push(self.closest(ray, stack));
                }
            }
        }
    }

    /// Whether any triangle has 0 < t < t_max, for every ray, appended to `blocked`.
    #[inline(always)]
    pub fn occluded_of(&self, rays: &[Ray], stack: &mut Stack, blocked: &mut Vec<bool>) {
        match &self.flat {
            Some(flat) => flat.occluded(rays, blocked),
            None => {
                for ray in rays {
                    blocked.push(self.occluded(ray, stack));
                }
            }
        }
    }

    /// The closest triangle with 0 < t < `t_max`.
    #[inline(always)]
    fn closest(&self, ray: &Ray, stack: &mut Stack) -> Found {
        let t_max = ray.t_max;
        let ray = Prepared::new(ray.origin - self.centre, ray.direction);
        let mut found = Found {
            triangle: INVALID,
            t: t_max,
            barycentrics: [0.0; 2],
        };
        stack.clear();
        stack.push((0, 0.0));
        while let Some((child, entry)) = stack.pop() {
            if entry >= found.t {
                continue;
            }
            if child & LEAF != 0 {
                if let Some(leaf) = self.leaves.get((child ^ LEAF) as usize) {
                    leaf.closest(&ray.line, &mut found);
                }
            } else if let Some(node) = self.nodes.get(child as usize) {
                let (mask, entries) = node.enter(&ray, found.t);
                push_sorted(stack, mask, &entries, &node.child);
            }
        }
        found
    }

    /// Whether any triangle has 0 < t < `t_max`.
    #[inline(always)]
    fn occluded(&self, ray: &Ray, stack: &mut Stack) -> bool {
        let t_max = ray.t_max;
        let ray = Prepared::new(ray.origin - self.centre, ray.direction);
        stack.clear();
        stack.push((0, 0.0));
        while let Some((child, _)) = stack.pop() {
            if child & LEAF != 0 {
                let leaf = self.leaves.get((child ^ LEAF) as usize);
                if leaf.is_some_and(|leaf| leaf.test(&ray.line, t_max).0 != 0) {
                    return true;
                }
            } else if let Some(node) = self.nodes.get(child as usize) {
                let (mut mask, _) = node.enter(&ray, t_max);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
                    mask &= mask - 1;
                    stack.push((node.child[lane], 0.0));
                }
            }
        }
        false
    }

    /// A stack that never has to grow.
    pub fn stack(&self) -> Stack {
        Vec::with_capacity(self.depth + WIDTH)
    }
}

/// Pushes the children that were entered, the nearest last.
#[inline(always)]
fn push_sorted(stack: &mut Stack, mut mask: u32, entries: &Lanes, children: &[u32; WIDTH]) {
    let first = stack.len();
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
        mask &= mask - 1;
        let item = (children[lane], entries[lane]);
        stack.push(item);
        let mut at = stack.len() - 1;
        while at > first && stack[at - 1].1 < item.1 {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = item;
    }
}

impl Node {
    /// Bit mask of the children whose box the ray enters in [0, t_max], and where.
    #[inline(always)]
    fn enter(&self, ray: &Prepared, t_max: f32) -> (u32, Lanes) {
        let mut entries = [0.0; WIDTH];
        let mut exits = [t_max; WIDTH];
        for axis in 0..3 {
            let near = ray.near[axis] & 1;
            let (o, inverse) = (ray.line.origin[axis], ray.inverse[axis]);
            let (enter, leave) = (&self.bounds[axis][near], &self.bounds[axis][1 - near]);
            for i in 0..WIDTH {
                entries[i] = max((enter[i] - o) * inverse, entries[i]);
            }
            for i in 0..WIDTH {
                exits[i] = min((leave[i] - o) * inverse, exits[i]);
            }
        }
        let mut mask = 0;
        for i in 0..WIDTH {
            mask |= u32::from(entries[i] <= exits[i] * FAR_SLACK) << i;
        }
        (mask, entries)
    }
}

impl Leaf {
    #[inline(always)]
    fn triangle(&self, lane: usize) -> Edges {
        let mut triangle = Edges {
            plane: [0.0; 4],
            edges: [[0.0; 6]; 3],
        };
        for (value, row) in triangle.plane.iter_mut().zip(&self.plane) {
            *value = row[lane];
        }
        for (edge, rows) in triangle.edges.iter_mut().zip(&self.edges) {
            for (value, row) in edge.iter_mut().zip(rows) {
                *value = row[lane];
            }
        }
        triangle
    }

    /// Bit mask of the triangles hit with 0 < t < t_max, where, and the corners' weights.
    #[inline(always)]
    fn test(&self, line: &Line, t_max: f32) -> (u32, Lanes, [Lanes; 3]) {
        let mut t = [0.0; WIDTH];
        let mut weights = [[0.0; WIDTH]; 3];
        let mut mask = 0;
        for i in 0..WIDTH {
            let met = self.triangle(i).meet(line);
            t[i] = met.t;
            for (row, weight) in weights.iter_mut().zip(met.weights) {
                row[i] = weight;
            }
            mask |= u32::from(met.inside & (met.t > 0.0) & (met.t < t_max)) << i;
        }
        (mask, t, weights)
    }

    /// Keeps the closest triangle in `found`.
    #[inline(always)]
    fn closest(&self, line: &Line, found: &mut Found) {
        let (mut mask, t, weights) = self.test(line, found.t);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            if t[lane] < found.t {
                *found = Found {
                    triangle: self.ids[lane],
                    t: t[lane],
                    barycentrics: barycentrics(weights.map(|row| row[lane])),
                };
            }
        }
    }
}
