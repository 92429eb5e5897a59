//! Whether a picture can be made of a view and its lights.

use crate::error::RenderError;
use rrf_trace::{Lights, View};

/// Whether a picture can be made of the view.
pub fn check_view(view: &View) -> Result<(), RenderError> {
    let (width, height) = (view.width, view.height);
    if !(1..=65_535).contains(&width) || !(1..=65_535).contains(&height) {
        return Err(RenderError::Size { width, height });
    }
    let axes = [view.right, view.up, view.forward];
    let refused = |reason| Err(RenderError::View { reason });
    if !view.eye.is_finite() {
        refused("its eye is not at a finite position")
    } else if !axes.iter().all(|a| (a.length() - 1.0).abs() < 1e-3) {
        refused("its axes are not unit vectors")
    } else if !(view.fov > 0.0 && view.fov < 180.0) {
        refused("its field of view is not between 0 and 180 degrees")
    } else {
        Ok(())
    }
}

/// Whether every light is at a place and shines finitely.
pub fn check_lights(lights: &Lights) -> Result<(), RenderError> {
    let bad = |l: &rrf_scene::PointLight| !l.position.is_finite() || !l.intensity.is_finite();
    match lights.points.iter().position(bad) {
        Some(light) => Err(RenderError::Light { light }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn views_that_show_nothing_are_refused() {
        let good = View::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 60.0, [2, 1]);
        assert!(check_view(&good).is_ok());
        let nan = Vec3::new(0.0, f32::NAN, 0.0);
        let views = [
            View::look_at(nan, Vec3::Z, Vec3::Y, 60.0, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 180.0, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, f32::NAN, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 60.0, [0, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 60.0, [1, 70_000]),
            View {
                up: Vec3::ZERO,
                ..good
            },
        ];
        for view in views {
            assert!(check_view(&view).is_err(), "{view:?}");
        }
    }
}
