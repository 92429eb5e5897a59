//! Irradiance by lights of all kinds against closed forms.

use glam::{Mat3, Vec2, Vec3};
use rrf_lights::{
    AreaLight, DistantLight, Environment, EnvironmentMap, Falloff, LightKind, LightSource, Mapping,
    PointLight, SpotLight, sky_direction,
};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Material, Scene};
use rrf_trace::Tracer;
use rrf_transfer::{
    DirectLight, FlatMirrors, Lamp, PatchConfig, Patches, Receivers, RowPoint, SourceLight,
    finer_near_lamps, named_light,
};
use std::f32::consts::PI;

/// Independent sets of random numbers of each estimate.
const REPLICATES: u32 = 16;
/// Student's t of 15 degrees of freedom, two-sided 99.9999 %.
const LARGEST_T: f64 = 7.9;

/// A square with these corners, in two triangles; emits `light` from its front.
fn add_square(scene: &mut Scene, corners: [Vec3; 4], material: Material, light: Option<AreaLight>) {
    let first = scene.positions.len() as u32;
    for corner in corners {
        scene.positions.push(corner);
        scene.normals.push(Vec3::ZERO);
        scene.uvs.push(Vec2::ZERO);
    }
    let id = scene.materials.len() as u32;
    let light_id = light.map_or(INVALID, |_| scene.area_lights.len() as u32);
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        scene.triangles.push([first + a, first + b, first + c]);
        scene.triangle_material.push(id);
        scene.triangle_light.push(light_id);
        scene.triangle_object.push(id);
    }
    scene.area_lights.extend(light);
    scene.objects.push(material.name.clone());
    scene.materials.push(material);
}

/// Corners of a horizontal square that faces up.
fn level(centre: Vec3, edge: f32) -> [Vec3; 4] {
    [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]]
        .map(|[x, z]| centre + edge * Vec3::new(x, 0.0, z))
}

/// A white square about the origin that faces up.
fn floor(edge: f32) -> Scene {
    let mut scene = Scene::default();
    let white = Material::lambert("floor", Vec3::ONE);
    add_square(&mut scene, level(Vec3::ZERO, edge), white, None);
    scene
}

/// Power [W] that the first object's upper side takes in.
fn taken_in(tracer: &Tracer, patches: &Patches, light: &dyn DirectLight, stream: Stream) -> Vec3 {
    let receivers = Receivers::new(tracer, patches, 32, None, stream);
    let found = receivers.irradiance(light);
    let own = (0..patches.len() as u32).filter(|&p| patches.object[p as usize] == 0);
    own.map(|p| {
        let back = patches.normal[p as usize].y < 0.0;
        found[patches.first_column(p, back) as usize] * patches.area[p as usize]
    })
    .sum()
}

/// Tests replicates of a mean irradiance over the floor against what it should be; they have to be within
/// 2 % for the test to say something.
fn assert_mean(
    scene: &Scene,
    count: usize,
    expected: f32,
    light: impl Fn(Stream) -> Box<dyn DirectLight>,
) {
    let tracer = Tracer::new(scene).unwrap();
    let patches = patches(scene, count);
    let mirrors = FlatMirrors::new(&tracer);
    let own = (0..patches.len()).filter(|&p| patches.object[p] == 0);
    let area: f32 = own.map(|p| patches.area[p]).sum();
    let values: Vec<f64> = (0..REPLICATES)
        .map(|r| {
            let stream = Stream::new(5, Stage::Test, r);
            let light = mirrors.of(light(stream.part(1)));
            f64::from(taken_in(&tracer, &patches, &light, stream).y / area)
        })
        .collect();
    let count = f64::from(REPLICATES);
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = (variance / count).sqrt() + 1e-5 * f64::from(expected);
    let t = (mean - f64::from(expected)) / error;
    assert!(
        t.abs() < LARGEST_T,
        "{mean} ± {error} for {expected}: t = {t}"
    );
    assert!(error < 0.02 * mean.abs(), "{mean} ± {error}");
}

fn patches(scene: &Scene, count: usize) -> Patches {
    let config = PatchConfig {
        count,
        ..PatchConfig::default()
    };
    Patches::new(scene, &config, &|_: Vec3| 1.0).unwrap()
}

/// A light that lives as long as the tests.
fn owned(source: impl Into<LightSource>) -> impl Fn(Stream) -> Box<dyn DirectLight> {
    let source: &'static LightSource = Box::leak(Box::new(source.into()));
    move |stream| Box::new(SourceLight::new(source, stream))
}

