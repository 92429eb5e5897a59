//! Classification of points by what they see: whether light can be learned there.

use crate::closed::ClosedSolids;
use crate::solids::{Shell, solids};
use glam::Vec3;
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

/// Directions that a point looks in.
const DIRECTIONS: u32 = 32;

/// Class of a point by what it sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointClass {
    /// Surfaces from their outer side.
    Open,
    /// A solid from within.
    InsideSolid,
    /// Nothing at all.
    Nothing,
}

/// Answers what points see, always by the same directions.
pub struct VisibilityQueries<'a> {
    tracer: &'a Tracer<'a>,
    shells: Vec<Shell>,
    closed: ClosedSolids,
}

impl<'a> VisibilityQueries<'a> {
    /// Finds the scene's solids.
    pub fn new(scene: &Scene, tracer: &'a Tracer<'a>) -> VisibilityQueries<'a> {
        let solids = solids(scene);
        VisibilityQueries {
            tracer,
            closed: ClosedSolids::new(scene, &solids),
            shells: solids.shell,
        }
    }

    /// Whether a free position (a light's) lies inside a solid.
    pub fn inside_solid(&self, place: Vec3) -> bool {
        self.inside_solid_with(place, &mut QueryScratch::default())
    }

    /// [`Self::inside_solid`] with working memory for many positions.
    pub fn inside_solid_with(&self, place: Vec3, scratch: &mut QueryScratch) -> bool {
        self.closed.contain(place)
            || self.classify(scratch, |i| (place, sphere(i))) == PointClass::InsideSolid
    }

    /// Whether the way from a surface point to one of some places is free.
    pub(crate) fn any_free(
        &self,
        point: &SurfacePoint,
        places: impl Iterator<Item = Vec3>,
        QueryScratch { rays, blocked, .. }: &mut QueryScratch,
    ) -> bool {
        rays.clear();
        for place in places {
            let origin = self
                .tracer
                .lift(point.triangle, point.position, place - point.position);
            rays.push(origin, place - origin, 1.0);
        }
        self.tracer.occluded(rays, blocked);
        blocked.iter().any(|blocked| !blocked)
    }

    /// Classifies a surface point on the side of the unit normal `side`.
    pub fn from_surface(&self, point: &SurfacePoint, side: Vec3) -> PointClass {
        self.from_surface_with(point, side, &mut QueryScratch::default())
    }

    /// [`Self::from_surface`] with working memory for many points.
    pub fn from_surface_with(
        &self,
        point: &SurfacePoint,
        side: Vec3,
        scratch: &mut QueryScratch,
    ) -> PointClass {
        let off = self.tracer.lift(point.triangle, point.position, side);
        if self.closed.contain(off) {
            return PointClass::InsideSolid;
        }
        self.classify(scratch, |i| {
            let w = sphere(i);
            let w = if w.dot(side) < 0.0 { -w } else { w };
            (self.tracer.lift(point.triangle, point.position, w), w)
        })
    }

    /// By rays `ray(i)`, origin and direction: by the even ones alone where the rest cannot change it.
    fn classify(
        &self,
        scratch: &mut QueryScratch,
        ray: impl Fn(u32) -> (Vec3, Vec3),
    ) -> PointClass {
        let mut votes = Votes::default();
        self.count(scratch, (0..DIRECTIONS).step_by(2).map(&ray), &mut votes);
        if votes.inside == 0 && votes.behind_open < votes.hits {
            return PointClass::Open;
        }
        self.count(scratch, (1..DIRECTIONS).step_by(2).map(&ray), &mut votes);
        votes.classify()
    }

    fn count(
        &self,
        QueryScratch { rays, hits, .. }: &mut QueryScratch,
        of: impl Iterator<Item = (Vec3, Vec3)>,
        votes: &mut Votes,
    ) {
        rays.clear();
        of.for_each(|(origin, w)| rays.push(origin, w, f32::INFINITY));
        self.tracer.closest(rays, hits);
        votes.asked += rays.len() as u32;
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
    }
}

