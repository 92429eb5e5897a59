//! Requirements on every scene, whatever its format.

use crate::coplanar::warn_of_coplanar;
use crate::sanitize::sanitize;
use crate::{INVALID, Scene, SceneError};
use glam::{Vec2, Vec3};
use std::collections::HashSet;

/// Checks a scene that a reader made and sanitizes it, with warnings.
///
/// Errors: columns of unequal length; positions, texture coordinates, lights or cameras that
/// are not finite; ids out of range; negative light; no triangles. Sanitized: triangles without
/// area are removed; material parameters and texels are clamped to [0, 1]; normals are
/// brought to unit length, and those without direction become the zero vector.
pub(crate) fn validate(mut scene: Scene) -> Result<Scene, SceneError> {
    check_columns(&scene)?;
    check_triangles(&scene)?;
    check_vertices(&scene)?;
    check_origin(&mut scene)?;
    check_lights(&scene)?;
    check_cameras(&scene)?;
    sanitize(&mut scene)?;
    if scene.triangles.is_empty() {
        return refuse(
            &scene,
            "the scene",
            "it has no triangles (with an area); a bake needs surfaces",
        );
    }
    if !scene.has_own_lights() {
        let message = "the scene has no lights of its own; a picture of it needs --light or --sky";
        scene.warn(message);
    }
    warn_of_coplanar(&mut scene);
    if absorbs_nothing(&scene) {
        let message = "no surface absorbs light: in a closed room it never ends, and paths are \
                       cut by chance after 128 reflections; lower the reflectance";
        scene.warn(message);
    }
    Ok(scene)
}

fn refuse<T>(
    scene: &Scene,
    place: impl Into<String>,
    message: impl Into<String>,
) -> Result<T, SceneError> {
    Err(SceneError::Content {
        path: scene.source.clone(),
        place: place.into(),
        message: message.into(),
    })
}

/// Whether every surface reflects all light in some channel.
fn absorbs_nothing(scene: &Scene) -> bool {
    const ALL: f32 = 0.999;
    let reflects_all = |&id: &u32| {
        let material = scene.materials.get(id as usize);
        material.is_some_and(|m| m.base_texture == INVALID && m.base_color.max_element() >= ALL)
    };
    !scene.triangle_material.is_empty() && scene.triangle_material.iter().all(reflects_all)
}

/// The name of a triangle's object, for messages.
fn object_of(scene: &Scene, triangle: usize) -> String {
    let object = scene.triangle_object.get(triangle);
    match object.and_then(|&object| scene.objects.get(object as usize)) {
        Some(name) => format!("object \"{name}\""),
        None => format!("triangle {triangle}"),
    }
}

fn check_columns(scene: &Scene) -> Result<(), SceneError> {
    let vertices = scene.positions.len();
    let triangles = scene.triangles.len();
    if vertices >= INVALID as usize || triangles >= INVALID as usize {
        return refuse(
            scene,
            "the scene",
            "it has 2^32 - 1 vertices or triangles or more; simplify it",
        );
    }
    for (column, length, wanted) in [
        ("normals", scene.normals.len(), vertices),
        ("uvs", scene.uvs.len(), vertices),
        (
            "triangle_material",
            scene.triangle_material.len(),
            triangles,
        ),
        ("triangle_light", scene.triangle_light.len(), triangles),
        ("triangle_object", scene.triangle_object.len(), triangles),
        (
            "area_light_names",
            scene.area_light_names.len(),
            scene.area_lights.len(),
        ),
    ] {
        if length != wanted {
            return refuse(
                scene,
                column,
                format!("{length} entries where {wanted} are needed"),
            );
        }
    }
    Ok(())
}

fn check_triangles(scene: &Scene) -> Result<(), SceneError> {
    let vertices = scene.positions.len();
    for (i, triangle) in scene.triangles.iter().enumerate() {
        if let Some(id) = triangle.iter().find(|&&id| id as usize >= vertices) {
            let message = format!(
                "triangle {i} has the vertex id {id}, but the scene has {vertices} vertices"
            );
            return refuse(scene, object_of(scene, i), message);
        }
    }
    let in_range = |ids: &[u32], count: usize, may_lack: bool| {
        ids.iter()
            .position(|&id| id as usize >= count && !(may_lack && id == INVALID))
    };
    for (what, found) in [
        (
            "material",
            in_range(&scene.triangle_material, scene.materials.len(), false),
        ),
        (
            "light",
            in_range(&scene.triangle_light, scene.area_lights.len(), true),
        ),
        (
            "object",
            in_range(&scene.triangle_object, scene.objects.len(), false),
        ),
    ] {
        if let Some(i) = found {
            return refuse(
                scene,
                object_of(scene, i),
                format!("triangle {i} has a {what} id out of range"),
            );
        }
    }
    Ok(())
}

