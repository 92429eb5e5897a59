//! Meshes, accessors and transforms of glTF files built here.

use crate::glb::Glb;
use crate::support::{edge_cross, some_triangle, warns};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rrf_scene::Scene;
use serde_json::json;

/// A unit square in the plane z = 0, front towards +z.
const SQUARE: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
];

/// A tetrahedron with its faces outwards: volume 1/6.
const TETRAHEDRON: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
const TETRAHEDRON_FACES: [u32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

/// Volume enclosed by outward faces (divergence theorem), negative for inward ones.
fn volume(scene: &Scene) -> f64 {
    let corner = |v: u32| scene.positions[v as usize].as_dvec3();
    let six_fold = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2])));
    scene.triangles.iter().map(six_fold).sum::<f64>() / 6.0
}

/// Triangles as sets of corner positions, to compare topologies.
fn triangle_positions(scene: &Scene) -> Vec<[[i32; 3]; 3]> {
    let corner = |v: u32| scene.positions[v as usize].to_array().map(|x| x as i32);
    let mut all: Vec<_> = scene
        .triangles
        .iter()
        .map(|t| {
            let mut corners = t.map(corner);
            let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
            corners.rotate_left(least); // the same winding, a fixed start
            corners
        })
        .collect();
    all.sort();
    all
}

#[test]
fn every_index_type_and_no_index_give_the_same() {
    for component in [5121, 5123, 5125] {
        let mut glb = Glb::new();
        let positions = glb.floats(&SQUARE);
        let indices = glb.integers(&[0, 1, 2, 0, 2, 3], component);
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
        glb.place(primitive, json!({}));
        let scene = glb.load().unwrap();
        assert_eq!(scene.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!((0..2).all(|t| edge_cross(&scene, t) == Vec3::Z));
    }
    let mut glb = Glb::new();
    let corners = [SQUARE[0], SQUARE[1], SQUARE[2]];
    let positions = glb.floats(&corners);
    glb.place(
        json!({ "attributes": { "POSITION": positions } }),
        json!({}),
    );
    let scene = glb.load().unwrap();
    assert_eq!(scene.triangles, [[0, 1, 2]]);
    assert_eq!(scene.normals, [Vec3::ZERO; 3]);
}

#[test]
fn strips_and_fans_are_the_triangles_that_they_stand_for() {
    let read = |positions: &[[f32; 3]], mode: u32, indices: &[u32]| {
        let mut glb = Glb::new();
        let positions = glb.floats(positions);
        let indices = glb.integers(indices, 5123);
        let attributes = json!({ "POSITION": positions });
        let primitive = json!({ "attributes": attributes, "mode": mode, "indices": indices });
        glb.place(primitive, json!({}));
        triangle_positions(&glb.load().unwrap())
    };
    // A ladder of four triangles, all with their front towards +z.
    let ladder: Vec<[f32; 3]> = (0..6)
        .map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0])
        .collect();
    let list = [0, 2, 1, 2, 3, 1, 2, 4, 3, 4, 5, 3];
    assert_eq!(read(&ladder, 5, &[1, 0, 3, 2, 5, 4]).len(), 4);
    let strip = read(&ladder, 5, &[0, 2, 1, 3]);
    assert_eq!(strip, read(&ladder, 4, &[0, 2, 1, 1, 2, 3]));
    assert_eq!(read(&ladder, 5, &[1, 0, 3, 2, 5, 4]), {
        // The specification's formula by hand: (1 0 3) (0 2 3) (3 2 5) (2 4 5).
        read(&ladder, 4, &[1, 0, 3, 0, 2, 3, 3, 2, 5, 2, 4, 5])
    });
    assert_eq!(read(&ladder, 4, &list).len(), 4);
    let fan = read(&SQUARE, 6, &[0, 1, 2, 3]);
    assert_eq!(fan, read(&SQUARE, 4, &[0, 1, 2, 0, 2, 3]));
}

