//! Makes a scene sound where that is possible, with warnings.

use crate::{INVALID, Material, Scene, SceneError, Warning};
use glam::Vec3;

/// Brings normals to unit length, material parameters and texels into [0, 1], and removes
/// triangles without area. Material parameters and texels that are no numbers are errors.
pub(crate) fn sanitize(scene: &mut Scene) -> Result<(), SceneError> {
    unit_normals(scene);
    clamp_materials(scene)?;
    clamp_textures(scene)?;
    remove_triangles_without_area(scene);
    Ok(())
}

/// Brings normals to unit length. A normal that is zero already means none.
fn unit_normals(scene: &mut Scene) {
    let mut without_direction = 0_usize;
    for normal in &mut scene.normals {
        if *normal == Vec3::ZERO {
            continue;
        }
        let unit = normal.as_dvec3().normalize_or_zero().as_vec3();
        without_direction += usize::from(unit == Vec3::ZERO);
        *normal = unit;
    }
    if without_direction > 0 {
        scene.warn(format!(
            "{without_direction} vertex normals have no direction: the triangles' own serve instead"
        ));
    }
}

fn clamp_materials(scene: &mut Scene) -> Result<(), SceneError> {
    let textures = scene.textures.len();
    let source = scene.source.clone();
    let mut warnings = Vec::new();
    for material in &mut scene.materials {
        let refuse = |message: &str| {
            let place = format!("material \"{}\"", material.name);
            Err(SceneError::Content {
                path: source.clone(),
                place,
                message: message.to_owned(),
            })
        };
        let numbers = [material.roughness, material.metallic, material.specular];
        let mut colours =
            std::iter::once(material.base_color).chain(material.own.iter().map(|p| p.value));
        if !colours.all(Vec3::is_finite) || !numbers.iter().all(|value| value.is_finite()) {
            return refuse("a parameter is not finite");
        }
        if (material.texture_ids()).any(|id| id != INVALID && id as usize >= textures) {
            return refuse("a texture id is out of range");
        }
        if let Some(message) = clamp_material(material) {
            let place = format!("{}: material \"{}\"", source.display(), material.name);
            warnings.push(Warning { place, message });
        }
    }
    scene.warnings.extend(warnings);
    Ok(())
}

/// Clamps a material's parameters to [0, 1]; says which it had to change.
fn clamp_material(material: &mut Material) -> Option<String> {
    let before = material.clone();
    material.base_color = before.base_color.clamp(Vec3::ZERO, Vec3::ONE);
    let mut changed = Vec::new();
    if material.base_color != before.base_color {
        changed.push(format!("base colour {}", before.base_color));
    }
    for (name, value) in [
        ("roughness", &mut material.roughness),
        ("metallic", &mut material.metallic),
        ("specular", &mut material.specular),
    ] {
        let clamped = value.clamp(0.0, 1.0);
        if clamped != *value {
            changed.push(format!("{name} {value}"));
            *value = clamped;
        }
    }
    (!changed.is_empty()).then(|| format!("clamped to [0, 1]: {}", changed.join(", ")))
}

fn clamp_textures(scene: &mut Scene) -> Result<(), SceneError> {
    let source = scene.source.clone();
    let mut warnings = Vec::new();
    for (i, texture) in scene.textures.iter_mut().enumerate() {
        let refuse = |message: &str| {
            let place = format!("texture {i}");
            Err(SceneError::Content {
                path: source.clone(),
                place,
                message: message.to_owned(),
            })
        };
        let size = u64::from(texture.width) * u64::from(texture.height);
        if size == 0 || size != texture.texels.len() as u64 {
            return refuse("it has no texels, or not width times height of them");
        }
        if !texture.texels.iter().all(|texel| texel.is_finite()) {
            return refuse("a texel is not finite");
        }
        let mut clamped = 0_usize;
        for texel in &mut texture.texels {
            let inside = texel.clamp(Vec3::ZERO, Vec3::ONE);
            clamped += usize::from(inside != *texel);
            *texel = inside;
        }
        if clamped > 0 {
            warnings.push(Warning {
                place: format!("{}: texture {i}", source.display()),
                message: format!("{clamped} of {size} texels clamped to [0, 1]"),
            });
        }
    }
    scene.warnings.extend(warnings);
    Ok(())
}

/// Whether a triangle's normal can be computed in single precision: its corners do not lie
/// on one line (to 1e-12 of the square of its longest side) nor closer than about 1e-10.
fn has_area(p: [Vec3; 3]) -> bool {
    let [a, b, c] = p.map(|p| p.as_dvec3());
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let longest = ab
        .length_squared()
        .max(ac.length_squared())
        .max(bc.length_squared());
    let cross = ab.cross(ac).length();
    cross > 1e-12 * longest && cross * cross >= f64::from(f32::MIN_POSITIVE)
}

fn remove_triangles_without_area(scene: &mut Scene) {
    let keep: Vec<bool> = scene
        .triangles
        .iter()
        .map(|triangle| {
            let corner = |i: u32| {
                scene
                    .positions
                    .get(i as usize)
                    .copied()
                    .unwrap_or(Vec3::ZERO)
            };
            has_area(triangle.map(corner))
        })
        .collect();
    let removed = keep.iter().filter(|&&keep| !keep).count();
    if removed == 0 {
        return;
    }
    fn retain<T>(column: &mut Vec<T>, keep: &[bool]) {
        let mut keep = keep.iter();
        column.retain(|_| keep.next().copied().unwrap_or(true));
    }
    retain(&mut scene.triangles, &keep);
    retain(&mut scene.triangle_material, &keep);
    retain(&mut scene.triangle_light, &keep);
    retain(&mut scene.triangle_object, &keep);
    scene.warn(format!("{removed} triangles without area are removed"));
}