/// π L; and with a white mirror beside it too: it shows as much sky as it hides.
#[test]
fn a_plane_under_a_constant_sky() {
    let sky = || owned(Environment::constant(Vec3::new(1.0, 2.0, 3.0)));
    let mut scene = floor(1.0);
    assert_mean(&scene, 16, 2.0 * PI, sky());
    let [x, low, high, z] = [0.5, 0.0, 3.0, 3.0];
    let corners = [[low, -z], [high, -z], [high, z], [low, z]].map(|[y, z]| Vec3::new(x, y, z));
    let mirror = Material::principled("mirror", Vec3::ONE, 0.0, 1.0, 0.5);
    add_square(&mut scene, corners, mirror, None);
    assert_mean(&scene, 16, 2.0 * PI, sky());
    // a dark one hides it: the view factor from the floor is left
    scene.materials[1] = Material::lambert("wall", Vec3::ZERO);
    let tracer = Tracer::new(&scene).unwrap();
    let taken = taken_in(
        &tracer,
        &patches(&scene, 16),
        &sky()(Stream::new(5, Stage::Test, 0)),
        Stream::new(5, Stage::Test, 1),
    );
    assert!(taken.y < 0.9 * 2.0 * PI, "{taken}");
}

/// By the map's own quadrature.
#[test]
fn a_plane_under_a_map() {
    let texels = (0..32 * 16).map(|k| {
        let (x, y) = (k % 32, k / 32);
        let bright = if (x, y) == (5, 4) { 40.0 } else { 0.0 };
        Vec3::splat(bright + 0.1 * y as f32)
    });
    let map =
        EnvironmentMap::new((32, 16), texels.collect(), Mapping::LatLong, Mat3::IDENTITY).unwrap();
    // interpolated texels: a finer quadrature than the map's own
    let (mut expected, n) = (0.0f64, 2048);
    for j in 0..n / 2 {
        let theta = (f64::from(j) + 0.5) * std::f64::consts::PI / f64::from(n / 2);
        for i in 0..n {
            let direction = Mapping::LatLong.direction([
                (f64::from(i) + 0.5) / f64::from(n),
                (f64::from(j) + 0.5) / f64::from(n / 2),
            ]);
            let angle = 2.0 * (std::f64::consts::PI / f64::from(n)).powi(2) * 2.0 * theta.sin();
            expected += f64::from(map.radiance(direction).y) * theta.cos().max(0.0) * angle;
        }
    }
    assert_mean(
        &floor(1.0),
        16,
        expected as f32,
        owned(Environment::of_map(map)),
    );
}

/// The sine of the elevation; as much again by way of a mirror that faces the sun.
#[test]
fn a_plane_under_the_sun() {
    let sun = || owned(DistantLight::sun(sky_direction(270.0, 30.0), Vec3::ONE));
    let mut scene = floor(1.0);
    assert_mean(&scene, 16, 0.5, sun());
    let corners =
        [[0.0, -3.0], [3.0, -3.0], [3.0, 3.0], [0.0, 3.0]].map(|[y, z]| Vec3::new(0.5, y, z));
    let mirror = Material::principled("mirror", Vec3::ONE, 0.0, 1.0, 0.5);
    add_square(&mut scene, corners, mirror, None);
    assert_mean(&scene, 16, 1.0, sun());
}

/// The whole cone's power falls on the floor.
#[test]
fn a_floor_takes_in_all_of_a_spot() {
    for falloff in [Falloff::Smoothstep, Falloff::Quartic, Falloff::Squared] {
        let spot = SpotLight {
            position: Vec3::new(0.1, 1.5, -0.2),
            axis: Vec3::new(0.1, -1.0, 0.05).normalize(),
            intensity: Vec3::splat(2.0),
            inner: 0.3,
            outer: 0.6,
            falloff,
        };
        let expected = spot.power(1.0).y / 16.0;
        assert_mean(&floor(4.0), 400, expected, owned(spot));
    }
}

/// A point and its image.
#[test]
fn a_point_in_a_mirror() {
    let mut scene = floor(0.02);
    let corners =
        [[0.0, -3.0], [3.0, -3.0], [3.0, 3.0], [0.0, 3.0]].map(|[y, z]| Vec3::new(0.5, y, z));
    let mirror = Material::principled("mirror", Vec3::splat(0.5), 0.0, 1.0, 0.5);
    add_square(&mut scene, corners, mirror, None);
    let position = Vec3::new(-0.4, 1.2, 0.3);
    let image = Vec3::new(1.4, 1.2, 0.3);
    let at = |p: Vec3| p.y / p.length().powi(3);
    let schlick = 0.5 + 0.5 * (1.0 - image.x / image.length()).powi(5);
    let point = PointLight {
        position,
        intensity: Vec3::ONE,
    };
    assert_mean(&scene, 1, at(position) + schlick * at(image), owned(point));
    // the row's own part is the image's alone
    let tracer = Tracer::new(&scene).unwrap();
    let viewer = Vec3::new(-0.3, 0.9, 0.2).normalize();
    let row = RowPoint {
        point: tracer.locate(Vec3::ZERO, Vec3::Y).unwrap(),
        viewer,
    };
    let light = owned(point)(Stream::new(5, Stage::Test, 0));
    let own = FlatMirrors::new(&tracer).at_rows(&light, &[row], 0)[0].y;
    assert!(
        (own / (schlick * at(image) / PI) - 1.0).abs() < 1e-3,
        "{own}"
    );
}

