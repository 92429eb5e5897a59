//! Points, frames, materials and textures.

use crate::chi_square::assert_chi_square;
use crate::scenes::{Builder, cornell, lambert};
use glam::{Vec2, Vec3};
use rrf_materials::ShadingFrame;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Material, Texture};
use rrf_trace::Tracer;

#[test]
fn area_samples_are_uniform() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    const DRAWS: u64 = 400_000;
    const SPLIT: usize = 4;
    let stream = Stream::new(31, Stage::Test, 0);
    let mut counts = vec![0.0; scene.triangles.len() * SPLIT];
    for i in 0..DRAWS {
        let u = stream.units(i, 0, 0);
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        let [b1, b2] = point.barycentrics;
        // The four similar triangles that midpoints of the edges make have a quarter each.
        let part = [1.0 - b1 - b2, b1, b2]
            .iter()
            .position(|&b| b > 0.5)
            .unwrap_or(3);
        counts[point.triangle as usize * SPLIT + part] += 1.0;
    }
    let area = |t: usize| {
        let [a, b, c] = scene.triangles[t].map(|v| scene.positions[v as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = (0..scene.triangles.len()).map(area).sum();
    assert!((tracer.area() - total).abs() < 1e-9);
    let expected: Vec<f64> = (0..counts.len())
        .map(|i| DRAWS as f64 * area(i / SPLIT) / total / SPLIT as f64)
        .collect();
    assert_chi_square("area", &counts, &expected, 1);
}

#[test]
fn located_points_are_the_sampled_ones() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let stream = Stream::new(32, Stage::Test, 0);
    for i in 0..20_000 {
        let u = stream.units(i, 0, 0);
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        for normal in [point.normal, -point.normal] {
            let found = tracer.locate(point.position, normal).unwrap();
            assert!(found.position.distance(point.position) < 1e-6);
            assert!(found.normal.dot(normal).abs() > 0.999_99);
            // Under the boxes the floor has a twin that faces the other way.
            assert!(
                found.triangle == point.triangle || found.normal.dot(normal) > 0.0 || {
                    let [a, b] = [found.triangle, point.triangle];
                    scene.triangle_object[a as usize] == scene.triangle_object[b as usize]
                }
            );
        }
    }
}

#[test]
fn coincident_faces_are_told_apart_by_their_normal() {
    let mut builder = Builder::default();
    let material = builder.material(lambert(Vec3::ONE));
    builder.quad(Vec3::ZERO, Vec3::X, Vec3::Y, material, INVALID);
    builder.quad(Vec3::ZERO, Vec3::Y, Vec3::X, material, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    for normal in [Vec3::Z, Vec3::NEG_Z] {
        let found = tracer.locate(Vec3::new(0.3, 0.4, 0.0), normal).unwrap();
        assert_eq!(found.normal, normal);
    }
    // Just outside the rim: the nearest point of the rim.
    let rim = tracer
        .locate(Vec3::new(1.000_01, 0.5, 0.0), Vec3::Z)
        .unwrap();
    assert!((rim.position - Vec3::new(1.0, 0.5, 0.0)).length() < 1e-6);
    assert!(tracer.locate(Vec3::new(0.5, 0.5, 0.1), Vec3::Z).is_none());
    assert!(tracer.locate(Vec3::splat(f32::NAN), Vec3::Z).is_none());
}

#[test]
fn frames_are_orthonormal_and_right_handed() {
    let stream = Stream::new(33, Stage::Test, 0);
    let random = (0..10_000).map(|i| {
        let u = stream.units(i, 0, 0);
        Vec3::new(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5).normalize()
    });
    let axes = [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|a| [a, -a]);
    for z in random.chain(axes) {
        let frame = ShadingFrame::new(z);
        assert!((frame.x.cross(frame.y) - z).length() < 1e-6, "{z}");
        assert!(frame.x.dot(frame.y).abs() < 1e-6, "{z}");
        let w = Vec3::new(0.48, 0.6, 0.64);
        assert!(
            (frame.to_local(frame.to_world(w)) - w).length() < 1e-6,
            "{z}"
        );
    }
}

#[test]
fn shading_normals_face_the_viewer() {
    let mut builder = Builder::default();
    let material = builder.material(lambert(Vec3::ONE));
    let centre = Vec3::new(1.0, 2.0, 3.0);
    builder.sphere(centre, 2.0, 32, material, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let stream = Stream::new(34, Stage::Test, 0);
    for i in 0..10_000 {
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        let v = Vec3::new(w[0] - 0.5, w[1] - 0.5, w[2] - 0.5).normalize();
        let normal = tracer.normal_at(&point, v);
        assert!(normal.dot(v) > 0.0 && (normal.length() - 1.0).abs() < 1e-5);
        // Interpolated, it is the sphere's own; it serves as long as it faces the viewer.
        let outward = (point.position - centre).normalize();
        let side = if point.normal.dot(v) < 0.0 {
            -outward
        } else {
            outward
        };
        if side.dot(v) > 1e-3 {
            assert!(normal.distance(side) < 1e-2, "{normal} {side}");
        }
    }
}

/// One quad in the plane z = 0 whose texture coordinates are `uvs`, with textures.
fn textured(uvs: [Vec2; 4], material: Material, textures: Vec<Texture>) -> rrf_scene::Scene {
    let mut builder = Builder::default();
    let material = builder.material(material);
    builder.quad(Vec3::ZERO, Vec3::X, Vec3::Y, material, INVALID);
    builder.scene.uvs = uvs.to_vec();
    builder.scene.textures = textures;
    builder.scene
}

const SQUARE: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

fn picture(texels: [Vec3; 4]) -> Texture {
    Texture {
        width: 2,
        height: 2,
        texels: texels.to_vec(),
    }
}

#[test]
fn textures_multiply_the_constants() {
    let rows = [
        Vec3::new(0.1, 0.2, 0.3),
        Vec3::new(0.4, 0.5, 0.6),
        Vec3::ONE,
        Vec3::ZERO,
    ];
    let material = Material {
        base_texture: 0,
        roughness_metallic_texture: 0,
        roughness: 0.5,
        metallic: 0.5,
        ..lambert(Vec3::new(0.8, 0.4, 0.2))
    };
    let scene = textured(SQUARE, material, vec![picture(rows)]);
    let tracer = Tracer::new(&scene).unwrap();
    // Centres of the texels; row 0 is the upper one.
    for (x, y, texel) in [
        (0.25, 0.75, 0),
        (0.75, 0.75, 1),
        (0.25, 0.25, 2),
        (0.75, 0.25, 3),
    ] {
        let point = tracer.locate(Vec3::new(x, y, 0.0), Vec3::Z).unwrap();
        let found = tracer.material_at(&point);
        let base = Vec3::new(0.8, 0.4, 0.2) * rows[texel];
        assert!((found.base_color - base).length() < 1e-5, "{texel}");
        assert!(
            (found.roughness - 0.5 * rows[texel].y).abs() < 1e-5,
            "{texel}"
        );
        assert!(
            (found.metallic - 0.5 * rows[texel].z).abs() < 1e-5,
            "{texel}"
        );
    }
}

/// A map that leans toward +u by atan(3/4) everywhere: the normal leans to where u grows, on
/// the quad as it is, with u and v swapped (mirrored), and with u reversed.
#[test]
fn normal_maps_lean_along_the_texture() {
    let leaning = Vec3::new(0.6, 0.0, 0.8) * 0.5 + 0.5;
    let upward = Vec3::new(0.0, 0.6, 0.8) * 0.5 + 0.5;
    let swapped = SQUARE.map(|uv| Vec2::new(uv.y, uv.x));
    let reversed = SQUARE.map(|uv| Vec2::new(1.0 - uv.x, uv.y));
    let point = [0.25, 0.5];
    for (uvs, texel, expected) in [
        (SQUARE, leaning, Vec3::new(0.6, 0.0, 0.8)),
        (SQUARE, upward, Vec3::new(0.0, 0.6, 0.8)),
        (swapped, leaning, Vec3::new(0.0, 0.6, 0.8)),
        (swapped, upward, Vec3::new(0.6, 0.0, 0.8)),
        (reversed, leaning, Vec3::new(-0.6, 0.0, 0.8)),
        (reversed, upward, Vec3::new(0.0, 0.6, 0.8)),
        (SQUARE, Vec3::new(0.5, 0.5, 1.0), Vec3::Z),
        // Without an area in (u, v) there is no direction to lean to.
        ([Vec2::ONE; 4], leaning, Vec3::Z),
    ] {
        let material = Material {
            normal_texture: 0,
            ..lambert(Vec3::ONE)
        };
        let scene = textured(uvs, material, vec![picture([texel; 4])]);
        let tracer = Tracer::new(&scene).unwrap();
        let at = tracer.point(0, point);
        assert!(
            tracer.normal_at(&at, Vec3::Z).distance(expected) < 1e-5,
            "{uvs:?}"
        );
        // From behind it is the same surface, seen from the other side.
        let behind = tracer.normal_at(&at, Vec3::NEG_Z);
        assert!(behind.distance(-expected) < 1e-5, "{uvs:?}: {behind}");
    }
}