/// Whether a vertex can be computed with.
fn sound(position: Vec3, uv: Vec2) -> bool {
    // A product of two differences of positions must stay in single precision.
    const FARTHEST: f32 = 1e15;
    position.abs().max_element() <= FARTHEST && position.is_finite() && uv.is_finite()
}

fn check_vertices(scene: &Scene) -> Result<(), SceneError> {
    let bad = scene
        .positions
        .iter()
        .zip(&scene.uvs)
        .position(|(&p, &uv)| !sound(p, uv));
    let Some(vertex) = bad else {
        return Ok(());
    };
    let of = |triangle: &[u32; 3]| triangle.contains(&(vertex as u32));
    let place = match scene.triangles.iter().position(of) {
        Some(triangle) => object_of(scene, triangle),
        None => format!("vertex {vertex}"),
    };
    let (p, uv) = (scene.positions.get(vertex), scene.uvs.get(vertex));
    let message = format!(
        "vertex {vertex} has the position {} and texture coordinates {}: not finite, or beyond 1e15",
        p.copied().unwrap_or(Vec3::NAN),
        uv.copied().unwrap_or(Vec2::NAN)
    );
    refuse(scene, place, message)
}

/// Refuses a scene so far from the origin that single precision loses its shape, and warns
/// of one that loses details.
fn check_origin(scene: &mut Scene) -> Result<(), SceneError> {
    // Steps of a coordinate in a scene's greatest extent: fewer leave no shape, or no details.
    const FEWEST: f32 = 2e3;
    const FEW: f32 = 5e4;
    let used = || {
        let ids = scene.triangles.iter().flatten();
        ids.filter_map(|&id| scene.positions.get(id as usize))
    };
    let low = used().fold(Vec3::MAX, |low, &p| low.min(p));
    let high = used().fold(Vec3::MIN, |high, &p| high.max(p));
    let extent = (high - low).max_element();
    let distance = low.abs().max(high.abs()).max_element();
    let step = distance * f32::EPSILON;
    if extent.is_nan() || extent <= 0.0 || step * FEW <= extent {
        return Ok(());
    }
    let message = format!(
        "it is {extent} wide and lies {distance} from the origin, where single precision has \
         steps of {step:.1e}; move it to the origin"
    );
    if step * FEWEST > extent {
        return refuse(scene, "the scene", message);
    }
    scene.warn(format!("the scene loses details: {message}"));
    Ok(())
}

fn check_lights(scene: &Scene) -> Result<(), SceneError> {
    let good = |v: Vec3| v.is_finite() && v.min_element() >= 0.0;
    for light in &scene.lights {
        let place = || format!("light \"{}\"", light.name);
        if let Err(error) = light.source.check() {
            return refuse(scene, place(), error.to_string());
        }
        if let Some(position) = light.source.position().filter(|&p| !sound(p, Vec2::ZERO)) {
            let message = format!("it stands at {position}, beyond 1e15");
            return refuse(scene, place(), message);
        }
    }
    check_names(scene)?;
    let textures = scene.textures.len();
    let lost = |&&id: &&u32| id != INVALID && id as usize >= textures;
    if scene.area_light_textures.iter().any(|id| lost(&id)) {
        return refuse(scene, "area light", "its texture's id is out of range");
    }
    for (i, light) in scene.area_lights.iter().enumerate() {
        if !good(light.radiance) {
            let message = format!(
                "radiance {}: it must be finite and not negative",
                light.radiance
            );
            return refuse(scene, format!("area light {i}"), message);
        }
    }
    Ok(())
}

/// Names of lights that are no surface are their own; area lights may share theirs.
fn check_names(scene: &Scene) -> Result<(), SceneError> {
    let mut seen: HashSet<&String> = scene.area_light_names.iter().collect();
    match scene.lights.iter().find(|light| !seen.insert(&light.name)) {
        Some(light) => refuse(
            scene,
            format!("light \"{}\"", light.name),
            "another light has this name",
        ),
        None => Ok(()),
    }
}

fn check_cameras(scene: &Scene) -> Result<(), SceneError> {
    for camera in &scene.cameras {
        let basis = [camera.right, camera.up, camera.forward];
        let unit = basis
            .iter()
            .all(|axis| axis.is_finite() && (axis.length() - 1.0).abs() < 1e-3);
        if !unit || !sound(camera.eye, Vec2::ZERO) {
            return refuse(
                scene,
                camera.name.clone(),
                "its position or axes are not finite, or an axis has no length",
            );
        }
        if !(camera.fov > 0.0 && camera.fov < 180.0) || camera.width == 0 || camera.height == 0 {
            let message = format!(
                "fov {} degrees, {} x {} pixels; 0 < fov < 180 and a size above 0 are needed",
                camera.fov, camera.width, camera.height
            );
            return refuse(scene, camera.name.clone(), message);
        }
    }
    Ok(())
}
