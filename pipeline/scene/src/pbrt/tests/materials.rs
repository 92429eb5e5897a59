//! What materials become, and that each approximation is named.

use super::{TRIANGLE, warnings, world_v3, world_v4};
use crate::{Material, Scene};
use glam::Vec3;
use rrf_materials::{
    CONDUCTOR, DIELECTRIC, DIFFUSE_TRANSMISSION, LAMBERT, ROUGH_DIELECTRIC, THIN_DIELECTRIC,
};

fn v3(material: &str) -> (Material, Scene) {
    first(world_v3(&format!("Material {material}\n{TRIANGLE}")).unwrap())
}

fn v4(material: &str) -> (Material, Scene) {
    first(world_v4(&format!("Material {material}\n{TRIANGLE}")).unwrap())
}

fn first(scene: Scene) -> (Material, Scene) {
    let id = scene.triangle_material[0] as usize;
    (scene.materials[id].clone(), scene)
}

/// Only the exact ones come without a word of approximation.
#[test]
fn exact_and_approximated() {
    for exact in [
        "\"matte\"",
        "\"matte\" \"rgb Kd\" [.1 .2 .3] \"float sigma\" 0",
    ] {
        let (material, scene) = v3(exact);
        assert_eq!(material.kind, &LAMBERT);
        assert!(
            !warnings(&scene).contains("approximated"),
            "{}",
            warnings(&scene)
        );
    }
    assert!(
        !warnings(&v4("\"diffuse\" \"rgb reflectance\" [.1 .2 .3]").1).contains("approximated")
    );
    for kind in [
        "plastic",
        "uber",
        "substrate",
        "translucent",
        "disney",
        "hair",
        "subsurface",
        "kdsubsurface",
        "fourier",
    ] {
        let (_, scene) = v3(&format!("\"{kind}\""));
        assert!(
            warnings(&scene).contains(&format!("scene.pbrt:3:1: material {kind} is approximated")),
            "{}",
            warnings(&scene)
        );
    }
    for kind in [
        "coateddiffuse",
        "coatedconductor",
        "measured",
        "subsurface",
        "hair",
    ] {
        let (_, scene) = v4(&format!("\"{kind}\""));
        assert!(
            warnings(&scene).contains(&format!("material {kind} is approximated")),
            "{}",
            warnings(&scene)
        );
    }
    assert!(warnings(&v3("\"matte\" \"float sigma\" 20").1).contains("Oren-Nayar with sigma 20"));
}

#[test]
fn defaults_of_pbrt() {
    assert_eq!(v3("\"matte\"").0.base_color, Vec3::splat(0.5));
    assert_eq!(v4("\"diffuse\"").0.base_color, Vec3::splat(0.5));
    let (none, _) = first(world_v4(TRIANGLE).unwrap());
    assert_eq!((none.kind, none.base_color), (&LAMBERT, Vec3::splat(0.5)));
}

/// Our alpha is roughness^2. Version 4 remaps by alpha = sqrt(r); version 3 by a polynomial
/// that meets alpha = 1.62142 at r = 1 (clamped) and, by hand, at r = 0.1, where
/// x = ln 0.1 = -2.302585: 1.62142 - 1.888016 + 0.919349 - 0.209003 + 0.018010 = 0.461760.
#[test]
fn roughness_conventions() {
    let conductor = |text: &str| v4(&format!("\"conductor\" {text}")).0.roughness;
    assert!(
        (conductor("\"float roughness\" 0.3 \"bool remaproughness\" false") - 0.3f32.sqrt()).abs()
            < 1e-6
    );
    assert!((conductor("\"float roughness\" 0.3") - 0.3f32.powf(0.25)).abs() < 1e-6);
    assert_eq!(conductor("\"float roughness\" 0"), 0.0);
    let anisotropic = conductor(
        "\"float uroughness\" 0.1 \"float vroughness\" 0.4 \"bool remaproughness\" false",
    );
    assert!((anisotropic - 0.2f32.sqrt()).abs() < 1e-6);
    let plastic = v3("\"plastic\" \"float roughness\" 0.1").0.roughness;
    assert!(
        (plastic.powi(2) - 0.461760).abs() < 1e-5,
        "{}",
        plastic.powi(2)
    );
    let plastic = v3("\"plastic\" \"float roughness\" 0.1 \"bool remaproughness\" \"false\"")
        .0
        .roughness;
    assert!((plastic.powi(2) - 0.1).abs() < 1e-6);
    let (rough, scene) = v3("\"plastic\" \"float roughness\" 1");
    assert_eq!(rough.roughness, 1.0);
    assert!(
        warnings(&scene).contains("alpha 1.621 is lowered to 1"),
        "{}",
        warnings(&scene)
    );
    assert_eq!(v3("\"disney\" \"float roughness\" 0.3").0.roughness, 0.3);
}

