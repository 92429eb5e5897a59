//! Scattering: given values, samplers against their densities, energy, reciprocity.

#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../../trace/tests/trace/chi_square.rs"]
mod chi_square;

use chi_square::assert_chi_square;
use glam::{DVec3, Vec3};
use rrf_materials::{
    Bsdf, Material, cosine_hemisphere, cosine_hemisphere_pdf, visible_normal, visible_normal_pdf,
};
use rrf_sampling::{Stage, Stream};
use std::f64::consts::TAU;

fn principled(base_color: Vec3, roughness: f32, metallic: f32, specular: f32) -> Bsdf {
    let material = Material::principled("", base_color, roughness, metallic, specular);
    Bsdf::of(&material)
}

fn lambert(base_color: Vec3) -> Bsdf {
    Bsdf::of(&Material::lambert("", base_color))
}

fn direction(cosine: f32, turn: f32) -> Vec3 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let angle = turn * std::f32::consts::TAU;
    Vec3::new(sine * angle.cos(), sine * angle.sin(), cosine)
}

#[test]
fn values_are_those_of_the_reference() {
    let bytes = include_bytes!("data/bsdf_principled.f32");
    let numbers: Vec<f32> = bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
        .collect();
    let vec3 = |row: &[f32], at: usize| Vec3::from_slice(&row[at..at + 3]);
    assert_eq!(numbers.len(), 5_000 * 15);
    let mut worst = 0.0f32;
    for row in numbers.chunks_exact(15) {
        let bsdf = principled(vec3(row, 0), row[3], row[4], row[5]);
        let value = bsdf.eval(Vec3::Z, vec3(row, 6), vec3(row, 9));
        let truth = vec3(row, 12);
        let error = ((value - truth) / truth).abs().max_element();
        worst = worst.max(error);
        assert!(error <= 1e-4, "{row:?}: {value}");
    }
    println!("5,000 values, largest relative difference {worst:.1e}");
}

/// Turning everything about must not matter: the reference values are for n = z only.
#[test]
fn values_do_not_depend_on_the_frame() {
    let stream = Stream::new(11, Stage::Test, 0);
    for i in 0..1_000 {
        let (a, b) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let turn = glam::Quat::from_axis_angle(direction(2.0 * a[0] - 1.0, a[1]), 6.0 * a[2]);
        let bsdf = principled(Vec3::new(0.2, 0.5, 0.8), 0.2 + 0.8 * a[3], b[0], 0.5);
        let (v, l) = (
            direction(0.1 + 0.9 * b[1], 0.0),
            direction(0.1 + 0.9 * b[2], b[3]),
        );
        let straight = bsdf.eval(Vec3::Z, v, l);
        let turned = bsdf.eval(turn * Vec3::Z, turn * v, turn * l);
        // alpha >= 0.04: rounding of directions is amplified by 2 / alpha at most.
        let error = ((straight - turned) / straight).abs().max_element();
        assert!(error < 1e-4, "{i}: {straight} {turned}");
    }
}

/// Every kind of material that a sampler has to serve, with a slanted viewer.
fn samplers() -> Vec<(String, Bsdf, Vec3)> {
    let mut all = Vec::new();
    for cosine in [1.0, 0.6, 0.2] {
        let v = direction(cosine, 0.1);
        all.push((format!("lambert, {cosine}"), lambert(Vec3::splat(0.5)), v));
        for (roughness, metallic, specular) in [
            (1.0, 0.0, 0.5),
            (0.6, 0.0, 0.5),
            (0.35, 0.0, 1.0),
            (0.5, 1.0, 0.5),
            (0.35, 1.0, 0.0),
            (0.4, 0.5, 0.2),
        ] {
            let base = Vec3::new(0.7, 0.3, 0.1);
            let bsdf = principled(base, roughness, metallic, specular);
            all.push((format!("{bsdf:?}, {cosine}"), bsdf, v));
        }
    }
    all
}

const RINGS: usize = 24;
const SECTORS: usize = 48;

