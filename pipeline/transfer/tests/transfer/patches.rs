//! Patches cover the surface once, and every point finds its own.

use crate::scenes::{cornell, file};
use glam::Vec3;
use rrf_sampling::sobol::Table;
use rrf_sampling::{Stage, Stream};
use rrf_trace::Tracer;
use rrf_transfer::{PatchConfig, Patches};

const EVEN: fn(Vec3) -> f32 = |_| 1.0;

fn config(count: usize) -> PatchConfig {
    PatchConfig {
        count,
        ..PatchConfig::default()
    }
}

/// As many as asked for, as large together as the surface, and each point of a patch finds it.
#[test]
fn patches_cover_the_surface_once() {
    for name in [
        "cornell-box/scene.pbrt",
        "cornell-glossy/cornell-glossy.glb",
        "zdm2/zdm2.glb",
    ] {
        let scene = file(name);
        let tracer = Tracer::new(&scene).unwrap();
        for count in [600, 6_000] {
            let patches = Patches::new(&scene, &config(count), &EVEN).unwrap();
            let ratio = patches.len() as f64 / count as f64;
            // a level's corners are patches of their own, however large the others are
            let most = if name.starts_with("zdm2") { 40.0 } else { 1.6 };
            assert!(
                ratio > 0.9 && ratio < most,
                "{name}: {} patches",
                patches.len()
            );
            let area: f64 = patches.area.iter().map(|&a| f64::from(a)).sum();
            assert!((area / tracer.area() - 1.0).abs() < 1e-4, "{name}: {area}");
            let table = Table::new(4);
            let mut lost = 0;
            for patch in 0..patches.len() as u32 {
                for point in patches.points(patch, 4, Stream::new(1, Stage::Test, 0), &table) {
                    let point = tracer.point(point.triangle, point.barycentrics);
                    lost += usize::from(patches.patch(&point) != Some(patch));
                }
            }
            // points on a cell's border may round to its neighbour
            assert!(lost <= patches.len() / 500, "{name}: {lost} points astray");
        }
    }
}

/// Points uniform over the surface fall into patches as often as these are large: chi-square of
/// 600 patches at 100,000 points, 99.999 % point by Wilson and Hilferty.
#[test]
fn points_fall_into_patches_by_their_area() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &config(600), &EVEN).unwrap();
    let mut counts = vec![0.0f64; patches.len()];
    let stream = Stream::new(5, Stage::Test, 0);
    let n = 100_000;
    for i in 0..n {
        let u = stream.units(i, 0, 0);
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        counts[patches.patch(&point).unwrap() as usize] += 1.0;
    }
    let squares = counts.iter().zip(&patches.area).map(|(&found, &area)| {
        let expected = f64::from(area) / tracer.area() * n as f64;
        (found - expected).powi(2) / expected
    });
    let (chi2, k) = (squares.sum::<f64>(), patches.len() as f64 - 1.0);
    let limit = k * (1.0 - 2.0 / (9.0 * k) + 4.265 * (2.0 / (9.0 * k)).sqrt()).powi(3);
    assert!(chi2 < limit, "{chi2} where {limit} is the limit");
}

/// A size field makes patches finer where it is small, and only there.
#[test]
fn a_size_field_makes_patches_finer() {
    let scene = cornell();
    let near = Vec3::new(-1.0, 1.0, 0.0);
    let field = |p: Vec3| if p.distance(near) < 0.3 { 0.25 } else { 1.0 };
    let even = Patches::new(&scene, &config(600), &EVEN).unwrap();
    let finer = Patches::new(&scene, &config(600), &field).unwrap();
    let count = |patches: &Patches, inside: bool| {
        let centres = patches.centre.iter();
        centres
            .filter(|c| (c.distance(near) < 0.3) == inside)
            .count()
    };
    let (before, after) = (count(&even, true), count(&finer, true));
    assert!(
        after > 10 * before && after < 25 * before,
        "{before} {after}"
    );
    let (before, after) = (count(&even, false), count(&finer, false));
    assert!(after.abs_diff(before) < before / 10, "{before} {after}");
    let area = |p: &Patches| p.area.iter().map(|&a| f64::from(a)).sum::<f64>();
    assert!((area(&even) / area(&finer) - 1.0).abs() < 1e-5);
}

/// Sides and directions are columns of their own; directions of a glossy patch are as likely as
/// each other under a cosine (chi-square over 16, 99.999 % point 52).
#[test]
fn columns_tell_sides_and_directions_apart() {
    let scene = file("cornell-glossy/cornell-glossy.glb");
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &config(600), &EVEN).unwrap();
    let glossy = (0..patches.len() as u32)
        .find(|&p| patches.directions(p) == 4)
        .unwrap();
    assert!((0..patches.len() as u32).any(|p| patches.directions(p) == 1));
    let last = patches.len() as u32 - 1;
    let ends = patches.first_column(last, true) + patches.directions(last).pow(2);
    assert_eq!(ends as usize, patches.columns());
    let stream = Stream::new(7, Stage::Test, 0);
    for back in [false, true] {
        let n = patches.normal[glossy as usize] * if back { -1.0 } else { 1.0 };
        let frame = rrf_materials::ShadingFrame::new(n);
        let mut counts = [0.0f64; 16];
        for i in 0..16_000 {
            let u = stream.units(i, 0, u32::from(back));
            let l = frame.to_world(rrf_materials::cosine_hemisphere([u[0], u[1]]));
            let column = patches.column(glossy, back, n, l);
            counts[(column - patches.first_column(glossy, back)) as usize] += 1.0;
        }
        // the middle of each direction is one of its own
        for cell in 0..16 {
            let middle = patches.middle_direction(glossy, n, cell);
            assert!((middle.length() - 1.0).abs() < 1e-5);
            let column = patches.column(glossy, back, n, middle);
            assert_eq!(column - patches.first_column(glossy, back), cell);
        }
        let chi2: f64 = counts.iter().map(|c| (c - 1e3).powi(2) / 1e3).sum();
        assert!(chi2 < 52.0, "{counts:?}");
    }
    drop(tracer);
}

#[test]
fn the_same_patches_each_time() {
    let scene = file("zdm2/zdm2.glb");
    let [a, b] = [0, 1].map(|_| Patches::new(&scene, &config(2_000), &EVEN).unwrap());
    assert_eq!(a.area, b.area);
    assert_eq!(a.centre, b.centre);
}

#[test]
fn scenes_without_surface_are_refused() {
    let mut scene = cornell();
    let first = scene.positions[0];
    scene.positions.iter_mut().for_each(|p| *p = first);
    assert!(Patches::new(&scene, &config(100), &EVEN).is_err());
    assert!(Patches::new(&cornell(), &config(0), &EVEN).is_err());
}