/// F0 = 0.08 specular: 0.04 for an index of 1.5, so 0.5; Ks scales it.
#[test]
fn specular_conventions() {
    let (coated, _) = v4("\"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3]");
    assert!((coated.specular - 0.5).abs() < 1e-6 && coated.metallic == 0.0);
    assert_eq!(coated.base_color, Vec3::new(0.1, 0.2, 0.3));
    let (plastic, _) = v3("\"plastic\" \"rgb Ks\" [.5 .5 .5]");
    assert!((plastic.specular - 0.25).abs() < 1e-6);
    let (glass, scene) = v4("\"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    assert_eq!((glass.kind, glass.own[0].value.x), (&DIELECTRIC, 1.5168));
    assert!(!warnings(&scene).contains("approximated"));
    let (frosted, _) = v3("\"glass\" \"float uroughness\" .2 \"float vroughness\" .2");
    assert_eq!(
        (frosted.kind, frosted.own[0].value.x),
        (&ROUGH_DIELECTRIC, 1.5)
    );
    let (clear, _) = v3("\"glass\" \"rgb Kr\" [.5 .5 .5] \"rgb Kt\" [1 .9 .8]");
    assert_eq!(
        (clear.kind, clear.base_color),
        (&DIELECTRIC, Vec3::new(1.0, 0.9, 0.8))
    );
    assert_eq!(clear.own[2].value, Vec3::splat(0.5));
    assert_eq!(v4("\"thindielectric\"").0.kind, &THIN_DIELECTRIC);
    let (leaf, _) = v4("\"diffusetransmission\" \"rgb transmittance\" [.1 .2 .3]");
    assert_eq!(
        (leaf.kind, leaf.own[0].value),
        (&DIFFUSE_TRANSMISSION, Vec3::new(0.1, 0.2, 0.3))
    );
    let (uber, _) = v3("\"uber\" \"rgb opacity\" [.25 .25 .25]");
    assert_eq!(uber.opacity.value, 0.25);
    let (substrate, scene) = v3("\"substrate\" \"rgb Ks\" [.5 .5 .5]");
    assert_eq!(substrate.specular, 1.0);
    assert!(warnings(&scene).contains("lowered to 0.08"));
}

/// Metals by name, by numbers and by default (copper) agree; gold is yellow.
#[test]
fn metals() {
    let (copper, _) = v4("\"conductor\"");
    let (named, _) =
        v4("\"conductor\" \"spectrum eta\" \"metal-Cu-eta\" \"spectrum k\" \"metal-Cu-k\"");
    let (rgb, _) = v3(
        "\"metal\" \"rgb eta\" [.200438 .924033 1.102212] \"rgb k\" [3.912949 2.452848 2.142188]",
    );
    assert_eq!((copper.kind, copper.metallic), (&CONDUCTOR, 1.0));
    assert_eq!((&copper.own, &copper.own), (&named.own, &rgb.own));
    let (gold, _) =
        v4("\"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"");
    assert_eq!(gold.own[0].value, Vec3::new(0.143119, 0.374957, 1.442479));
    // k = 2 sqrt(r / (1 - r)) reflects r
    let (by_reflectance, _) = v4("\"conductor\" \"rgb reflectance\" [.9 .5 .1]");
    assert_eq!(by_reflectance.own[0].value, Vec3::ONE);
    assert!(
        (by_reflectance.own[1].value - Vec3::new(6.0, 2.0, 2.0 / 3.0))
            .abs()
            .max_element()
            < 1e-4
    );
    let (mirror, _) = v3("\"mirror\"");
    assert_eq!(
        (mirror.base_color, mirror.roughness, mirror.kind),
        (Vec3::splat(0.9), 0.0, &CONDUCTOR)
    );
}

#[test]
fn colours_in_other_forms() {
    // A constant spectrum is grey; D65's XYZ is white.
    let (grey, _) = v4("\"diffuse\" \"spectrum reflectance\" [300 .4 900 .4]");
    assert!((grey.base_color - Vec3::splat(0.4)).abs().max_element() < 1e-6);
    let (white, _) = v4("\"diffuse\" \"xyz reflectance\" [.475235 .5 .544415]");
    assert!(
        (white.base_color - Vec3::splat(0.5)).abs().max_element() < 1e-3,
        "{}",
        white.base_color
    );
    let (bright, scene) = v4("\"diffuse\" \"rgb reflectance\" [1.5 .5 -1]");
    assert_eq!(bright.base_color, Vec3::new(1.0, 0.5, 0.0));
    assert!(
        warnings(&scene).contains("clamped to [0, 1]"),
        "{}",
        warnings(&scene)
    );
}

#[test]
fn mixes() {
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0]
        MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 1 0]";
    let text = format!(
        "{named} Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25 {TRIANGLE}"
    );
    let (mixed, scene) = first(world_v4(&text).unwrap());
    assert_eq!(mixed.base_color, Vec3::new(0.75, 0.25, 0.0));
    assert!(!warnings(&scene).contains("approximated"));
    let named = named
        .replace("diffuse", "matte")
        .replace("reflectance", "Kd");
    let text = format!(
        "{named} Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"float amount\" .25 {TRIANGLE}"
    );
    let (mixed, _) = first(world_v3(&text).unwrap());
    assert_eq!(mixed.base_color, Vec3::new(0.25, 0.75, 0.0));
}

