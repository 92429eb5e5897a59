//! Lamps that lie in the plane of another surface.

use crate::{INVALID, Scene, Warning};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Distance within which planes are one, as a share of the largest coordinate.
const SAME_PLANE: f64 = 1e-5;

/// Sine of the angle within which planes are one.
const SAME_NORMAL: f64 = 1e-4;

/// Depth below which triangles only touch, as a share of the smaller one's longest edge.
const TOUCHING: f64 = 1e-3;

/// Most triangles of lamps that are looked at.
const MOST_LAMPS: usize = 1024;

/// A triangle that shines.
struct Lamp {
    triangle: usize,
    corners: [DVec3; 3],
    normal: DVec3,
    near: f64,
}

/// Warns of lamps that share a place with a surface that does not shine: which of the two a ray
/// meets there is chance, so that part of the light is lost.
pub(crate) fn warn_of_coplanar(scene: &mut Scene) {
    let lamps: Vec<Lamp> = (0..scene.triangles.len())
        .filter(|&t| shines(scene, t))
        .take(MOST_LAMPS)
        .filter_map(|t| lamp(scene, t))
        .collect();
    if lamps.is_empty() {
        return;
    }
    let groups = by_light(scene, &lamps);
    let mut found = BTreeMap::new();
    for triangle in (0..scene.triangles.len()).filter(|&t| !shines(scene, t)) {
        let Some(corners) = scene.corners(triangle) else {
            continue;
        };
        let corners = corners.map(|p| p.as_dvec3());
        for (low, high, members) in &groups {
            if apart(corners, *low, *high) {
                continue;
            }
            if let Some(lamp) = members.iter().find(|lamp| share_a_place(lamp, corners)) {
                let light = scene.triangle_light.get(lamp.triangle);
                found.entry(light.copied()).or_insert(triangle);
            }
        }
    }
    let warnings: Vec<Warning> = found
        .into_iter()
        .filter_map(|(light, triangle)| warning(scene, light?, triangle))
        .collect();
    scene.warnings.extend(warnings);
}

fn warning(scene: &Scene, light: u32, triangle: usize) -> Option<Warning> {
    let name = scene.area_light_names.get(light as usize)?;
    let object = *scene.triangle_object.get(triangle)?;
    let object = scene.objects.get(object as usize)?;
    let material = *scene.triangle_material.get(triangle)?;
    let material = &scene.materials.get(material as usize)?.name;
    Some(Warning {
        place: format!("light \"{name}\""),
        message: format!(
            "it lies in the plane of object \"{object}\" (material \"{material}\"): part of its \
             light is lost; move one of them apart"
        ),
    })
}

fn shines(scene: &Scene, triangle: usize) -> bool {
    scene.triangle_light.get(triangle) != Some(&INVALID)
}

fn lamp(scene: &Scene, triangle: usize) -> Option<Lamp> {
    let corners = scene.corners(triangle)?.map(|p| p.as_dvec3());
    let largest = corners
        .iter()
        .fold(0.0, |l: f64, p| l.max(p.abs().max_element()));
    Some(Lamp {
        triangle,
        normal: normal(corners)?,
        corners,
        near: SAME_PLANE * largest,
    })
}

fn normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}

/// The triangles of each area light with the box around them.
fn by_light<'l>(scene: &Scene, lamps: &'l [Lamp]) -> Vec<(DVec3, DVec3, Vec<&'l Lamp>)> {
    let mut groups: BTreeMap<u32, (DVec3, DVec3, Vec<&Lamp>)> = BTreeMap::new();
    for lamp in lamps {
        let light = scene.triangle_light.get(lamp.triangle);
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY, Vec::new());
        let group = groups.entry(light.copied().unwrap_or(INVALID));
        let (low, high, members) = group.or_insert(empty);
        for p in lamp.corners {
            (*low, *high) = (low.min(p - lamp.near), high.max(p + lamp.near));
        }
        members.push(lamp);
    }
    groups.into_values().collect()
}

/// Whether a box and a triangle's do not meet.
fn apart(corners: [DVec3; 3], low: DVec3, high: DVec3) -> bool {
    let [a, b, c] = corners;
    let (least, greatest) = (a.min(b).min(c), a.max(b).max(c));
    least.cmpgt(high).any() || greatest.cmplt(low).any()
}

