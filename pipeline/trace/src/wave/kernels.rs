//! Shading of a tile's vertices: light gathered, a direction chosen.

use super::random::Draws;
use super::tile::{Contributions, Surfaces};
use glam::Vec3;
use multiversion::multiversion;
use rrf_materials::math::pick;
use rrf_materials::{Lane, Lane3, MaterialLanes, Scatter, Scattered, TILE};
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
    pub(crate) mirror_density: Lane,
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
        mirror_density: [0.0; TILE],
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

/// Questions to the materials of a tile and their answers, where not all are Lambert.
pub(crate) struct Answers {
    /// Unit directions from the vertices to the light, and back.
    to: Lane3,
    back: Lane3,
    /// Shading normals of the lit points on the vertices' side.
    normal: Lane3,
    /// At the vertices, and at the lit points.
    here: Scattered,
    there: Scattered,
}

impl Answers {
    pub(crate) const ZERO: Answers = Answers {
        to: Lane3::ZERO,
        back: Lane3::ZERO,
        normal: Lane3::ZERO,
        here: Scattered::ZERO,
        there: Scattered::ZERO,
    };
}

/// Value and density of a lane: what its kind has answered or, where all are Lambert, found here.
#[inline(always)]
fn eval<const MIXED: bool>(
    lanes: &MaterialLanes,
    answer: &Scattered,
    i: usize,
    [n, v, l]: [Vec3; 3],
) -> (Vec3, f32) {
    if MIXED {
        (answer.value.get(i), answer.density[i])
    } else {
        lanes.diffuse(i, n, v, l)
    }
}

/// Squared distance from a vertex to a point, and the unit direction.
#[inline(always)]
fn toward(at: &Vertices, i: usize, point: Vec3) -> (f32, Vec3) {
    let to = point - at.surfaces.position.get(i);
    let distance2 = to.length_squared();
    (distance2, to / distance2.sqrt())
}

/// Shading normal of a lit point on the side that `l` arrives from; the geometric one where it
/// turns away.
#[inline(always)]
fn lit_normal(lit: &Lit, i: usize, l: Vec3) -> Vec3 {
    let shading = lit.surfaces.shading.get(i);
    pick(shading.dot(l) < 0.0, shading, lit.surfaces.geometric.get(i))
}

