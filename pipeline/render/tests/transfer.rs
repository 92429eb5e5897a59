//! Frames by a transfer: linear in the lights, and what the model says.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use glam::Vec3;
use rrf_lights::{DistantLight, OwnLight};
use rrf_render::{
    AreaLights, Frame, FrameStage, Lights, OFF_CENTRE, Part, RenderOptions, Renderer, View,
};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, LoadOptions, PointLight, Scene, load};
use rrf_trace::{Hits, Queries, Rays, Tracer, indirect};
use rrf_transfer::{
    DirectLight, LightBook, PointSource, RowPoint, TransferConfig, TransferModel, TransferQuery,
    bake_transfer,
};
use std::time::Duration;

fn cornell() -> Scene {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    );
    load(path.as_ref(), &LoadOptions::default()).unwrap()
}

/// Surface points that eyes in the room see.
fn seen(tracer: &Tracer, count: usize) -> Vec<RowPoint> {
    let stream = Stream::new(3, Stage::Test, 0);
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    for i in 0..count as u64 {
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let eye = Vec3::new(1.6 * u[0] - 0.8, 1.3 + 0.5 * u[1], 1.6 * u[2] - 0.8);
        let direction = rrf_lights::uniform_sphere([w[0], w[1]]);
        rays.push(eye, direction, f32::INFINITY);
    }
    tracer.closest(&rays, &mut hits);
    let met = (0..count).filter(|&i| hits.triangle[i] != INVALID);
    met.map(|i| RowPoint {
        point: tracer.point(hits.triangle[i], hits.barycentrics[i]),
        viewer: -rays.direction[i],
    })
    .collect()
}

/// A small model of the box without its lamp.
fn model(tracer: &Tracer) -> TransferModel {
    let stream = Stream::new(4, Stage::Test, 0);
    let lights: Vec<PointSource> = (0..60)
        .map(|i| {
            let u = stream.units(i, 0, 0);
            PointSource {
                // above the boxes: a light in a solid lights nothing that eyes see
                position: Vec3::new(1.4 * u[0] - 0.7, 1.3 + 0.5 * u[1], 1.4 * u[2] - 0.7),
                intensity: Vec3::ONE,
            }
        })
        .collect();
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let mut config = TransferConfig {
        rows: 1_200,
        pool: 2.0,
        candidates: 1.5,
        least_rows: 16,
        pilot_rows: 300,
        rounds: 0,
        trust: 2.0,
        ..TransferConfig::default()
    };
    config.patches.count = 300;
    config.paths.paths = 64;
    let draw = |_: u64, count: usize| seen(tracer, count);
    bake_transfer(tracer, &draw, &lights, &config, &|| false).unwrap()
}

fn view(scene: &Scene) -> View {
    let mut view = View::from(&scene.cameras[0]);
    (view.width, view.height) = (40, 30);
    view
}

fn point(x: f32, intensity: Vec3) -> PointLight {
    PointLight {
        position: Vec3::new(x, 1.4, 0.3),
        intensity,
    }
}

fn lights(points: &[PointLight], sun: bool, area: bool) -> Lights {
    let toward = Vec3::new(0.1, 0.2, 1.0).normalize();
    let sun = sun.then(|| OwnLight {
        name: "sun".into(),
        source: DistantLight::sun(toward, Vec3::new(1.0, 2.0, 0.5)).into(),
    });
    Lights {
        points: points.to_vec(),
        area,
        sources: sun.into_iter().collect(),
        ..Lights::default()
    }
}

