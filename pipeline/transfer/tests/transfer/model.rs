//! A baked model against the path tracer that knows the light, and its exact properties.

use crate::scenes::cornell;
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Hits, Queries, Rays, Tracer, indirect};
use rrf_transfer::{
    CellChoice, DirectLight, PointSource, RowPoint, TransferConfig, TransferModel, TransferQuery,
    bake_transfer,
};

fn lights(count: u64, seed: u64) -> Vec<PointSource> {
    let stream = Stream::new(seed, Stage::Test, 3);
    let light = |i| {
        let u = stream.units(i, 0, 0);
        PointSource {
            position: Vec3::new(1.2 * u[0] - 0.6, 1.3 + 0.5 * u[1], 1.2 * u[2] - 0.6),
            intensity: Vec3::ONE,
        }
    };
    (0..count).map(light).collect()
}

/// Surface points that eyes in the room see in random directions.
fn seen(tracer: &Tracer, first: u64, count: usize, seed: u64) -> Vec<RowPoint> {
    let stream = Stream::new(seed, Stage::Test, 4);
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    for i in first..first + count as u64 {
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let eye = Vec3::new(1.6 * u[0] - 0.8, 1.25 + 0.6 * u[1], 1.6 * u[2] - 0.8);
        let z = 1.0 - 2.0 * w[0];
        let (sin, cos) = (std::f32::consts::TAU * w[1]).sin_cos();
        let r = (1.0 - z * z).sqrt();
        rays.push(eye, Vec3::new(r * cos, r * sin, z), f32::INFINITY);
    }
    tracer.closest(&rays, &mut hits);
    let row = |i: usize| {
        let point = tracer.point(hits.triangle[i], hits.barycentrics[i]);
        let viewer = -rays.direction[i];
        (point.normal.dot(viewer).abs() > 0.05).then_some(RowPoint { point, viewer })
    };
    let met = (0..rays.len()).filter(|&i| hits.triangle[i] != rrf_scene::INVALID);
    met.filter_map(row).collect()
}

pub fn config(choice: CellChoice) -> TransferConfig {
    let mut config = TransferConfig {
        rows: 2_500,
        pool: 2.0,
        candidates: 1.5,
        least_rows: 16,
        pilot_rows: 500,
        rounds: 0,
        choice,
        ..TransferConfig::default()
    };
    config.patches.count = 400;
    config.paths.paths = 128;
    config
}

pub fn bake(tracer: &Tracer, config: &TransferConfig) -> TransferModel {
    let lights = lights(120, 1);
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let draw = |_: u64, count: usize| -> Vec<RowPoint> { seen(tracer, 0, count, 31) };
    bake_transfer(tracer, &draw, &lights, config, &|| false).unwrap()
}

/// Relative error of a model at fresh points under fresh lights, noise of the truth taken out.
fn error(tracer: &Tracer, model: &TransferModel) -> f32 {
    let points = seen(tracer, 0, 60, 77);
    let lights = lights(6, 78);
    let columns: Vec<_> = (points.iter())
        .flat_map(|p| lights.iter().map(move |l| (p.point, p.viewer, l.position)))
        .collect();
    let queries = Queries {
        points: &columns.iter().map(|c| c.0).collect::<Vec<_>>(),
        viewers: &columns.iter().map(|c| c.1).collect::<Vec<_>>(),
        lights: &columns.iter().map(|c| c.2).collect::<Vec<_>>(),
    };
    let truth = indirect(
        tracer,
        queries,
        2_048,
        2,
        Stream::new(5, Stage::Points, 0),
        0,
    )
    .unwrap();
    let asked: Vec<_> = points
        .iter()
        .map(|p| TransferQuery::of_row(tracer, p))
        .collect();
    let receivers = model.receivers(tracer);
    let means: Vec<f32> = (0..columns.len())
        .map(|q| truth.mean(q).element_sum() / 3.0)
        .collect();
    let least = 0.05 * means.iter().sum::<f32>() / means.len() as f32;
    let mut sum = 0.0;
    for (l, light) in lights.iter().enumerate() {
        let light = model.coefficients(&receivers.irradiance(light)).unwrap();
        for (p, answer) in model.evaluate(&light, &asked).iter().enumerate() {
            let q = p * lights.len() + l;
            let [a, b] = [truth.halves(q)[0], truth.halves(q)[1]];
            let off = (answer.radiance - a) * (answer.radiance - b);
            sum += off.element_sum() / 3.0 / means[q].max(least).powi(2);
        }
    }
    (sum / columns.len() as f32).sqrt()
}

