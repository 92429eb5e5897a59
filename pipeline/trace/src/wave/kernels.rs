//! What happens at the vertices of a tile: light gathered, a direction chosen.

use super::random::Draws;
use super::tile::{Contributions, Lane, Lane3, Surfaces, TILE};
use crate::math::pick;
use glam::Vec3;
use multiversion::multiversion;
use std::f32::consts::PI;

/// Path vertices of a tile.
pub(crate) struct Vertices {
    pub(crate) surfaces: Surfaces,
    /// Unit directions to where the path came from.
    pub(crate) viewer: Lane3,
    /// Product of f cos / pdf up to here.
    pub(crate) throughput: Lane3,
    /// Largest channel of the throughput after the first scattering.
    pub(crate) first: Lane,
    /// Density of having arrived here, with respect to area.
    pub(crate) density: Lane,
    /// Density with which a mirror would have led here.
    pub(crate) glint: Lane,
    /// Point light of the lane's path.
    pub(crate) light: Lane3,
}

/// The points that a point light's own ray met, or that mirrors show it by.
pub(crate) struct Lit {
    /// Seen from the light.
    pub(crate) surfaces: Surfaces,
    /// Unit direction to the light.
    pub(crate) toward: Lane3,
    /// Irradiance at normal incidence, 1 / distance^2 for 1 W/sr; zero where the ray missed.
    pub(crate) falloff: Lane,
    /// Density of the point with respect to area, by the light's ray and by a mirror together.
    pub(crate) density: Lane,
}

/// Points on lamps, one for each path of a tile.
pub(crate) struct LampLanes {
    pub(crate) position: Lane3,
    /// Unit normal on the path's side.
    pub(crate) normal: Lane3,
    pub(crate) lift: Lane,
    /// Radiance emitted toward the path.
    pub(crate) radiance: Lane3,
    /// Density of the point with respect to area.
    pub(crate) density: Lane,
}

/// Where the paths go next.
pub(crate) struct Departures {
    pub(crate) throughput: Lane3,
    pub(crate) origin: Lane3,
    pub(crate) direction: Lane3,
    /// Density with respect to solid angle; zero where the path ends.
    pub(crate) density: Lane,
}

impl Vertices {
    pub(crate) const ZERO: Vertices = Vertices {
        surfaces: Surfaces::ZERO,
        viewer: Lane3::ZERO,
        throughput: Lane3::ZERO,
        first: [0.0; TILE],
        density: [0.0; TILE],
        glint: [0.0; TILE],
        light: Lane3::ZERO,
    };
}

impl Lit {
    pub(crate) const ZERO: Lit = Lit {
        surfaces: Surfaces::ZERO,
        toward: Lane3::ZERO,
        falloff: [0.0; TILE],
        density: [0.0; TILE],
    };
}

impl LampLanes {
    pub(crate) const ZERO: LampLanes = LampLanes {
        position: Lane3::ZERO,
        normal: Lane3::ZERO,
        lift: [0.0; TILE],
        radiance: Lane3::ZERO,
        density: [0.0; TILE],
    };
}

impl Departures {
    pub(crate) const ZERO: Departures = Departures {
        throughput: Lane3::ZERO,
        origin: Lane3::ZERO,
        direction: Lane3::ZERO,
        density: [0.0; TILE],
    };
}

/// Next-event estimation: light that comes straight from the point light; when `shared`,
/// by the balance heuristic (Veach and Guibas 1995) against [`connect`] or a mirror having found
/// the vertex.
#[inline(always)]
fn next_event_lanes<const MIXED: bool>(at: &Vertices, shared: bool, out: &mut Contributions) {
    for i in 0..TILE {
        let geometric = at.surfaces.geometric.get(i);
        let light = at.light.get(i);
        let to = light - at.surfaces.position.get(i);
        let distance2 = to.length_squared();
        let l = to / distance2.sqrt();
        let bsdf = at.surfaces.bsdf(i);
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, _) = bsdf.eval_pdf::<MIXED>(n, v, l);
        let cosine = geometric.dot(l);
        let other = if shared {
            cosine / (4.0 * PI * distance2) + at.glint[i]
        } else {
            0.0
        };
        let weight = at.density[i] / (at.density[i] + other);
        let value = at.throughput.get(i) * value * (weight / distance2);
        let origin = at.surfaces.origin(i);
        out.value.set(
            i,
            pick((cosine > 0.0) & (distance2 > 0.0), value, Vec3::ZERO),
        );
        out.origin.set(i, origin);
        out.direction.set(i, light - origin);
    }
}