#[test]
fn points_and_lines_are_left_out_with_a_warning() {
    for mode in 0..4 {
        let mut glb = Glb::new();
        let positions = glb.floats(&SQUARE);
        let primitive = json!({ "attributes": { "POSITION": positions }, "mode": mode });
        glb.place(primitive, json!({}));
        assert!(glb.refused().contains("no triangles"));
        some_triangle(&mut glb);
        let scene = glb.load().unwrap();
        assert_eq!((scene.triangles.len(), scene.positions.len()), (1, 3));
        assert!(warns(&scene, "no surface"), "{:?}", scene.warnings);
    }
}

#[test]
fn sparse_accessors_replace_elements_of_a_base_or_of_zeros() {
    for with_base in [true, false] {
        let mut glb = Glb::new();
        let base = glb.floats(&SQUARE);
        let ids = glb.integers(&[1, 2], 5121);
        let values = glb.floats(&[[5.0, 0.0, 0.0], [5.0, 7.0, 0.0]]);
        let view =
            |glb: &Glb, accessor: usize| glb.json["accessors"][accessor]["bufferView"].clone();
        let sparse = json!({
            "count": 2,
            "indices": { "bufferView": view(&glb, ids), "componentType": 5121 },
            "values": { "bufferView": view(&glb, values) },
        });
        let mut accessor = json!({
            "componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse,
        });
        if with_base {
            accessor["bufferView"] = view(&glb, base);
        }
        let positions = glb.push("accessors", accessor);
        let indices = glb.integers(&[0, 1, 2, 0, 2, 3], 5123);
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
        glb.place(primitive, json!({}));
        let scene = glb.load().unwrap();
        let last = if with_base { Vec3::Y } else { Vec3::ZERO };
        let want = [Vec3::ZERO, Vec3::X * 5.0, Vec3::new(5.0, 7.0, 0.0), last];
        assert_eq!(scene.positions, want);
        // Without a base the second triangle has two corners at the origin.
        assert_eq!(scene.triangles.len(), if with_base { 2 } else { 1 });
    }
}

#[test]
fn strided_and_quantised_positions_are_read() {
    let mut glb = Glb::new();
    // Normalised i16 with two bytes of padding: -32768 and -32767 both mean -1.
    let stored: [[i16; 4]; 3] = [
        [-32_768, -32_767, 0, 99],
        [32_767, 0, 0, 99],
        [0, 32_767, 16_384, 99],
    ];
    let bytes: Vec<u8> = stored
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let view = glb.view(&bytes);
    glb.json["bufferViews"][view]["byteStride"] = json!(8);
    glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let positions = glb.push(
        "accessors",
        json!({
            "bufferView": view, "componentType": 5122, "count": 3, "type": "VEC3",
            "normalized": true,
        }),
    );
    glb.place(
        json!({ "attributes": { "POSITION": positions } }),
        json!({}),
    );
    let want = [
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::X,
        Vec3::new(0.0, 1.0, 16_384.0 / 32_767.0),
    ];
    assert_eq!(glb.load().unwrap().positions, want);
}

