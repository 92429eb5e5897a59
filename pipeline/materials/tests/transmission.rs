//! Samplers, energy and reciprocity of the kinds beyond Lambert and Principled, also where lobes are
//! as narrow as they get and viewers graze.

#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../../trace/tests/trace/chi_square.rs"]
mod chi_square;

use chi_square::assert_chi_square;
use glam::{DVec3, Vec3};
use rrf_materials::{Bsdf, Layers, Material, Metal};
use rrf_sampling::{Stage, Stream};
use std::f64::consts::TAU;

fn direction(cosine: f32, turn: f32) -> Vec3 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let angle = turn * std::f32::consts::TAU;
    Vec3::new(sine * angle.cos(), sine * angle.sin(), cosine)
}

fn gold(roughness: f32) -> Bsdf {
    let metal = Metal {
        eta: Vec3::new(0.143, 0.375, 1.44),
        k: Vec3::new(3.98, 2.39, 1.6),
    };
    Bsdf::of(&Material::conductor("", metal, Vec3::ONE, roughness))
}

fn frosted(roughness: f32) -> Bsdf {
    Bsdf::of(&Material::rough_dielectric(
        "",
        1.5,
        Vec3::ONE,
        Vec3::ZERO,
        roughness,
    ))
}

fn plastic(roughness: f32) -> Bsdf {
    Bsdf::of(&Material::plastic(
        "",
        Vec3::new(0.7, 0.3, 0.1),
        roughness,
        1.5,
    ))
}

fn coated(roughness: f32) -> Bsdf {
    let body = Vec3::new(0.7, 0.3, 0.1);
    Bsdf::of(&Material::nonlinear_plastic("", body, roughness, 1.5))
}

fn layered(roughness: f32, clearcoat: f32, transmission: f32) -> Bsdf {
    let layers = Layers {
        clearcoat,
        clearcoat_gloss: 0.2,
        transmission,
        ior: 1.45,
        absorption: Vec3::ZERO,
    };
    let base = Vec3::new(0.7, 0.3, 0.1);
    Bsdf::of(&Material::principled_extended(
        "", base, roughness, 0.2, layers,
    ))
}

fn leaf() -> Bsdf {
    let (back, through) = (Vec3::new(0.2, 0.5, 0.1), Vec3::new(0.3, 0.4, 0.1));
    Bsdf::of(&Material::diffuse_transmission("", back, through))
}

/// The normal of microfacets that send `v` to `l`, upward, and the solid angle of l over that of it.
fn facet(v: DVec3, l: DVec3, eta: f64) -> (DVec3, f64) {
    if l.z > 0.0 {
        let h = (v + l).normalize();
        (h, 4.0 * v.dot(h).abs())
    } else {
        let sum = v + l * eta;
        let h = sum.normalize() * sum.z.signum();
        let spread = v.dot(h) + eta * l.dot(h);
        (h, spread * spread / (eta * eta * l.dot(h).abs()))
    }
}

/// The direction that a microfacet sends `v` to, above or below; `None` where there is none.
fn sent(v: DVec3, h: DVec3, eta: f64, above: bool) -> Option<DVec3> {
    let cosine = v.dot(h);
    if cosine <= 0.0 {
        return None;
    }
    if above {
        let l = h * (2.0 * cosine) - v;
        return (l.z > 0.0).then_some(l);
    }
    let inside = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    let l = h * (cosine / eta - inside.max(0.0).sqrt()) - v / eta;
    (inside > 0.0 && l.z < 0.0).then_some(l.normalize())
}

const RINGS: usize = 20;
const SECTORS: usize = 24;

/// Slopes of microfacets over alpha, in polar cells of equal steps of r² / (1 + r²) and azimuth.
fn cell(h: DVec3, alpha: f64) -> usize {
    let slope = DVec3::new(h.x / h.z, h.y / h.z, 0.0) / alpha;
    let r2 = slope.length_squared();
    let ring = (r2 / (1.0 + r2) * RINGS as f64) as usize;
    let turn = slope.y.atan2(slope.x) / TAU;
    let sector = ((turn - turn.floor()) * SECTORS as f64) as usize;
    ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)
}

