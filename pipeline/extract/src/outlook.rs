//! What a place sees: whether light can be learned there.

use crate::solids::{Shell, shells};
use glam::Vec3;
use rrf_scene::Scene;
use rrf_trace::{SurfacePoint, Tracer};

/// Directions that a place looks in.
const DIRECTIONS: u32 = 32;

/// What a place sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outlook {
    /// Surfaces from their outer side.
    Open,
    /// A solid from within.
    InsideSolid,
    /// Nothing at all.
    Nothing,
}

/// Answers what a place sees, always by the same directions.
pub struct Lookout<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    shells: Vec<Shell>,
}

impl<'a> Lookout<'a> {
    /// Finds the scene's solids.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer<'a>) -> Lookout<'a> {
        Lookout {
            scene,
            tracer,
            shells: shells(scene),
        }
    }

    /// Whether a free place (a light) lies inside a solid.
    pub fn inside_solid(&self, place: Vec3) -> bool {
        let votes = self.count((0..DIRECTIONS).map(sphere), |_| place);
        votes.outlook() == Outlook::InsideSolid
    }

    /// What a surface point sees on the side of the unit normal `side`.
    pub fn from_surface(&self, point: &SurfacePoint, side: Vec3) -> Outlook {
        let up = |w: Vec3| if w.dot(side) < 0.0 { -w } else { w };
        let directions = (0..DIRECTIONS).map(|i| up(sphere(i)));
        self.count(directions, |w| {
            self.tracer.lift(point.triangle, point.position, w)
        })
        .outlook()
    }

    fn count(
        &self,
        directions: impl Iterator<Item = Vec3>,
        origin: impl Fn(Vec3) -> Vec3,
    ) -> Votes {
        let mut votes = Votes::default();
        for w in directions {
            let hit = self.tracer.closest(origin(w), w, f32::INFINITY);
            votes.asked += 1;
            if !hit.is_hit() {
                continue;
            }
            votes.hits += 1;
            let behind = self
                .tracer
                .point(hit.triangle, hit.barycentrics)
                .normal
                .dot(w)
                > 0.0;
            match self.shells[hit.triangle as usize] {
                Shell::Outward => votes.inside += u32::from(behind),
                Shell::Inward => votes.inside += u32::from(!behind),
                Shell::Open => votes.behind_open += u32::from(behind),
            }
        }
        debug_assert_eq!(self.shells.len(), self.scene.triangles.len());
        votes
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Votes {
    asked: u32,
    hits: u32,
    /// Hits on a closed solid from within.
    inside: u32,
    /// Hits on an open surface from behind.
    behind_open: u32,
}

impl Votes {
    fn outlook(self) -> Outlook {
        if self.hits == 0 {
            Outlook::Nothing
        } else if 2 * self.inside > self.asked {
            Outlook::InsideSolid
        } else if self.inside + self.behind_open == self.hits && 10 * self.hits >= 9 * self.asked {
            // closed in by the backs of surfaces: inside the walls of a level
            Outlook::InsideSolid
        } else {
            Outlook::Open
        }
    }
}

/// Direction `i` of a Fibonacci lattice on the sphere (González 2010): even, and never along
/// an axis, where scenes have their edges.
fn sphere(i: u32) -> Vec3 {
    let z = 1.0 - (2 * i + 1) as f32 / DIRECTIONS as f32;
    let turn = std::f32::consts::TAU * (i as f32 * 0.618_034 + 0.137);
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * turn.cos(), r * turn.sin(), z)
}
