//! Rays that are gathered from broad surfaces, against closed forms and the path tracer.

use crate::support::*;
use glam::{DVec3, Vec2, Vec3};
use rrf_field::Field;
use rrf_field::columns::{self, Columns};
use rrf_field::tree::Tree;
use rrf_render::{Lights, OFF_CENTRE, Part, Passes, RenderOptions, Renderer, ShadowRays, View};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Material, PointLight, Scene};
use rrf_trace::{Queries, SurfacePoint, Tracer, indirect};

/// In a closed room whose walls all answer the same and that no light enters, a gathered wall sends
/// its reflectance times that answer.
#[test]
fn gathered_walls_are_a_furnace() {
    let materials = vec![Material::lambert("walls", ALBEDO)];
    let mut scene = squares(&[], materials, &[]);
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    scene.positions = (0..8).map(|i| 4.0 * corner(i) - Vec3::splat(2.0)).collect();
    let faces = [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ];
    for [a, b, c, d] in faces {
        scene.triangles.extend([[a, b, c], [a, c, d]]);
    }
    scene.triangle_material = vec![0; 12];
    scene.triangle_light = vec![INVALID; 12];
    scene.triangle_object = vec![0; 12];
    scene.normals = vec![Vec3::ZERO; 8];
    scene.uvs = vec![Vec2::ZERO; 8];
    let tracer = Tracer::new(&scene).unwrap();
    let lights = Lights {
        points: vec![point_light([7.0, 0.0, 0.0])],
        ..Lights::default()
    };
    let trusted = |rows: &Columns| vec![true; rows.len()];
    for gather in [1, 5] {
        let options = RenderOptions {
            gather,
            trusted: Some(&trusted),
            ..RenderOptions::default()
        };
        let (frame, timings) = frame_of(&tracer, &slanting([16, 12]), &lights, &options);
        assert_eq!(timings.1[0], 192 * u64::from(gather));
        for (pixel, trust) in frame.full.iter().zip(frame.trust.unwrap()) {
            // the third output of either cell is l_x + 1 or l_x: here 7 or more, 8 at the most
            let found = pixel.z / (3.0 * ALBEDO.z);
            assert!((6.999..8.001).contains(&found), "{found}");
            assert!((trust - 1.0).abs() < 1e-5);
        }
    }
}

/// Nets that answer 0.
fn dark() -> Field {
    let mut model = field().models()[0].clone();
    model.weights.fill(0.0);
    Field::new(Tree::single(), vec![model]).unwrap()
}

/// Points of three squares: a coat, a mirror and a rough metal, under a shade that keeps the light off them.
fn shaded_room() -> Scene {
    let coat = Material::principled("coat", ALBEDO, 0.15, 0.0, 0.8);
    let walls = Material::lambert("walls", Vec3::splat(0.4));
    squares(
        &[
            ([-1.2, 0.0], 0.6, 0.0, 0),
            ([0.0, 0.0], 0.6, 0.0, 1),
            ([1.2, 0.0], 0.6, 0.0, 2),
            ([0.0, 0.0], 2.0, 0.8, 3),
            ([0.3, 0.2], 4.0, 1.6, 3),
            ([0.3, 0.2], 4.0, -0.7, 3),
        ],
        vec![coat, metal(0.02), metal(0.22), walls],
        &[],
    )
}

/// Where nothing is believed, what is gathered is the light that paths find: at points of a coat, a mirror and a
/// rough metal, which follow their narrow part, and of the walls around them.
#[test]
fn gathering_without_trust_is_path_tracing() {
    let scene = shaded_room();
    let tracer = Tracer::new(&scene).unwrap();
    let light = Vec3::new(0.4, -0.3, 1.2);
    let stream = Stream::new(5, Stage::Test, 0);
    let points: Vec<SurfacePoint> = (0..30u64)
        .map(|i| {
            let u = stream.units(i, 0, 0);
            let triangle = 2 * (i as u32 % 6) + u32::from(u[2] < 0.5);
            tracer.point(triangle, [0.9 * u[0] * (1.0 - u[1]), 0.9 * u[0] * u[1]])
        })
        .collect();
    let viewers: Vec<Vec3> = (0..30u64)
        .map(|i| {
            let u = stream.units(i, 1, 0);
            let up = if i % 6 == 4 { -1.0 } else { 1.0 };
            Vec3::new(u[0] - 0.5, u[1] - 0.5, up * (0.3 + u[2])).normalize()
        })
        .collect();
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &[light; 30],
    };
    let whole = indirect(
        &tracer,
        queries,
        8192,
        16,
        Stream::new(6, Stage::Test, 0),
        0,
    )
    .unwrap();
    let field = dark();
    let renderer = Renderer::new(&tracer, &field).tracing_narrow(true);
    let lights = Lights {
        points: vec![PointLight {
            position: light,
            intensity: Vec3::ONE,
        }],
        ..Lights::default()
    };
    let nothing = |rows: &Columns| vec![false; rows.len()];
    let names: Vec<u64> = (0..30).collect();
    let found: Vec<Vec<Vec3>> = (0..16u64)
        .map(|seed| {
            let options = RenderOptions {
                trusted: Some(&nothing),
                fallback: 1024,
                narrow_rays: 64,
                shadow_rays: Some(ShadowRays {
                    count: 1,
                    ..ShadowRays::default()
                }),
                seed: 50 + seed,
                ..RenderOptions::default()
            };
            let answers = renderer.at_points(&points, &viewers, &names, &lights, &options);
            answers.unwrap().radiance
        })
        .collect();
    let mut worst = 0.0f64;
    for query in 0..30 {
        let mean = level(whole.mean(query));
        let error = level(whole.standard_error(query));
        let seeds: Vec<f64> = found.iter().map(|of| level(of[query])).collect();
        let gathered = seeds.iter().sum::<f64>() / 16.0;
        let squares = seeds.iter().map(|x| (x - gathered).powi(2)).sum::<f64>() / 240.0;
        // the centre of a mirror's lobe stands for the lobe, and walls of 0.4 leave out what comes after eight
        // surfaces: a thousandth each
        let error = (error.powi(2) + squares).sqrt().hypot(2e-3 * mean);
        worst = worst.max(((gathered - mean) / error).abs());
    }
    // 30 of t with 15 degrees of freedom and more, at 1e-4 for each: 5.2
    assert!(worst < 5.2, "z {worst}");
}

