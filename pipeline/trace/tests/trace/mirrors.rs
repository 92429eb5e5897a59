//! A small patch over two flat metals that show it a point light: by way of a mirror's image, of
//! the light's own rays and of the patch's, weighted against each other.

use crate::scenes::{Builder, lambert, principled};
use crate::statistics::assert_z;
use glam::{DVec2, Vec3};
use rrf_materials::Bsdf;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Material};
use rrf_trace::{Estimator, Queries, Sampling, Tracer, indirect_with};

const ALBEDO: Vec3 = Vec3::new(0.9, 0.5, 0.3);
/// Two metals side by side in the plane z = 0, |x| and |y| at most 1.
fn metals() -> [Material; 2] {
    [
        principled(Vec3::new(0.9, 0.7, 0.4), 0.25, 1.0, 0.5),
        principled(Vec3::new(0.5, 0.6, 0.9), 0.4, 0.8, 0.5),
    ]
}

/// What the patch at `p`, facing down, reflects of the light at `l` by way of the plane: the sum over a
/// grid of `n` by `n` points of a/π cos θ_p · cos θ_y / r² · f cos θ_l / d².
fn radiance(p: Vec3, l: Vec3, n: usize) -> Vec3 {
    let metals = metals().map(|metal| Bsdf::of(&metal));
    let step = 2.0 / n as f64;
    let mut sum = glam::DVec3::ZERO;
    for i in 0..n * n {
        let at = DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) * step - 1.0;
        let y = Vec3::new(at.x as f32, at.y as f32, 0.0);
        let (back, to) = (p - y, l - y);
        let (r2, d2) = (back.length_squared(), to.length_squared());
        let metal = &metals[usize::from(at.x > 0.0)];
        let value = metal.eval(Vec3::Z, back.normalize(), to.normalize());
        let cosine = back.z / r2.sqrt();
        sum += (value * (cosine * cosine / (r2 * d2))).as_dvec3();
    }
    (sum * (step * step)).as_vec3() * ALBEDO / std::f32::consts::PI
}

#[test]
fn a_patch_sees_a_light_in_two_mirrors() {
    let p = Vec3::new(-0.1, 0.05, 0.8);
    // images in either mirror, in both about the seam, at the edge, beyond it, and a light that grazes
    let lights = [
        Vec3::new(-0.5, 0.3, 0.6),
        Vec3::new(0.7, -0.4, 0.5),
        Vec3::new(0.1, 0.0, 0.9),
        Vec3::new(1.7, 0.6, 0.7),
        Vec3::new(2.6, 0.2, 0.5),
        Vec3::new(0.4, 0.3, 0.05),
    ];
    for light in lights {
        let mut builder = Builder::default();
        let patch = builder.material(lambert(ALBEDO));
        for (side, metal) in metals().into_iter().enumerate() {
            let metal = builder.material(metal);
            let corner = Vec3::new(side as f32 - 1.0, -1.0, 0.0);
            builder.quad(corner, Vec3::X, Vec3::Y * 2.0, metal, INVALID);
        }
        // so small that what it sends back to the plane does not count (1e-6)
        let corner = p - Vec3::new(0.0005, 0.0005, 0.0);
        builder.quad(corner, Vec3::Y * 0.001, Vec3::X * 0.001, patch, INVALID);
        let scene = builder.scene;
        let tracer = Tracer::new(&scene).unwrap();
        let queries = Queries {
            points: &[tracer.locate(p, Vec3::NEG_Z).unwrap()],
            viewers: &[Vec3::new(0.8, 0.0, -0.6)],
            lights: &[light],
        };
        let sampling = Sampling {
            paths: 65_536,
            replicates: 64,
        };
        let stream = Stream::new(62, Stage::Test, 0);
        // the midpoint rule errs by a quarter at twice the points: a third of the difference is left
        let (coarse, truth) = (radiance(p, light, 1_000), radiance(p, light, 2_000));
        let slack = ((truth - coarse) / truth).abs().max_element() / 3.0 + 2e-5;
        assert!(slack < 1e-3, "light {light}: the sum is off by {slack}");
        // 64 replicates: Student's t, whose tail at the limit is a quarter longer
        for estimator in [Estimator::Connected, Estimator::Bidirectional] {
            let found = indirect_with(&tracer, queries, sampling, estimator, stream, 0).unwrap();
            let (mean, error) = (found.mean(0), 1.25 * found.standard_error(0));
            let name = format!("{estimator:?}, light {light}");
            assert_z(&name, mean, error, truth, slack, 2 * lights.len());
        }
    }
}

/// Vertices after the first look at mirrors too, but not all of them: a wall that sees, and reflects
/// to the point asked for, what a metal floor sends it of the light, against plain next-event
/// estimation, which knows of no mirror.
#[test]
fn later_vertices_weigh_what_mirrors_show() {
    let mut builder = Builder::default();
    let white = builder.material(lambert(Vec3::splat(0.9)));
    let metal = builder.material(principled(Vec3::new(0.9, 0.7, 0.5), 0.5, 1.0, 0.5));
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    builder.quad(corner, z, x, metal, INVALID);
    builder.quad(corner, y, z, white, INVALID);
    builder.quad(corner + x, z, y, white, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    assert!(tracer.has_mirrors());
    let points = [
        Vec3::new(-1.0, 0.9, 0.1),
        Vec3::new(1.0, 0.6, -0.3),
        Vec3::new(-1.0, 1.5, 0.5),
    ];
    let queries = Queries {
        points: &points.map(|p| tracer.locate(p, Vec3::X * -p.x).unwrap()),
        viewers: &points.map(|p| Vec3::new(-p.x, 0.2, 0.3).normalize()),
        lights: &[Vec3::new(0.2, 0.8, 0.1); 3],
    };
    let sampling = Sampling {
        paths: 1 << 22,
        replicates: 64,
    };
    let run = |estimator, seed| {
        let stream = Stream::new(seed, Stage::Test, 0);
        indirect_with(&tracer, queries, sampling, estimator, stream, 0).unwrap()
    };
    let (with, without) = (run(Estimator::Connected, 81), run(Estimator::NextEvent, 82));
    for (q, p) in points.into_iter().enumerate() {
        let (a, b) = (with.standard_error(q), without.standard_error(q));
        // Student's t of twice 64 replicates has a tail a tenth longer at the limit
        let error = 1.1 * Vec3::from((a * a + b * b).to_array().map(f32::sqrt));
        assert_z(
            &format!("{p}"),
            with.mean(q),
            error,
            without.mean(q),
            0.0,
            points.len(),
        );
    }
}