/// Lambert's closed form for a polygon above the horizon, front and back, near and far.
#[test]
fn lamps_by_lamberts_formula() {
    for (height, edge, tilt) in [
        (2.0, 0.3, 0.4),
        (0.5, 1.0, 0.2),
        (0.03, 1.0, 0.0),
        (40.0, 1.0, 0.3),
    ] {
        let corners = level(Vec3::ZERO, edge)
            .map(|c| Vec3::new(0.02, height, 0.01) + Mat3::from_rotation_x(PI + tilt) * c);
        let mut sum = 0.0;
        for i in 0..4 {
            let [a, b] = [corners[i], corners[(i + 1) % 4]].map(|c| c.as_dvec3());
            sum += a.angle_between(b) * a.cross(b).normalize().y;
        }
        let radiance = Vec3::new(1.0, 3.0, 2.0);
        let expected = 0.5 * 3.0 * sum.abs() as f32;
        for two_sided in [false, true] {
            let mut scene = floor(1e-3);
            let black = Material::lambert("lamp", Vec3::ZERO);
            add_square(
                &mut scene,
                corners,
                black,
                Some(AreaLight {
                    radiance,
                    two_sided,
                }),
            );
            let lamp =
                |stream| Box::new(Lamp::new(&scene, |_| true, stream)) as Box<dyn DirectLight>;
            assert_mean(&scene, 1, expected, lamp);
        }
        let mut turned = floor(1e-3);
        let [a, b, c, d] = corners;
        let light = AreaLight {
            radiance,
            two_sided: false,
        };
        add_square(
            &mut turned,
            [a, d, c, b],
            Material::lambert("lamp", Vec3::ZERO),
            Some(light),
        );
        let tracer = Tracer::new(&turned).unwrap();
        let lamp = Lamp::new(&turned, |_| true, Stream::new(5, Stage::Test, 0));
        let taken = taken_in(
            &tracer,
            &patches(&turned, 1),
            &lamp,
            Stream::new(5, Stage::Test, 1),
        );
        assert_eq!(taken, Vec3::ZERO);
    }
}

/// Several lights are the sum of each; a light twice as bright is twice the light; threads change
/// nothing.
#[test]
fn linear_and_the_same_on_any_number_of_threads() {
    let scene = crate::scenes::cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let patches = patches(&scene, 300);
    let receivers = Receivers::new(&tracer, &patches, 8, None, Stream::new(5, Stage::Test, 0));
    let stream = Stream::new(5, Stage::Test, 1);
    let sources: [LightSource; 3] = [
        Environment::constant(Vec3::new(0.5, 1.0, 2.0)).into(),
        DistantLight::sun(Vec3::new(0.1, 0.3, 1.0).normalize(), Vec3::ONE).into(),
        PointLight {
            position: Vec3::new(0.2, 1.5, 0.1),
            intensity: Vec3::ONE,
        }
        .into(),
    ];
    let lights: Vec<SourceLight> = sources
        .iter()
        .map(|s| SourceLight::new(s, stream))
        .collect();
    let all = receivers.irradiance(&lights);
    let each: Vec<Vec<Vec3>> = lights.iter().map(|l| receivers.irradiance(l)).collect();
    for (column, all) in all.iter().enumerate() {
        let sum: Vec3 = each.iter().map(|e| e[column]).sum();
        assert!((sum - *all).length() <= 1e-5 * all.length(), "{sum} {all}");
    }
    let double = sources[0].dimmed(Vec3::splat(2.0));
    let double = receivers.irradiance(&SourceLight::new(&double, stream));
    assert!(
        double
            .iter()
            .zip(&each[0])
            .all(|(two, one)| *two == 2.0 * *one)
    );
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        assert_eq!(pool.install(|| receivers.irradiance(&lights)), all);
    }
}

/// An own light by its name; patches are finer where a lamp is near.
#[test]
fn own_lights_by_name() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    );
    let scene = rrf_scene::load(path.as_ref(), &rrf_scene::LoadOptions::default()).unwrap();
    let stream = Stream::new(5, Stage::Test, 0);
    for name in scene.own_light_names() {
        assert!(named_light(&scene, name, stream).is_some(), "{name}");
    }
    assert!(named_light(&scene, "moon", stream).is_none());
    let finer = finer_near_lamps(&scene, 0.2);
    assert_eq!(finer(Vec3::new(0.0, 0.0, 0.0)), 1.0);
    assert_eq!(finer(Vec3::new(0.0, 1.98, 0.0)), 0.25);
    let even = patches(&scene, 300).len();
    let config = PatchConfig {
        count: 300,
        ..PatchConfig::default()
    };
    assert!(Patches::new(&scene, &config, &finer).unwrap().len() > even);
}
