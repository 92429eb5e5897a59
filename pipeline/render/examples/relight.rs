//! A scene baked as a transfer in memory, and frames of it under several lights.
//!
//! ```text
//! cargo run --release -p rrf-render --example relight -- SCENE OUT [sky=FILE.exr] [size=480x320] [patches=2000] [rows=30000]
//! ```
//!
//! Writes OUT-own.png (its own lights), OUT-point.png (a point before the camera) and OUT-sun.png (the
//! first sun alone), each with OUT-….exr, and says what they cost.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use glam::Vec3;
use rrf_lights::{LightSource, OwnLight, uniform_sphere};
use rrf_metrics::tone::Exposure;
use rrf_render::{AreaLights, Frame, FrameStage, Lights, RenderOptions, Renderer, View, exr, png};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, LoadOptions, PointLight, Scene, SkyOption, SkySource, load};
use rrf_trace::{Hits, Rays, Tracer};
use rrf_transfer::{
    ConditionPlan, DirectLight, FlatMirrors, LightBook, LightConditions, RowPoint, TransferConfig,
    bake_transfer, named_light,
};
use std::time::Instant;

/// Places that a camera can come to: free ways from it, in two legs.
fn free_places(scene: &Scene, tracer: &Tracer) -> Vec<Vec3> {
    let bounds = scene.bounds().expect("a surface");
    let (low, high) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
    let mut places = vec![scene.cameras.first().expect("a camera").eye];
    let stream = Stream::new(1, Stage::Test, 1);
    for i in 0..20_000 {
        let u = stream.units(i, 0, 0);
        let place = low + (high - low) * Vec3::new(u[0], u[1], u[2]);
        if places.len() < 128 && is_free(tracer, &places, place) {
            places.push(place);
        }
    }
    places
}

fn is_free(tracer: &Tracer, places: &[Vec3], place: Vec3) -> bool {
    let mut rays = Rays::default();
    places
        .iter()
        .for_each(|&from| rays.push(from, place - from, 1.0));
    let mut blocked = Vec::new();
    tracer.occluded(&rays, &mut blocked);
    blocked.contains(&false)
}

/// Surface points that eyes at free places see in all directions.
fn draw(tracer: &Tracer, places: &[Vec3], first: u64, count: usize) -> Vec<RowPoint> {
    let stream = Stream::new(1, Stage::Test, 2);
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    for i in first..first + count as u64 {
        let u = stream.units(i, 0, 0);
        let eye = places[((u[0] * places.len() as f32) as usize).min(places.len() - 1)];
        rays.push(eye, uniform_sphere([u[1], u[2]]), f32::INFINITY);
    }
    tracer.closest(&rays, &mut hits);
    let met = (0..count).filter(|&i| hits.triangle[i] != INVALID);
    met.map(|i| RowPoint {
        point: tracer.point(hits.triangle[i], hits.barycentrics[i]),
        viewer: -rays.direction[i],
    })
    .collect()
}

