//! Vertices of light subpaths, and what surfaces do to light between either end.

use super::emit::{End, Group, Lights};
use crate::mirrors::{NO_MIRROR, Shown};
use crate::surface::Site;
use crate::tracer::Tracer;
use glam::Vec3;

/// Vertices of a light subpath beyond the light, at the most.
pub(super) const LIGHT_VERTICES: usize = 3;

/// A vertex z_k of a light subpath, k of 1 or more.
#[derive(Clone, Copy)]
pub(super) struct LightVertex {
    /// Of the batch's paths.
    pub(super) path: u32,
    pub(super) site: Site,
    /// Unit direction to z_{k-1}.
    pub(super) toward: Vec3,
    /// Light that arrives, over the density of the subpath.
    pub(super) arriving: Vec3,
    pub(super) end: End,
    /// Density of this vertex with respect to area; of z_1 times that of z_0 over the density that z_1
    /// itself would choose z_0 with.
    pub(super) density: f32,
    /// Area at z_{k-1} an angle here, inverted: its cosine over the squared distance. Of z_0: inverted
    /// density of the choice of z_0 from here, with respect to angle; zero where no ray meets it.
    pub(super) back: f32,
    /// Density of z_{k-1} as `density` is that of z_k; of z_0: 1.
    pub(super) before: f32,
    /// Sum over the ways in which z_{k-2} and all before belong to the other end, relative to their density here.
    pub(super) others: f32,
    /// Which vertex this is: k.
    pub(super) number: u32,
    /// Mirror of z_1, if this is z_1 or z_2: which, and where.
    pub(super) mirror: u8,
    /// The density of z_1 with respect to area; its position and normal.
    pub(super) by_light: f32,
    pub(super) first_place: (Vec3, Vec3),
}

/// f cos and density at a point, for light from `l` sent to `v`.
#[inline]
pub(super) fn scattered(site: &Site, v: Vec3, l: Vec3) -> (Vec3, f32) {
    let at = site.seen_from(v);
    if !at.agrees(l) {
        return (Vec3::ZERO, 0.0);
    }
    let value = at.bsdf.eval(at.shading, v, l);
    (value, at.bsdf.pdf(at.shading, v, l))
}

/// Density at a point with which light from `l` is sent to `v`; zero into solids of glass, where light
/// subpaths do not go.
#[inline]
pub(super) fn sent_to(site: &Site, v: Vec3, l: Vec3) -> f32 {
    let at = site.seen_from(l);
    if !at.agrees(v) || site.enters(v, l) {
        return 0.0;
    }
    at.bsdf.pdf(at.shading, l, v)
}

impl LightVertex {
    /// z_1 at a point, if light from `end` arrives there.
    pub(super) fn first(
        (tracer, lights): (&Tracer, &Lights),
        path: u32,
        (triangle, barycentrics): (u32, [f32; 2]),
        end: &End,
    ) -> Option<LightVertex> {
        let site = tracer.site(triangle, barycentrics);
        let sent = lights.sent(end, site.position)?;
        let cosine = site.outward.dot(sent.toward).abs();
        let by_light = sent.leave * cosine;
        let choice = lights.choice(end, site.position);
        if by_light <= 0.0 || choice <= 0.0 || end.emit <= 0.0 {
            return None;
        }
        let visible = sent.area_per_angle > 0.0;
        Some(LightVertex {
            path,
            site,
            toward: sent.toward,
            arriving: sent.irradiance / (end.emit * by_light),
            end: *end,
            density: by_light * end.emit / choice,
            back: if visible {
                1.0 / (sent.area_per_angle * choice)
            } else {
                0.0
            },
            before: 1.0,
            others: 0.0,
            number: 1,
            mirror: tracer.mirrors.of(triangle),
            by_light,
            first_place: (site.position, site.outward),
        })
    }

    /// Density of z_1 by a mirror as z_2 or x at `from` sees it, over that by its light.
    pub(super) fn mirrored(&self, tracer: &Tracer, from: Vec3) -> f32 {
        if self.mirror == NO_MIRROR {
            return 0.0;
        }
        let mirrors = &tracer.mirrors;
        mirrors.density_any(self.mirror, from, self.end.shown(), self.first_place) / self.by_light
    }

    /// The sum over all ways in which z_{k-1} and those before belong to the other end, if paths from
    /// there go on to z_{k-1} with `density`.
    pub(super) fn earlier(&self, density: f32, tracer: &Tracer) -> f32 {
        let own = density * self.back / self.before;
        match self.number {
            1 => own,
            // z_1 may be found by a mirror too
            2 => own * (1.0 + self.others) + self.mirrored(tracer, self.site.position),
            _ => own * (1.0 + self.others),
        }
    }
}

impl End {
    /// The end as mirrors show it.
    pub(super) fn shown(&self) -> Shown {
        match self.group {
            Group::Far => Shown::far_end(self.at),
            _ => Shown::point(self.at),
        }
    }
}