#[test]
fn frames_of_a_transfer() {
    let scene = cornell();
    let unlit = scene.unlit();
    let (whole, tracer) = (Tracer::new(&scene).unwrap(), Tracer::new(&unlit).unwrap());
    let model = model(&tracer);
    let book = LightBook::new(&model, &tracer).unwrap();
    let renderer = Renderer::of_transfer(&whole, &book);
    let lamps = AreaLights::without_proxies(&scene);
    let view = view(&scene);
    let told = |_: &rrf_field::columns::Columns| Vec::new();
    let frame = |lights: &Lights| {
        let options = RenderOptions {
            part: Part::Indirect,
            area_lights: Some(&lamps),
            trusted: Some(&told),
            ..RenderOptions::default()
        };
        let mut frame = Frame::default();
        let timings = renderer
            .render(&view, lights, &options, &mut frame)
            .unwrap();
        let coefficients = timings.0[FrameStage::Coefficients as usize];
        assert!(coefficients > Duration::ZERO);
        frame
    };
    // frame(a) + frame(b) + frame(c) = frame(a + b + c), whatever the kinds
    let (a, b) = (
        point(-0.2, Vec3::new(3.0, 1.0, 0.0)),
        point(0.3, Vec3::new(0.0, 1.0, 2.0)),
    );
    let parts = [
        lights(&[a], false, false),
        lights(&[b], true, false),
        lights(&[], false, true),
    ];
    let parts: Vec<Vec<Vec3>> = parts.iter().map(|l| frame(l).full).collect();
    let together = frame(&lights(&[a, b], true, true));
    let mean = together.full.iter().map(|p| p.element_sum()).sum::<f32>() / 1200.0;
    assert!(mean > 0.0);
    for (pixel, all) in together.full.iter().enumerate() {
        let sum: Vec3 = parts.iter().map(|part| part[pixel]).sum();
        assert!(
            (sum - *all).abs().max_element() < 1e-4 * mean,
            "{sum} {all}"
        );
    }
    // a light of 0 is no light
    let dark = frame(&lights(&[point(0.1, Vec3::ZERO)], false, false));
    assert!(dark.full.iter().all(|&p| p == Vec3::ZERO));
    // a pixel is what the model says of the point that it shows
    let alone = lights(&[a], false, false);
    let lit = book.under(&[a.into()], None).unwrap();
    let shown = frame(&alone);
    let (cells, trust) = (shown.cell.unwrap(), shown.trust.unwrap());
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    for y in 0..view.height {
        for x in 0..view.width {
            let [dx, dy] = OFF_CENTRE;
            let direction = view.direction(x as f32 + 0.5 + dx, y as f32 + 0.5 + dy);
            rays.push(view.eye, direction, f32::INFINITY);
        }
    }
    whole.closest(&rays, &mut hits);
    let mut known = 0;
    for pixel in (0..1200).filter(|&i| hits.triangle[i] != INVALID) {
        let place = whole.point(hits.triangle[pixel], hits.barycentrics[pixel]);
        let query = TransferQuery::new(&whole, &place, -rays.direction[pixel]);
        let answer = lit.evaluate(&[query])[0];
        let lamp = whole.material_at(&place).is_black();
        let expected = if lamp { Vec3::ZERO } else { answer.radiance };
        assert_eq!(shown.full[pixel], expected);
        assert_eq!(cells[pixel], answer.cell);
        // nothing is asked about a lamp, and so nothing is wrong; beside edges nothing is believed
        assert!(trust[pixel] < 0.5 || answer.trusted || lamp);
        known += usize::from(trust[pixel] > 0.5);
    }
    assert!(known > 600, "{known}");
    // the same bits on one thread
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(pool.install(|| frame(&alone).full), shown.full);
}

/// Where no cell is believed, rays find the light: what paths find, but for patches whose light is taken as even.
/// Bright patches are looked at on purpose, the same bits on one thread.
#[test]
fn a_transfer_that_is_not_believed_is_gathered() {
    let scene = cornell();
    let unlit = scene.unlit();
    let (whole, tracer) = (Tracer::new(&scene).unwrap(), Tracer::new(&unlit).unwrap());
    let mut model = model(&tracer);
    model.trust = -1.0;
    let book = LightBook::new(&model, &tracer).unwrap();
    // with the lamp's triangles among those that rays meet
    let renderer = Renderer::of_transfer(&whole, &book);
    let light = point(0.2, Vec3::ONE);
    let is_lamp = |row: &RowPoint| whole.material_at(&row.point).is_black();
    let rows: Vec<RowPoint> = (seen(&whole, 60).into_iter())
        .filter(|row| !is_lamp(row))
        .take(24)
        .collect();
    assert_eq!(rows.len(), 24);
    let points: Vec<_> = rows.iter().map(|row| row.point).collect();
    let viewers: Vec<Vec3> = rows.iter().map(|row| row.viewer).collect();
    let places = [light.position; 24];
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &places,
    };
    let truth = indirect(&whole, queries, 4096, 16, Stream::new(9, Stage::Test, 0), 0).unwrap();
    let options = RenderOptions {
        fallback: 512,
        ..RenderOptions::default()
    };
    let lights = lights(&[light], false, false);
    let gathered = |repeat: u64| {
        let names: Vec<u64> = (0..24).map(|i| 100 * repeat + i).collect();
        let answers = renderer.at_points(&points, &viewers, &names, &lights, &options);
        answers.unwrap().radiance
    };
    let found: Vec<Vec<Vec3>> = (0..8).map(gathered).collect();
    let level = |v: Vec3| f64::from(v.element_sum()) / 3.0;
    let (mut sum, mut all) = (0.0, 0.0);
    for row in 0..24 {
        let values: Vec<f64> = found.iter().map(|of| level(of[row])).collect();
        let mean = values.iter().sum::<f64>() / 8.0;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 56.0;
        let (wanted, noise) = (level(truth.mean(row)), level(truth.standard_error(row)));
        // 24 of t with 7 degrees of freedom at 1e-4 for each: 7.9; 300 patches: a tenth
        let error = 7.9 * (variance + noise * noise).sqrt() + 0.1 * wanted;
        assert!(
            (mean - wanted).abs() < error,
            "{row}: {mean} {wanted} {error}"
        );
        sum += mean;
        all += wanted;
    }
    assert!((sum / all - 1.0).abs() < 0.03, "{}", sum / all);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    assert_eq!(pool.unwrap().install(|| gathered(0)), found[0]);
}
