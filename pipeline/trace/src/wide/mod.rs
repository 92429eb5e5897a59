//! The hierarchy that rays walk: obvhs' binary tree, collapsed to eight children a node and
//! eight triangles a leaf, so that one ray meets eight boxes or eight triangles at once.
//!
//! Eight-wide collapse: Wald, Benthin, Boulos, *Getting Rid of Packets*, IRT 2008.
//! Edges are tested by the sign of Pluecker products that two neighbours compute from the
//! same numbers with opposite signs (Davidovic et al. 2012), so no ray slips between them.
//! All arithmetic is plain IEEE without fused operations: every instruction set gives the
//! same bits.

mod collapse;
mod plan;

use glam::Vec3;
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
}

/// What a ray met: the scene id ([`INVALID`] for nothing), distance and barycentrics of the
/// second and third corner.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    pub triangle: u32,
    pub t: f32,
    pub barycentrics: [f32; 2],
}

/// A ray with what the tests of one traversal share.
#[derive(Clone, Copy)]
struct Prepared {
    origin: [f32; 3],
    direction: [f32; 3],
    /// origin x direction.
    moment: [f32; 3],
    inverse: [f32; 3],
    /// Which bound of an axis the ray meets first: 1 when it runs downwards.
    near: [usize; 3],
}

/// Children that wait, kept from ray to ray to save the allocation.
pub type Stack = Vec<(u32, f32)>;

impl Prepared {
    #[inline(always)]
    fn new(o: Vec3, d: Vec3) -> Prepared {
        let direction = d.to_array();
        let inverse = direction.map(|c| 1.0 / if c.abs() < TINY { TINY.copysign(c) } else { c });
        Prepared {
            origin: o.to_array(),
            direction,
            moment: o.cross(d).to_array(),
            inverse,
            near: inverse.map(|i| usize::from(i < 0.0)),
        }
    }
}

impl Wide {
    /// The closest triangle with 0 < t < `t_max`.
    #[inline(always)]
    pub fn closest(&self, origin: Vec3, direction: Vec3, t_max: f32, stack: &mut Stack) -> Found {
        let ray = Prepared::new(origin - self.centre, direction);
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
                    leaf.closest(&ray, &mut found);
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
    pub fn occluded(&self, origin: Vec3, direction: Vec3, t_max: f32, stack: &mut Stack) -> bool {
        let ray = Prepared::new(origin - self.centre, direction);
        stack.clear();
        stack.push((0, 0.0));
        while let Some((child, _)) = stack.pop() {
            if child & LEAF != 0 {
                let leaf = self.leaves.get((child ^ LEAF) as usize);
                if leaf.is_some_and(|leaf| leaf.test(&ray, t_max).0 != 0) {
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
            let (o, inverse) = (ray.origin[axis], ray.inverse[axis]);
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
    /// Bit mask of the triangles hit with 0 < t < t_max, where, and the edge products.
    #[inline(always)]
    fn test(&self, ray: &Prepared, t_max: f32) -> (u32, Lanes, [Lanes; 3]) {
        let [ox, oy, oz] = ray.origin;
        let [dx, dy, dz] = ray.direction;
        let [mx, my, mz] = ray.moment;
        let mut t = [0.0; WIDTH];
        let mut sides = [[0.0; WIDTH]; 3];
        let mut mask = 0;
        for i in 0..WIDTH {
            for (side, edge) in sides.iter_mut().zip(&self.edges) {
                side[i] = (edge[0][i] * mx + edge[1][i] * my + edge[2][i] * mz)
                    + (edge[3][i] * dx + edge[4][i] * dy + edge[5][i] * dz);
            }
            let [nx, ny, nz, c] = &self.plane;
            let slope = nx[i] * dx + ny[i] * dy + nz[i] * dz;
            t[i] = (c[i] - (nx[i] * ox + ny[i] * oy + nz[i] * oz)) / slope;
            let low = min(min(sides[0][i], sides[1][i]), sides[2][i]);
            let high = max(max(sides[0][i], sides[1][i]), sides[2][i]);
            let inside = (low >= 0.0) | (high <= 0.0);
            let within = (t[i] > 0.0) & (t[i] < t_max);
            mask |= u32::from(inside & within) << i;
        }
        (mask, t, sides)
    }

    /// Keeps the closest triangle in `found`.
    #[inline(always)]
    fn closest(&self, ray: &Prepared, found: &mut Found) {
        let (mut mask, t, sides) = self.test(ray, found.t);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            if t[lane] < found.t {
                let sum = sides[0][lane] + sides[1][lane] + sides[2][lane];
                let scale = if sum == 0.0 { 0.0 } else { 1.0 / sum };
                *found = Found {
                    triangle: self.ids[lane],
                    t: t[lane],
                    barycentrics: [sides[1][lane] * scale, sides[2][lane] * scale],
                };
            }
        }
    }
}

#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
