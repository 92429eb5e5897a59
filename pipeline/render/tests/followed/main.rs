//! What mirrors show: frames and queries against closed forms and the path tracer.

#![allow(clippy::unwrap_used)]

mod gathered;
mod support;

use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_render::{
    AreaLights, Frame, Lights, MOST_FOLLOWED, OFF_CENTRE, Part, PathOptions, RenderOptions,
    Renderer, trace_frame,
};
use rrf_scene::Material;
use rrf_trace::Tracer;
use std::f32::consts::PI;
use support::*;

#[test]
fn a_mirror_shows_what_is_behind_the_eye() {
    let scene = mirror_room();
    let tracer = Tracer::new(&scene).unwrap();
    let view = slanting([40, 30]);
    let light = point_light([0.5, -0.6, 1.5]);
    let lights = Lights {
        points: vec![light],
        ..Lights::default()
    };
    let trusted = |rows: &Columns| rows.columns[columns::P].iter().map(|&x| x > 1.0).collect();
    let options = RenderOptions {
        trusted: Some(&trusted),
        ..RenderOptions::default()
    };
    let (frame, timings) = frame_of(&tracer, &view, &lights, &options);
    let (cells, trust) = (frame.cell.as_ref().unwrap(), frame.trust.as_ref().unwrap());
    let indirect = frame.indirect.as_ref().unwrap();
    let mut checked = 0u64;
    for y in 0..30 {
        for x in 0..40 {
            let [dx, dy] = OFF_CENTRE;
            let d = view.direction(x as f32 + 0.5 + dx, y as f32 + 0.5 + dy);
            let p = view.eye - d * (view.eye.z / d.z);
            if p.truncate().abs().max_element() > 1.99 {
                continue;
            }
            let up = Vec3::new(d.x, d.y, -d.z);
            let q = p + up * (2.0 / up.z);
            let to = light.position - q;
            let nets = Vec3::new(1.0, q.x, light.position.x + 1.0);
            let direct = ALBEDO / PI * (-to.z / to.length().powi(3));
            let want = fresnel(-d.z) * light.intensity * (nets + direct);
            let at = y * 40 + x;
            let found = indirect[at];
            // the lobe of alpha 0.001 about the mirror direction, a thousandth wide
            let error = ((found - want) / want.abs().max(Vec3::splat(0.01))).abs();
            assert!(error.max_element() < 4e-3, "{x} {y}: {found} {want}");
            if (q.x - 1.0).abs() > 0.02 {
                assert_eq!((cells[at], trust[at] > 0.5), (1, q.x > 1.0));
            }
            checked += 1;
        }
    }
    assert!(checked > 900, "{checked}");
    assert!(timings.1[0] >= checked);
    assert_eq!(timings.1[1..], [0; MOST_FOLLOWED - 1]);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let (alone, _) = pool.install(|| frame_of(&tracer, &view, &lights, &options));
    assert!(alone == frame, "the same bits on one thread");
}

#[test]
fn chains_end_after_eight_surfaces() {
    let white = Material::principled("mirror", Vec3::ONE, 0.0, 1.0, 0.5);
    let two = [([0.0; 2], 900.0, 0.0, 0), ([0.0; 2], 900.0, 2.0, 0)];
    let scene = squares(&two, vec![white], &[]);
    let tracer = Tracer::new(&scene).unwrap();
    let lights = Lights {
        points: vec![point_light([0.0, 0.0, 1.5])],
        ..Lights::default()
    };
    let options = RenderOptions {
        part: Part::Indirect,
        ..RenderOptions::default()
    };
    let (_, timings) = frame_of(&tracer, &slanting([8, 8]), &lights, &options);
    assert_eq!(timings.1, [64; MOST_FOLLOWED]);
}

