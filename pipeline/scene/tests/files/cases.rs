//! Files as other programs write them: each failed once.

use crate::support::{edge_cross, repository, warns};
use glam::Vec3;
use rrf_scene::{INVALID, LoadOptions, Scene, load};

fn case(name: &str) -> Result<Scene, String> {
    let path = repository("tests/data/cases").join(name);
    load(&path, &LoadOptions::default()).map_err(|error| error.to_string())
}

fn read(name: &str) -> Scene {
    case(name).unwrap()
}

fn area(scene: &Scene) -> f32 {
    let count = scene.triangles.len();
    (0..count)
        .map(|t| edge_cross(scene, t).length() / 2.0)
        .sum()
}

const RED: Vec3 = Vec3::new(0.8, 0.1, 0.1);

#[test]
fn marks_of_byte_order_are_taken_off() {
    for name in ["obj/bom/a.obj", "gltf/bom/a.gltf"] {
        let scene = read(name);
        assert_eq!(scene.triangles.len(), 2, "{name}");
        assert_eq!(scene.materials[0].base_color, RED, "{name}");
    }
}

#[test]
fn names_in_old_code_pages_stay_apart() {
    let scene = read("obj/cp1251/a.obj");
    let colours: Vec<Vec3> = scene.materials.iter().map(|m| m.base_color).collect();
    assert_eq!(
        colours,
        [RED, Vec3::new(0.1, 0.8, 0.1), Vec3::new(0.1, 0.1, 0.8)]
    );
}

#[test]
fn concave_faces_keep_their_area() {
    let scene = read("obj/dart/a.obj");
    assert!((area(&scene) - 1.8).abs() < 1e-6, "{}", area(&scene));
}

#[test]
fn libraries_are_found() {
    for name in ["obj/twolibs/a.obj", "obj/libback/a.obj"] {
        assert_eq!(read(name).materials[0].base_color, RED, "{name}");
    }
}

#[test]
fn pictures_are_found_and_decoded() {
    for name in ["obj/texcase/a.obj", "obj/tga.obj", "obj/kd0.obj"] {
        let scene = read(name);
        assert_eq!(scene.textures.len(), 1, "{name}: {:?}", scene.warnings);
        assert_eq!(scene.materials[0].base_color, Vec3::ONE, "{name}");
    }
}

#[test]
fn every_kind_of_picture_is_read() {
    use image::ImageFormat::{Bmp, Tga, WebP};
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &str| std::fs::write(folder.path().join(name), bytes).unwrap();
    let picture = image::RgbImage::from_pixel(3, 2, image::Rgb([255, 0, 51]));
    for (name, format) in [("a.tga", Tga), ("a.bmp", Bmp), ("a.webp", WebP)] {
        picture
            .save_with_format(folder.path().join(name), format)
            .unwrap();
        write("m.mtl", &format!("newmtl a\nKd 1\nmap_Kd {name}\n"));
        write(
            "a.obj",
            "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n",
        );
        let scene = load(&folder.path().join("a.obj"), &LoadOptions::default()).unwrap();
        let texel = scene.textures[0].texels[0];
        let want = Vec3::new(1.0, 0.0, 0.033_104_766);
        assert!((texel - want).abs().max_element() < 1e-6, "{name}: {texel}");
    }
}

#[test]
fn lost_textures_are_found_by_name() {
    let scene = read("bake/lost_textures/a.obj");
    assert_eq!(scene.textures.len(), 1);
    assert!(
        warns(&scene, "wall.png is read from"),
        "{:?}",
        scene.warnings
    );
}

/// In each format, all lost pictures are named at once and leave the default albedo.
#[test]
fn lost_textures_leave_the_default_albedo() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &str| std::fs::write(folder.path().join(name), bytes).unwrap();
    write(
        "m.mtl",
        "newmtl a\nKd 1\nmap_Kd x.png\nnewmtl b\nKd 0.5\nmap_Kd y.png\nnorm x.png\n",
    );
    write(
        "a.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n",
    );
    let shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    let material = |name: &str, scale: f32| {
        format!(
            "Texture \"{name}\" \"spectrum\" \"imagemap\" \"string filename\" \"{name}.png\" \
             \"float scale\" {scale} Material \"diffuse\" \"texture reflectance\" \"{name}\"\n{shape}\n"
        )
    };
    write(
        "a.pbrt",
        &format!("WorldBegin\n{}{}", material("x", 1.0), material("y", 0.5)),
    );
    for name in ["a.obj", "a.pbrt"] {
        let scene = load(&folder.path().join(name), &LoadOptions::default()).unwrap();
        let colours: Vec<Vec3> = scene.materials.iter().map(|m| m.base_color).collect();
        assert_eq!(colours, [Vec3::splat(0.7), Vec3::splat(0.35)], "{name}");
        assert_eq!(scene.textures.len(), 0);
        let lost = scene
            .warnings
            .iter()
            .filter(|w| w.message.contains("cannot be read"));
        let messages: Vec<&str> = lost.map(|w| w.message.as_str()).collect();
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(
            messages[0].starts_with("2 pictures cannot be read: x.png ("),
            "{messages:?}"
        );
        assert!(messages[0].contains("y.png ("), "{messages:?}");
    }
}

#[test]
fn gltf_as_others_write_it() {
    let scene = read("gltf/tex_nosource/a.gltf");
    assert_ne!(scene.materials[0].base_texture, INVALID);
    let scene = read("gltf/matrix_rounded/a.gltf");
    assert!((area(&scene) - 1.0).abs() < 1e-6);
    assert_eq!(area(&read("gltf/uri_rawpct20/a.gltf")), 1.0);
    let error = case("gltf/BoxDraco.gltf").unwrap_err();
    assert!(
        error.contains("Draco") && error.contains("gltf-transform"),
        "{error}"
    );
}

#[test]
fn pbrt_as_others_write_it() {
    let scene = read("pbrt/undefined_named/a.pbrt");
    assert_eq!(scene.materials[0].base_color, Vec3::splat(0.5));
    assert!(warns(&scene, "no material \"Sun_Light\" is known"));
    for name in ["pbrt/gz/s.pbrt", "pbrt/inc/s.pbrt"] {
        assert_eq!(area(&read(name)), 0.5, "{name}");
    }
    let scene = read("pbrt/nest.pbrt");
    assert_eq!(area(&scene), 0.5);
    assert!(warns(&scene, "AttributeEnd inside ObjectBegin"));
}

#[test]
fn a_scene_too_far_from_the_origin_is_refused() {
    let error = case("bake/t5e6/a.obj").unwrap_err();
    assert!(
        error.contains("2 wide") && error.contains("move it to the origin"),
        "{error}"
    );
}

#[test]
fn a_lamp_in_the_plane_of_the_ceiling_is_said() {
    let scene = read("bake/coplanar_lamp/a.obj");
    let found = scene.warnings.iter().find(|w| w.place == "light \"lamp\"");
    let message = &found.unwrap().message;
    assert!(message.contains("(material \"ceil\")"), "{message}");
}

/// Every scene may be packed.
#[test]
fn packed_scenes_are_read() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj.gz");
    let file = std::fs::File::create(&path).unwrap();
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::default());
    packed
        .write_all(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        .unwrap();
    packed.finish().unwrap();
    let scene = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(area(&scene), 0.5);
}