/// Processor seconds of all threads so far (Linux; 0 elsewhere).
fn cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after.split_whitespace().skip(11).take(2);
    0.01 * ticks.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>()
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |key: &str| {
        words
            .iter()
            .find_map(|w| w.strip_prefix(&format!("{key}=")))
    };
    let number =
        |key: &str, otherwise: usize| word(key).map_or(otherwise, |v| v.parse().expect("a number"));
    let options = LoadOptions {
        sky: word("sky").map(|file| SkyOption {
            source: SkySource::Picture(file.into()),
            rotate: 0.0,
        }),
        ..LoadOptions::default()
    };
    let scene = load(words[0].as_ref(), &options).expect("a scene");
    let unlit = scene.unlit();
    let tracer = Tracer::new(&unlit).unwrap();
    let start = Instant::now();
    let places = free_places(&unlit, &tracer);
    let bounds = scene.bounds().unwrap();
    let plan = ConditionPlan::within([Vec3::from(bounds.min), Vec3::from(bounds.max)]);
    let stream = Stream::new(1, Stage::Transfer, 2);
    let free = |place: Vec3| is_free(&tracer, &places, place);
    let conditions = LightConditions::new(&tracer, &free, &plan, stream);
    let mirrors = FlatMirrors::new(&tracer);
    let own = scene.own_light_names();
    let own = own
        .iter()
        .filter_map(|name| named_light(&scene, name, stream));
    let drawn = conditions.lights(stream).into_iter();
    let drawn = drawn.map(|group| Box::new(group) as Box<dyn DirectLight>);
    let lights: Vec<_> = drawn.chain(own).map(|light| mirrors.of(light)).collect();
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let mut config = TransferConfig {
        rows: number("rows", 30_000),
        ..TransferConfig::default()
    };
    config.patches.count = number("patches", 2_000);
    let points = |first: u64, count: usize| draw(&tracer, &places, first, count);
    let model = bake_transfer(&tracer, &points, &lights, &config, &|| false).unwrap();
    println!(
        "{} conditions ({:.0} % of the sky seen), {} patches, {} cells, {} bytes, {:.1} s",
        lights.len(),
        100.0 * conditions.sky_seen,
        model.patches.len(),
        model.cells.len(),
        model.bytes(),
        start.elapsed().as_secs_f64()
    );
    let trusted = model
        .cells
        .iter()
        .filter(|cell| cell.error <= model.trust)
        .count();
    println!("{trusted} cells are trusted");
    let book = LightBook::new(&model, &tracer).unwrap();
    let whole = Tracer::new(&scene).unwrap();
    let renderer = Renderer::of_transfer(&whole, &book);
    let mut view = View::from(&scene.cameras[0]);
    if let Some((w, h)) = word("size").and_then(|s| s.split_once('x')) {
        (view.width, view.height) = (w.parse().unwrap(), h.parse().unwrap());
    }
    let other = |l: &&OwnLight| !matches!(l.source, LightSource::Point(_));
    let own = Lights {
        points: scene.points().collect(),
        area: true,
        sources: scene.lights.iter().filter(other).cloned().collect(),
        ..Lights::default()
    };
    let point = PointLight {
        position: view.eye + 0.6 * view.forward,
        intensity: Vec3::splat(3.0),
    };
    let alone = Lights {
        points: vec![point],
        ..Lights::default()
    };
    let is_sun = |l: &&OwnLight| matches!(l.source, LightSource::Distant(_));
    let sun = Lights {
        sources: scene
            .lights
            .iter()
            .find(is_sun)
            .cloned()
            .into_iter()
            .collect(),
        ..Lights::default()
    };
    let lamps = AreaLights::without_proxies(&scene);
    let told = |_: &rrf_field::columns::Columns| Vec::new();
    let options = RenderOptions {
        area_lights: Some(&lamps),
        trusted: Some(&told),
        ..RenderOptions::default()
    };
    for (name, lights) in [("own", &own), ("point", &alone), ("sun", &sun)] {
        let mut frame = Frame::default();
        for turn in ["first", "again"] {
            let start = cpu();
            let timings = renderer
                .render(&view, lights, &options, &mut frame)
                .unwrap();
            let ms = |stage: FrameStage| 1e3 * timings.0[stage as usize].as_secs_f64();
            println!(
                "{name}, {turn}: {:.0} CPU ms; thread ms: coefficients {:.1}, model {:.0}, direct {:.0}",
                1e3 * (cpu() - start),
                ms(FrameStage::Coefficients),
                ms(FrameStage::Nets),
                ms(FrameStage::Direct) + ms(FrameStage::ShadowRays),
            );
        }
        let trust = frame.trust.iter().flatten().sum::<f32>() / frame.full.len() as f32;
        let sources: Vec<LightSource> = (lights.points.iter().map(|&p| p.into()))
            .chain(lights.sources.iter().map(|l| l.source.clone()))
            .collect();
        let lit = book.under(&sources, lights.area.then_some(&scene)).unwrap();
        println!(
            "   trusted: {:.0} % of the picture; the basis leaves out {:.1} %",
            100.0 * trust,
            100.0 * lit.residual
        );
        let picture = frame.picture();
        let exposure = Exposure::automatic(&picture);
        png::tone_mapped(&picture, exposure)
            .save(format!("{}-{name}.png", words[1]))
            .unwrap();
        let indirect = frame.layer(frame.indirect.as_deref().unwrap_or_default());
        let shown = png::tone_mapped(&indirect, exposure);
        shown
            .save(format!("{}-{name}-indirect.png", words[1]))
            .unwrap();
        exr::write_exr(format!("{}-{name}.exr", words[1]).as_ref(), &frame).unwrap();
    }
    // a moving light
    let mut frame = Frame::default();
    let start = cpu();
    for k in 0..20 {
        let mut moved = alone.clone();
        moved.points[0].position += Vec3::X * (0.01 * k as f32);
        renderer
            .render(&view, &moved, &options, &mut frame)
            .unwrap();
    }
    println!(
        "a moving point: {:.0} CPU ms a frame",
        50.0 * (cpu() - start)
    );
}
