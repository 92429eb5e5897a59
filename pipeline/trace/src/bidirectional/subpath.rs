//! Light subpaths: what leaves a light, and the vertices that it meets.

use super::emit::{End, Lights};
use super::light::{LIGHT_VERTICES, LightVertex, scattered};
use super::run::Joined;
use crate::mirrors::NO_MIRROR;
use crate::rays;
use crate::tracer::Tracer;
use crate::walk::Ray;
use rrf_materials::INVALID;

impl Joined {
    /// Traces the rays that leave the lights, `self.rays` with path and end of each, and what goes
    /// on from there; fills `self.light_vertices`.
    pub(super) fn trace_light(
        &mut self,
        (tracer, lights): (&Tracer, &Lights),
        leaving: &[(u32, End)],
        draw: &dyn Fn(&LightVertex) -> [f32; 4],
    ) {
        self.light_vertices.clear();
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        let mut last = Vec::new();
        for ((path, end), hit) in leaving.iter().zip(&self.hits) {
            if hit.triangle != INVALID {
                let place = (hit.triangle, hit.barycentrics);
                last.extend(LightVertex::first((tracer, lights), *path, place, end));
            }
        }
        for k in 1..=LIGHT_VERTICES as u32 {
            self.light_vertices.extend(&last);
            if k == LIGHT_VERTICES as u32 || last.is_empty() {
                break;
            }
            last = self.go_on(tracer, &last, draw);
        }
        // by path, in the order along it: connections go through them path by path
        self.light_vertices.sort_by_key(|z| z.path);
    }

    /// The vertices after `last`.
    fn go_on(
        &mut self,
        tracer: &Tracer,
        last: &[LightVertex],
        draw: &dyn Fn(&LightVertex) -> [f32; 4],
    ) -> Vec<LightVertex> {
        self.rays.clear();
        let mut leaving = Vec::new();
        for z in last {
            let u = draw(z);
            let at = z.site.seen_from(z.toward);
            let to = at.bsdf.sample(at.shading, z.toward, [u[0], u[1], u[2]]);
            let cosine = at.geometric.dot(to.l);
            if to.pdf <= 0.0 || cosine <= 0.0 {
                continue;
            }
            let (value, density) = scattered(&z.site, to.l, z.toward);
            let sent = value * cosine / to.pdf;
            // by what the light loses here
            let arriving = at.geometric.dot(z.toward);
            let survival = (sent.max_element() / arriving).min(1.0);
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
        let mut next = Vec::new();
        for ((z, to, sent, [cosine, others]), hit) in leaving.into_iter().zip(&self.hits) {
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
                arriving: sent / arriving,
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