/// The same unnamed material again is the same material.
#[test]
fn equal_materials_are_one() {
    let scene = world_v4(&format!("Material \"diffuse\" {TRIANGLE} Material \"diffuse\" {TRIANGLE} Material \"diffuse\" \"rgb reflectance\" [0 0 0] {TRIANGLE}")).unwrap();
    assert_eq!(scene.triangle_material, [0, 0, 1]);
}

#[test]
fn constant_textures_and_their_products() {
    let textures = "Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [.5 .5 1]
        Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"float scale\" .5
        Texture \"c\" \"spectrum\" \"mix\" \"texture tex1\" \"a\" \"texture tex2\" \"b\" \"float amount\" .5
        Texture \"d\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 1 1] \"rgb tex2\" [0 0 0]
        Texture \"r\" \"float\" \"constant\" \"float value\" .25";
    for (name, wanted) in [
        ("a", [0.5, 0.5, 1.0]),
        ("b", [0.25, 0.25, 0.5]),
        ("c", [0.375, 0.375, 0.75]),
        ("d", [0.5; 3]),
    ] {
        let text = format!(
            "{textures} Material \"diffuse\" \"texture reflectance\" \"{name}\" {TRIANGLE}"
        );
        assert_eq!(
            first(world_v4(&text).unwrap()).0.base_color,
            Vec3::from_array(wanted),
            "{name}"
        );
    }
    let text = format!(
        "{textures} Material \"conductor\" \"texture roughness\" \"r\" \"bool remaproughness\" false {TRIANGLE}"
    );
    assert_eq!(first(world_v4(&text).unwrap()).0.roughness, 0.5);
}
