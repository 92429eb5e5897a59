//! Frames against closed forms: a Lambert floor under point lights, nets that are known functions.

#![allow(clippy::unwrap_used)]

mod support;

use glam::{Vec2, Vec3};
use rrf_field::columns::{self, Columns};
use rrf_metrics::color::luminance;
use rrf_render::{
    Frame, Lights, Part, RenderError, RenderOptions, Surroundings, View, render, trace_frame,
    trace_untrusted,
};
use rrf_scene::{AreaLight, INVALID};
use rrf_trace::Tracer;
use std::f32::consts::PI;
use support::*;

#[test]
fn direct_light_is_the_closed_form() {
    let scene = floor(true);
    let tracer = Tracer::new(&scene).unwrap();
    let view = above([40, 30]);
    let lights = lights(vec![
        point([0.3, -0.2, 1.0], [1.0, 2.0, 3.0]),
        point([-0.4, 0.1, 0.7], [5.0, 0.0, 1.0]),
    ]);
    let options = RenderOptions {
        part: Part::Direct,
        ..RenderOptions::default()
    };
    let frame = render(&tracer, &linear_field(), &view, &lights, &options).unwrap();
    assert_eq!((frame.width, frame.height), (40, 30));
    assert!(frame.indirect.is_none() && frame.cell.is_none());
    let (mut shadowed, mut lit) = (0, 0);
    for y in 0..30 {
        for x in 0..40 {
            let p = on_floor(&view, x as f32 + 0.5, y as f32 + 0.5);
            let eye_at = |z: f32| view.eye + (p - view.eye) * ((3.0 - z) / 3.0);
            let over = |q: Vec3| (q.x - 0.5).abs() < 0.2 && q.y.abs() < 0.2;
            if over(eye_at(0.5)) {
                continue; // the camera sees the small square
            }
            let mut want = Vec3::ZERO;
            for light in &lights.points {
                let to = light.position - p;
                if over(p + to * (0.5 / to.z)) {
                    shadowed += 1;
                    continue;
                }
                lit += 1;
                let cosine = to.z / to.length();
                want += light.intensity * ALBEDO / PI * cosine / to.length_squared();
            }
            let got = frame.full[y * 40 + x];
            assert!(close(got, want), "pixel {x} {y}: {got} {want}");
        }
    }
    assert!(shadowed > 20 && lit > 1000, "{shadowed} {lit}");
}

#[test]
fn indirect_light_is_the_intensity_weighted_sum_of_the_nets() {
    let scene = floor(false);
    let tracer = Tracer::new(&scene).unwrap();
    let view = above([33, 17]);
    let lights = lights(vec![
        point([0.3, -0.2, 1.0], [1.0, 2.0, 3.0]),
        point([-0.4, 0.1, 0.7], [5.0, 0.5, 1.0]),
    ]);
    let trusted = |rows: &Columns| rows.columns[columns::P].iter().map(|&x| x < 0.0).collect();
    let options = RenderOptions {
        part: Part::Indirect,
        aa: 2,
        trusted: Some(&trusted),
        ..RenderOptions::default()
    };
    let frame = render(&tracer, &linear_field(), &view, &lights, &options).unwrap();
    let cells = frame.cell.unwrap();
    let trust = frame.trust.unwrap();
    for y in 0..17 {
        for x in 0..33 {
            let mut want = Vec3::ZERO;
            let mut left = 0.0;
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let offset = |i: i32| 0.25 + 0.5 * i as f32;
                let p = on_floor(&view, x as f32 + offset(i), y as f32 + offset(j));
                let ten = if p.x < 0.0 { 0.0 } else { 10.0 };
                left += if p.x < 0.0 { 0.25 } else { 0.0 };
                for light in &lights.points {
                    let phi = Vec3::new(1.0, p.x, light.position.x + ten);
                    want += 0.25 * light.intensity * phi;
                }
            }
            let at = y * 33 + x;
            let scale = Vec3::new(6.0, 1.0, 50.0); // sums of sizes before they cancel
            assert!(
                ((frame.full[at] - want) / scale).abs().max_element() < 1e-5,
                "pixel {x} {y}: {} {want}",
                frame.full[at]
            );
            assert_eq!(trust[at], left);
            let first = on_floor(&view, x as f32 + 0.25, y as f32 + 0.25);
            assert_eq!(cells[at], u32::from(first.x >= 0.0));
        }
    }
}

#[test]
fn negative_radiance_stays() {
    let scene = floor(false);
    let tracer = Tracer::new(&scene).unwrap();
    let lights = lights(vec![point([-0.4, 0.1, 0.7], [1.0; 3])]);
    let options = RenderOptions::default();
    let frame = render(&tracer, &linear_field(), &above([8, 8]), &lights, &options).unwrap();
    assert!(frame.indirect.unwrap().iter().any(|p| p.y < -0.1));
}

