//! The matrices of the transform directives; points are columns, so `M * p`.

use glam::{DMat3, DMat4, DVec3};

/// `Rotate angle x y z`: a right-handed rotation in degrees; `None` for no axis.
pub(super) fn rotate(degrees: f64, axis: DVec3) -> Option<DMat4> {
    Some(DMat4::from_axis_angle(
        axis.try_normalize()?,
        degrees.to_radians(),
    ))
}

/// `LookAt`: camera from world, the camera looking along +z with +y up and +x to the right
/// (left-handed); `None` where eye, target and up do not span one.
pub(super) fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DMat4> {
    let forward = (target - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    let world_from_camera = DMat4::from_cols(
        right.extend(0.0),
        up.extend(0.0),
        forward.extend(0.0),
        eye.extend(1.0),
    );
    Some(world_from_camera.inverse())
}

/// Whether a point transform turns a right hand into a left one.
pub(super) fn swaps_handedness(m: &DMat4) -> bool {
    DMat3::from_mat4(*m).determinant() < 0.0
}

/// The matrix for normals (inverse transpose of the linear part), or `None` if singular.
pub(super) fn normal_matrix(m: &DMat4) -> Option<DMat3> {
    let linear = DMat3::from_mat4(*m);
    let inverse = linear.inverse();
    (linear.determinant() != 0.0 && inverse.is_finite()).then(|| inverse.transpose())
}

/// The axes of a transform's linear part at unit length and right angles, made so one after
/// another, and whether that took no more than one common scale from it (to a thousandth); `None`
/// if singular.
pub(super) fn orthogonal(m: &DMat4) -> Option<(DMat3, bool)> {
    let linear = DMat3::from_mat4(*m);
    let [a, b, c] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let x = a.try_normalize()?;
    let y = (b - x * x.dot(b)).try_normalize()?;
    let z = x.cross(y) * linear.determinant().signum();
    let scale = a.length();
    let rest = DMat3::from_cols(a - x * scale, b - y * scale, c - z * scale);
    let most = rest
        .to_cols_array()
        .into_iter()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    let sound = linear.determinant() != 0.0 && z.is_finite();
    sound.then_some((DMat3::from_cols(x, y, z), most <= 1e-3 * scale))
}

/// Whether the last row is 0 0 0 1 (up to scale), so that no perspective is in it.
pub(super) fn is_affine(m: &DMat4) -> bool {
    let row = m.row(3);
    row.truncate() == DVec3::ZERO && row.w == 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The view basis of a case that can be worked out by hand: from (0, 0, 5) to the origin.
    #[test]
    fn look_at_by_hand() {
        let m = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y).unwrap();
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
        near(m.transform_point3(DVec3::new(0.0, 0.0, 5.0)), DVec3::ZERO);
        near(m.transform_point3(DVec3::ZERO), DVec3::new(0.0, 0.0, 5.0));
        near(m.transform_vector3(DVec3::Y), DVec3::Y);
        // y x (-z) = -x: pbrt's camera is left-handed, so world +x goes to the image's left.
        near(m.transform_vector3(DVec3::X), DVec3::NEG_X);
        assert!(look_at(DVec3::ZERO, DVec3::ZERO, DVec3::Y).is_none());
        assert!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_none());
    }

    #[test]
    fn rotation_and_handedness() {
        let quarter = rotate(90.0, DVec3::Z).unwrap();
        assert!((quarter.transform_vector3(DVec3::X) - DVec3::Y).length() < 1e-15);
        assert!(rotate(90.0, DVec3::ZERO).is_none());
        assert!(!swaps_handedness(&quarter));
        assert!(swaps_handedness(&DMat4::from_scale(DVec3::new(
            1.0, -1.0, 1.0
        ))));
        assert!(normal_matrix(&DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
    }
}