/// Next-event estimation: light that comes straight from the point light; when `shared`,
/// by the balance heuristic (Veach and Guibas 1995) against [`connect`] or a mirror having found
/// the vertex.
#[inline(always)]
fn next_event_lanes<const MIXED: bool>(
    at: &Vertices,
    shared: bool,
    answers: &Answers,
    out: &mut Contributions,
) {
    for i in 0..TILE {
        let geometric = at.surfaces.geometric.get(i);
        let light = at.light.get(i);
        let (distance2, l) = toward(at, i, light);
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, _) = eval::<MIXED>(&at.surfaces.materials, &answers.here, i, [n, v, l]);
        let cosine = geometric.dot(l);
        let other = if shared {
            cosine / (4.0 * PI * distance2) + at.mirror_density[i]
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
fn next_lamp_lanes<const MIXED: bool>(
    at: &Vertices,
    lamps: &LampLanes,
    answers: &Answers,
    out: &mut Contributions,
) {
    for i in 0..TILE {
        let (distance2, l) = toward(at, i, lamps.position.get(i));
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, density) = eval::<MIXED>(&at.surfaces.materials, &answers.here, i, [n, v, l]);
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
fn connect_lanes<const MIXED: bool>(
    at: &Vertices,
    lit: &Lit,
    answers: &Answers,
    out: &mut Contributions,
) {
    for i in 0..TILE {
        let (distance2, l) = toward(at, i, lit.surfaces.position.get(i));
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, density) = eval::<MIXED>(&at.surfaces.materials, &answers.here, i, [n, v, l]);
        let geometric = lit.surfaces.geometric.get(i);
        let directions = [lit_normal(lit, i, l), -l, lit.toward.get(i)];
        let (onward, _) = eval::<MIXED>(&lit.surfaces.materials, &answers.there, i, directions);
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
fn scatter_lanes<const MIXED: bool>(
    at: &Vertices,
    draws: &Draws,
    keep: f32,
    answers: &Answers,
    out: &mut Departures,
) {
    for i in 0..TILE {
        let sampled = if MIXED {
            Scatter {
                l: answers.here.direction.get(i),
                weight: answers.here.value.get(i),
                pdf: answers.here.density[i],
            }
        } else {
            let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
            let u = [draws.units[0][i], draws.units[1][i], draws.units[2][i]];
            at.surfaces.materials.diffuse_sample(i, n, v, u)
        };
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

/// Unit directions from the vertices to some points.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
fn aim(at: &Vertices, points: &Lane3, to: &mut Lane3) {
    for i in 0..TILE {
        to.set(i, toward(at, i, points.get(i)).1);
    }
}

/// The way back from lit points, and their normals on that side.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
fn aim_back(lit: &Lit, answers: &mut Answers) {
    for i in 0..TILE {
        let l = answers.to.get(i);
        answers.back.set(i, -l);
        answers.normal.set(i, lit_normal(lit, i, l));
    }
}

impl Answers {
    /// Asks the vertices' materials for light from some points; false where all are Lambert.
    fn ask(&mut self, at: &Vertices, points: &Lane3) -> bool {
        let materials = &at.surfaces.materials;
        if materials.all_diffuse() {
            return false;
        }
        aim(at, points, &mut self.to);
        let directions = [&at.surfaces.shading, &at.viewer, &self.to];
        materials.eval(directions, &mut self.here);
        true
    }

    /// Asks the materials of vertices and lit points for the way between them.
    fn ask_both(&mut self, at: &Vertices, lit: &Lit) -> bool {
        let [here, there] = [&at.surfaces.materials, &lit.surfaces.materials];
        if here.all_diffuse() && there.all_diffuse() {
            return false;
        }
        aim(at, &lit.surfaces.position, &mut self.to);
        aim_back(lit, self);
        let directions = [&at.surfaces.shading, &at.viewer, &self.to];
        here.eval(directions, &mut self.here);
        there.eval([&self.normal, &self.back, &lit.toward], &mut self.there);
        true
    }

    /// Asks the vertices' materials where paths go.
    fn ask_where(&mut self, at: &Vertices, draws: &Draws) -> bool {
        let materials = &at.surfaces.materials;
        if materials.all_diffuse() {
            return false;
        }
        let [a, b, c, _] = &draws.units;
        let directions = [&at.surfaces.shading, &at.viewer];
        materials.sample(directions, [a, b, c], &mut self.here);
        true
    }
}

macro_rules! dispatched {
    ($name:ident, $lanes:ident, ($($argument:ident: $kind:ty),*)) => {
        fn $name(mixed: bool, $($argument: $kind),*) {
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
dispatched!(next_event_widest, next_event_lanes, (at: &Vertices, shared: bool, answers: &Answers, out: &mut Contributions));
dispatched!(connect_widest, connect_lanes, (at: &Vertices, lit: &Lit, answers: &Answers, out: &mut Contributions));
dispatched!(next_lamp_widest, next_lamp_lanes, (at: &Vertices, lamps: &LampLanes, answers: &Answers, out: &mut Contributions));
dispatched!(scatter_widest, scatter_lanes, (at: &Vertices, draws: &Draws, keep: f32, answers: &Answers, out: &mut Departures));

/// [`next_event_lanes`] for the widest instruction set.
pub(crate) fn next_event(
    at: &Vertices,
    shared: bool,
    answers: &mut Answers,
    out: &mut Contributions,
) {
    let mixed = answers.ask(at, &at.light);
    next_event_widest(mixed, at, shared, answers, out);
}

/// [`next_lamp_lanes`] for the widest instruction set.
pub(crate) fn next_lamp(
    at: &Vertices,
    lamps: &LampLanes,
    answers: &mut Answers,
    out: &mut Contributions,
) {
    let mixed = answers.ask(at, &lamps.position);
    next_lamp_widest(mixed, at, lamps, answers, out);
}

/// [`connect_lanes`] for the widest instruction set.
pub(crate) fn connect(at: &Vertices, lit: &Lit, answers: &mut Answers, out: &mut Contributions) {
    let mixed = answers.ask_both(at, lit);
    connect_widest(mixed, at, lit, answers, out);
}

/// [`scatter_lanes`] for the widest instruction set.
pub(crate) fn scatter(
    at: &Vertices,
    draws: &Draws,
    keep: f32,
    answers: &mut Answers,
    out: &mut Departures,
) {
    let mixed = answers.ask_where(at, draws);
    scatter_widest(mixed, at, draws, keep, answers, out);
}
