//! Which side of which surface is the inside of a solid.
//!
//! Triangles that share edges form a component. A component in which every edge is shared by
//! exactly two triangles encloses a volume: a solid, whichever way its triangles are wound, or
//! the room itself, if they are wound inward or it encloses everything else. In open components
//! the winding alone can tell front from back.

use glam::{DVec3, Vec3};
use rrf_scene::Scene;
use std::collections::HashMap;

/// Corners nearer than this share of the scene's diagonal are one corner.
const WELD: f32 = 1e-6;
/// Bounds that agree within this share of the scene's diagonal are equal.
const SAME_BOUNDS: f32 = 1e-3;

/// What a hit on the inner side of a triangle says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shell {
    /// Of a closed solid wound outward: a hit from behind is a hit from inside.
    Outward,
    /// Of a closed solid wound inward in the file: a hit from the front is a hit from inside.
    Inward,
    /// Not of a closed solid: only the whole outlook can tell.
    Open,
}

/// The shell of every triangle.
pub fn shells(scene: &Scene) -> Vec<Shell> {
    let corners = weld(scene);
    let component = components(&corners);
    let count = component.iter().max().map_or(0, |&c| c as usize + 1);
    let mut facts = vec![Facts::default(); count];
    for (t, &c) in component.iter().enumerate() {
        facts[c as usize].add(scene, t);
    }
    for ([a, b], sharing) in edges(&corners) {
        debug_assert!(a < b);
        if sharing.len() != 2 {
            sharing
                .iter()
                .for_each(|&t| facts[component[t as usize] as usize].open = true);
        }
    }
    let whole = facts.iter().fold(Facts::default(), |all, f| all.join(f));
    let diagonal = (whole.high - whole.low).length();
    let shell = |f: &Facts| f.shell(&whole, SAME_BOUNDS * diagonal, count);
    let of: Vec<Shell> = facts.iter().map(shell).collect();
    component.iter().map(|&c| of[c as usize]).collect()
}

#[derive(Clone, Copy, Debug)]
struct Facts {
    low: Vec3,
    high: Vec3,
    /// Six times the signed volume.
    volume: f64,
    open: bool,
}

impl Default for Facts {
    fn default() -> Facts {
        Facts {
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            volume: 0.0,
            open: false,
        }
    }
}

impl Facts {
    fn add(&mut self, scene: &Scene, t: usize) {
        let p = scene.triangles[t].map(|v| scene.positions[v as usize]);
        for p in p {
            (self.low, self.high) = (self.low.min(p), self.high.max(p));
        }
        let [a, b, c]: [DVec3; 3] = p.map(|p| p.as_dvec3());
        self.volume += a.dot(b.cross(c));
    }

    fn join(self, other: &Facts) -> Facts {
        Facts {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            ..self
        }
    }

    fn shell(&self, whole: &Facts, tolerance: f32, components: usize) -> Shell {
        let encloses_all = components > 1
            && (self.low - whole.low).abs().max_element() <= tolerance
            && (self.high - whole.high).abs().max_element() <= tolerance;
        match self.volume {
            _ if self.open || encloses_all => Shell::Open,
            v if v > 0.0 => Shell::Outward,
            // alone and wound inward: a room seen from within
            _ if components == 1 => Shell::Open,
            v if v < 0.0 => Shell::Inward,
            _ => Shell::Open,
        }
    }
}

/// Corner ids by position rather than by vertex: vertices on one spot become one.
fn weld(scene: &Scene) -> Vec<[u32; 3]> {
    let bounds = scene.bounds();
    let low = bounds.map_or(Vec3::ZERO, |b| b.min.into());
    let cell = (bounds.map_or(0.0, |b| b.diagonal()) * WELD).max(f32::MIN_POSITIVE);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut spots: Vec<Vec3> = Vec::new();
    let of: Vec<u32> = scene
        .positions
        .iter()
        .map(|&p| {
            let key = ((p - low) / cell).to_array().map(|x| x.round() as i64);
            let near = neighbours(key)
                .filter_map(|key| grid.get(&key))
                .flatten()
                .copied()
                .find(|&s| spots[s as usize].distance(p) <= cell);
            near.unwrap_or_else(|| {
                let id = spots.len() as u32;
                spots.push(p);
                grid.entry(key).or_default().push(id);
                id
            })
        })
        .collect();
    scene
        .triangles
        .iter()
        .map(|t| t.map(|v| of[v as usize]))
        .collect()
}

fn neighbours(key: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |i| {
        [
            key[0] + i % 3 - 1,
            key[1] + i / 3 % 3 - 1,
            key[2] + i / 9 - 1,
        ]
    })
}

/// Triangles on each edge, by its two corners in ascending order.
fn edges(corners: &[[u32; 3]]) -> HashMap<[u32; 2], Vec<u32>> {
    let mut edges: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
    for (t, &[a, b, c]) in (0u32..).zip(corners) {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            edges.entry([i.min(j), i.max(j)]).or_default().push(t);
        }
    }
    edges
}

/// Component of each triangle; triangles that share an edge share a component.
fn components(corners: &[[u32; 3]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..corners.len() as u32).collect();
    for sharing in edges(corners).values() {
        for pair in sharing.windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut names: HashMap<u32, u32> = HashMap::new();
    (0..corners.len() as u32)
        .map(|t| {
            let root = root(&mut parent, t);
            let next = names.len() as u32;
            *names.entry(root).or_insert(next)
        })
        .collect()
}

fn root(parent: &mut [u32], mut t: u32) -> u32 {
    while parent[t as usize] != t {
        parent[t as usize] = parent[parent[t as usize] as usize];
        t = parent[t as usize];
    }
    t
}
