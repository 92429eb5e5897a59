//! Light subpaths: what leaves a light, and the vertices that it meets.

use super::emit::{End, Lights};
use super::light::{LIGHT_VERTICES, LightVertex, scattered};
use super::run::Joined;
use crate::mirrors::NO_MIRROR;
use crate::rays;
use crate::tracer::Tracer;
use crate::walk::Ray;
use glam::Vec3;
use rrf_materials::{CERTAIN, INVALID};

/// A light subpath goes on with probability KEEP times what a surface sends on of its light, at most 1.
const KEEP: f32 = 8.0;

impl Joined {
    /// Traces the rays that leave the lights, `self.rays` with path and end of each, and what goes
    /// on from there; fills `self.light_vertices`.
    pub(super) fn trace_light(
        &mut self,
        (tracer, lights): (&Tracer, &Lights),
        leaving: &[(u32, End)],
        draw: &dyn Fn(&LightVertex) -> [f32; 4],
        pass: &dyn Fn(u32, u32) -> f32,
    ) {
        self.light_vertices.clear();
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        let mut last = Vec::new();
        let factors = self.pass(tracer, &|k, n| {
            pass(4 * leaving[k].0 + leaving[k].1.group as u32, n)
        });
        for (((path, end), hit), factor) in leaving.iter().zip(&self.hits).zip(factors) {
            if hit.triangle != INVALID {
                let place = (hit.triangle, hit.barycentrics);
                let first = LightVertex::first((tracer, lights), *path, place, end);
                last.extend(first.map(|z| LightVertex {
                    arriving: z.arriving * factor,
                    ..z
                }));
            }
        }
        for k in 1..=LIGHT_VERTICES as u32 {
            self.light_vertices.extend(&last);
            if k == LIGHT_VERTICES as u32 || last.is_empty() {
                break;
            }
            last = self.go_on(tracer, &last, draw, pass);
        }
        // by path, in the order along it: connections go through them path by path
        self.light_vertices.sort_by_key(|z| z.path);
    }

    /// Lets `self.rays` pass panes and alpha masks, by a number for each ray and surface: the factors of
    /// their light.
    pub(super) fn pass(
        &mut self,
        tracer: &Tracer,
        number: &dyn Fn(usize, u32) -> f32,
    ) -> Vec<Vec3> {
        let mut factors = vec![Vec3::ONE; self.rays.len()];
        if tracer.passes {
            let columns = self.rays.iter().zip(&mut self.hits).zip(&mut factors);
            for (k, ((ray, hit), factor)) in columns.enumerate() {
                let (stack, hits) = (&mut self.stack, &mut self.beyond);
                *factor = tracer.pass_by_chance(ray, hit, stack, hits, |n| number(k, n));
            }
        }
        factors
    }

    /// The vertices after `last`.
    fn go_on(
        &mut self,
        tracer: &Tracer,
        last: &[LightVertex],
        draw: &dyn Fn(&LightVertex) -> [f32; 4],
        pass: &dyn Fn(u32, u32) -> f32,
    ) -> Vec<LightVertex> {
        self.rays.clear();
        let mut leaving = Vec::new();
        for z in last {
            let u = draw(z);
            let at = z.site.seen_from(z.toward);
            let to = at.bsdf.sample(at.shading, z.toward, [u[0], u[1], u[2]]);
            let cosine = at.geometric.dot(to.l).abs();
            // light that is reflected sharply or goes into glass is left to the other end
            let ends = to.pdf >= CERTAIN || !at.agrees(to.l) || z.site.enters(z.toward, to.l);
            if to.pdf <= 0.0 || cosine <= 0.0 || ends {
                continue;
            }
            let (value, density) = scattered(&z.site, to.l, z.toward);
            let sent = value * cosine / to.pdf;
            // by what the light loses here
            let arriving = at.geometric.dot(z.toward);
            let survival = (KEEP * sent.max_element() / arriving).min(1.0);
            if u[3] >= survival {
                continue;
            }
            self.rays.push(Ray {
                origin: z.site.origin(to.l),
                direction: to.l,
                t_max: f32::INFINITY,
            });
            let others = z.earlier(density, tracer);
            leaving.push((z, to, z.arriving * sent / survival, [cosine, others]));
        }
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        let factors = self.pass(tracer, &|k, n| {
            let z: &LightVertex = leaving[k].0;
            pass(4 * (z.path + (z.number << 20)) + z.end.group as u32, n)
        });
        let mut next = Vec::new();
        let ends = self.hits.iter().zip(factors);
        for ((z, to, sent, [cosine, others]), (hit, factor)) in leaving.into_iter().zip(ends) {
            if hit.triangle == INVALID {
                continue;
            }
            let site = tracer.site(hit.triangle, hit.barycentrics);
            let arriving = site.outward.dot(to.l).abs();
            if arriving <= 0.0 || hit.t <= 0.0 {
                continue;
            }
            let distance2 = hit.t * hit.t;
            next.push(LightVertex {
                site,
                toward: -to.l,
                arriving: sent * factor / arriving,
                density: to.pdf * arriving / distance2,
                back: cosine / distance2,
                before: z.density,
                others,
                number: z.number + 1,
                mirror: if z.number == 1 { z.mirror } else { NO_MIRROR },
                ..*z
            });
        }
        next
    }
}
