//! OBJ files and their MTL libraries.

use crate::glb::{load_bytes, png};
use crate::support::{edge_cross, notes, warns};
use glam::{Vec2, Vec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rrf_materials::{DIELECTRIC, LAMBERT, PRINCIPLED};
use rrf_scene::{INVALID, LoadOptions, Scene, load};

/// A unit cube of quadrilaterals, faces outwards.
const CUBE: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf -8 -4 -1 -5\nf 2 3 7 6\n";

fn read(text: &str) -> Scene {
    load_bytes("x.obj", text.as_bytes(), &LoadOptions::default()).unwrap()
}

fn refused(text: &str) -> String {
    let result = load_bytes("x.obj", text.as_bytes(), &LoadOptions::default());
    result.unwrap_err().to_string()
}

/// The scene of an OBJ text beside a library `m.mtl` and a picture `p.png`.
fn read_with(obj: &str, mtl: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("x.obj", obj.as_bytes());
    write("m.mtl", mtl.as_bytes());
    write("p.png", &png(1, 2, &[[255, 0, 0], [0, 0, 255]]));
    load(&folder.path().join("x.obj"), &LoadOptions::default()).unwrap()
}

const TRIANGLE: &str =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.75\nusemtl a\nf 1/1 2/1 3/1\n";

#[test]
fn a_cube_is_triangulated_outwards() {
    let scene = read(CUBE);
    assert_eq!((scene.triangles.len(), scene.positions.len()), (12, 8));
    let area: f32 = (0..12).map(|t| edge_cross(&scene, t).length() / 2.0).sum();
    assert_eq!(area, 6.0);
    for (t, triangle) in scene.triangles.iter().enumerate() {
        let centre = triangle
            .map(|v| scene.positions[v as usize])
            .iter()
            .sum::<Vec3>()
            / 3.0;
        assert!(
            edge_cross(&scene, t).dot(centre - 0.5) > 0.0,
            "triangle {t}"
        );
    }
    assert_eq!(scene.normals, [Vec3::ZERO; 8]);
    let notes = notes(&scene);
    assert_eq!(notes.len(), 1);
    assert_eq!(notes[0].place, "12 triangles");
    assert_eq!(scene.materials[0].base_color, Vec3::splat(0.7));
}

#[test]
fn normals_and_coordinates_stay_with_their_corners() {
    // The second face has no texture coordinates: those of the first must not move.
    let scene = read(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.1 0.2\nvt 0.3 0.4\nvt 0.5 0.6\nvn 0 0 2\n\
         o first\nf 3//1 1//1 2//1\nf 1/1/1 2/2/1 3/3/1\n",
    );
    assert_eq!(scene.positions.len(), 6);
    assert_eq!(scene.normals, [Vec3::Z; 6]);
    let [a, b, c] = scene.triangles[1].map(|v| scene.uvs[v as usize]);
    let want = [
        Vec2::new(0.1, 0.2),
        Vec2::new(0.3, 0.4),
        Vec2::new(0.5, 0.6),
    ];
    assert_eq!([a, b, c], want);
    assert_eq!(
        scene.triangles[0].map(|v| scene.uvs[v as usize]),
        [Vec2::ZERO; 3]
    );
    assert_eq!(scene.objects, ["first", "first"]);
}

#[test]
fn lines_and_points_are_no_faces() {
    let scene = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\np 1\nf 1 2 3\n");
    assert_eq!(scene.triangles.len(), 1);
    assert!(warns(&scene, "only polygons"));
}

#[test]
fn errors_name_the_line() {
    assert!(refused("v 0 0 0\nv 1 zwei 0\n").contains("x.obj:2:1: position"));
    assert!(refused("v 0 0\n").contains("x.obj:1:1: "));
    assert!(refused("v 0 0 0\n\nvn 1\n").contains("x.obj:3:1: normal"));
    assert!(refused("v 0 0 0\nf 1 1 7\n").contains("x.obj:2:1: a face uses number 7"));
    let nan = refused("v 0 0 0\nv nan 0 0\nv 0 1 0\no N\nf 1 2 3\n");
    assert!(
        nan.contains("object \"N\": vertex 1 has the position [NaN, 0, 0]"),
        "{nan}"
    );
    assert!(refused("\u{7f}ELF\u{1}\u{2}").contains("x.obj:1:1: unknown statement"));
}

#[test]
fn materials_map_onto_lambert_and_principled() {
    let scene = read_with(
        TRIANGLE,
        "newmtl a\nKd 0.1 0.2 0.3\nNs 10\nillum 1\nKs 1 1 1\n",
    );
    let material = &scene.materials[0];
    assert_eq!((material.name.as_str(), material.kind), ("a", &LAMBERT));
    assert_eq!(material.base_color, Vec3::new(0.1, 0.2, 0.3));
    assert!(notes(&scene).is_empty(), "{:?}", scene.warnings);

    let scene = read_with(TRIANGLE, "newmtl a\nKd 0.5\nPr 0.25\nPm 1\nNi 1.5\n");
    let material = &scene.materials[0];
    assert_eq!(material.kind, &PRINCIPLED);
    assert_eq!((material.roughness, material.metallic), (0.25, 1.0));
    assert!((material.specular - 0.5).abs() < 1e-6);

    let glass = &read_with(TRIANGLE, "newmtl a\nillum 7\nNi 1.33\nTf 1 0.9 0.8\n").materials[0];
    assert_eq!((glass.kind, glass.own[0].value.x), (&DIELECTRIC, 1.33));
    assert_eq!(glass.base_color, Vec3::new(1.0, 0.9, 0.8));
    let veil = &read_with(TRIANGLE, "newmtl a\nKd 1\nd 0.25\n").materials[0];
    assert_eq!(veil.opacity.value, 0.25);

    for (mtl, part) in [
        ("newmtl a\nKd 1\nKs 0.5 0.5 0.5\nillum 2\n", "Phong"),
        ("newmtl a\nKd 1\nillum 5\n", "a mirror"),
        ("newmtl a\nKd 1\nd 0.5\n", "veil"),
        ("newmtl a\nillum 7\nNi 0\n", "Ni 0 is no index"),
        ("newmtl a\nillum 7\nNi -1.5\n", "Ni -1.5 is no index"),
        ("newmtl a\nKd 1\nPr 0.5\nNi -1\n", "Ni -1 is no index"),
        ("newmtl a\nKd 1.5\n", "base colour [1.5, 1.5, 1.5]"),
        ("newmtl a\n", "no Kd"),
        (
            "newmtl a\nKd 1\nmap_Kd gone.png\n",
            "cannot be read: gone.png",
        ),
        ("newmtl b\nKd 1\n", "\"a\" is not defined"),
    ] {
        let scene = read_with(TRIANGLE, mtl);
        assert!(warns(&scene, part), "{part}: {:?}", scene.warnings);
    }
}

#[test]
fn textures_lie_with_v_upwards() {
    let scene = read_with(TRIANGLE, "newmtl a\nKd 1\nmap_Kd p.png\nnorm p.png\n");
    let material = &scene.materials[0];
    assert_eq!(scene.uvs[0], Vec2::new(0.5, 0.75));
    let colour = scene.textures[material.base_texture as usize].sample(scene.uvs[0]);
    assert_eq!(colour, Vec3::X);
    assert_ne!(material.normal_texture, INVALID);
    assert_eq!(scene.textures.len(), 2);
    assert!(notes(&scene).is_empty(), "{:?}", scene.warnings);
}

#[test]
fn emission_becomes_an_area_light() {
    let scene = read_with(TRIANGLE, "newmtl a\nKd 0\nKe 17 12 4\n");
    assert_eq!(scene.triangle_light, [0]);
    assert_eq!(scene.area_lights[0].radiance, Vec3::new(17.0, 12.0, 4.0));
    assert!(!scene.area_lights[0].two_sided);
    assert_eq!(scene.own_light_names(), ["a"]);
    let scene = read_with(TRIANGLE, "newmtl a\nKd 0\nKe 2 2 2\nmap_Ke p.png\n");
    // The upper half of the picture is red, the lower one blue.
    assert_eq!(scene.area_lights[0].radiance, Vec3::splat(2.0));
    assert_eq!(scene.emitted_share(0, [0.25, 0.25]), Vec3::X);
    assert_eq!(scene.summary().area_lights[0].texture, Some(0));
}

#[test]
fn a_missing_library_is_a_warning_a_broken_one_an_error() {
    let scene = read("mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    assert!(
        warns(&scene, "gone.mtl: cannot be read"),
        "{:?}",
        scene.warnings
    );
    assert!(warns(&scene, "\"a\" is not defined"));
    assert_eq!(scene.materials[0].kind, &LAMBERT);
    let places: Vec<_> = notes(&scene).iter().map(|w| w.place.as_str()).collect();
    assert_eq!(places, ["x.obj:1", "x.obj:5", "1 triangles"]);

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.obj"), TRIANGLE).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl a\nKd 1 2\n").unwrap();
    let error = load(&folder.path().join("x.obj"), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("m.mtl:2:1: Kd takes"), "{error}");
}

