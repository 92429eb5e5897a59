//! Scenes, views and frames of many seeds, and their moments against a truth.

pub use crate::dark::field;
use glam::{Vec2, Vec3};
use rrf_render::{
    AreaLights, Lights, Part, PathOptions, RenderOptions, ShadowRays, View, render, trace_frame,
};
use rrf_scene::{AreaLight, INVALID, Material, Scene};
use rrf_trace::Tracer;

pub const ALBEDO: f32 = 0.6;
pub const SIZE: [u32; 2] = [24, 16];
/// Independent frames of each estimator.
pub const SEEDS: u64 = 64;

/// Quads of one grey Lambert material: corner and two edges, lamps last.
pub fn scene(quads: &[[Vec3; 3]], lamps: &[[Vec3; 3]], radiance: f32) -> Scene {
    let mut scene = Scene {
        materials: vec![Material::lambert("grey", Vec3::splat(ALBEDO))],
        area_lights: vec![AreaLight {
            radiance: Vec3::splat(radiance),
            two_sided: false,
        }],
        area_light_names: vec!["lamp".into()],
        ..Scene::default()
    };
    let black = Material {
        base_color: Vec3::ZERO,
        ..scene.materials[0].clone()
    };
    scene.materials.push(black);
    let kinds = [(quads, 0, INVALID), (lamps, 1, 0)];
    for (quads, material, light) in kinds {
        for &[corner, a, b] in quads {
            let first = scene.positions.len() as u32;
            scene
                .positions
                .extend([corner, corner + a, corner + a + b, corner + b]);
            scene.normals.extend([Vec3::ZERO; 4]);
            scene.uvs.extend([Vec2::ZERO; 4]);
            for [i, j, k] in [[0, 1, 2], [0, 2, 3]] {
                scene.triangles.push([first + i, first + j, first + k]);
                scene.triangle_material.push(material);
                scene.triangle_light.push(light);
                scene.triangle_object.push(0);
            }
        }
    }
    if lamps.is_empty() {
        scene.area_lights.clear();
        scene.area_light_names.clear();
    }
    scene
}

pub fn floor() -> [Vec3; 3] {
    [Vec3::new(-5.0, -5.0, 0.0), Vec3::X * 10.0, Vec3::Y * 10.0]
}

/// From the side, so that what hangs over the floor does not hide it.
pub fn view() -> View {
    View::look_at(
        Vec3::new(0.0, -2.5, 0.9),
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::Z,
        40.0,
        SIZE,
    )
}

/// Red channels of direct frames with seeds 1, 2 ...
pub fn frames(scene: &Scene, lights: &Lights, count: u32, adaptive: bool) -> Vec<Vec<f64>> {
    let rays = ShadowRays {
        count,
        adaptive,
        ..ShadowRays::default()
    };
    frames_by(scene, lights, rays)
}

/// As [`frames`], with any rays.
pub fn frames_by(scene: &Scene, lights: &Lights, rays: ShadowRays) -> Vec<Vec<f64>> {
    let tracer = Tracer::new(scene).unwrap();
    let field = field();
    let light_box = [Vec3::splat(-1.0), Vec3::ONE];
    let lamps = AreaLights::new(scene, &field, light_box, |_| true).unwrap();
    let frame = |seed| {
        let options = RenderOptions {
            part: Part::Direct,
            area_lights: Some(&lamps),
            shadow_rays: Some(rays),
            seed,
            ..RenderOptions::default()
        };
        let frame = render(&tracer, &field, &view(), lights, &options).unwrap();
        frame.full.iter().map(|p| f64::from(p.x)).collect()
    };
    (1..=SEEDS).map(frame).collect()
}

/// Moments of path-traced direct frames, 64 paths a pixel each.
pub fn traced(scene: &Scene, lights: &Lights) -> Vec<(f64, f64)> {
    let tracer = Tracer::new(scene).unwrap();
    let frame = |seed| {
        let options = PathOptions {
            spp: 64,
            aa: 1,
            seed,
        };
        let frame = trace_frame(&tracer, &view(), lights, options, &|_| {}).unwrap();
        let direct = frame.direct.unwrap();
        direct.iter().map(|p| f64::from(p.x)).collect()
    };
    moments(&(1..=SEEDS).map(frame).collect::<Vec<_>>())
}

/// Per-pixel means and squared standard errors of independent frames.
pub fn moments(frames: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let n = frames.len() as f64;
    (0..frames[0].len())
        .map(|pixel| {
            let values = frames.iter().map(|f| f[pixel]);
            let mean = values.clone().sum::<f64>() / n;
            let square = values.map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (mean, square / n)
        })
        .collect()
}

/// No pixel is farther from the truth than chance allows. The threshold is the two-sided
/// quantile of Student's t with 63 degrees of freedom at 1e-4 / 384 pixels (Šidák): 6.04; the
/// truth's own squared error is added. The sum over pixels, uncorrelated given what was learned,
/// is tested at 1e-4: 4.2.
pub fn assert_unbiased(name: &str, frames: &[Vec<f64>], truth: &[(f64, f64)]) {
    let (mut difference, mut variance) = (0.0, 0.0);
    for (pixel, (&(mean, se2), &(m, m_se2))) in moments(frames).iter().zip(truth).enumerate() {
        let rounding = (1e-5 * m).powi(2);
        let t = (mean - m) / (se2 + m_se2 + rounding).sqrt().max(1e-12);
        assert!(
            t.abs() < 6.04,
            "{name}, pixel {pixel}: {mean} against {m}, t {t}"
        );
        difference += mean - m;
        variance += se2 + m_se2 + rounding;
    }
    let z = difference / variance.sqrt().max(1e-12);
    assert!(z.abs() < 4.2, "{name}: z {z} of the sum");
}