/// Cell of a direction on the upper hemisphere: equal steps of cosine and azimuth.
fn cell(l: Vec3) -> usize {
    let turn = f64::from(l.y).atan2(f64::from(l.x)) / TAU;
    let sector = ((turn - turn.floor()) * SECTORS as f64) as usize;
    let ring = (f64::from(l.z) * RINGS as f64) as usize;
    ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)
}

/// Integral of a density over every cell, by Gauss-Legendre points on a subdivision that is
/// refined until it settles.
fn integrate(pdf: &dyn Fn(Vec3) -> f64) -> Vec<f64> {
    let mut cells = Vec::new();
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let z = [ring as f64, ring as f64 + 1.0].map(|x| x / RINGS as f64);
            let turn = [sector as f64, sector as f64 + 1.0].map(|x| x / SECTORS as f64);
            let whole = gauss(pdf, z, turn);
            cells.push(refine(pdf, z, turn, whole, 0));
        }
    }
    cells
}

fn refine(pdf: &dyn Fn(Vec3) -> f64, z: [f64; 2], turn: [f64; 2], whole: f64, depth: u32) -> f64 {
    let (zm, tm) = (0.5 * (z[0] + z[1]), 0.5 * (turn[0] + turn[1]));
    let quarters = [
        ([z[0], zm], [turn[0], tm]),
        ([zm, z[1]], [turn[0], tm]),
        ([z[0], zm], [tm, turn[1]]),
        ([zm, z[1]], [tm, turn[1]]),
    ];
    let parts = quarters.map(|(z, turn)| gauss(pdf, z, turn));
    let sum: f64 = parts.iter().sum();
    if (sum - whole).abs() < 1e-9 || depth > 7 {
        return sum;
    }
    let refined = quarters.iter().zip(parts);
    refined
        .map(|(&(z, turn), part)| refine(pdf, z, turn, part, depth + 1))
        .sum()
}

/// Four by four points of Gauss and Legendre.
fn gauss(pdf: &dyn Fn(Vec3) -> f64, z: [f64; 2], turn: [f64; 2]) -> f64 {
    const X: [f64; 2] = [0.339_981_043_584_856_3, 0.861_136_311_594_052_6];
    const W: [f64; 2] = [0.652_145_154_862_546_1, 0.347_854_845_137_453_9];
    let nodes = [(-X[1], W[1]), (-X[0], W[0]), (X[0], W[0]), (X[1], W[1])];
    let at = |[a, b]: [f64; 2], x: f64| 0.5 * (a + b) + 0.5 * (b - a) * x;
    let mut sum = 0.0;
    for (x, wx) in nodes {
        for (y, wy) in nodes {
            let (z, phi) = (at(z, x), at(turn, y) * TAU);
            let sine = (1.0 - z * z).sqrt();
            let l = DVec3::new(sine * phi.cos(), sine * phi.sin(), z);
            sum += wx * wy * pdf(l.as_vec3());
        }
    }
    sum * 0.25 * (z[1] - z[0]) * (turn[1] - turn[0]) * TAU
}

/// Draws of a sampler against the integrals of its density; what falls below the surface is
/// one more cell.
fn assert_sampler(
    name: &str,
    sample: &dyn Fn([f32; 3]) -> Vec3,
    pdf: &dyn Fn(Vec3) -> f64,
    tests: usize,
) {
    const DRAWS: u64 = 400_000;
    let stream = Stream::new(5, Stage::Test, 0);
    let mut counts = vec![0.0; RINGS * SECTORS + 1];
    for i in 0..DRAWS {
        let u = stream.units(i, 0, 0);
        let l = sample([u[0], u[1], u[2]]);
        assert!((l.length() - 1.0).abs() < 1e-5, "{name}: {l} is not unit");
        let at = if l.z > 0.0 { cell(l) } else { RINGS * SECTORS };
        counts[at] += 1.0;
    }
    let mut expected = integrate(pdf);
    let inside: f64 = expected.iter().sum();
    assert!(
        inside < 1.0 + 1e-4,
        "{name}: the density integrates to {inside}"
    );
    expected.push((1.0 - inside).max(0.0));
    expected.iter_mut().for_each(|e| *e *= DRAWS as f64);
    assert_chi_square(name, &counts, &expected, tests);
}

