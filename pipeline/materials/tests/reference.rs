//! Values and densities of the further kinds against Mitsuba 3's.

#![allow(missing_docs, clippy::unwrap_used)]

use glam::Vec3;
use rrf_materials::{Bsdf, Layers, Material, Metal};

const COLUMNS: usize = 22;

fn rows() -> Vec<[f32; COLUMNS]> {
    let bytes = include_bytes!("data/bsdf_more.f32");
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let rows = bytes.chunks_exact(4 * COLUMNS);
    rows.map(|row| {
        let mut numbers = [0.0; COLUMNS];
        for (number_, b) in numbers.iter_mut().zip(row.chunks_exact(4)) {
            *number_ = number(b);
        }
        numbers
    })
    .collect()
}

fn vec3(row: &[f32], at: usize) -> Vec3 {
    Vec3::from_slice(&row[at..at + 3])
}

/// Mitsuba's index of refraction of a `specular` parameter.
fn index_of(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

fn bsdf(row: &[f32]) -> Bsdf {
    let (kind, roughness, metallic, base) = (row[0], row[1], row[2], vec3(row, 3));
    let layers = |clearcoat, clearcoat_gloss, transmission, ior| Layers {
        clearcoat,
        clearcoat_gloss,
        transmission,
        ior,
        absorption: Vec3::ZERO,
    };
    let extended = |layers| Material::principled_extended("", base, roughness, metallic, layers);
    let material = match kind as u32 {
        0 => {
            let metal = Metal {
                eta: vec3(row, 6),
                k: vec3(row, 9),
            };
            Material::conductor("", metal, Vec3::ONE, roughness)
        }
        1 => Material::rough_dielectric("", row[6], Vec3::ONE, Vec3::ZERO, roughness),
        2 => Material::plastic("", base, roughness, row[6]),
        3 => extended(layers(row[7], row[8], 0.0, index_of(row[6]))),
        _ => extended(layers(0.0, 0.0, row[6], row[7])),
    };
    let outside = Bsdf::of(&material);
    if row[14] < 0.0 {
        outside.from_within()
    } else {
        outside
    }
}

/// How far rounding to single precision may move Mitsuba's coat: its density of normals has
/// 1 + (alpha² - 1) cos², of which a few units of 2^-24 are lost, relative.
fn rounding_of_coat(row: &[f32]) -> f32 {
    if row[0] != 3.0 {
        return 0.0;
    }
    let h = (vec3(row, 12) + vec3(row, 15)).as_dvec3().normalize();
    let alpha2 = f64::from(0.1 - 0.099 * row[8]).powi(2);
    let spread = 1.0 - h.z * h.z * (1.0 - alpha2);
    (2.0 * f64::from(f32::EPSILON) / spread) as f32
}

/// Relative differences, where a value exceeds a thousandth of the largest of its material.
#[test]
fn values_and_densities_are_those_of_the_reference() {
    let rows = rows();
    assert_eq!(rows.len(), 5_000);
    let mut worst = [[0.0f32; 2]; 5];
    let mut beyond = [[0; 2]; 5];
    for row in &rows {
        let same = |other: &&[f32; COLUMNS]| other[..12] == row[..12];
        let mates = || rows.iter().filter(same);
        let peak = |at: usize| mates().map(|r| r[at]).fold(0.0, f32::max);
        let (v, l) = (vec3(row, 12), vec3(row, 15));
        let side = v.z.signum();
        let n = Vec3::Z * side;
        // a viewer from within an opaque material sees nothing in Mitsuba, where ours are two-sided
        if side < 0.0 && matches!(row[0] as u32, 0 | 2 | 3) {
            continue;
        }
        let bsdf = bsdf(row);
        let (value, density) = (bsdf.eval(n, v, l), bsdf.pdf(n, v, l));
        let kind = row[0] as usize;
        let mut judge = |which: usize, found: f32, truth: f32, peak: f32| {
            if truth <= 1e-3 * peak {
                assert!(
                    found <= 2e-3 * peak,
                    "{row:?}: {found} where {truth} is expected"
                );
                return;
            }
            let error = (found / truth - 1.0).abs();
            worst[kind][which] = worst[kind][which].max(error);
            // the share of plastic's coat, 1 - T of a table, has fewer digits than T
            let table = if (kind, which) == (2, 1) { 5e-4 } else { 0.0 };
            if error.is_nan() || error > 1e-3 + rounding_of_coat(row) + table {
                beyond[kind][which] += 1;
                println!("{which} {found} {truth} {error:.1e} {row:?}");
            }
        };
        for c in 0..3 {
            judge(0, value[c], row[18 + c], peak(18 + c));
        }
        judge(1, density, row[21], peak(21));
    }
    println!("largest relative differences (value, density) a kind: {worst:.1?}");
    assert_eq!(
        beyond, [[0; 2]; 5],
        "rows beyond 1e-3, a kind: value, density"
    );
}
