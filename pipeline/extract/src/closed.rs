//! Whether a place lies within a closed solid, whatever else lies there too.
//!
//! What a place sees first does not tell where solids interpenetrate: from within one it may see the
//! front of another. The solid angles of a closed surface sum to 4π seen from within and to 0 from
//! outside, and know of no other surface.

use crate::solids::{Shell, Solids, solid_angle};
use glam::{DVec3, Vec3};
use rrf_scene::Scene;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Most triangles of a solid that is summed over at every place; of larger ones first hits tell.
const MOST_TRIANGLES: usize = 512;

/// A closed surface and its bounds.
struct Closed {
    low: Vec3,
    high: Vec3,
    triangles: Vec<[DVec3; 3]>,
}

/// The closed solids of a scene that share room with another one.
#[derive(Default)]
pub struct ClosedSolids(Vec<Closed>);

impl ClosedSolids {
    /// Collects them.
    pub fn new(scene: &Scene, solids: &Solids) -> ClosedSolids {
        let mut of: BTreeMap<u32, Closed> = BTreeMap::new();
        for (t, &component) in solids.component.iter().enumerate() {
            if solids.shell[t] == Shell::Open {
                continue;
            }
            let corners = scene.triangles[t].map(|v| scene.positions[v as usize]);
            let closed = of.entry(component).or_insert(Closed {
                low: Vec3::INFINITY,
                high: Vec3::NEG_INFINITY,
                triangles: Vec::new(),
            });
            for corner in corners {
                closed.low = closed.low.min(corner);
                closed.high = closed.high.max(corner);
            }
            closed.triangles.push(corners.map(|p| p.as_dvec3()));
        }
        let all: Vec<Closed> = of.into_values().collect();
        let meets = |a: &Closed, b: &Closed| (a.low.cmple(b.high) & b.low.cmple(a.high)).all();
        let shares: Vec<bool> = (all.iter().enumerate())
            .map(|(i, a)| {
                let others = all.iter().enumerate().filter(|&(j, _)| j != i);
                let few = a.triangles.len() <= MOST_TRIANGLES;
                few && others.into_iter().any(|(_, b)| meets(a, b))
            })
            .collect();
        let kept = all.into_iter().zip(shares).filter(|(_, shares)| *shares);
        ClosedSolids(kept.map(|(closed, _)| closed).collect())
    }

    /// Whether a place lies within one of them.
    pub fn contain(&self, place: Vec3) -> bool {
        let within = |c: &&Closed| (place.cmpgt(c.low) & place.cmplt(c.high)).all();
        self.0.iter().filter(within).any(|closed| {
            let p = place.as_dvec3();
            let angles = closed.triangles.iter().map(|&t| solid_angle(t, p));
            angles.sum::<f64>().abs() > TAU
        })
    }
}
