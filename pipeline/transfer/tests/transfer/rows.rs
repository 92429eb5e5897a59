//! TransferRows against the path tracer that knows the light, and against closed forms.

use crate::scenes::{MIDDLE, cornell, file, points, room};
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{Material, Scene};
use rrf_trace::{Queries, Sampling, Tracer, broad_indirect, indirect};
use rrf_transfer::{
    PatchConfig, Patches, PointSource, Receivers, RowConfig, RowPoint, TransferRows, trace_rows,
};

const EVEN: fn(Vec3) -> f32 = |_| 1.0;

/// Every vertex deposits a / pi and goes on with a, so that an irradiance of 1 everywhere gives
/// a / pi (a + a^2 + ...) = a^2 / (pi (1 - a)) at every point of a closed room.
#[test]
fn a_furnace_gives_the_geometric_series() {
    assert_furnace(Vec3::new(0.7, 0.5, 0.2), 64, f32::INFINITY);
}

/// Paths of more than 128 reflections end by chance. They carry 8 % of the light where walls reflect 98 % of
/// it, eight standard errors at least.
#[test]
fn long_paths_are_ended_without_bias() {
    assert_furnace(Vec3::new(0.95, 0.97, 0.98), 64, 0.01);
}

/// The rows of a closed room against the series; the last channel's relative error has to be below `power`.
fn assert_furnace(albedo: Vec3, count: usize, power: f32) {
    let scene = room(Vec3::ZERO, Vec3::new(3.0, 2.0, 4.0), albedo);
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &PatchConfig::default(), &EVEN).unwrap();
    let points = points(&tracer, Vec3::new(1.5, 1.0, 2.0), count, 3);
    let config = RowConfig {
        paths: 2_048,
        ..RowConfig::default()
    };
    let stream = Stream::new(2, Stage::Test, 0);
    let rows = trace_rows(&tracer, &patches, &points, &config, stream, 0).unwrap();
    let ones = vec![Vec3::ONE; patches.columns()];
    let expected = albedo * albedo / (Vec3::ONE - albedo) / std::f32::consts::PI;
    let halves: Vec<Vec3> = (0..rows.len())
        .flat_map(|r| (0..2).map(move |h| (r, h)))
        .map(|(r, h)| rows.apply(r, h, &ones).coloured(albedo))
        .collect();
    let n = halves.len() as f32;
    let mean = halves.iter().sum::<Vec3>() / n;
    let squares: Vec3 = halves.iter().map(|v| (*v - mean) * (*v - mean)).sum();
    let error = Vec3::from((squares / (n * (n - 1.0))).to_array().map(f32::sqrt));
    for c in 0..3 {
        // three channels at once in 10^5 runs: 4.65
        let off = (mean[c] - expected[c]).abs();
        assert!(
            off < 4.65 * error[c],
            "channel {c}: {mean} {expected} {error}"
        );
    }
    let relative = (error / expected).z;
    assert!(relative < power, "the test has no power: {relative}");
    // a row's constant part is a dielectric's reflection: Lambert has none
    assert!(rows.entries.iter().all(|e| e.constant == Vec3::ZERO));
}

/// One row and one light in both ways.
struct Comparison {
    found: Vec3,
    found_error: Vec3,
    truth: Vec3,
    truth_error: Vec3,
}

const REPLICATES: usize = 16;

/// Means and standard errors of rows times irradiance and of paths that know the light; of broad parts, at
/// points that have a narrow one too.
fn compare(
    scene: &Scene,
    config: &PatchConfig,
    lights: &[Vec3],
    (seed, broad): (u64, bool),
) -> Vec<Comparison> {
    let tracer = Tracer::new(scene).unwrap();
    let patches = Patches::new(scene, config, &EVEN).unwrap();
    let points: Vec<RowPoint> = match broad {
        false => points(&tracer, MIDDLE, 12, seed),
        true => (points(&tracer, MIDDLE, 200, seed).into_iter())
            .filter(|p| tracer.material_at(&p.point).narrow().is_some())
            .take(12)
            .collect(),
    };
    assert_eq!(points.len(), 12);
    let repeated: Vec<RowPoint> = points
        .iter()
        .flat_map(|p| std::iter::repeat_n(*p, REPLICATES))
        .collect();
    let config = RowConfig {
        paths: 512,
        broad,
        ..RowConfig::default()
    };
    let stream = Stream::new(seed, Stage::Extract, 0);
    let rows = trace_rows(&tracer, &patches, &repeated, &config, stream, 0).unwrap();
    let used = rows.used();
    let receivers = Receivers::new(&tracer, &patches, 16, Some(&used), stream.part(1));
    let columns: Vec<_> = (points.iter())
        .flat_map(|p| lights.iter().map(move |l| (p.point, p.viewer, *l)))
        .collect();
    let queries = Queries {
        points: &columns.iter().map(|c| c.0).collect::<Vec<_>>(),
        viewers: &columns.iter().map(|c| c.1).collect::<Vec<_>>(),
        lights: &columns.iter().map(|c| c.2).collect::<Vec<_>>(),
    };
    let sampling = Sampling {
        paths: 8_192,
        replicates: 32,
    };
    let numbers = Stream::new(seed, Stage::Points, 0);
    let truth = match broad {
        true => broad_indirect(&tracer, queries, sampling, numbers, 0),
        false => indirect(&tracer, queries, 8_192, 32, numbers, 0),
    };
    let truth = truth.unwrap();
    let irradiances: Vec<Vec<Vec3>> = (lights.iter())
        .map(|&position| {
            let intensity = Vec3::ONE;
            receivers.irradiance(&PointSource {
                position,
                intensity,
            })
        })
        .collect();
    (0..columns.len())
        .map(|at| {
            let (point, light) = (at / lights.len(), at % lights.len());
            let colour = tracer.material_at(&points[point].point).base_color;
            let values: Vec<Vec3> = (0..REPLICATES)
                .map(|k| both(&rows, point * REPLICATES + k, &irradiances[light], colour))
                .collect();
            let n = REPLICATES as f32;
            let mean = values.iter().sum::<Vec3>() / n;
            let squares: Vec3 = values.iter().map(|v| (*v - mean) * (*v - mean)).sum();
            Comparison {
                found: mean,
                found_error: (squares / (n * (n - 1.0))).to_array().map(f32::sqrt).into(),
                truth: truth.mean(at),
                truth_error: truth.standard_error(at),
            }
        })
        .collect()
}