/// What lies above z = 10 is solid: each odd place is told once, in the order of the lights.
#[test]
fn odd_places_are_told() {
    let scene = floor(false);
    let surroundings = Surroundings {
        tracer: &Tracer::new(&scene).unwrap(),
        inside_solid: &|p| p.z > 10.0,
        light_box: [Vec3::splat(-1.0), Vec3::ONE],
        eye_box: Some([Vec3::splat(-1.0), Vec3::splat(50.0)]),
    };
    let told = |eye: [f32; 3], lights: &[[f32; 3]]| {
        let lights = lights.iter().map(|&l| Vec3::from(l));
        let warnings = surroundings.warnings(eye.into(), lights);
        let told = warnings.into_iter().map(|w| (w.is_fatal, w.message));
        told.collect::<Vec<_>>()
    };
    let expect = |told: &[(bool, String)], wanted: &[(bool, &str)]| {
        assert_eq!(told.len(), wanted.len(), "{told:?}");
        for ((fatal, said), (wanted_fatal, words)) in told.iter().zip(wanted) {
            assert!(fatal == wanted_fatal && said.starts_with(words), "{said}");
        }
    };
    let lights = [[0.0, 0.0, 0.06], [0.5, 0.0, 0.0], [0.0, 0.0, 11.0]];
    let wanted = [
        (true, "the eye at 0,0,20 is inside a solid"),
        (
            false,
            "point light 0 at 0,0,0.06 is 0.06 from a surface; below 0.0866",
        ),
        (true, "point light 1 at 0.5,0,0 lies on a surface"),
        (true, "point light 2 at 0,0,11 is inside a solid"),
        (
            false,
            "point light 2 at 0,0,11 is outside the baked light box -1,-1,-1 to 1,1,1",
        ),
    ];
    expect(&told([0.0, 0.0, 20.0], &lights), &wanted);
    let outside = "the eye at 0,0,-2.8 is outside the eye box -1,-1,-1 to 50,50,50";
    expect(&told([0.0, 0.0, -2.800_000_2], &[]), &[(false, outside)]);
    expect(&told([0.0, 0.0, 1.0], &[[0.0, 0.0, 0.5]]), &[]);
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let scene = floor(true);
    let tracer = Tracer::new(&scene).unwrap();
    let lights = lights(vec![point([0.3, -0.2, 1.0], [1.0, 2.0, 3.0])]);
    let view = above([70, 40]);
    let baked = || -> Frame {
        let options = RenderOptions::default();
        render(&tracer, &linear_field(), &view, &lights, &options).unwrap()
    };
    let traced = || trace_frame(&tracer, &view, &lights, paths(8, 2, 7), &|_| ()).unwrap();
    assert!(on_threads(1, baked) == on_threads(2, baked));
    assert!(on_threads(1, traced) == on_threads(2, traced));
}

#[test]
fn traced_and_rendered_frames_share_their_pixels() {
    let scene = floor(true);
    let tracer = Tracer::new(&scene).unwrap();
    let lights = lights(vec![point([0.3, -0.2, 1.0], [1.0, 2.0, 3.0])]);
    let view = above([70, 40]);
    for aa in [1, 3] {
        let options = RenderOptions {
            aa,
            ..RenderOptions::default()
        };
        let baked = render(&tracer, &linear_field(), &view, &lights, &options).unwrap();
        let traced =
            trace_frame(&tracer, &view, &lights, paths(2 * aa * aa, aa, 1), &|_| ()).unwrap();
        assert!(baked.direct == traced.direct);
    }
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let mut scene = floor(false);
    let field = linear_field();
    let options = RenderOptions::default();
    let none = Lights::default();
    {
        let tracer = Tracer::new(&scene).unwrap();
        let refused = render(&tracer, &field, &above([0, 4]), &none, &options).unwrap_err();
        assert!(matches!(refused, RenderError::Size { .. }));
        let mut view = above([4, 4]);
        view.eye.x = f32::NAN;
        let refused = render(&tracer, &field, &view, &none, &options).unwrap_err();
        assert!(matches!(refused, RenderError::View { .. }));
        let bad = lights(vec![
            point([0.0; 3], [1.0; 3]),
            point([f32::NAN; 3], [1.0; 3]),
        ]);
        let refused = render(&tracer, &field, &above([4, 4]), &bad, &options).unwrap_err();
        assert!(matches!(refused, RenderError::Light { light: 1 }));
        let refused =
            trace_frame(&tracer, &above([4, 4]), &none, paths(6, 2, 1), &|_| ()).unwrap_err();
        assert!(matches!(
            refused,
            RenderError::Samples { samples: 6, aa: 2 }
        ));
        // Without lights all is dark, and that is a frame.
        let dark = render(&tracer, &field, &above([4, 4]), &none, &options).unwrap();
        assert!(dark.full.iter().all(|&p| p == Vec3::ZERO));
    }
    scene.area_lights.push(AreaLight {
        radiance: Vec3::ONE,
        two_sided: false,
    });
    scene.area_light_names.push("lamp".into());
    scene.triangle_light[0] = 0;
    let tracer = Tracer::new(&scene).unwrap();
    let area = Lights {
        points: Vec::new(),
        area: true,
        ..Lights::default()
    };
    let refused = render(&tracer, &field, &above([4, 4]), &area, &options).unwrap_err();
    assert!(matches!(refused, RenderError::AreaLights));
}