#[test]
fn a_change_of_material_divides_an_object() {
    let scene = read_with(
        "mtllib m.mtl\no both\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n\
         usemtl a\nf 2 3 1\n",
        "newmtl a\nKd 0.1\nnewmtl b\nKd 0.2\n",
    );
    let colours: Vec<f32> = scene
        .triangle_material
        .iter()
        .map(|&m| scene.materials[m as usize].base_color.x)
        .collect();
    assert_eq!(colours, [0.1, 0.2, 0.1]);
    assert_eq!(scene.materials.len(), 2);
    assert_eq!(scene.objects, ["both", "both", "both"]);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2048,
        rng_seed: RngSeed::Fixed(13),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn flipped_bytes_never_panic(flips in prop::collection::vec((any::<usize>(), any::<u8>()), 1..6)) {
        let mut bytes = format!("{TRIANGLE}g b\nf 1 2 3\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n{CUBE}").into_bytes();
        for (position, value) in flips {
            let position = position % bytes.len();
            bytes[position] = value;
        }
        if let Ok(scene) = load_bytes("x.obj", &bytes, &LoadOptions::default()) {
            let count = scene.positions.len();
            prop_assert!(scene.triangles.iter().flatten().all(|&v| (v as usize) < count));
            prop_assert_eq!((scene.normals.len(), scene.uvs.len()), (count, count));
            prop_assert_eq!(scene.triangle_material.len(), scene.triangles.len());
        }
    }
}

#[test]
fn every_truncation_is_a_scene_or_an_error() {
    for end in 0..CUBE.len() {
        let _ = load_bytes("x.obj", &CUBE.as_bytes()[..end], &LoadOptions::default());
    }
}