fn both(rows: &TransferRows, row: usize, irradiance: &[Vec3], colour: Vec3) -> Vec3 {
    let half = |h| rows.apply(row, h, irradiance).coloured(colour);
    (half(0) + half(1)) * 0.5
}

/// TransferRows times irradiance are what paths that know the light find, but for the patches' means.
/// `bias` is the relative difference that these are allowed in one row.
fn assert_agree(name: &str, found: &[Comparison], bias: f32) {
    let (mut sum, mut variance, mut truth) = (0.0f64, 0.0f64, 0.0f64);
    for (i, c) in found.iter().enumerate() {
        let error = c.found_error * c.found_error + c.truth_error * c.truth_error;
        for k in 0..3 {
            // 16 replicates have tails: 6.5 where a normal variable of as many tests has 5.3
            let limit = 6.5 * error[k].sqrt() + bias * c.truth[k] + 1e-6;
            let off = (c.found[k] - c.truth[k]).abs();
            assert!(off < limit, "{name}, row {i}: {} {}", c.found, c.truth);
            sum += f64::from(c.found[k] - c.truth[k]);
            variance += f64::from(error[k]);
            truth += f64::from(c.truth[k]);
        }
    }
    // the patches' errors average out
    let whole = sum.abs() / truth;
    let noise = 4.5 * variance.sqrt() / truth;
    assert!(
        whole < 0.2 * f64::from(bias) + noise,
        "{name}: {whole} {noise}"
    );
}

const LIGHTS: [Vec3; 4] = [
    Vec3::new(0.0, 1.7, 0.0),
    Vec3::new(-0.6, 1.0, 0.6),
    Vec3::new(0.7, 0.9, -0.6),
    Vec3::new(0.1, 0.3, 0.8),
];

#[test]
fn rows_of_the_cornell_box_are_those_of_the_path_tracer() {
    let config = PatchConfig {
        count: 8_000,
        ..PatchConfig::default()
    };
    assert_agree(
        "cornell",
        &compare(&cornell(), &config, &LIGHTS, (11, false)),
        0.015,
    );
}

/// Patches of metals tell directions apart, and a row's own material is split in two parts.
#[test]
fn rows_of_glossy_surfaces_are_close_to_those_of_the_path_tracer() {
    let scene = file("cornell-glossy/cornell-glossy.glb");
    let config = PatchConfig {
        count: 2_000,
        directions: 12,
        ..PatchConfig::default()
    };
    let found = compare(&scene, &config, &LIGHTS, (12, false));
    assert_agree("glossy", &found, 0.15);
}

/// Rows of broad parts leave out what narrow parts send to the viewer: of a polished floor, its coat.
#[test]
fn rows_of_broad_parts_are_those_of_the_path_tracer() {
    let mut scene = cornell();
    let floor = scene.materials.iter_mut().find(|m| m.name == "Floor");
    let floor = floor.unwrap();
    *floor = Material::principled("Floor", floor.base_color, 0.15, 0.0, 0.5);
    let config = PatchConfig {
        count: 8_000,
        ..PatchConfig::default()
    };
    let found = compare(&scene, &config, &LIGHTS, (13, true));
    assert_agree("broad", &found, 0.05);
}

/// TransferRows made alone equal their part of the whole; halves differ; wrong counts are refused.
#[test]
fn rows_are_functions_of_their_index() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &PatchConfig::default(), &EVEN).unwrap();
    let points = points(&tracer, MIDDLE, 20, 5);
    let stream = Stream::new(4, Stage::Test, 0);
    let config = RowConfig {
        paths: 64,
        ..RowConfig::default()
    };
    let all = trace_rows(&tracer, &patches, &points, &config, stream, 7).unwrap();
    for row in [0, 13, 19] {
        let part = &points[row..row + 1];
        let alone = trace_rows(&tracer, &patches, part, &config, stream, 7 + row as u64).unwrap();
        assert_eq!(alone.half(0, 0), all.half(row, 0));
        assert_eq!(alone.half(0, 1), all.half(row, 1));
        assert_eq!(alone.distance[0], all.distance[row]);
        assert_ne!(alone.half(0, 0), alone.half(0, 1));
        assert!(alone.half(0, 0).0.is_sorted());
    }
    for paths in [0, 7] {
        let config = RowConfig { paths, ..config };
        assert!(trace_rows(&tracer, &patches, &points, &config, stream, 0).is_err());
    }
}