/// Working memory of one thread that asks what many places see.
#[derive(Default)]
pub struct QueryScratch {
    rays: Rays,
    hits: Hits,
    blocked: Vec<bool>,
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
    fn classify(self) -> PointClass {
        if self.hits == 0 {
            PointClass::Nothing
        } else if 2 * self.inside > self.asked {
            PointClass::InsideSolid
        } else if self.inside + self.behind_open == self.hits && 10 * self.hits >= 9 * self.asked {
            // closed in by the backs of surfaces: inside the walls of a level
            PointClass::InsideSolid
        } else {
            PointClass::Open
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cornell;

    /// Corner and two edges of a footprint (x, z), and a height.
    type Solid = ([f32; 2], [f32; 2], [f32; 2], f32);

    /// Footprint corner and edges of the two boxes, from their vertices in the file, and heights.
    const BOXES: [Solid; 2] = [
        (
            [-0.0460751, 0.573007],
            [0.5790841, 0.173072],
            [0.1703281, -0.56990235],
            0.6,
        ),
        (
            [-0.720444, -0.473882],
            [0.573552, -0.199597],
            [0.196458, 0.5645313],
            1.2,
        ),
    ];

    /// A grid of places in the room: inside a solid exactly where the boxes' own coordinates,
    /// solved from their footprints, say so. The walls of this file are wound outward, so that
    /// the winding alone would call most of the room solid.
    #[test]
    fn lights_inside_the_boxes_and_no_others() {
        let scene = cornell();
        let tracer = Tracer::new(&scene).unwrap();
        let visibility = VisibilityQueries::new(&scene, &tracer);
        let inside = |p: Vec3| {
            BOXES.iter().any(|&(corner, a, b, height)| {
                let (x, z) = (p.x - corner[0], p.z - corner[1]);
                let det = a[0] * b[1] - a[1] * b[0];
                let (s, t) = ((x * b[1] - z * b[0]) / det, (a[0] * z - a[1] * x) / det);
                (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t) && p.y < height
            })
        };
        let mut solid = 0;
        for i in 0..13 * 13 * 13 {
            let at = |k: i32| (k as f32 + 0.5) / 13.0;
            let p = Vec3::new(
                2.0 * at(i % 13) - 1.0,
                2.0 * at(i / 13 % 13),
                2.0 * at(i / 169) - 1.0,
            );
            assert_eq!(visibility.inside_solid(p), inside(p), "{p}");
            solid += i32::from(inside(p));
        }
        assert!(solid > 50, "the grid meets the boxes");
    }

    #[test]
    fn sealed_points_blind_points_and_the_rest() {
        let scene = cornell();
        let tracer = Tracer::new(&scene).unwrap();
        let visibility = VisibilityQueries::new(&scene, &tracer);
        let from = |p: [f32; 3], side: Vec3| {
            visibility.from_surface(&tracer.locate(p.into(), side).unwrap(), side)
        };
        assert_eq!(
            from([0.33, 0.0, 0.37], Vec3::Y),
            PointClass::InsideSolid,
            "under the short box"
        );
        assert_eq!(
            from([0.8, 0.0, 0.9], Vec3::Y),
            PointClass::Open,
            "the free floor"
        );
        assert_eq!(
            from([0.0, 1.0, -1.0], Vec3::Z),
            PointClass::Open,
            "the back wall"
        );
        assert_eq!(
            from([0.0, 1.0, -1.0], Vec3::NEG_Z),
            PointClass::Nothing,
            "its outer side"
        );
    }

    /// Boxes that interpenetrate: from within one, most of what is seen is the front of the others.
    #[test]
    fn interpenetrating_solids_are_solid() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../tests/data/cases/rooms/sofa3.glb");
        let scene = rrf_scene::load(&path, &rrf_scene::LoadOptions::default()).unwrap();
        let tracer = Tracer::new(&scene).unwrap();
        let visibility = VisibilityQueries::new(&scene, &tracer);
        assert!(visibility.inside_solid(Vec3::new(0.01, 0.02, 0.03)));
        assert!(!visibility.inside_solid(Vec3::new(1.5, 1.5, 1.5)));
    }

    /// A closed box wound inward in its file is a solid too, unless it is all there is.
    #[test]
    fn winding_does_not_decide_what_is_solid() {
        let mut scene = cornell();
        let flipped: Vec<usize> = (0..scene.triangles.len())
            .filter(|&t| {
                scene.objects[scene.triangle_object[t] as usize].contains("ShortBox")
                    || scene.materials[scene.triangle_material[t] as usize].name == "ShortBox"
            })
            .collect();
        assert_eq!(flipped.len(), 12);
        flipped.iter().for_each(|&t| scene.triangles[t].swap(1, 2));
        let tracer = Tracer::new(&scene).unwrap();
        let visibility = VisibilityQueries::new(&scene, &tracer);
        assert!(visibility.inside_solid(Vec3::new(0.33, 0.3, 0.37)));
        assert!(!visibility.inside_solid(Vec3::new(0.33, 0.9, 0.37)));
        let alone = scene.clone();
        let room = Scene {
            triangles: flipped.iter().map(|&t| alone.triangles[t]).collect(),
            triangle_material: flipped
                .iter()
                .map(|&t| alone.triangle_material[t])
                .collect(),
            triangle_light: flipped.iter().map(|&t| alone.triangle_light[t]).collect(),
            triangle_object: flipped.iter().map(|&t| alone.triangle_object[t]).collect(),
            ..alone
        };
        let tracer = Tracer::new(&room).unwrap();
        let visibility = VisibilityQueries::new(&room, &tracer);
        assert!(
            !visibility.inside_solid(Vec3::new(0.33, 0.3, 0.37)),
            "a room, seen from within"
        );
    }

    /// A level's room is a closed shell wound inward. Standing in it is not standing in a solid;
    /// standing in the crate in it, or between it and the next house, is.
    #[test]
    fn an_eye_in_a_room_of_a_level_is_free() {
        let mut scene = cornell();
        let material = scene.triangle_material[0];
        let mut add = |low: Vec3, high: Vec3, inward: bool| {
            let first = scene.positions.len() as u32;
            for i in 0..8 {
                let pick = |axis: usize| if i >> axis & 1 == 1 { high } else { low }[axis];
                scene.positions.push(Vec3::new(pick(0), pick(1), pick(2)));
                scene.normals.push(Vec3::ZERO);
                scene.uvs.push(glam::Vec2::ZERO);
            }
            for [a, b, c, d] in [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ] {
                for [a, b, c] in [[a, b, c], [a, c, d]] {
                    let t = if inward { [a, c, b] } else { [a, b, c] };
                    scene.triangles.push(t.map(|i: u32| first + i));
                    scene.triangle_material.push(material);
                    scene.triangle_light.push(INVALID);
                    scene.triangle_object.push(0);
                }
            }
        };
        let at = |x: f32| Vec3::new(x, 0.0, 0.0);
        add(at(5.0), at(5.0) + Vec3::splat(4.0), true);
        add(at(6.0), at(6.0) + Vec3::ONE, false);
        let tracer = Tracer::new(&scene).unwrap();
        let visibility = VisibilityQueries::new(&scene, &tracer);
        assert!(
            !visibility.inside_solid(Vec3::new(8.0, 2.0, 2.0)),
            "the room"
        );
        assert!(
            visibility.inside_solid(Vec3::new(6.5, 0.5, 0.5)),
            "its crate"
        );
        assert!(
            !visibility.inside_solid(Vec3::new(0.0, 1.0, 0.8)),
            "the box"
        );
        let block = Vec3::new(0.33, 0.3, 0.37);
        assert!(visibility.inside_solid(block), "its short block");
    }
}
