//! The columns' checks, measures and hash.

mod summary;

use crate::validate::validate;
use crate::{
    AreaLight, Camera, INVALID, LightSource, Material, MaterialKind, OwnLight, PointLight, Scene,
    SceneError, Texture, Warning,
};
use glam::{Vec2, Vec3};
use rrf_materials::{LAMBERT, PRINCIPLED};

/// A unit square of two triangles in z = 0, lit, seen and textured.
fn square() -> Scene {
    Scene {
        source: "square.test".into(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        normals: vec![Vec3::Z; 4],
        uvs: vec![Vec2::ZERO; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_material: vec![0, 1],
        triangle_light: vec![INVALID, 0],
        triangle_object: vec![0, 0],
        objects: vec!["square".into()],
        materials: vec![material("wall", &LAMBERT), material("gloss", &PRINCIPLED)],
        textures: vec![Texture {
            width: 1,
            height: 1,
            texels: vec![Vec3::ONE],
        }],
        lights: vec![OwnLight {
            name: "bulb".into(),
            source: LightSource::Point(PointLight {
                position: Vec3::Z,
                intensity: Vec3::ONE,
            }),
        }],
        area_lights: vec![AreaLight {
            radiance: Vec3::new(1.0, 2.0, 3.0),
            two_sided: true,
        }],
        area_light_names: vec!["panel".into()],
        area_light_textures: Vec::new(),
        cameras: vec![Camera {
            name: "eye".into(),
            eye: Vec3::Z,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            fov: 40.0,
            width: 4,
            height: 3,
        }],
        warnings: Vec::new(),
    }
}

fn material(name: &str, kind: &'static MaterialKind) -> Material {
    Material {
        kind,
        base_texture: 0,
        ..Material::principled(name, Vec3::splat(0.5), 0.5, 0.0, 0.5)
    }
}

/// The square's point light.
fn bulb(scene: &mut Scene) -> &mut PointLight {
    match &mut scene.lights[0].source {
        LightSource::Point(point) => point,
        other => panic!("{other:?}"),
    }
}

/// One change to a scene.
type Change = fn(&mut Scene);

#[test]
fn a_sound_scene_passes_unchanged() {
    assert_eq!(validate(square()).unwrap(), square());
}

#[test]
fn unsound_scenes_are_refused_with_their_place() {
    let cases: [(Change, &str, &str); 24] = [
        (|s| s.normals.clear(), "normals", "0 entries where 4"),
        (|s| s.uvs.push(Vec2::ZERO), "uvs", "5 entries where 4"),
        (
            |s| s.triangle_material.truncate(1),
            "triangle_material",
            "1 entries where 2",
        ),
        (
            |s| s.triangle_light.truncate(1),
            "triangle_light",
            "1 entries where 2",
        ),
        (
            |s| s.triangle_object.truncate(1),
            "triangle_object",
            "1 entries where 2",
        ),
        (
            |s| s.triangles[1] = [0, 4, 1],
            "object \"square\"",
            "vertex id 4",
        ),
        (
            |s| s.triangles[1] = [0, INVALID, 1],
            "object \"square\"",
            "vertex id",
        ),
        (
            |s| s.triangle_material[1] = 2,
            "object \"square\"",
            "material id",
        ),
        (
            |s| s.triangle_material[1] = INVALID,
            "object \"square\"",
            "material id",
        ),
        (|s| s.triangle_light[0] = 1, "object \"square\"", "light id"),
        (|s| s.triangle_object[0] = 1, "triangle 0", "object id"),
        (
            |s| s.positions[3].y = f32::NAN,
            "object \"square\"",
            "vertex 3",
        ),
        (
            |s| s.positions[3].y = f32::INFINITY,
            "object \"square\"",
            "vertex 3",
        ),
        (|s| s.positions[3].y = 1e30, "object \"square\"", "vertex 3"),
        (|s| s.uvs[0].x = f32::NAN, "object \"square\"", "vertex 0"),
        (
            |s| bulb(s).intensity.x = -1.0,
            "light \"bulb\"",
            "none negative",
        ),
        (
            |s| bulb(s).position.x = f32::NAN,
            "light \"bulb\"",
            "finite",
        ),
        (
            |s| s.area_lights[0].radiance.x = f32::INFINITY,
            "area light 0",
            "finite",
        ),
        (|s| s.cameras[0].up = Vec3::ZERO, "eye", "no length"),
        (|s| s.cameras[0].fov = 180.0, "eye", "fov 180"),
        (
            |s| s.materials[0].roughness = f32::NAN,
            "material \"wall\"",
            "not finite",
        ),
        (
            |s| s.materials[0].normal_texture = 7,
            "material \"wall\"",
            "texture id",
        ),
        (
            |s| s.textures[0].width = 2,
            "texture 0",
            "width times height",
        ),
        (
            |s| s.textures[0].texels[0].x = f32::NAN,
            "texture 0",
            "not finite",
        ),
    ];
    for (i, (change, wanted_place, words)) in cases.into_iter().enumerate() {
        let mut scene = square();
        change(&mut scene);
        match validate(scene) {
            Err(SceneError::Content {
                path,
                place,
                message,
            }) => {
                assert_eq!(
                    (path.to_str(), place.as_str()),
                    (Some("square.test"), wanted_place),
                    "{i}"
                );
                assert!(message.contains(words), "{i}: {message}");
            }
            other => panic!("{i}: {other:?}"),
        }
    }
    let mut scene = square();
    scene.positions = vec![Vec3::ZERO; 4];
    assert!(
        validate(scene)
            .unwrap_err()
            .to_string()
            .contains("no triangles")
    );
}

#[test]
fn what_can_be_mended_is_mended_with_a_warning() {
    let mut scene = square();
    scene
        .positions
        .extend([Vec3::new(2.0, 0.0, 0.0), Vec3::splat(1e-30)]);
    scene.normals.extend([Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO]);
    scene.uvs.extend([Vec2::ZERO; 2]);
    // On one line; of one point; of points too near each other.
    for flat in [[0, 1, 4], [2, 2, 3], [0, 5, 5], [0, 0, 0]] {
        scene.triangles.insert(1, flat);
        scene.triangle_material.insert(1, 0);
        scene.triangle_light.insert(1, INVALID);
        scene.triangle_object.insert(1, 0);
    }
    scene.materials[1].specular = 1.25;
    scene.materials[1].base_color.y = -0.5;
    scene.textures[0].texels[0].x = 1.5;
    scene.lights.clear();
    scene.area_lights.clear();
    scene.area_light_names.clear();
    scene.triangle_light.fill(INVALID);
    let scene = validate(scene).unwrap();
    assert_eq!(scene.triangles, square().triangles);
    assert_eq!(scene.triangle_material, [0, 1]);
    assert_eq!((scene.normals[4], scene.normals[5]), (Vec3::Z, Vec3::ZERO));
    assert_eq!(
        (scene.materials[1].specular, scene.materials[1].base_color.y),
        (1.0, 0.0)
    );
    assert_eq!(scene.textures[0].texels[0], Vec3::ONE);
    let text: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(text.len(), 4, "{text:?}");
    assert!(text[0].contains("specular 1.25") && text[0].contains("base colour"));
    assert_eq!(text[1], "1 of 1 texels clamped to [0, 1]");
    assert_eq!(text[2], "4 triangles without area are removed");
    assert!(text[3].contains("no lights"));
}

#[test]
fn normals_without_direction_become_none() {
    let mut scene = square();
    scene.normals[2] = Vec3::new(0.0, f32::NAN, 1.0);
    scene.normals[3] = Vec3::new(f32::INFINITY, 0.0, 0.0);
    let scene = validate(scene).unwrap();
    assert_eq!(scene.normals[2..], [Vec3::ZERO; 2]);
    assert!(
        scene.warnings[0]
            .message
            .starts_with("2 vertex normals have no direction")
    );
}

/// A tiny but sound triangle stays: its cross product is far above the smallest f32.
#[test]
fn small_triangles_stay() {
    let mut scene = square();
    for p in &mut scene.positions {
        *p *= 1e-7;
    }
    assert_eq!(validate(scene).unwrap().triangles.len(), 2);
}

#[test]
fn hash_sees_all_that_changes_the_light_and_nothing_else() {
    let changes: [Change; 26] = [
        |s| s.positions[0].x = 0.25,
        |s| s.normals[0].x = 0.25,
        |s| s.uvs[0].x = 0.25,
        |s| s.triangles[0] = [1, 2, 0],
        |s| s.triangle_material[0] = 1,
        |s| s.triangle_light[1] = INVALID,
        |s| s.triangle_object[1] = 1,
        |s| s.materials[0].kind = &PRINCIPLED,
        |s| s.materials[0].base_color.z = 0.25,
        |s| s.materials[0].roughness = 0.25,
        |s| s.materials[0].metallic = 0.25,
        |s| s.materials[0].specular = 0.25,
        |s| s.materials[0].base_texture = INVALID,
        |s| s.materials[0].normal_texture = 0,
        |s| s.textures[0].texels[0].x = 0.5,
        |s| {
            s.textures.push(Texture {
                width: 1,
                height: 1,
                texels: vec![Vec3::ONE],
            })
        },
        |s| bulb(s).position.x = 0.25,
        |s| bulb(s).intensity.x = 0.25,
        |s| s.area_lights[0].radiance.x = 0.25,
        |s| s.area_lights[0].two_sided = false,
        |s| s.area_light_textures = vec![0],
        |s| s.cameras[0].eye.x = 0.25,
        |s| s.cameras[0].right = Vec3::NEG_X,
        |s| s.cameras[0].fov = 41.0,
        |s| s.cameras[0].width = 5,
        |s| s.positions.push(Vec3::ZERO),
    ];
    let mut seen = vec![square().hash()];
    for (i, change) in changes.into_iter().enumerate() {
        let mut scene = square();
        change(&mut scene);
        let hash = scene.hash();
        assert!(!seen.contains(&hash), "change {i} is not seen");
        seen.push(hash);
    }
    let mut scene = square();
    scene.source = "elsewhere".into();
    scene.materials[0].name = "other".into();
    scene.objects[0] = "other".into();
    scene.warnings.push(Warning {
        place: "a".into(),
        message: "b".into(),
    });
    assert_eq!(scene.hash(), square().hash());
    assert_eq!(square().hash_hex().len(), 64);
    assert!(
        square()
            .hash_hex()
            .starts_with(&format!("{:02x}", square().hash()[0]))
    );
}

#[test]
fn measures() {
    let scene = square();
    assert_eq!(
        (
            scene.triangle_area(0),
            scene.triangle_area(1),
            scene.triangle_area(2)
        ),
        (0.5, 0.5, 0.0)
    );
    let bounds = scene.bounds().unwrap();
    assert_eq!((bounds.min, bounds.max), ([0.0; 3], [1.0, 1.0, 0.0]));
    assert_eq!(
        (bounds.center(), bounds.diagonal()),
        (Vec3::new(0.5, 0.5, 0.0), 2f32.sqrt())
    );
    assert!(bounds.contains(Vec3::ZERO) && !bounds.contains(Vec3::Z));
    assert_eq!(Scene::default().bounds(), None);
}
