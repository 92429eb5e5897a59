//! Light of emitting triangles.

use crate::scenes::{Builder, lambert};
use crate::statistics::assert_z;
use glam::{DVec3, Vec2, Vec3};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene, Texture};
use rrf_trace::{Reflections, Sampling, SurfacePoint, Tracer, lamp_light};

const SAMPLING: Sampling = Sampling {
    paths: 65_536,
    replicates: 64,
};

fn direct(tracer: &Tracer, point: SurfacePoint, viewer: Vec3) -> (Vec3, Vec3) {
    let stream = Stream::new(51, Stage::Test, 0);
    let one = Reflections::One;
    let estimates = lamp_light(tracer, &[point], &[viewer], one, SAMPLING, stream, 0).unwrap();
    (estimates.mean(0), estimates.standard_error(0))
}

/// Form factor from a small patch to a parallel rectangle a by b at height h whose corner is
/// straight above the patch (Howell, catalogue of configuration factors, B-3).
fn corner_form_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / std::f64::consts::TAU
}

/// A floor of albedo `a` and a rectangle -1..2 by -0.5..1 at height `h` that shines down.
fn under_a_rectangle(a: Vec3, radiance: Vec3, h: f32, two_sided: bool) -> Scene {
    let mut builder = Builder::default();
    let floor = builder.material(lambert(a));
    let black = builder.material(lambert(Vec3::ZERO));
    let light = builder.light(radiance, two_sided);
    let corner = Vec3::new(-10.0, -10.0, 0.0);
    builder.quad(corner, Vec3::X * 20.0, Vec3::Y * 20.0, floor, INVALID);
    // y by x: the normal points down.
    let corner = Vec3::new(-1.0, -0.5, h);
    builder.quad(corner, Vec3::Y * 1.5, Vec3::X * 3.0, black, light);
    builder.scene
}

#[test]
fn rectangle_over_a_floor() {
    let (a, radiance) = (Vec3::new(0.8, 0.5, 0.2), Vec3::new(1.0, 2.0, 17.0));
    for h in [0.05f32, 0.7, 3.0] {
        let scene = under_a_rectangle(a, radiance, h, false);
        let tracer = Tracer::new(&scene).unwrap();
        let point = tracer.locate(Vec3::ZERO, Vec3::Z).unwrap();
        let factor: f64 = [(1.0, 0.5), (1.0, 1.0), (2.0, 0.5), (2.0, 1.0)]
            .iter()
            .map(|&(x, y)| corner_form_factor(x, y, f64::from(h)))
            .sum();
        let truth = a * radiance * factor as f32;
        let (mean, error) = direct(&tracer, point, Vec3::new(0.6, 0.0, 0.8));
        assert_z(&format!("height {h}"), mean, error, truth, 0.0, 3);
    }
}

#[test]
fn lamps_shine_on_their_front_only_unless_two_sided() {
    for two_sided in [false, true] {
        let mut scene = under_a_rectangle(Vec3::ONE, Vec3::ONE, 1.0, two_sided);
        let last = scene.triangles.len();
        for triangle in &mut scene.triangles[last - 2..] {
            triangle.swap(1, 2);
        }
        let tracer = Tracer::new(&scene).unwrap();
        let point = tracer.locate(Vec3::ZERO, Vec3::Z).unwrap();
        let (mean, _) = direct(&tracer, point, Vec3::Z);
        assert_eq!(mean.max_element() > 0.1, two_sided, "{mean}");
    }
}

/// A lamp by its picture, against the integral over its surface by fine midpoints.
#[test]
fn a_picture_shines_where_it_lies() {
    const SIDE: u32 = 32;
    let radiance = Vec3::new(1.0, 2.0, 17.0);
    let mut scene = under_a_rectangle(Vec3::ONE, radiance, 0.7, false);
    let first = scene.positions.len() - 4;
    for (k, uv) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .into_iter()
        .enumerate()
    {
        scene.uvs[first + k] = uv.into();
    }
    // A bright corner in red, a ramp in green, a single texel in blue.
    let texel = |k: u32| {
        let (x, y) = (k % SIDE, k / SIDE);
        let corner = f32::from(u8::from(x > 24 && y > 24));
        Vec3::new(
            corner,
            x as f32 / SIDE as f32,
            f32::from(u8::from((x, y) == (9, 20))),
        )
    };
    scene.textures.push(Texture {
        width: SIDE,
        height: SIDE,
        texels: (0..SIDE * SIDE).map(texel).collect(),
    });
    scene.area_light_textures = vec![0];
    let tracer = Tracer::new(&scene).unwrap();
    let point = tracer.locate(Vec3::ZERO, Vec3::Z).unwrap();
    // Corner (-1, -0.5), u along y over 1.5, v along x over 3.
    const STEPS: u32 = 1024;
    let (mut sum, height) = (DVec3::ZERO, 0.7f32 as f64);
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(STEPS));
        let place = DVec3::new(-1.0 + 3.0 * v, -0.5 + 1.5 * u, height);
        let share = scene.textures[0].sample(Vec2::new(u as f32, v as f32));
        let squared = place.length_squared();
        sum += share.as_dvec3() * (height * height / (squared * squared));
    }
    let area = 4.5 / f64::from(STEPS * STEPS);
    let truth = radiance * (sum * area / std::f64::consts::PI).as_vec3();
    let (mean, error) = direct(&tracer, point, Vec3::new(0.6, 0.0, 0.8));
    // The midpoint rule errs by far less than the standard error.
    assert_z("picture", mean, error, truth, 1e-4, 1);
}

#[test]
fn shade_is_black() {
    let mut scene = under_a_rectangle(Vec3::ONE, Vec3::ONE, 1.0, false);
    let mut builder = Builder { scene };
    let corner = Vec3::new(-5.0, -5.0, 0.5);
    builder.quad(corner, Vec3::X * 10.0, Vec3::Y * 10.0, 1, INVALID);
    scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let point = tracer.locate(Vec3::ZERO, Vec3::Z).unwrap();
    assert_eq!(direct(&tracer, point, Vec3::Z).0, Vec3::ZERO);
}

#[test]
fn a_scene_without_lamps_is_dark() {
    let mut builder = Builder::default();
    let material = builder.material(lambert(Vec3::ONE));
    builder.cuboid(Vec3::ZERO, Vec3::ONE, true, material, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let point = tracer.point(0, [0.3, 0.3]);
    assert_eq!(direct(&tracer, point, point.normal).0, Vec3::ZERO);
}