/// Points that are asked about are what pixels show that see them, to the bit: model, narrow parts and what is
/// gathered where the model is not believed.
#[test]
fn points_are_what_pixels_show() {
    let scene = shaded_room();
    let tracer = Tracer::new(&scene).unwrap();
    let view = View::look_at(
        Vec3::new(-0.9, 0.1, 0.6),
        Vec3::new(0.2, 0.0, 0.0),
        Vec3::Z,
        70.0,
        [24, 16],
    );
    let lights = Lights {
        points: vec![point_light([0.4, -0.3, 1.2])],
        ..Lights::default()
    };
    let trusted = |rows: &Columns| rows.columns[columns::P].iter().map(|&x| x > 0.0).collect();
    let options = RenderOptions {
        part: Part::Indirect,
        trusted: Some(&trusted),
        fallback: 8,
        ..RenderOptions::default()
    };
    let (frame, timings) = frame_of(&tracer, &view, &lights, &options);
    let (mut rays, mut hits) = (rrf_trace::Rays::default(), rrf_trace::Hits::default());
    for pixel in 0..24 * 16 {
        let [dx, dy] = OFF_CENTRE;
        let (x, y) = ((pixel % 24) as f32, (pixel / 24) as f32);
        let direction = view.direction(x + 0.5 + dx, y + 0.5 + dy);
        rays.push(view.eye, direction, f32::INFINITY);
    }
    tracer.closest(&rays, &mut hits);
    let names: Vec<u64> = (0..24 * 16)
        .filter(|&i| hits.triangle[i as usize] != INVALID)
        .collect();
    let pick = |i: &u64| tracer.point(hits.triangle[*i as usize], hits.barycentrics[*i as usize]);
    let points: Vec<SurfacePoint> = names.iter().map(pick).collect();
    let viewers: Vec<Vec3> = (names.iter())
        .map(|&i| -rays.direction[i as usize])
        .collect();
    let field = field();
    let renderer = Renderer::new(&tracer, &field).tracing_narrow(true);
    let answers = renderer.at_points(&points, &viewers, &names, &lights, &options);
    let answers = answers.unwrap();
    let (cells, trust) = (frame.cell.unwrap(), frame.trust.unwrap());
    for (k, &i) in names.iter().enumerate() {
        let i = i as usize;
        assert_eq!(answers.radiance[k], frame.full[i]);
        assert_eq!((answers.cells[k], answers.trust[k]), (cells[i], trust[i]));
    }
    assert!(names.len() > 150 && timings.2 > 100, "{}", timings.2);
    // paths that go on until they are believed are believed
    let partly = trust.iter().filter(|&&t| t > 0.3 && t < 0.99).count();
    assert!(partly < trust.len() / 10, "{partly}");
}

/// Passes are means of answers with names of their own, and points of a standard error above the bound get twice
/// as many.
#[test]
fn passes_go_on_where_noise_is_high() {
    let scene = shaded_room();
    let tracer = Tracer::new(&scene).unwrap();
    let lights = Lights {
        points: vec![point_light([0.4, -0.3, 1.2])],
        ..Lights::default()
    };
    let none = |rows: &Columns| vec![false; rows.len()];
    let options = RenderOptions {
        trusted: Some(&none),
        gather: 8,
        fallback: 8,
        ..RenderOptions::default()
    };
    // on the coat, the mirror and the rough metal
    let points = [0, 2, 4].map(|triangle| tracer.point(triangle, [0.3, 0.4]));
    let viewers = [Vec3::new(0.3, -0.2, 0.9).normalize(); 3];
    let names = [4u64, 5, 9];
    let field = field();
    let renderer = Renderer::new(&tracer, &field).tracing_narrow(true);
    let found = (0..8u64).map(|pass| {
        let names = names.map(|name| name + (pass << 44));
        let found = renderer.at_points(&points, &viewers, &names, &lights, &options);
        found.unwrap().radiance
    });
    let found: Vec<Vec<Vec3>> = found.collect();
    let mean = |row: usize, count: usize| {
        let sum: DVec3 = found[..count].iter().map(|of| of[row].as_dvec3()).sum();
        (sum / count as f64).as_vec3()
    };
    // none of the three is below ε
    let level = |radiance: Vec3| f64::from(radiance.element_sum()) / 3.0;
    let noise = [0, 1, 2].map(|row: usize| {
        let mean = level(mean(row, 4));
        let square = |of: &Vec<Vec3>| (level(of[row]) - mean).powi(2);
        (found[..4].iter().map(square).sum::<f64>() / 12.0).sqrt() / mean
    });
    let bound = noise.iter().sum::<f64>() / 3.0;
    let passes = Passes {
        least: 4,
        most: 8,
        noise: bound,
    };
    let at = (&points[..], &viewers[..]);
    let answers = renderer.at_points_in_passes(at, &names, &lights, &options, &passes);
    let answers = answers.unwrap();
    for row in 0..3 {
        let count = if noise[row] > bound { 8 } else { 4 };
        assert_eq!(answers.radiance[row], mean(row, count), "{row}, {noise:?}");
    }
}
