//! What a place sees: whether light can be learned there.

use crate::solids::{Shell, shells};
use glam::Vec3;
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

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
    tracer: &'a Tracer<'a>,
    shells: Vec<Shell>,
}

impl<'a> Lookout<'a> {
    /// Finds the scene's solids.
    pub fn new(scene: &Scene, tracer: &'a Tracer<'a>) -> Lookout<'a> {
        Lookout {
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
        let mut rays = Rays::default();
        directions.for_each(|w| rays.push(origin(w), w, f32::INFINITY));
        let mut hits = Hits::default();
        self.tracer.closest(&rays, &mut hits);
        let mut votes = Votes {
            asked: rays.len() as u32,
            ..Votes::default()
        };
        for (i, &w) in rays.direction.iter().enumerate() {
            let triangle = hits.triangle[i];
            if triangle == INVALID {
                continue;
            }
            votes.hits += 1;
            let behind = self
                .tracer
                .point(triangle, hits.barycentrics[i])
                .normal
                .dot(w)
                > 0.0;
            match self.shells[triangle as usize] {
                Shell::Outward => votes.inside += u32::from(behind),
                Shell::Inward => votes.inside += u32::from(!behind),
                Shell::Open => votes.behind_open += u32::from(behind),
            }
        }
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