#[test]
fn only_used_vertices_are_kept() {
    let mut glb = Glb::new();
    let many: Vec<[f32; 3]> = (0..1000).map(|i| [i as f32, (i * i) as f32, 1.0]).collect();
    let positions = glb.floats(&many);
    let mut primitives = Vec::new();
    for first in [0_u32, 500, 900] {
        let indices = glb.integers(&[first, first + 2, first + 1], 5125);
        primitives.push(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    }
    let mesh = glb.push("meshes", json!({ "name": "m", "primitives": primitives }));
    glb.root(json!({ "mesh": mesh }));
    let scene = glb.load().unwrap();
    assert_eq!(scene.positions.len(), 9);
    assert_eq!(scene.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    assert_eq!(scene.positions[4].x, 502.0);
    assert_eq!(scene.objects, ["m/0", "m/1", "m/2"]);
    assert_eq!(scene.triangle_object, [0, 1, 2]);
}

#[test]
fn nodes_are_flattened_with_their_ancestors_and_instances_are_copied() {
    let mut glb = Glb::new();
    let positions = glb.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let mesh = glb.push(
        "meshes",
        json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }),
    );
    // A quarter turn about z: x to y, y to -x.
    let turn = [0.0, 0.0, (0.5_f32).sqrt(), (0.5_f32).sqrt()];
    let child = glb.push(
        "nodes",
        json!({ "mesh": mesh, "rotation": turn, "name": "child" }),
    );
    glb.root(json!({ "translation": [10, 0, 0], "scale": [2, 2, 2], "children": [child] }));
    // Column-major: x to z, y to x, z to y, then (0, 0, 5).
    let matrix = [0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 5, 1];
    glb.root(json!({ "mesh": mesh, "matrix": matrix, "name": "by matrix" }));
    let scene = glb.load().unwrap();
    let want = [
        Vec3::new(10.0, 2.0, 0.0),
        Vec3::new(8.0, 0.0, 0.0),
        Vec3::new(10.0, 0.0, 2.0),
        Vec3::new(0.0, 0.0, 6.0),
        Vec3::new(1.0, 0.0, 5.0),
        Vec3::new(0.0, 1.0, 5.0),
    ];
    for (got, want) in scene.positions.iter().zip(want) {
        assert!((got - want).length() < 1e-6, "{got}, not {want}");
    }
    assert_eq!(scene.objects, ["child", "by matrix"]);
}

#[test]
fn other_scenes_are_left_out_and_no_scene_means_all() {
    let mut glb = Glb::new();
    let positions = glb.floats(&TETRAHEDRON);
    let indices = glb.integers(&TETRAHEDRON_FACES, 5121);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    glb.place(primitive, json!({}));
    glb.push("nodes", json!({ "mesh": 0, "translation": [9, 0, 0] }));
    glb.push("scenes", json!({ "nodes": [1] }));
    let scene = glb.load().unwrap();
    assert_eq!(scene.triangles.len(), 4);
    assert!(warns(&scene, "others are left out"));
    glb.json.as_object_mut().unwrap().remove("scenes");
    glb.json.as_object_mut().unwrap().remove("scene");
    let scene = glb.load().unwrap();
    assert_eq!(scene.triangles.len(), 8);
    assert!(warns(&scene, "no scene"));
}

#[test]
fn deep_hierarchies_do_not_recurse() {
    let mut glb = Glb::new();
    let depth = 100_000;
    for i in 1..depth {
        glb.push(
            "nodes",
            json!({ "children": [i], "translation": [0.0078125, 0, 0] }),
        );
    }
    let positions = glb.floats(&SQUARE[..3]);
    let primitives = json!([{ "attributes": { "POSITION": positions } }]);
    let mesh = glb.push("meshes", json!({ "primitives": primitives }));
    glb.push("nodes", json!({ "mesh": mesh }));
    glb.json["scenes"][0]["nodes"] = json!([0]);
    let scene = glb.load().unwrap();
    assert_eq!(scene.positions[0], Vec3::X * (depth - 1) as f32 / 128.0);
}