#[test]
fn models_of_older_runs_answer_for_mirrors() {
    let scene = mirror_room();
    let tracer = Tracer::new(&scene).unwrap();
    let lights = Lights {
        points: vec![point_light([0.5, -0.6, 1.5])],
        ..Lights::default()
    };
    let options = RenderOptions {
        part: Part::Indirect,
        ..RenderOptions::default()
    };
    let (field, mut frame) = (field(), Frame::default());
    let renderer = Renderer::new(&tracer, &field);
    let view = slanting([8, 6]);
    let timings = renderer
        .render(&view, &lights, &options, &mut frame)
        .unwrap();
    assert_eq!(timings.1, [0; MOST_FOLLOWED]);
    // the middle of the floor is of cell 0, the third output is l_x alone
    assert!(
        (frame.full[27].z - 3.0 * 0.5).abs() < 1e-5,
        "{}",
        frame.full[27]
    );
}

/// Two ways to the same light share it: the mean over the picture is the path tracer's, whatever
/// the roughness. Twenty seeds tell the standard error of the mean; the tracer's is told by two.
#[test]
fn lamps_in_glossy_floors_are_counted_once() {
    let view = slanting([24, 18]);
    for roughness in [0.0, 0.06, 0.12, 0.2, 0.3, 0.45] {
        let materials = vec![metal(roughness), Material::lambert("lamp", Vec3::ZERO)];
        let lamp = ([1.2, 0.2], 0.35, 1.2, 1);
        let radiance = Vec3::new(5.0, 3.0, 1.0);
        let scene = squares(
            &[([0.0; 2], 2.0, 0.0, 0), lamp],
            materials,
            &[(1, radiance)],
        );
        let tracer = Tracer::new(&scene).unwrap();
        let area_lights = AreaLights::without_proxies(&scene);
        let lights = Lights {
            area: true,
            ..Lights::default()
        };
        let mean = |layer: &[Vec3]| layer.iter().map(|&p| level(p)).sum::<f64>() / 432.0;
        let means: Vec<f64> = (1..=20)
            .map(|seed| {
                let options = RenderOptions {
                    part: Part::Direct,
                    area_lights: Some(&area_lights),
                    seed,
                    ..RenderOptions::default()
                };
                mean(&frame_of(&tracer, &view, &lights, &options).0.full)
            })
            .collect();
        let truth = |seed| {
            let options = PathOptions {
                spp: 512,
                aa: 1,
                seed,
            };
            let frame = trace_frame(&tracer, &view, &lights, options, &|_| ()).unwrap();
            mean(frame.direct.as_ref().unwrap())
        };
        let truths: Vec<f64> = (100..106).map(truth).collect();
        let z = difference(&means, &truths);
        // six tests at 1e-4 each, t with 5 degrees of freedom or more: 9.1 at the most
        assert!(
            z.abs() < 9.1,
            "roughness {roughness}: z {z}: {means:?} {truths:?}"
        );
        assert!(truths[0] > 0.01);
    }
}

/// Clear glass shows what is behind it and what it mirrors, one ray each: a slab under a ceiling and
/// over a floor that answer alike is invisible but for what its paths lose after eight surfaces.
#[test]
fn glass_is_invisible_in_even_light() {
    let glass = Material::dielectric("glass", 1.5, Vec3::ONE, Vec3::ZERO);
    let walls = Material::lambert("walls", Vec3::splat(0.5));
    let mut scene = squares(
        &[
            ([0.0; 2], 50.0, 0.0, 0),
            ([0.0; 2], 50.0, 0.2, 0),
            ([0.0; 2], 900.0, 3.0, 1),
            ([0.0; 2], 900.0, -2.0, 1),
        ],
        vec![glass, walls],
        &[],
    );
    // the slab's upper face looks up
    for triangle in &mut scene.triangles[2..4] {
        triangle.swap(1, 2);
    }
    let tracer = Tracer::new(&scene).unwrap();
    let lights = Lights {
        points: vec![point_light([3000.0, 0.0, 0.5])],
        ..Lights::default()
    };
    let options = RenderOptions {
        part: Part::Indirect,
        ..RenderOptions::default()
    };
    let (frame, timings) = frame_of(&tracer, &slanting([12, 9]), &lights, &options);
    assert!(timings.1[0] >= 2 * 100, "{:?}", timings.1);
    for pixel in &frame.full {
        // Φ = l_x, by the blue intensity of 3, or l_x + 1
        let found = pixel.z / (3.0 * 3000.0);
        assert!((0.985..1.001).contains(&found), "{found}");
    }
}
