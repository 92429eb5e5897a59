//! Which surface frames will show: what is seen from where eyes may be.

use crate::error::ExtractError;
use crate::region::Region;
use crate::visibility::{QueryScratch, VisibilityQueries};
use glam::Vec3;
use rrf_trace::SurfacePoint;

/// Places that eyes look from.
const PLACES: u32 = 64;
/// How many of them look at a time: most points are seen by one of the first.
const AT_ONCE: usize = 8;

/// Places spread over the box that eyes may be in, none inside a solid.
#[derive(Clone, Debug)]
pub struct Eyes {
    places: Vec<Vec3>,
}

impl Eyes {
    /// Positions in `eye_box`.
    ///
    /// # Errors
    /// Where all of them lie inside solids.
    pub fn new(visibility: &VisibilityQueries, eye_box: Region) -> Result<Eyes, ExtractError> {
        let mut scratch = QueryScratch::default();
        let places: Vec<Vec3> = (0..PLACES)
            .map(|i| eye_box.at(spread(i)))
            .filter(|&place| !visibility.inside_solid_with(place, &mut scratch))
            .collect();
        if places.is_empty() {
            return Err(ExtractError::Box {
                what: "eye",
                bounds: eye_box,
                message: "lies inside a solid: nothing is seen from there".into(),
            });
        }
        Ok(Eyes { places })
    }

    /// Whether one of them sees a surface point on the side of the unit normal `side`.
    pub fn see(
        &self,
        visibility: &VisibilityQueries,
        point: &SurfacePoint,
        side: Vec3,
        scratch: &mut QueryScratch,
    ) -> bool {
        self.places.chunks(AT_ONCE).any(|places| {
            let before = places
                .iter()
                .filter(|&&e| (e - point.position).dot(side) > 0.0);
            visibility.any_free(point, before.copied(), scratch)
        })
    }
}

/// Point `i` of the additive sequence of the plastic number's analogue in three dimensions
/// (Roberts 2018): even at any length.
fn spread(i: u32) -> [f32; 3] {
    const G: f64 = 1.220_744_084_605_759_6;
    [1, 2, 3].map(|k| (0.5 + f64::from(i + 1) * G.powi(-k)).fract() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cornell;
    use rrf_scene::Scene;
    use rrf_trace::Tracer;

    const EYE_BOX: Region = Region {
        minimum: [-0.9, 0.05, 0.2],
        maximum: [-0.3, 0.5, 0.9],
    };

    fn in_the_box(see: impl FnOnce(&Scene, &Tracer, &VisibilityQueries)) {
        let scene = cornell();
        let tracer = Tracer::new(&scene).unwrap();
        see(&scene, &tracer, &VisibilityQueries::new(&scene, &tracer));
    }

    /// Whether a triangle crosses the open way from `a` to `b`, in f64 (Möller and Trumbore 1997).
    fn crosses(scene: &Scene, triangle: usize, a: glam::DVec3, b: glam::DVec3) -> bool {
        let [p, q, r] = scene.triangles[triangle].map(|v| scene.positions[v as usize].as_dvec3());
        let (e, f, d) = (q - p, r - p, b - a);
        let h = d.cross(f);
        let (det, s) = (e.dot(h), a - p);
        let (u, k) = (s.dot(h) / det, s.cross(e));
        let (v, t) = (d.dot(k) / det, f.dot(k) / det);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-9 && t < 1.0
    }

    /// From a corner of the floor, behind the boxes: what every triangle asked one by one says.
    #[test]
    fn as_without_a_tree() {
        in_the_box(|scene, tracer, visibility| {
            let eyes = Eyes::new(visibility, EYE_BOX).unwrap();
            assert!(eyes.places.iter().all(|&e| EYE_BOX.contains(e)));
            let sequence = rrf_sampling::sobol::Sequence::new(3);
            let mut scratch = QueryScratch::default();
            let (mut seen, mut unseen) = (0, 0);
            for k in 0..2000 {
                let u = sequence.point(k);
                let triangle = k as usize % scene.triangles.len();
                let (a, b) = (1.0 - u[0].sqrt(), u[1] * u[0].sqrt());
                let point = tracer.point(triangle as u32, [a, b]);
                for side in [point.normal, -point.normal] {
                    let free = |e: Vec3| {
                        let (from, to) = (point.position.as_dvec3(), e.as_dvec3());
                        (to - from).dot(side.as_dvec3()) > 0.0
                            && (0..scene.triangles.len())
                                .filter(|&other| other != triangle)
                                .all(|other| !crosses(scene, other, from, to))
                    };
                    let expected = eyes.places.iter().any(|&e| free(e));
                    assert_eq!(
                        eyes.see(visibility, &point, side, &mut scratch),
                        expected,
                        "{point:?}"
                    );
                    *(if expected { &mut seen } else { &mut unseen }) += 1;
                }
            }
            assert!(seen > 200 && unseen > 200, "{seen} {unseen}");
        });
    }

    /// Every row of a proposal is seen, and it leaves some out.
    #[test]
    fn rows_are_seen() {
        in_the_box(|scene, tracer, visibility| {
            let eyes = Eyes::new(visibility, EYE_BOX).unwrap();
            let lights = Region {
                minimum: [-0.6, 1.3, -0.6],
                maximum: [0.6, 1.8, 0.6],
            };
            let all = rrf_field::tree::Domain::ALL;
            let proposal = crate::Proposal::new(scene, tracer, visibility, all, lights, 1)
                .unwrap()
                .seen_by(Some(&eyes));
            let accepted = crate::accept(&proposal, 500, 64);
            assert_eq!(accepted.rows.len(), 500);
            assert!(accepted.census.unseen > 0, "{:?}", accepted.census);
            let mut scratch = QueryScratch::default();
            for (row, point) in accepted.surface.iter().enumerate() {
                let v = Vec3::from(accepted.rows.vec3(rrf_field::columns::V, row));
                let side = if point.normal.dot(v) < 0.0 {
                    -point.normal
                } else {
                    point.normal
                };
                assert!(eyes.see(visibility, point, side, &mut scratch));
            }
        });
    }

    #[test]
    fn an_eye_box_inside_a_solid_is_refused() {
        in_the_box(|_, _, visibility| {
            // within the short box
            let inside = Region {
                minimum: [0.3, 0.2, 0.3],
                maximum: [0.35, 0.3, 0.35],
            };
            let refused = Eyes::new(visibility, inside).unwrap_err();
            assert!(
                refused.to_string().starts_with("eye box 0.3,0.2,0.3"),
                "{refused}"
            );
        });
    }
}