/// A small bake comes within 10 % of the truth, whichever cells it has: 5 % to 6 % was measured, and
/// less for larger bakes (docs/science/transfer.md).
#[test]
fn models_answer_fresh_points_and_lights() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    for choice in [CellChoice::Best, CellChoice::Nets, CellChoice::Nodes] {
        let model = bake(&tracer, &config(choice));
        let error = error(&tracer, &model);
        assert!(error < 0.10, "{choice:?}: {error}");
    }
}

/// A light of 0 is no light, twice a light is twice the radiance, and two lights together are their
/// sum, channel by channel; the answers are the same at any number of threads.
#[test]
fn models_are_linear_and_deterministic() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
    };
    let [one, model] = [1, 2].map(|n| pool(n).install(|| bake(&tracer, &config(CellChoice::Best))));
    assert_eq!(one.bytes(), model.bytes());
    let points = seen(&tracer, 0, 200, 9);
    let asked: Vec<_> = points
        .iter()
        .map(|p| TransferQuery::of_row(&tracer, p))
        .collect();
    let receivers = model.receivers(&tracer);
    let light = |position, intensity| {
        let light = PointSource {
            position,
            intensity,
        };
        receivers.irradiance(&light)
    };
    let a = light(Vec3::new(0.1, 1.6, 0.2), Vec3::new(1.0, 0.5, 0.2));
    let b = light(Vec3::new(-0.4, 0.9, 0.5), Vec3::new(0.1, 0.7, 2.0));
    let both: Vec<Vec3> = a.iter().zip(&b).map(|(a, b)| *a + *b * 2.0).collect();
    let of = |model: &TransferModel, e: &[Vec3]| {
        let light = model.coefficients(e).unwrap();
        model.evaluate(&light, &asked)
    };
    let [sum, first, second] = [&both, &a, &b].map(|e| of(&model, e));
    assert_eq!(of(&one, &both), sum);
    let mut added = model.coefficients(&a).unwrap();
    added.add_scaled(&model.coefficients(&b).unwrap(), Vec3::splat(2.0));
    let added = model.evaluate(&added, &asked);
    for i in 0..asked.len() {
        let expected = first[i].radiance + second[i].radiance * 2.0;
        let size = first[i].radiance.abs() + second[i].radiance.abs() * 2.0;
        // sums of some hundred single precision terms, some of them larger than the sum
        let room = size * 1e-3 + 1e-5;
        for found in [sum[i].radiance, added[i].radiance] {
            assert!(
                found.abs_diff_eq(expected, room.max_element()),
                "{found} {expected}"
            );
        }
    }
    let dark = vec![Vec3::ZERO; a.len()];
    assert!(of(&model, &dark).iter().all(|a| a.radiance == Vec3::ZERO));
    assert_eq!(model.residual(&dark).unwrap(), 0.0);
    assert!(model.coefficients(&a[1..]).is_err());
}

/// A halted bake says so.
#[test]
fn bakes_can_be_halted() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let lights = lights(20, 1);
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let draw = |_: u64, count: usize| -> Vec<RowPoint> { seen(&tracer, 0, count, 31) };
    let config = TransferConfig {
        rows: 200,
        ..config(CellChoice::Best)
    };
    let halted = bake_transfer(&tracer, &draw, &lights, &config, &|| true).unwrap_err();
    assert_eq!(halted, rrf_transfer::TransferError::Halted);
    let none = |_: u64, _: usize| Vec::new();
    let empty = bake_transfer(&tracer, &none, &lights, &config, &|| false).unwrap_err();
    assert_eq!(empty, rrf_transfer::TransferError::NoRows);
}

/// Cells of up to four times the error that is trusted are so still where answers are averaged with others.
#[test]
fn averaged_answers_are_trusted_longer() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let mut model = bake(&tracer, &config(CellChoice::Nodes));
    let points = seen(&tracer, 0, 40, 77);
    let asked: Vec<_> = points
        .iter()
        .map(|p| TransferQuery::of_row(&tracer, p))
        .collect();
    let light = model.receivers(&tracer).irradiance(&lights(1, 78)[0]);
    let light = model.coefficients(&light).unwrap();
    model.trust = 0.5;
    let mut trusted = |error: f32| -> [Vec<bool>; 2] {
        model.cells.iter_mut().for_each(|cell| cell.error = error);
        let answers = model.evaluate(&light, &asked);
        [
            answers.iter().map(|a| a.trusted).collect(),
            answers.iter().map(|a| a.trusted_on_average).collect(),
        ]
    };
    let [inside, averaged] = trusted(0.4);
    assert_eq!(inside, averaged);
    assert!(inside.contains(&true));
    let none = vec![false; inside.len()];
    assert_eq!(trusted(1.9), [none.clone(), inside]);
    assert_eq!(trusted(2.1), [none.clone(), none]);
}