/// Draws of a microfacet sampler against its density, in cells of slope above and below: narrow
/// lobes are as wide there as rough ones.
fn assert_facets(name: &str, bsdf: &Bsdf, alpha: f64, v: Vec3, tests: usize) {
    const DRAWS: u64 = 200_000;
    const FINE: usize = 12;
    let (stream, eta) = (Stream::new(21, Stage::Test, 0), f64::from(bsdf.eta));
    let cells = 2 * RINGS * SECTORS;
    let mut counts = vec![0.0; cells + 1];
    for i in 0..DRAWS {
        let u = stream.units(i, 0, 0);
        let s = bsdf.sample(Vec3::Z, v, [u[0], u[1], u[2]]);
        if s.pdf <= 0.0 {
            counts[cells] += 1.0;
            continue;
        }
        let l = s.l.as_dvec3();
        let side = if l.z > 0.0 { 0 } else { RINGS * SECTORS };
        counts[side + cell(facet(v.as_dvec3(), l, eta).0, alpha)] += 1.0;
    }
    let mut expected = Vec::new();
    for above in [true, false] {
        for at in 0..RINGS * SECTORS {
            let mut sum = 0.0;
            for i in 0..FINE * FINE {
                let fine = |k: usize| (k as f64 + 0.5) / FINE as f64;
                let (y, ring) = (fine(i / FINE), at / SECTORS);
                // the last ring holds all of the tail, which a fourth power spreads
                let (part, weight) = match ring + 1 == RINGS {
                    true => (1.0 - (1.0 - y).powi(4), 4.0 * (1.0 - y).powi(3)),
                    false => (y, 1.0),
                };
                let t = (ring as f64 + part) / RINGS as f64;
                let turn = ((at % SECTORS) as f64 + fine(i % FINE)) / SECTORS as f64;
                let r = (t / (1.0 - t)).sqrt() * alpha;
                let (sine, cosine) = (turn * TAU).sin_cos();
                let h = DVec3::new(r * cosine, r * sine, 1.0).normalize();
                let Some(l) = sent(v.as_dvec3(), h, eta, above) else {
                    continue;
                };
                let density = f64::from(bsdf.pdf(Vec3::Z, v, l.as_vec3()));
                if density == 0.0 {
                    continue;
                }
                // d(slope) = alpha² r dr dphi = alpha² dt / (2 (1 - t)²) dphi; d(solid angle) = cos³ d(slope)
                let slopes = alpha * alpha * TAU / (2.0 * (1.0 - t) * (1.0 - t));
                let solid = slopes * h.z.powi(3) * facet(v.as_dvec3(), l, eta).1;
                sum += density * solid * weight;
            }
            expected.push(sum / ((FINE * FINE * RINGS * SECTORS) as f64) * DRAWS as f64);
        }
    }
    let inside: f64 = expected.iter().sum();
    expected.push((DRAWS as f64 - inside).max(0.0));
    assert!(
        inside < DRAWS as f64 * 1.001,
        "{name}: the density integrates to {inside}"
    );
    assert_chi_square(name, &counts, &expected, tests);
}

#[test]
fn facets_follow_their_densities() {
    let mut all = Vec::new();
    for roughness in [0.01, 0.1, 0.5] {
        for cosine in [1.0, 0.5, 0.05] {
            let alpha = f64::from(roughness * roughness).max(0.001);
            let v = direction(cosine, 0.13);
            all.push((
                format!("gold {roughness} {cosine}"),
                gold(roughness),
                alpha,
                v,
            ));
            let glass = frosted(roughness);
            all.push((format!("frosted {roughness} {cosine}"), glass, alpha, v));
            let within = glass.from_within();
            all.push((format!("within {roughness} {cosine}"), within, alpha, v));
        }
    }
    for (name, bsdf, alpha, v) in &all {
        assert_facets(name, bsdf, *alpha, *v, all.len());
    }
}

/// Mean of a function of directions over a sphere's cells, each by midpoints; and the cell of one.
const BANDS: usize = 40;

fn band(l: Vec3) -> usize {
    let turn = f64::from(l.y).atan2(f64::from(l.x)) / TAU;
    let sector = (((turn - turn.floor()) * SECTORS as f64) as usize).min(SECTORS - 1);
    let ring = ((f64::from(l.z) + 1.0) * 0.5 * BANDS as f64) as usize;
    ring.min(BANDS - 1) * SECTORS + sector
}

fn over_bands(of: impl Fn(Vec3) -> f64) -> Vec<f64> {
    const FINE: usize = 32;
    let cells = (0..BANDS * SECTORS).map(|at| {
        let mut sum = 0.0;
        for i in 0..FINE * FINE {
            let fine = |k: usize| (k as f64 + 0.5) / FINE as f64;
            let z = ((at / SECTORS) as f64 + fine(i / FINE)) / BANDS as f64 * 2.0 - 1.0;
            let phi = ((at % SECTORS) as f64 + fine(i % FINE)) / SECTORS as f64 * TAU;
            let sine = (1.0 - z * z).sqrt();
            sum += of(DVec3::new(sine * phi.cos(), sine * phi.sin(), z).as_vec3());
        }
        sum / (FINE * FINE * BANDS * SECTORS) as f64 * 2.0 * TAU
    });
    cells.collect()
}

