//! Nonlinear plastic against a walk of light between its coat and its body, and a smooth one against
//! the closed form.

#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use glam::{DVec3, Vec3};
use rrf_materials::{Bsdf, Material, cosine_hemisphere};
use rrf_sampling::{Stage, Stream};

const BODY: Vec3 = Vec3::new(0.9, 0.5, 0.1);
const IOR: f32 = 1.5;

/// Mean and squared standard error of some draws, a channel each.
fn mean(draws: u64, of: impl Fn(u64) -> Vec3) -> [DVec3; 2] {
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for i in 0..draws {
        let x = of(i).as_dvec3();
        (sum, squares) = (sum + x, squares + x * x);
    }
    let mean = sum / draws as f64;
    [mean, (squares / draws as f64 - mean * mean) / draws as f64]
}

/// Light of a constant surrounding that a viewer at `v` sees after a walk: through the coat, any number
/// of times from the body and back to it, and out again; or off the coat at once.
fn walk(coat: &Bsdf, stream: &Stream, i: u64, v: Vec3) -> Vec3 {
    let within = coat.from_within();
    let at = |step: u32| stream.units(i, step, 0);
    let u = at(0);
    let mut s = coat.sample(Vec3::Z, v, [u[0], u[1], u[2]]);
    let mut weight = s.weight;
    for step in 1..400 {
        if weight == Vec3::ZERO || s.l.z > 0.0 {
            return weight;
        }
        let (up, out) = (at(2 * step), at(2 * step + 1));
        let l = cosine_hemisphere([up[0], up[1]]);
        // from within the coat, whose normal there points down, the viewer is where light comes from
        s = within.sample(Vec3::NEG_Z, -l, [out[0], out[1], out[2]]);
        weight *= BODY * s.weight;
    }
    panic!("a walk of 400 steps");
}

/// Reflectance toward a viewer: the material's own by its sampler, and that of the walk.
#[test]
fn the_body_is_what_a_walk_finds() {
    const DRAWS: u64 = 400_000;
    let stream = Stream::new(31, Stage::Test, 0);
    let mut tests = 0.0;
    let mut worst: f64 = 0.0;
    for roughness in [0.0, 0.3, 0.6] {
        let coat = match roughness {
            0.0 => Material::dielectric("", IOR, Vec3::ONE, Vec3::ZERO),
            _ => Material::rough_dielectric("", IOR, Vec3::ONE, Vec3::ZERO, roughness),
        };
        let coat = Bsdf::of(&coat);
        let plastic = Bsdf::of(&Material::nonlinear_plastic("", BODY, roughness, IOR));
        for cosine in [1.0f32, 0.5, 0.2] {
            let v = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let [walked, walked_var] = mean(DRAWS, |i| walk(&coat, &stream, i, v));
            let [own, own_var] = mean(DRAWS, |i| {
                let u = stream.units(i, 0, 1);
                plastic.sample(Vec3::Z, v, [u[0], u[1], u[2]]).weight
            });
            // the table of transmittances is within 1e-3, twice through and once back
            let table = own * 2e-3 + own * BODY.as_dvec3() * 1e-3 / (1.0 - 0.6 * BODY.as_dvec3());
            for c in 0..3 {
                let beyond = ((walked - own)[c].abs() - table[c]).max(0.0);
                let z = beyond / (walked_var[c] + own_var[c]).sqrt();
                println!(
                    "{roughness} {cosine} {c}: {:.4} {:.4} z {z:.1}",
                    walked[c], own[c]
                );
                (tests, worst) = (tests + 1.0, worst.max(z));
            }
        }
    }
    // a significance of 0.001 over all 27 by Šidák is 4.1 standard errors
    assert_eq!(tests, 27.0);
    assert!(worst < 4.1, "{worst} standard errors");
}

/// Fresnel's reflectance in double precision.
fn fresnel(cosine: f64, eta: f64) -> f64 {
    let inside = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    if inside <= 0.0 {
        return 1.0;
    }
    let inside = inside.sqrt();
    let s = (cosine - eta * inside) / (cosine + eta * inside);
    let p = (inside - eta * cosine) / (inside + eta * cosine);
    0.5 * (s * s + p * p)
}

/// Under a smooth coat the body's value is a (1 - F(v)) (1 - F(l)) cos(l) / (pi eta² (1 - a R)), R the
/// mean reflectance of the coat from within: 2 ∫ F c dc.
#[test]
fn a_smooth_coat_has_the_closed_form() {
    const STEPS: u32 = 100_000;
    let eta = f64::from(IOR);
    let inner = |k: u32| {
        let c = (f64::from(k) + 0.5) / f64::from(STEPS);
        2.0 * c * fresnel(c, 1.0 / eta)
    };
    let back = (0..STEPS).map(inner).sum::<f64>() / f64::from(STEPS);
    assert!((back - 0.596).abs() < 1e-3, "{back}");
    let body = Bsdf::of(&Material::nonlinear_plastic("", BODY, 0.0, IOR));
    let body = body.broad().unwrap();
    for (cos_v, cos_l) in [(1.0f32, 0.9f32), (0.6, 0.6), (0.3, 0.8)] {
        let v = Vec3::new((1.0 - cos_v * cos_v).sqrt(), 0.0, cos_v);
        let l = Vec3::new(0.0, (1.0 - cos_l * cos_l).sqrt(), cos_l);
        let (c_v, c_l) = (f64::from(cos_v), f64::from(cos_l));
        let through = (1.0 - fresnel(c_v, eta)) * (1.0 - fresnel(c_l, eta));
        let scale = through * c_l / (std::f64::consts::PI * eta * eta);
        let a = BODY.as_dvec3();
        let found = body.eval(Vec3::Z, v, l);
        for c in 0..3 {
            let expected = a[c] * scale / (1.0 - a[c] * back);
            // the table's 1e-3, at most thrice: in, out, and in the series
            let error = f64::from(found[c]) / expected - 1.0;
            assert!(error.abs() < 3e-3 + 1e-3 / (1.0 - a[c] * back), "{error}");
        }
    }
}
