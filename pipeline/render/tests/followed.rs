//! What mirrors show: frames and queries against closed forms and the path tracer.

#![allow(clippy::unwrap_used)]

use glam::{Vec2, Vec3};
use rrf_field::Field;
use rrf_field::columns::{self, Columns};
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_render::{
    AreaLights, Frame, FrameTimings, Lights, MOST_FOLLOWED, OFF_CENTRE, Part, PathOptions,
    RenderOptions, Renderer, ShadowRays, View, trace_frame,
};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{AreaLight, INVALID, Material, PointLight, Scene};
use rrf_trace::{Queries, SurfacePoint, Tracer, indirect};
use std::f32::consts::PI;

const ALBEDO: Vec3 = Vec3::new(0.8, 0.5, 0.2);
const SILVER: Vec3 = Vec3::new(0.9, 0.85, 0.7);

/// A square in the plane z = `height`: its middle, half its side, and its material.
type Square = ([f32; 2], f32, f32, u32);

/// Horizontal squares; those of `lamps` shine downward.
fn squares(squares: &[Square], materials: Vec<Material>, lamps: &[(usize, Vec3)]) -> Scene {
    let mut scene = Scene {
        materials,
        ..Scene::default()
    };
    for (number, &([x, y], half, height, material)) in squares.iter().enumerate() {
        let first = scene.positions.len() as u32;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corner = |(dx, dy)| Vec3::new(x + half * dx, y + half * dy, height);
        scene.positions.extend(corners.map(corner));
        // the normal of the second order looks down
        scene
            .triangles
            .extend([[0, 2, 1], [0, 3, 2]].map(|t: [u32; 3]| t.map(|v| first + v)));
        scene.triangle_material.extend([material; 2]);
        scene.triangle_object.extend([number as u32; 2]);
        let lamp = lamps.iter().find(|(of, _)| *of == number);
        let light = lamp.map_or(INVALID, |&(_, radiance)| {
            scene.area_lights.push(AreaLight {
                radiance,
                two_sided: false,
            });
            scene.area_lights.len() as u32 - 1
        });
        scene.triangle_light.extend([light; 2]);
    }
    scene.normals = vec![Vec3::ZERO; scene.positions.len()];
    scene.uvs = vec![Vec2::ZERO; scene.positions.len()];
    scene
}

fn metal(roughness: f32) -> Material {
    Material::principled("metal", SILVER, roughness, 1.0, 0.5)
}

/// A mirror at z = 0 under a Lambert ceiling at z = 2.
fn mirror_room() -> Scene {
    let materials = vec![metal(0.0), Material::lambert("ceiling", ALBEDO)];
    squares(
        &[([0.0; 2], 2.0, 0.0, 0), ([0.0; 2], 6.0, 2.0, 1)],
        materials,
        &[],
    )
}

/// A camera at height 1 that looks down at a slant.
fn slanting(size: [u32; 2]) -> View {
    View::look_at(
        Vec3::new(-0.8, 0.1, 1.0),
        Vec3::new(0.2, 0.0, 0.0),
        Vec3::Z,
        30.0,
        size,
    )
}

/// Φ = (1, p_x, l_x) for z < 1, (1, p_x, l_x + 1) above.
fn field() -> Field {
    let mut tree = Tree::single();
    tree.split(0, columns::P + 2, 1.0, 1);
    let model = |cell: u32| CellModel {
        cell,
        kind: Kind::Net,
        inputs: vec![columns::P as u8, columns::L as u8],
        input_offset: vec![0.0; 2],
        input_scale: vec![1.0; 2],
        shape: Shape { sizes: vec![2, 3] },
        weights: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, cell as f32, 0.0, 1.0],
        output_scale: [1.0; 3],
        output_offset: [0.0; 3],
        divide_base: false,
        exponential: false,
    };
    Field::new(tree, vec![model(0), model(1)]).unwrap()
}

fn point_light(position: [f32; 3]) -> PointLight {
    PointLight {
        position: position.into(),
        intensity: Vec3::new(1.0, 2.0, 3.0),
    }
}

fn frame_of(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    options: &RenderOptions,
) -> (Frame, FrameTimings) {
    let field = field();
    let renderer = Renderer::new(tracer, &field).tracing_narrow(true);
    let mut frame = Frame::default();
    let timings = renderer.render(view, lights, options, &mut frame).unwrap();
    (frame, timings)
}

/// Schlick's Fresnel factor of a metal.
fn fresnel(cosine: f32) -> Vec3 {
    SILVER + (Vec3::ONE - SILVER) * (1.0 - cosine).powi(5)
}

/// Mean of three channels.
fn level(v: Vec3) -> f64 {
    f64::from(v.element_sum()) / 3.0
}

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
                    shadow_rays: Some(ShadowRays {
                        seed,
                        ..ShadowRays::default()
                    }),
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

/// Difference of two means over its standard error; a thousandth of the mean is rounding.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let statistics = |x: &[f64]| {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        let squares = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        (mean, squares / (n * (n - 1.0)))
    };
    let ((a, va), (b, vb)) = (statistics(a), statistics(b));
    let rounding = 1e-3 * b;
    (a - b) / (va + vb + rounding * rounding).sqrt()
}

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
                    seed: 50 + seed,
                    ..ShadowRays::default()
                }),
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