fn affine() -> impl Strategy<Value = ([f64; 4], [f64; 3], [f64; 3])> {
    let axis = prop_oneof![-3.0..-0.2, 0.2..3.0];
    let unit = -1.0..1.0_f64;
    let quaternion = [unit.clone(), unit.clone(), unit.clone(), unit]
        .prop_filter("has a direction", |q| {
            q.iter().map(|x| x * x).sum::<f64>() > 0.01
        });
    (
        quaternion,
        [axis.clone(), axis.clone(), axis],
        [-5.0..5.0, -5.0..5.0, -5.0..5.0],
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 256,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Mirrors, rotations and uneven scales, one below the other (which shears): the
    /// outside stays the outside, shading normals stay perpendicular to flat faces.
    #[test]
    fn transforms_keep_the_outside(outer in affine(), inner in affine()) {
        let mut glb = Glb::new();
        let triangles = TETRAHEDRON_FACES.chunks(3);
        let corners = triangles.clone().flat_map(|t| t.iter().map(|&v| TETRAHEDRON[v as usize]));
        let positions = glb.floats(&corners.collect::<Vec<_>>());
        let corner = |v: u32| Vec3::from_array(TETRAHEDRON[v as usize]);
        let normals = triangles.flat_map(|t| {
            let (a, b, c) = (corner(t[0]), corner(t[1]), corner(t[2]));
            [(b - a).cross(c - a).normalize().to_array(); 3]
        });
        let normals = glb.floats(&normals.collect::<Vec<_>>());
        let node = |(rotation, scale, translation): ([f64; 4], [f64; 3], [f64; 3])| {
            let rotation = DQuat::from_array(rotation).normalize().to_array();
            json!({ "rotation": rotation, "scale": scale, "translation": translation })
        };
        let attributes = json!({ "POSITION": positions, "NORMAL": normals });
        let child = glb.place(json!({ "attributes": attributes }), node(inner));
        let mut parent = node(outer);
        parent["children"] = json!([child]);
        glb.json["scenes"][0]["nodes"] = json!([]);
        glb.root(parent);
        let scene = glb.load().unwrap();

        let matrix = |(rotation, scale, translation): ([f64; 4], [f64; 3], [f64; 3])| {
            DAffine3::from_scale_rotation_translation(
                DVec3::from_array(scale),
                DQuat::from_array(rotation).normalize(),
                DVec3::from_array(translation),
            )
        };
        let world = matrix(outer) * matrix(inner);
        let want = world.matrix3.determinant().abs() / 6.0;
        // Coordinates reach 60 with 24 bits each; the volume sums products of three.
        let size = scene.positions.iter().map(|p| p.length()).fold(1.0, f32::max);
        let bound = 24.0 * f64::from(size).powi(3) * f64::from(f32::EPSILON);
        prop_assert!((volume(&scene) - want).abs() < bound, "{} not {want}", volume(&scene));
        for (t, triangle) in scene.triangles.iter().enumerate() {
            let cross = edge_cross(&scene, t);
            let cross_error = size * size * f32::EPSILON * 16.0;
            for &v in triangle {
                let normal = scene.normals[v as usize];
                prop_assert!((normal.length() - 1.0).abs() < 1e-6);
                let across = (normal * cross.length() - cross).length();
                prop_assert!(across < cross_error, "{normal} against {cross}");
            }
        }
    }
}

#[test]
fn a_flat_scaling_keeps_the_normals_of_the_plane() {
    let mut glb = Glb::new();
    let positions = glb.floats(&SQUARE);
    let normals = glb.floats(&[[0.0, 0.0, 1.0]; 4]);
    let indices = glb.integers(&[0, 1, 2, 0, 2, 3], 5123);
    let attributes = json!({ "POSITION": positions, "NORMAL": normals });
    let primitive = json!({ "attributes": attributes, "indices": indices });
    glb.place(primitive, json!({ "scale": [1, 1, 0] }));
    let scene = glb.load().unwrap();
    assert_eq!(scene.normals, [Vec3::Z; 4]);
    assert!(
        scene
            .warnings
            .iter()
            .all(|w| !w.message.contains("direction"))
    );
}

#[test]
fn normals_without_direction_fall_back_with_a_warning() {
    let mut glb = Glb::new();
    let positions = glb.floats(&SQUARE[..3]);
    let normals = glb.floats(&[[0.0, 0.0, 0.0], [f32::NAN, 0.0, 1.0], [0.0, 0.0, 2.0]]);
    let attributes = json!({ "POSITION": positions, "NORMAL": normals });
    glb.place(json!({ "attributes": attributes }), json!({}));
    let scene = glb.load().unwrap();
    assert_eq!(scene.normals, [Vec3::ZERO, Vec3::ZERO, Vec3::Z]);
    assert!(warns(&scene, "without direction"));
}