#[test]
fn samplers_follow_their_densities() {
    let all = samplers();
    for (name, bsdf, v) in &all {
        let sample = |u| bsdf.sample(Vec3::Z, *v, u).l;
        let pdf = |l| f64::from(bsdf.pdf(Vec3::Z, *v, l));
        assert_sampler(name, &sample, &pdf, all.len());
    }
}

#[test]
fn cosine_hemisphere_follows_its_density() {
    let sample = |u: [f32; 3]| cosine_hemisphere([u[0], u[1]]);
    let pdf = |l: Vec3| f64::from(cosine_hemisphere_pdf(l.z));
    assert_sampler("cosine hemisphere", &sample, &pdf, 1);
}

#[test]
fn visible_normals_follow_their_density() {
    let cases = [(1.0, 0.2), (0.6, 0.5), (0.3, 1.0), (0.1, 0.3)];
    for (cosine, alpha) in cases {
        let v = direction(cosine, 0.3);
        let sample = |u: [f32; 3]| visible_normal(v, alpha, [u[0], u[1]]);
        let pdf = |h: Vec3| f64::from(visible_normal_pdf(v, alpha, h));
        assert_sampler(
            &format!("normals {cosine} {alpha}"),
            &sample,
            &pdf,
            cases.len(),
        );
    }
}

#[test]
fn weights_are_values_over_densities() {
    let stream = Stream::new(6, Stage::Test, 0);
    for (name, bsdf, v) in samplers() {
        for i in 0..2_000 {
            let u = stream.units(i, 0, 0);
            let s = bsdf.sample(Vec3::Z, v, [u[0], u[1], u[2]]);
            let pdf = bsdf.pdf(Vec3::Z, v, s.l);
            let value = bsdf.eval(Vec3::Z, v, s.l);
            assert_eq!(pdf, s.pdf, "{name}");
            assert_eq!(s.l.z > 0.0, pdf > 0.0, "{name}");
            let error = (s.weight * pdf - value).abs().max_element();
            assert!(
                error <= 1e-5 * value.max_element(),
                "{name}: {} {value}",
                s.weight * pdf
            );
        }
    }
}

/// Share of the light from all around that leaves toward v, by midpoints of both lobes' own
/// samplers (a product rule on 256 x 256 squares).
fn albedo(bsdf: &Bsdf, v: Vec3) -> f64 {
    const N: u32 = 256;
    let mut sum = 0.0;
    for i in 0..N {
        for j in 0..N {
            let middle = |k: u32| (k as f32 + 0.5) / N as f32;
            // The lobe is chosen by a third number: radical inverse, so that it is even too.
            let lobe = (i * N + j).reverse_bits() as f32 / 4_294_967_296.0;
            let s = bsdf.sample(Vec3::Z, v, [lobe, middle(i), middle(j)]);
            sum += f64::from(s.weight.x);
        }
    }
    sum / f64::from(N * N)
}

/// The specular lobe never gives back more than it gets, and neither does a metal, a black
/// dielectric or a Lambert surface, from any side.
#[test]
fn lobes_do_not_make_energy() {
    for cosine in [0.02, 0.1, 0.3, 0.7, 1.0] {
        let v = direction(cosine, 0.0);
        assert!(albedo(&lambert(Vec3::ONE), v) <= 1.0 + 1e-6);
        for roughness in [0.1, 0.3, 0.6, 1.0] {
            let metal = albedo(&principled(Vec3::ONE, roughness, 1.0, 0.5), v);
            let black = albedo(&principled(Vec3::ZERO, roughness, 0.0, 1.0), v);
            assert!(metal <= 1.0 + 1e-3, "metal {roughness} {cosine}: {metal}");
            assert!(black <= 1.0 + 1e-3, "black {roughness} {cosine}: {black}");
        }
    }
}