/// A closed cube seen from its middle, the picture's diagonals along its edges. Indirect light
/// is continuous up to an edge, but a point exactly on one sees past both walls and has half of
/// it. With 128 paths a pixel has a standard error of 4 %: 0.75 is 5 of them away from either.
#[test]
fn pixels_on_edges_are_lit() {
    let mut scene = floor(false);
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    scene.positions = (0..8).map(corner).collect();
    scene.normals = vec![Vec3::ZERO; 8];
    scene.uvs = vec![Vec2::ZERO; 8];
    let faces = [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ];
    scene.triangles = faces
        .iter()
        .flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]])
        .collect();
    scene.triangle_material = vec![0; 12];
    scene.triangle_light = vec![INVALID; 12];
    scene.triangle_object = vec![0; 12];
    let tracer = Tracer::new(&scene).unwrap();
    let middle = Vec3::splat(0.5);
    let view = View::look_at(middle, Vec3::new(0.5, 0.5, 0.0), Vec3::Y, 120.0, [64, 64]);
    let lights = lights(vec![point([0.5; 3], [1.0; 3])]);
    let frame = trace_frame(&tracer, &view, &lights, paths(128, 1, 1), &|_| ()).unwrap();
    let indirect = frame.indirect.unwrap();
    for i in 4..18usize {
        let at = |x: usize| indirect[i * 64 + x].x;
        let beside = 0.5 * (at(i - 2) + at(i + 2));
        assert!(
            at(i) > 0.75 * beside,
            "pixel {i}: {} beside {beside}",
            at(i)
        );
    }
}

/// Trusted pixels stay to the bit; the others' mean is that of a path-traced frame. The
/// difference of two traced frames tells the standard error; 4.9 of them is 1e-6.
#[test]
fn untrusted_pixels_are_path_traced() {
    let scene = floor(true);
    let tracer = Tracer::new(&scene).unwrap();
    let view = above([40, 30]);
    let lights = lights(vec![point([0.4, 0.3, 1.0], [2.0, 2.0, 2.0])]);
    let trusted = |rows: &Columns| rows.columns[columns::P].iter().map(|&x| x < 0.0).collect();
    let options = RenderOptions {
        trusted: Some(&trusted),
        ..RenderOptions::default()
    };
    let nets = render(&tracer, &linear_field(), &view, &lights, &options).unwrap();
    let fall_back = |threads| {
        let mut frame = nets.clone();
        let traced = on_threads(threads, || {
            trace_untrusted(&tracer, &view, &lights, &mut frame, paths(64, 1, 7))
        });
        (traced.unwrap(), frame)
    };
    let (count, mixed) = fall_back(1);
    assert_eq!((count, &mixed), (fall_back(2).0, &fall_back(2).1));
    let reference =
        |seed| trace_frame(&tracer, &view, &lights, paths(64, 1, seed), &|_| ()).unwrap();
    let (one, two) = (reference(1), reference(2));
    let layer = |frame: &Frame, i: usize| f64::from(luminance(frame.indirect.as_ref().unwrap()[i]));
    let (mut apart, mut variance, mut untrusted) = (0.0, 0.0, 0);
    for i in 0..nets.full.len() {
        if nets.trust.as_ref().unwrap()[i] == 1.0 {
            assert_eq!(mixed.full[i], nets.full[i]);
            continue;
        }
        untrusted += usize::from(mixed.cell.as_ref().unwrap()[i] == u32::MAX);
        apart += layer(&mixed, i) - 0.5 * (layer(&one, i) + layer(&two, i));
        // of one frame half the squared difference, of the mean of two a quarter
        variance += 0.75 * (layer(&one, i) - layer(&two, i)).powi(2);
        let parts = mixed.direct.as_ref().unwrap()[i] + mixed.indirect.as_ref().unwrap()[i];
        assert!((parts - mixed.full[i]).abs().max_element() < 1e-4 * (1.0 + parts.max_element()));
    }
    assert!(count > 100 && untrusted >= count && variance > 0.0);
    assert!(apart.abs() < 4.9 * variance.sqrt(), "{apart} {variance}");
}