/// Whether a lamp and a triangle lie in one plane and overlap there.
fn share_a_place(lamp: &Lamp, corners: [DVec3; 3]) -> bool {
    let distance = |p: DVec3| (p - lamp.corners[0]).dot(lamp.normal).abs();
    // a large triangle's far corners may leave the plane by their rounding alone
    let Some(other) = normal(corners) else {
        return false;
    };
    let offset = (lamp.corners[0] - corners[0]).dot(other).abs();
    let is_near = corners.into_iter().any(|p| distance(p) <= lamp.near) || offset <= lamp.near;
    if !is_near || other.cross(lamp.normal).length() > SAME_NORMAL {
        return false;
    }
    let x = lamp.normal.any_orthonormal_vector();
    let y = lamp.normal.cross(x);
    let flat = |corners: [DVec3; 3]| corners.map(|p| DVec2::new(p.dot(x), p.dot(y)));
    overlap(flat(lamp.corners), flat(corners))
}

/// Whether two triangles of a plane share more than an edge, by separating axes.
fn overlap(a: [DVec2; 3], b: [DVec2; 3]) -> bool {
    let edges = |[a, b, c]: [DVec2; 3]| [b - a, c - b, a - c];
    let longest = |t| {
        edges(t)
            .into_iter()
            .fold(0.0, |l: f64, e| l.max(e.length()))
    };
    let least = TOUCHING * longest(a).min(longest(b));
    edges(a).into_iter().chain(edges(b)).all(|edge| {
        let Some(axis) = edge.perp().try_normalize() else {
            return true;
        };
        let span = |t: [DVec2; 3]| {
            let along = t.map(|p| p.dot(axis));
            let low = along.into_iter().fold(f64::INFINITY, f64::min);
            (low, along.into_iter().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((a0, a1), (b0, b1)) = (span(a), span(b));
        a1.min(b1) - a0.max(b0) > least
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AreaLight, Material};
    use glam::{Vec2, Vec3};

    /// A ceiling of 2 x 2 at height 2 and a lamp of 0.6 x 0.6 below, in or beside it.
    fn room(lamp: Vec3) -> Scene {
        let mut scene = Scene {
            objects: vec!["roof".into(), "bulb".into()],
            materials: vec![
                Material::lambert("white", Vec3::ONE),
                Material::lambert("black", Vec3::ZERO),
            ],
            ..Scene::default()
        };
        let light = AreaLight {
            radiance: Vec3::ONE,
            two_sided: false,
        };
        scene.add_area_light(light, "lamp".into(), INVALID);
        for (object, (corner, side)) in [(Vec3::new(-1.0, 2.0, -1.0), 2.0), (lamp, 0.6)]
            .into_iter()
            .enumerate()
        {
            let first = scene.positions.len() as u32;
            for (x, z) in [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)] {
                scene.positions.push(corner + Vec3::new(x, 0.0, z));
                scene.normals.push(Vec3::ZERO);
                scene.uvs.push(Vec2::ZERO);
            }
            for corners in [[0, 1, 2], [0, 2, 3]] {
                scene.triangles.push(corners.map(|k: u32| first + k));
                scene.triangle_object.push(object as u32);
                scene.triangle_material.push(object as u32);
                scene
                    .triangle_light
                    .push(if object == 1 { 0 } else { INVALID });
            }
        }
        scene
    }

    #[test]
    fn lamps_in_a_ceiling_are_named_with_it() {
        for (lamp, is_in) in [
            (Vec3::new(-0.3, 2.0, -0.3), true),
            (Vec3::new(-0.3, 2.0 - 1e-6, -0.3), true),
            (Vec3::new(-0.3, 1.999, -0.3), false),
            (Vec3::new(1.0, 2.0, -0.3), false),
            (Vec3::new(0.9, 2.0, 0.9), true),
        ] {
            let mut scene = room(lamp);
            warn_of_coplanar(&mut scene);
            assert_eq!(scene.warnings.len(), usize::from(is_in), "{lamp}");
            for warning in &scene.warnings {
                assert_eq!(warning.place, "light \"lamp\"");
                assert!(warning.message.contains("\"roof\" (material \"white\")"));
            }
        }
    }
}
