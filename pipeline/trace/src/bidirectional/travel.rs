//! Where paths go from their vertices.

use super::connect::met;
use super::emit::{Group, Lights};
use super::eye::EyeVertex;
use super::run::{BLOCKS, Draws, Joined, PASS, PASSES};
use crate::rays;
use crate::walk::Ray;
use crate::wave::Part;
use rrf_materials::INVALID;
use rrf_sampling::roulette_tail;

/// From its second reflection on, a path goes on with probability KEEP times its throughput relative to
/// the first one, at most 1. Ten times that of plain paths: where paths seldom leave a gap, those that are
/// ended early leave few that count much, and standard errors that miss them.
const KEEP: f32 = 16.0;

impl Joined {
    /// Chooses where paths go, adds the light that they meet there, and moves them on.
    pub(super) fn travel(&mut self, part: &Part, lights: &Lights, draws: &Draws) {
        let tracer = part.tracer;
        self.rays.clear();
        let mut leaving = Vec::new();
        for x in &self.eyes {
            let mut u = draws.block(x.path, BLOCKS * x.number);
            if x.number < 2 {
                let even = draws.spread(x.path, &draws.scrambles, 3 * x.number as usize);
                u[..3].copy_from_slice(&even);
            }
            let at = x.site.seen_from(x.viewer);
            let to = at.bsdf.sample(at.shading, x.viewer, [u[0], u[1], u[2]]);
            let throughput = x.throughput * to.weight;
            let largest = throughput.max_element();
            let survival = match x.number {
                0 => 1.0,
                n => (KEEP * roulette_tail(n) * largest / x.first).min(1.0),
            };
            let goes_on = to.pdf > 0.0 && at.agrees(to.l);
            if !goes_on || u[3] >= survival || largest < f32::MIN_POSITIVE {
                continue;
            }
            self.rays.push(Ray {
                origin: x.site.origin(to.l),
                direction: to.l,
                t_max: f32::INFINITY,
            });
            let mut x = *x;
            if x.site.enters(x.viewer, to.l) {
                let facet = &tracer.facets[x.triangle as usize];
                x.media.cross(facet, facet.is_inside(x.viewer));
            }
            leaving.push((x, to, throughput / survival));
        }
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        let factors = self.pass(tracer, &|k, n| {
            let x: &EyeVertex = &leaving[k].0;
            draws.block(x.path, PASS + x.number * PASSES + n)[0]
        });
        let rays = self.rays.iter().zip(&self.hits).zip(factors);
        for ((x, to, throughput), ((ray, hit), factor)) in leaving.iter_mut().zip(rays) {
            *throughput *= factor;
            if tracer.encloses && hit.triangle != INVALID {
                let facet = &tracer.facets[hit.triangle as usize];
                // rays start off their surface
                let distance = hit.t + ray.origin.distance(x.site.position);
                *throughput *= tracer.left_after(distance, x.media, facet, -to.l);
            }
        }
        self.eyes.clear();
        let has = |wanted| lights.groups().any(|group| group == wanted);
        let (lamps, far) = (has(Group::Lamps), has(Group::Far));
        for ((x, to, throughput), hit) in leaving.into_iter().zip(&self.hits) {
            let counts = x.number > 0;
            let went = (throughput, to.pdf);
            if hit.triangle == INVALID {
                if counts && far {
                    for index in lights.visible_from_afar() {
                        let end = lights.far_end(index, to.l);
                        self.sums[x.path as usize] += met(tracer, lights, &x, went, &end);
                    }
                }
                continue;
            }
            if counts
                && lamps
                && let Some(end) = lights.met_lamp(hit.triangle, hit.barycentrics)
            {
                self.sums[x.path as usize] += met(tracer, lights, &x, went, &end);
            }
            let site = tracer.site_of(hit, x.media, -to.l);
            let [there, here] = [&site, &x.site].map(|site| site.outward.dot(to.l).abs());
            let distance2 = hit.t * hit.t;
            self.eyes.push(EyeVertex {
                triangle: hit.triangle,
                site,
                viewer: -to.l,
                throughput,
                first: if counts {
                    x.first
                } else {
                    throughput.max_element()
                },
                number: x.number + 1,
                density: to.pdf * there / distance2,
                back: here / distance2,
                before: x.density,
                from: x.site.position,
                others: x.earlier(to.l, 1),
                ..x
            });
        }
    }
}