/// Burley's diffuse lobe is not scaled by what the specular one takes: toward grazing viewers a
/// bright dielectric gives back more than it gets (Mitsuba's does the same). Over all viewers it
/// keeps the balance up to a base colour of 0.85.
#[test]
fn dielectrics_keep_the_balance_over_all_viewers() {
    const STEPS: u32 = 24;
    for roughness in [0.1, 0.3, 0.6, 1.0] {
        let bsdf = principled(Vec3::splat(0.85), roughness, 0.0, 0.5);
        let mean = (0..STEPS)
            .map(|i| {
                let squared = (i as f32 + 0.5) / STEPS as f32;
                albedo(&bsdf, direction(squared.sqrt(), 0.0))
            })
            .sum::<f64>()
            / f64::from(STEPS);
        assert!(mean <= 1.0, "roughness {roughness}: {mean}");
    }
}

#[test]
fn light_may_run_both_ways() {
    let stream = Stream::new(7, Stage::Test, 0);
    for (name, bsdf, _) in samplers() {
        for i in 0..500 {
            let u = stream.units(i, 0, 0);
            let (v, l) = (
                direction(0.05 + 0.95 * u[0], u[1]),
                direction(0.05 + 0.95 * u[2], u[3]),
            );
            let there = bsdf.eval(Vec3::Z, v, l) / l.z;
            let back = bsdf.eval(Vec3::Z, l, v) / v.z;
            let error = (there - back).abs().max_element();
            assert!(
                error <= 2e-5 * there.max_element(),
                "{name}: {there} {back}"
            );
        }
    }
}

/// Broad and narrow part sum to the whole, and each has its own sampler.
#[test]
fn parts_sum_to_the_whole() {
    let stream = Stream::new(8, Stage::Test, 0);
    let mirror = principled(Vec3::splat(0.9), 0.05, 1.0, 0.5);
    let coat = principled(Vec3::new(0.7, 0.3, 0.1), 0.2, 0.0, 0.5);
    let rough = principled(Vec3::new(0.7, 0.3, 0.1), 0.3, 0.5, 0.5);
    assert!(mirror.is_narrow() && mirror.broad().is_none());
    assert!(!coat.is_narrow() && coat.narrow().is_some() && coat.broad().is_some());
    assert!(rough.narrow().is_none() && lambert(Vec3::ONE).narrow().is_none());
    for bsdf in [mirror, coat, rough, lambert(Vec3::ONE)] {
        for i in 0..2_000 {
            let (a, b) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
            let v = direction(0.05 + 0.95 * a[0], a[1]);
            let l = bsdf.sample(Vec3::Z, v, [a[2], a[3], b[0]]).l;
            let parts = [bsdf.broad(), bsdf.narrow()];
            let parts = parts.into_iter().flatten();
            let sum: Vec3 = parts.map(|part| part.eval(Vec3::Z, v, l)).sum();
            let whole = bsdf.eval(Vec3::Z, v, l);
            let error = (sum - whole).abs().max_element();
            assert!(
                error <= 1e-6 * whole.max_element(),
                "{bsdf:?}: {sum} {whole}"
            );
        }
    }
    for part in [coat.broad(), coat.narrow()].into_iter().flatten() {
        let v = direction(0.6, 0.1);
        let pdf = |l| f64::from(part.pdf(Vec3::Z, v, l));
        let sample = |u| part.sample(Vec3::Z, v, u).l;
        assert_sampler(&format!("{:?}", part.parts), &sample, &pdf, 2);
    }
}

#[test]
fn nothing_is_scattered_through_the_surface() {
    let above = direction(0.5, 0.2);
    let below = -direction(0.4, 0.7);
    for (name, bsdf, _) in samplers() {
        for (v, l) in [(above, below), (below, above), (below, below)] {
            assert_eq!(bsdf.eval(Vec3::Z, v, l), Vec3::ZERO, "{name}");
            assert_eq!(bsdf.pdf(Vec3::Z, v, l), 0.0, "{name}");
        }
    }
}