/// Kinds of several lobes: their samplers against their densities on the whole sphere.
#[test]
fn lobes_follow_their_densities() {
    let all = [
        ("plastic", plastic(0.6)),
        ("nonlinear plastic", coated(0.6)),
        ("coat", layered(0.7, 1.0, 0.0)),
        ("transmission", layered(0.6, 0.0, 0.7)),
        ("transmission, within", layered(0.6, 0.0, 0.7).from_within()),
        ("leaf", leaf()),
        ("body of plastic", plastic(0.05).broad().unwrap()),
    ];
    const DRAWS: u64 = 300_000;
    let stream = Stream::new(22, Stage::Test, 0);
    for (name, bsdf) in &all {
        for cosine in [0.9, 0.25] {
            let v = direction(cosine, 0.2);
            let mut counts = vec![0.0; BANDS * SECTORS + 1];
            for i in 0..DRAWS {
                let u = stream.units(i, 0, 0);
                let s = bsdf.sample(Vec3::Z, v, [u[0], u[1], u[2]]);
                let at = if s.pdf > 0.0 {
                    band(s.l)
                } else {
                    BANDS * SECTORS
                };
                counts[at] += 1.0;
                if s.pdf > 0.0 {
                    assert_eq!(s.pdf, bsdf.pdf(Vec3::Z, v, s.l), "{name}");
                    let value = bsdf.eval(Vec3::Z, v, s.l);
                    let error = (s.weight * s.pdf - value).abs().max_element();
                    assert!(error <= 1e-5 * value.max_element(), "{name}: {value}");
                }
            }
            let mut expected = over_bands(|l| f64::from(bsdf.pdf(Vec3::Z, v, l)));
            let inside: f64 = expected.iter().sum();
            assert!(inside < 1.001, "{name} {cosine}: {inside}");
            expected.push((1.0 - inside).max(0.0));
            expected.iter_mut().for_each(|e| *e *= DRAWS as f64);
            assert_chi_square(
                &format!("{name} {cosine}"),
                &counts,
                &expected,
                2 * all.len(),
            );
        }
    }
}

/// No kind gives back more power than it gets: radiance from a denser side counts its square.
#[test]
fn nothing_makes_energy() {
    let stream = Stream::new(23, Stage::Test, 0);
    let white = |bsdf: Bsdf| Bsdf {
        base_color: Vec3::ONE,
        ..bsdf
    };
    for roughness in [0.01, 0.1, 0.4, 1.0] {
        let glass = frosted(roughness);
        for (name, bsdf) in [
            ("gold", gold(roughness)),
            ("glass", glass),
            ("within", glass.from_within()),
            ("plastic", white(plastic(roughness))),
            ("nonlinear plastic", white(coated(roughness))),
        ] {
            for cosine in [0.03, 0.2, 0.6, 1.0] {
                let v = direction(cosine, 0.0);
                let (mut sum, mut squares) = (0.0, 0.0);
                const N: u64 = 20_000;
                for i in 0..N {
                    let u = stream.units(i, 0, 0);
                    let s = bsdf.sample(Vec3::Z, v, [u[0], u[1], u[2]]);
                    let denser = if s.l.z < 0.0 {
                        bsdf.eta * bsdf.eta
                    } else {
                        1.0
                    };
                    let share = f64::from(s.weight.max_element() * denser);
                    (sum, squares) = (sum + share, squares + share * share);
                }
                let mean = sum / N as f64;
                let error = ((squares / N as f64 - mean * mean).max(0.0) / N as f64).sqrt();
                assert!(
                    mean <= 1.0 + 5.0 * error + 1e-4,
                    "{name} {roughness} {cosine}: {mean}"
                );
            }
        }
    }
}

/// f(v, l) / eta² is the same both ways (Veach 1997, section 5.2): l seen from its own side.
#[test]
fn light_may_cross_both_ways() {
    let stream = Stream::new(24, Stage::Test, 0);
    for (name, bsdf) in [
        ("gold", gold(0.4)),
        ("glass", frosted(0.4)),
        ("plastic", plastic(0.4)),
        ("nonlinear plastic", coated(0.4)),
        ("leaf", leaf()),
        ("transmission", layered(0.5, 0.0, 0.7)),
    ] {
        for i in 0..2_000 {
            let u = stream.units(i, 0, 0);
            let v = direction(0.1 + 0.9 * u[0], u[1]);
            let s = bsdf.sample(Vec3::Z, v, [u[2], u[3], u[1]]);
            if s.pdf <= 0.0 || s.l.z.abs() < 0.05 {
                continue;
            }
            let there = bsdf.eval(Vec3::Z, v, s.l) / s.l.z.abs();
            let (n, from) = match s.l.z > 0.0 {
                true => (Vec3::Z, bsdf),
                false => (Vec3::NEG_Z, bsdf.from_within()),
            };
            let eta2 = if s.l.z > 0.0 {
                1.0
            } else {
                bsdf.eta * bsdf.eta
            };
            let back = from.eval(n, s.l, v) / v.z;
            // radiance seen from l's side is scaled by eta² the other way
            let error = (there * eta2 - back).abs().max_element();
            assert!(
                error <= 2e-3 * (there * eta2).max_element(),
                "{name}: {there} {back} {eta2}"
            );
        }
    }
}