/// Next-event estimation toward a point on a lamp, by the balance heuristic against the
/// path's next direction having found that point.
#[inline(always)]
fn next_lamp_lanes<const MIXED: bool>(at: &Vertices, lamps: &LampLanes, out: &mut Contributions) {
    for i in 0..TILE {
        let to = lamps.position.get(i) - at.surfaces.position.get(i);
        let distance2 = to.length_squared();
        let l = to / distance2.sqrt();
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, density) = at.surfaces.bsdf(i).eval_pdf::<MIXED>(n, v, l);
        let cosine = -lamps.normal.get(i).dot(l);
        let per_area = density * cosine / distance2;
        let scale = cosine / (distance2 * (lamps.density[i] + per_area));
        let value = at.throughput.get(i) * value * lamps.radiance.get(i) * scale;
        let faces = (at.surfaces.geometric.get(i).dot(l) > 0.0) & (cosine > 0.0);
        let origin = at.surfaces.origin(i);
        let target = lamps.position.get(i) + lamps.normal.get(i) * lamps.lift[i];
        out.value
            .set(i, pick(faces & (distance2 > 0.0), value, Vec3::ZERO));
        out.origin.set(i, origin);
        out.direction.set(i, target - origin);
    }
}

/// Light that comes by way of a point that the light's own ray met or that a mirror shows it by, by
/// the balance heuristic among these two and the path's next direction having found that point:
/// value / (sum of the three densities), whichever of the two it was.
#[inline(always)]
fn connect_lanes<const MIXED: bool>(at: &Vertices, lit: &Lit, out: &mut Contributions) {
    for i in 0..TILE {
        let to = lit.surfaces.position.get(i) - at.surfaces.position.get(i);
        let distance2 = to.length_squared();
        let l = to / distance2.sqrt();
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, density) = at.surfaces.bsdf(i).eval_pdf::<MIXED>(n, v, l);
        let geometric = lit.surfaces.geometric.get(i);
        let shading = lit.surfaces.shading.get(i);
        let shading = pick(shading.dot(l) < 0.0, shading, geometric);
        let (onward, _) = lit
            .surfaces
            .bsdf(i)
            .eval_pdf::<MIXED>(shading, -l, lit.toward.get(i));
        let cosine = -geometric.dot(l);
        let per_area = density * cosine / distance2;
        let scale = cosine * lit.falloff[i] / (distance2 * (lit.density[i] + per_area));
        let value = at.throughput.get(i) * value * onward * scale;
        let faces = (at.surfaces.geometric.get(i).dot(l) > 0.0) & (cosine > 0.0);
        let origin = at.surfaces.origin(i);
        let counts = faces & (distance2 > 0.0) & (lit.falloff[i] > 0.0);
        out.value.set(i, pick(counts, value, Vec3::ZERO));
        out.origin.set(i, origin);
        out.direction.set(i, lit.surfaces.origin(i) - origin);
    }
}

/// Chooses the next direction, and whether the path goes on: it does with probability
/// `keep` times its throughput relative to the first one (Russian roulette, Arvo and Kirk 1990); below the normal numbers, whose
/// products never reach zero, it ends.
#[inline(always)]
fn scatter_lanes<const MIXED: bool>(at: &Vertices, draws: &Draws, keep: f32, out: &mut Departures) {
    for i in 0..TILE {
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let u = [draws.units[0][i], draws.units[1][i], draws.units[2][i]];
        let sampled = at.surfaces.bsdf(i).sample_lane::<MIXED>(n, v, u);
        let throughput = at.throughput.get(i) * sampled.weight;
        let largest = throughput.max_element();
        let survival = (keep * largest / at.first[i]).min(1.0);
        let goes_on = (draws.units[3][i] < survival)
            & (at.surfaces.geometric.get(i).dot(sampled.l) > 0.0)
            & (largest >= f32::MIN_POSITIVE);
        out.throughput.set(i, throughput / survival);
        out.origin.set(i, at.surfaces.origin(i));
        out.direction.set(i, sampled.l);
        out.density[i] = if goes_on { sampled.pdf } else { 0.0 };
    }
}

macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $lanes:ident, ($($argument:ident: $kind:ty),*)) => {
        $(#[$doc])*
        pub(crate) fn $name(mixed: bool, $($argument: $kind),*) {
            #[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
            fn all_lambert($($argument: $kind),*) {
                $lanes::<false>($($argument),*)
            }
            #[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
            fn of_any_kind($($argument: $kind),*) {
                $lanes::<true>($($argument),*)
            }
            if mixed { of_any_kind($($argument),*) } else { all_lambert($($argument),*) }
        }
    };
}

dispatched!(
    /// [`next_event_lanes`] for the widest instruction set.
    next_event, next_event_lanes, (at: &Vertices, shared: bool, out: &mut Contributions)
);
dispatched!(
    /// [`connect_lanes`] for the widest instruction set.
    connect, connect_lanes, (at: &Vertices, lit: &Lit, out: &mut Contributions)
);
dispatched!(
    /// [`next_lamp_lanes`] for the widest instruction set.
    next_lamp, next_lamp_lanes, (at: &Vertices, lamps: &LampLanes, out: &mut Contributions)
);
dispatched!(
    /// [`scatter_lanes`] for the widest instruction set.
    scatter, scatter_lanes, (at: &Vertices, draws: &Draws, keep: f32, out: &mut Departures)
);
