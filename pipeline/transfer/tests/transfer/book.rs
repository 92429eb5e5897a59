//! Lights that are kept: sums, colours, and lights that the model does not know.

use crate::model::{bake, config};
use crate::scenes::{MIDDLE, cornell, points};
use glam::Vec3;
use rrf_lights::{LightSource, PointLight};
use rrf_scene::{AreaLight, Scene};
use rrf_trace::Tracer;
use rrf_transfer::{CellChoice, LightBook, LightCoefficients, TransferModel, TransferQuery};

fn point(x: f32, y: f32, intensity: Vec3) -> LightSource {
    PointLight {
        position: Vec3::new(x, y, 0.2),
        intensity,
    }
    .into()
}

/// Where lights are compared.
fn queries(tracer: &Tracer) -> Vec<TransferQuery> {
    let rows = points(tracer, MIDDLE, 200, 5);
    let query = |row| TransferQuery::of_row(tracer, row);
    rows.iter().map(query).collect()
}

/// Largest difference of two lights at points, relative to the largest radiance.
fn apart(model: &TransferModel, at: &[TransferQuery], lights: [&LightCoefficients; 2]) -> f32 {
    let [a, b] = lights.map(|light| model.evaluate(light, at));
    let largest = a.iter().map(|a| a.radiance.abs().max_element());
    let largest = largest.fold(f32::MIN_POSITIVE, f32::max);
    let differences = a.iter().zip(&b);
    let differences = differences.map(|(a, b)| (a.radiance - b.radiance).abs().max_element());
    differences.fold(0.0, f32::max) / largest
}

/// One lamp: the triangles of the box's ceiling shine down.
fn lamp(radiance: Vec3) -> Scene {
    let mut scene = cornell();
    scene.area_lights = vec![AreaLight {
        radiance,
        two_sided: true,
    }];
    scene.area_light_names = vec!["ceiling".into()];
    for triangle in 0..scene.triangles.len() {
        let high = |&v: &u32| scene.positions[v as usize].y > 1.98;
        if scene.triangles[triangle].iter().all(high) {
            scene.triangle_light[triangle] = 0;
        }
    }
    scene
}

#[test]
fn lights_superpose_and_are_kept() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let model = bake(&tracer, &config(CellChoice::Nodes));
    let book = LightBook::new(&model, &tracer).unwrap();
    let red = point(0.1, 1.5, Vec3::new(2.0, 0.0, 0.0));
    let blue = point(-0.3, 1.6, Vec3::new(0.0, 0.5, 4.0));
    let lit = |sources: &[LightSource], lamps: Option<&Scene>| {
        book.under(sources, lamps).unwrap().coefficients
    };
    let mut sum = lit(std::slice::from_ref(&red), None);
    sum.add_scaled(&lit(std::slice::from_ref(&blue), None), Vec3::ONE);
    let at = queries(&tracer);
    let both = lit(&[red.clone(), blue.clone()], None);
    assert!(apart(&model, &at, [&both, &sum]) < 1e-4);
    // twice as bright is twice the light, to the bit; kept or not
    let twice = lit(&[red.dimmed(Vec3::splat(2.0))], None);
    let mut doubled = lit(&[red.dimmed(Vec3::ZERO)], None);
    let dark = model.evaluate(&doubled, &at);
    assert!(dark.iter().all(|answer| answer.radiance == Vec3::ZERO));
    doubled.add_scaled(&lit(std::slice::from_ref(&red), None), Vec3::splat(2.0));
    assert_eq!(twice, doubled);
    let fresh = LightBook::new(&model, &tracer).unwrap();
    assert_eq!(
        fresh
            .under(&[red.dimmed(Vec3::splat(2.0))], None)
            .unwrap()
            .coefficients,
        twice
    );
    // lamps too, in their colours
    let (white, amber) = (lamp(Vec3::ONE), lamp(Vec3::new(4.0, 2.0, 1.0)));
    let mut coloured = lit(&[], None);
    coloured.add_scaled(&lit(&[], Some(&white)), Vec3::new(4.0, 2.0, 1.0));
    assert_eq!(lit(&[], Some(&amber)), coloured);
    let shown = model.evaluate(&coloured, &at);
    assert!(shown.iter().any(|answer| answer.radiance.x > 0.0));
}

/// A light of the ensemble's kind has a small residual, one on the floor behind a box a large one.
#[test]
fn lights_that_the_basis_does_not_know_have_a_residual() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let model = bake(&tracer, &config(CellChoice::Nodes));
    let book = LightBook::new(&model, &tracer).unwrap();
    let residual = |source: LightSource| book.under(&[source], None).unwrap().residual;
    let known = residual(point(0.1, 1.5, Vec3::ONE));
    let unknown = residual(point(0.1, 0.01, Vec3::ONE));
    assert!(known < 0.1 && unknown > 2.0 * known, "{known} {unknown}");
}
