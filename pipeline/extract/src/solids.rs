//! Which side of which surface is the inside of a solid.
//!
//! Triangles that share edges form a component. A component in which every edge is shared by
//! exactly two triangles encloses a volume: a solid, whichever way its triangles are wound, or
//! a room, if they are wound inward and other surfaces stand within it, or if it encloses
//! everything else. In open components the winding alone can tell front from back.

use glam::{DVec3, Vec3};
use rrf_scene::Scene;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Corners nearer than this share of the scene's diagonal are one corner.
const WELD: f32 = 1e-6;
/// Bounds that agree within this share of the scene's diagonal are equal.
const SAME_BOUNDS: f32 = 1e-3;

/// Meaning of a hit on the inner side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shell {
    /// Of a closed solid wound outward: a hit from behind is a hit from inside.
    Outward,
    /// Of a closed solid wound inward in the file: a hit from the front is a hit from inside.
    Inward,
    /// Not of a closed solid: only all that a point sees can tell.
    Open,
}

/// The shell of every triangle, and the component that it belongs to.
pub struct Solids {
    /// By triangle.
    pub shell: Vec<Shell>,
    /// By triangle.
    pub component: Vec<u32>,
}

/// Finds the solids of a scene: among all of its triangles, and where those of several objects meet in
/// one edge, so that none is closed, among the triangles of each object.
pub fn solids(scene: &Scene) -> Solids {
    let corners = weld(scene);
    let (mut found, open) = of_corners(scene, &corners);
    let (apart, _) = of_corners(scene, &within_objects(scene, &corners));
    let first = found.component.iter().max().map_or(0, |&c| c + 1);
    for (t, open) in open.iter().enumerate() {
        if *open && apart.shell[t] != Shell::Open {
            found.shell[t] = apart.shell[t];
            found.component[t] = first + apart.component[t];
        }
    }
    found
}

/// Corner ids that objects do not share.
fn within_objects(scene: &Scene, corners: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut ids: HashMap<(u32, u32), u32> = HashMap::new();
    let object = |t: usize| scene.triangle_object.get(t).copied().unwrap_or(0);
    let triangles = corners.iter().enumerate();
    let own = triangles.map(|(t, corners)| {
        corners.map(|corner| {
            let next = ids.len() as u32;
            *ids.entry((object(t), corner)).or_insert(next)
        })
    });
    own.collect()
}

/// The solids of triangles with these corners, and by triangle whether its component has an edge that
/// is not of exactly two triangles.
fn of_corners(scene: &Scene, corners: &[[u32; 3]]) -> (Solids, Vec<bool>) {
    let component = components(corners);
    let count = component.iter().max().map_or(0, |&c| c as usize + 1);
    let mut facts = vec![Facts::default(); count];
    for (t, &c) in component.iter().enumerate() {
        facts[c as usize].add(scene, t);
    }
    for ([a, b], sharing) in edges(corners) {
        // one with two corners in one place is a line, which neither closes nor opens anything
        let line = |t: u32| {
            let [a, b, c] = corners[t as usize];
            a == b || b == c || c == a
        };
        let sides = sharing.iter().filter(|&&t| !line(t)).count();
        if a != b && sides != 2 {
            sharing
                .iter()
                .for_each(|&t| facts[component[t as usize] as usize].open = true);
        }
    }
    let whole = facts.iter().fold(Facts::default(), |all, f| all.join(f));
    let diagonal = (whole.high - whole.low).length();
    let shell = |f: &Facts| f.shell(&whole, SAME_BOUNDS * diagonal, count);
    let mut of: Vec<Shell> = facts.iter().map(shell).collect();
    let mut triangles = vec![Vec::new(); count];
    for (t, &c) in (0u32..).zip(&component) {
        triangles[c as usize].push(t);
    }
    for (c, shell) in of.iter_mut().enumerate() {
        // seen from within, by whoever furnished it: a room
        if *shell == Shell::Inward && furnished(scene, &triangles, &facts, c) {
            *shell = Shell::Open;
        }
    }
    let open = component.iter().map(|&c| facts[c as usize].open).collect();
    let found = Solids {
        shell: component.iter().map(|&c| of[c as usize]).collect(),
        component,
    };
    (found, open)
}

/// Most triangles of a component that are looked at.
const MOST_LOOKED_AT: usize = 256;
/// How far its corners are drawn to its middle: a crate touches the floor that it stands on.
const DRAWN_IN: f64 = 0.02;

/// Whether another component lies whole within the closed component `own`: what only pokes into a
/// solid, a knob or a leg, furnishes nothing.
fn furnished(scene: &Scene, triangles: &[Vec<u32>], facts: &[Facts], own: usize) -> bool {
    let corners = |&t: &u32| {
        let ids = scene.triangles[t as usize];
        ids.map(|v| scene.positions[v as usize].as_dvec3())
    };
    let shell: Vec<[DVec3; 3]> = triangles[own].iter().map(corners).collect();
    let inside = |p: DVec3| shell.iter().map(|t| solid_angle(*t, p)).sum::<f64>().abs() > TAU;
    let (room, all) = (&facts[own], facts.iter().enumerate());
    let mut boxed = all.filter(|&(other, f)| {
        other != own && (f.low.cmpge(room.low) & f.high.cmple(room.high)).all()
    });
    boxed.any(|(other, f)| {
        let middle = (f.low.as_dvec3() + f.high.as_dvec3()) / 2.0;
        let step = triangles[other].len().div_ceil(MOST_LOOKED_AT).max(1);
        let looked = triangles[other].iter().step_by(step).flat_map(corners);
        looked.map(|p| p.lerp(middle, DRAWN_IN)).all(inside)
    })
}

/// Signed solid angle of a triangle seen from `p` (Van Oosterom and Strackee 1983). Those of a
/// closed surface sum to 4π inside of it and to 0 outside.
pub(crate) fn solid_angle(triangle: [DVec3; 3], p: DVec3) -> f64 {
    let [a, b, c] = triangle.map(|x| x - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(below)
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

#[cfg(test)]
mod tests;
