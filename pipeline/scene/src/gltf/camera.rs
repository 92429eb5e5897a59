//! Perspective cameras.

use super::document::{Document, place};
use super::nodes::Placed;
use super::output::Output;
use crate::{Camera, SceneError};
use ::gltf::json::camera::Perspective;
use glam::{DAffine3, DVec3};

/// Pixels along the longer image side: glTF gives an aspect ratio, no size.
const LONGER_SIDE: f64 = 1024.0;

/// Adds a node's camera.
pub(super) fn add(
    document: &Document,
    placed: &Placed,
    output: &mut Output,
) -> Result<(), SceneError> {
    let warnings = &mut output.warnings;
    let Some((index, camera)) = placed
        .node
        .camera
        .and_then(|index| Some((index.value(), document.root.get(index)?)))
    else {
        return Ok(());
    };
    let place = place("camera", index, camera.name.as_deref());
    let Some(perspective) = &camera.perspective else {
        warnings.add(
            place,
            "orthographic camera left out: only perspective is read",
        );
        return Ok(());
    };
    let Some([right, up, forward]) = axes(&placed.world) else {
        warnings.add(place, "camera left out: its node's transform is flat");
        return Ok(());
    };
    let (fov, width, height) =
        lens(perspective).map_err(|message| document.error(place, message))?;
    let name = placed.node.name.as_ref().or(camera.name.as_ref());
    output.scene.cameras.push(Camera {
        name: name.cloned().unwrap_or_else(|| format!("camera {index}")),
        eye: placed.world.translation.as_vec3(),
        right: right.as_vec3(),
        up: up.as_vec3(),
        forward: forward.as_vec3(),
        fov: fov as f32,
        width,
        height,
    });
    Ok(())
}

/// Right, up and forward: a glTF camera looks along -z with +y up. Scaling does not change
/// the view, shear is taken out, a mirror leaves the axes left-handed.
fn axes(world: &DAffine3) -> Option<[DVec3; 3]> {
    let forward = (-world.matrix3.z_axis).try_normalize()?;
    let up = world.matrix3.y_axis.reject_from_normalized(forward);
    let up = up.try_normalize()?;
    let right = forward.cross(up);
    let side = right.dot(world.matrix3.x_axis);
    (side != 0.0).then(|| [right * side.signum(), up, forward])
}

/// Full angle of the shorter side in degrees, width and height in pixels, or a message.
fn lens(perspective: &Perspective) -> Result<(f64, u32, u32), String> {
    let yfov = f64::from(perspective.yfov);
    let aspect = f64::from(perspective.aspect_ratio.unwrap_or(1.0));
    if !(yfov > 0.0 && yfov < std::f64::consts::PI) {
        return Err(format!("yfov {yfov} must be between 0 and pi"));
    }
    if !(aspect > 0.0 && aspect.is_finite()) {
        return Err(format!("aspect ratio {aspect} must be positive"));
    }
    let shorter = |longer: f64| longer.round().max(1.0) as u32;
    let longer = LONGER_SIDE as u32;
    Ok(if aspect >= 1.0 {
        (yfov.to_degrees(), longer, shorter(LONGER_SIDE / aspect))
    } else {
        let xfov = 2.0 * (aspect * (yfov / 2.0).tan()).atan();
        (xfov.to_degrees(), shorter(LONGER_SIDE * aspect), longer)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat};

    fn lens_of(yfov: f32, aspect_ratio: Option<f32>) -> Result<(f64, u32, u32), String> {
        lens(&Perspective {
            aspect_ratio,
            yfov,
            zfar: None,
            znear: 0.1,
            extensions: None,
            extras: None,
        })
    }

    #[test]
    fn the_shorter_side_carries_the_angle() {
        let right_angle = std::f32::consts::FRAC_PI_2;
        let (fov, width, height) = lens_of(right_angle, Some(2.0)).unwrap();
        assert!((fov - 90.0).abs() < 1e-5);
        assert_eq!((width, height), (1024, 512));
        // Upright at tan 45° = 1 vertically: tan is 1/2 horizontally.
        let (fov, width, height) = lens_of(right_angle, Some(0.5)).unwrap();
        assert!((fov - 2.0 * 0.5_f64.atan().to_degrees()).abs() < 1e-5);
        assert_eq!((width, height), (512, 1024));
        assert_eq!(lens_of(1.0, None).unwrap().1, 1024);
        assert_eq!(lens_of(1.0, Some(1e-30)).unwrap().1, 1);
        for bad in [0.0, -1.0, 4.0, f32::NAN, f32::INFINITY] {
            assert!(lens_of(bad, None).is_err());
        }
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(lens_of(1.0, Some(bad)).is_err());
        }
    }

    #[test]
    fn axes_are_orthonormal_after_scale_and_shear_and_keep_a_mirror() {
        let rotation = DMat3::from_quat(DQuat::from_xyzw(0.1, 0.7, -0.2, 0.6).normalize());
        let shear = DMat3::from_cols(
            DVec3::new(2.0, 0.0, 0.0),
            DVec3::new(0.5, 3.0, 0.25),
            DVec3::new(0.0, 0.0, 0.5),
        );
        for mirror in [1.0, -1.0] {
            let mirrored = DMat3::from_diagonal(DVec3::new(mirror, 1.0, 1.0));
            let world = DAffine3::from_mat3(rotation * shear * mirrored);
            let [right, up, forward] = axes(&world).unwrap();
            assert!((right.length() - 1.0).abs() < 1e-12);
            assert!(right.dot(up).abs() + up.dot(forward).abs() < 1e-12);
            assert!((forward + rotation.z_axis).length() < 1e-12);
            assert!(right.dot(world.matrix3.x_axis) > 0.0);
            assert!((right.cross(up).dot(-forward) - mirror).abs() < 1e-12);
        }
        assert!(axes(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
    }
}
