//! Media within glass.

use super::{TRIANGLE, syntax, warnings, world_v3, world_v4};
use glam::Vec3;
use rrf_materials::Bsdf;

const GREEN: &str = "MakeNamedMedium \"green\" \"string type\" \"homogeneous\" \
     \"rgb sigma_a\" [.5 .2 .4] \"rgb sigma_s\" [0 0 0] \"float scale\" 2\n";

/// Absorption fills the glass of shapes within the interface alone, clear or frosted, and no other
/// material.
#[test]
fn glass_is_filled_with_what_absorbs() {
    let scene = world_v4(&format!(
        "{GREEN} MakeNamedMaterial \"pane\" \"string type\" \"dielectric\" \
         AttributeBegin MediumInterface \"green\" \"\" NamedMaterial \"pane\" {TRIANGLE} {TRIANGLE} \
         Material \"dielectric\" \"float roughness\" .3 {TRIANGLE} Material \"diffuse\" {TRIANGLE} \
         AttributeEnd NamedMaterial \"pane\" {TRIANGLE}"
    ))
    .unwrap();
    let filled = |triangle: usize| {
        let id = scene.triangle_material[triangle] as usize;
        Bsdf::of(&scene.materials[id]).interior()
    };
    let green = Some(Vec3::new(1.0, 0.4, 0.8));
    assert_eq!(
        [filled(0), filled(1), filled(2), filled(3), filled(4)],
        [green, green, green, None, Some(Vec3::ZERO)]
    );
    assert_eq!(scene.triangle_material[0], scene.triangle_material[1]);
    assert!(!warnings(&scene).contains("left out"));
    let old = world_v3(&format!(
        "{GREEN} MediumInterface \"green\" \"\" Material \"glass\" {TRIANGLE}"
    ))
    .unwrap();
    let id = old.triangle_material[0] as usize;
    assert_eq!(Bsdf::of(&old.materials[id]).interior(), green);
}

/// Media that scatter are left out with their name, whatever the reason.
#[test]
fn what_scatters_is_left_out() {
    for (medium, words) in [
        ("\"homogeneous\" \"rgb sigma_a\" [1 1 1]", "scatters light"),
        (
            "\"homogeneous\" \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [0 1 0]",
            "scatters light",
        ),
        (
            "\"homogeneous\" \"string preset\" \"Skin1\"",
            "scatters light",
        ),
        ("\"uniformgrid\"", "is of the type \"uniformgrid\""),
    ] {
        let scene = world_v4(&format!(
            "MakeNamedMedium \"m\" \"string type\" {medium} MediumInterface \"m\" \"m\" \
             Material \"dielectric\" {TRIANGLE}"
        ))
        .unwrap();
        let text = warnings(&scene);
        assert!(text.contains(&format!("medium \"m\" {words}")), "{text}");
        let id = scene.triangle_material[0] as usize;
        let interior = Bsdf::of(&scene.materials[id]).interior();
        assert_eq!(interior, Some(Vec3::ZERO), "{medium}");
    }
}

#[test]
fn media_that_make_no_sense_are_named() {
    let (.., message) = syntax(world_v4(
        "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 -1 1] \
         \"rgb sigma_s\" [0 0 0]",
    ));
    assert!(message.contains("must not be negative"), "{message}");
    let scene = world_v4(&format!(
        "{GREEN} MediumInterface \"red\" \"green\" Material \"dielectric\" {TRIANGLE}"
    ))
    .unwrap();
    let text = warnings(&scene);
    assert!(text.contains("no medium \"red\" is known"), "{text}");
    assert!(text.contains("outside of shapes is left out"), "{text}");
}
