//! Shading of a tile's vertices: light gathered, a direction chosen.

use super::lanes::{Departures, FarLanes, LampLanes, Lit, Vertices};
use super::random::Draws;
use super::tile::Contributions;
use glam::Vec3;
use multiversion::multiversion;
use rrf_materials::math::pick;
use rrf_materials::{Lane3, MaterialLanes, Scatter, Scattered, TILE};

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

/// Whether `l` leaves to the viewer's side, and whether both normals agree about that: light through
/// a surface by one of them alone does not count.
#[inline(always)]
fn side<const MIXED: bool>(at: &Vertices, i: usize, n: Vec3, l: Vec3) -> (bool, bool) {
    let above = at.surfaces.geometric.get(i).dot(l) > 0.0;
    let agrees = if MIXED {
        above == (n.dot(l) > 0.0)
    } else {
        above
    };
    (above, agrees)
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
        let (above, faces) = side::<MIXED>(at, i, n, l);
        // the others find light on the viewer's side alone
        let weight = if shared & above {
            let other = cosine / (at.solid_angle[i] * distance2) + at.mirror_density[i];
            at.density[i] / (at.density[i] + other)
        } else {
            1.0
        };
        let value = at.throughput.get(i) * value * (weight / distance2);
        let value = value * at.intensity.get(i);
        let origin = at.surfaces.origin_on(i, above);
        out.value
            .set(i, pick(faces & (distance2 > 0.0), value, Vec3::ZERO));
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
        let (above, agrees) = side::<MIXED>(at, i, n, l);
        let faces = agrees & (cosine > 0.0);
        let origin = at.surfaces.origin_on(i, above);
        let target = lamps.position.get(i) + lamps.normal.get(i) * lamps.lift[i];
        out.value
            .set(i, pick(faces & (distance2 > 0.0), value, Vec3::ZERO));
        out.origin.set(i, origin);
        out.direction.set(i, target - origin);
    }
}

/// Next-event estimation toward light from afar, by the balance heuristic against the path's next
/// direction having met it.
#[inline(always)]
fn next_far_lanes<const MIXED: bool>(
    at: &Vertices,
    far: &FarLanes,
    answers: &Answers,
    out: &mut Contributions,
) {
    for i in 0..TILE {
        let l = far.toward.get(i);
        let (n, v) = (at.surfaces.shading.get(i), at.viewer.get(i));
        let (value, density) = eval::<MIXED>(&at.surfaces.materials, &answers.here, i, [n, v, l]);
        let own = far.density[i];
        let weight = if own > 0.0 {
            own / (own + density)
        } else {
            1.0
        };
        let value = at.throughput.get(i) * value * far.irradiance.get(i) * weight;
        let (above, faces) = side::<MIXED>(at, i, n, l);
        out.value.set(i, pick(faces, value, Vec3::ZERO));
        out.origin.set(i, at.surfaces.origin_on(i, above));
        out.direction.set(i, l);
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
        let value = at.throughput.get(i) * value * onward * scale * lit.intensity.get(i);
        let (above, agrees) = side::<MIXED>(at, i, n, l);
        let faces = agrees & (cosine > 0.0);
        let origin = at.surfaces.origin_on(i, above);
        let is_lit = (lit.falloff[i] > 0.0) & (lit.density[i] > 0.0);
        let counts = faces & (distance2 > 0.0) & is_lit;
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
        let n = at.surfaces.shading.get(i);
        let (above, agrees) = side::<MIXED>(at, i, n, sampled.l);
        let goes_on = (draws.units[3][i] < survival) & agrees & (largest >= f32::MIN_POSITIVE);
        out.throughput.set(i, throughput / survival);
        out.origin.set(i, at.surfaces.origin_on(i, above));
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

    /// Asks the vertices' materials for light from some directions; false where all are Lambert.
    fn ask_along(&mut self, at: &Vertices, toward: &Lane3) -> bool {
        let materials = &at.surfaces.materials;
        if materials.all_diffuse() {
            return false;
        }
        let directions = [&at.surfaces.shading, &at.viewer, toward];
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
dispatched!(next_far_widest, next_far_lanes, (at: &Vertices, far: &FarLanes, answers: &Answers, out: &mut Contributions));
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

/// [`next_far_lanes`] for the widest instruction set.
pub(crate) fn next_far(
    at: &Vertices,
    far: &FarLanes,
    answers: &mut Answers,
    out: &mut Contributions,
) {
    let mixed = answers.ask_along(at, &far.toward);
    next_far_widest(mixed, at, far, answers, out);
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
