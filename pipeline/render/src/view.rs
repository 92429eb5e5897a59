//! Views and lights of a frame.

use crate::error::RenderError;
use glam::{Vec2, Vec3};
use rrf_lights::OwnLight;
use rrf_scene::{Camera, PointLight};

/// A pinhole view. `right`, `up` and `forward` are unit and orthogonal, of either handedness.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// World position of the eye.
    pub eye: Vec3,
    /// World direction of the image's +x.
    pub right: Vec3,
    /// World direction of the image's up.
    pub up: Vec3,
    /// World viewing direction.
    pub forward: Vec3,
    /// Full angle of the shorter image side \[degrees\].
    pub fov: f32,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
}

impl From<&Camera> for View {
    fn from(camera: &Camera) -> View {
        View {
            eye: camera.eye,
            right: camera.right,
            up: camera.up,
            forward: camera.forward,
            fov: camera.fov,
            width: camera.width,
            height: camera.height,
        }
    }
}

impl View {
    /// The right-handed view from `eye` towards `target`. Directions that do not make a view
    /// (no distance, `up` along it) are refused when the view is used.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, fov: f32, size: [u32; 2]) -> View {
        let forward = (target - eye).normalize_or_zero();
        let right = forward.cross(up).normalize_or_zero();
        View {
            eye,
            right,
            up: right.cross(forward),
            forward,
            fov,
            width: size[0],
            height: size[1],
        }
    }

    /// Whether a picture can be made of it.
    pub fn check(&self) -> Result<(), RenderError> {
        let (width, height) = (self.width, self.height);
        if !(1..=65_535).contains(&width) || !(1..=65_535).contains(&height) {
            return Err(RenderError::Size { width, height });
        }
        let axes = [self.right, self.up, self.forward];
        let refused = |reason| Err(RenderError::View { reason });
        if !self.eye.is_finite() {
            refused("its eye is not at a finite position")
        } else if !axes.iter().all(|a| (a.length() - 1.0).abs() < 1e-3) {
            refused("it has no direction: eye and target coincide, or up lies along the view")
        } else if !(self.fov > 0.0 && self.fov < 180.0) {
            refused("its field of view is not between 0 and 180 degrees")
        } else {
            Ok(())
        }
    }

    /// The unit direction through image position (x, y) in pixels from the top left corner;
    /// pixel centres lie at half integers.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        self.lens().direction(x, y)
    }

    /// The picture plane, which all of the view's rays share.
    pub fn lens(&self) -> Lens {
        let size = Vec2::new(self.width as f32, self.height as f32);
        Lens {
            right: self.right,
            up: self.up,
            forward: self.forward,
            middle: 0.5 * size,
            pixel: 2.0 * (0.5 * self.fov.to_radians()).tan() / size.min_element(),
        }
    }
}

/// A view's picture plane at distance 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// The picture's middle in pixels.
    middle: Vec2,
    /// Side of a pixel on the plane.
    pixel: f32,
}

impl Lens {
    /// As [`View::direction`].
    #[inline(always)]
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let at = (Vec2::new(x, y) - self.middle) * self.pixel;
        (self.forward + at.x * self.right - at.y * self.up).normalize()
    }
}

/// Lights of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// Point lights.
    pub points: Vec<PointLight>,
    /// The scene's own area lights shine too.
    pub area: bool,
    /// What each area light of the scene is multiplied with; none: all shine as in the scene. A model's
    /// frame needs [`crate::AreaLights::dimmed`] with it.
    pub dims: Vec<Vec3>,
    /// All other lights: spots, points with a profile, sky and sun.
    pub sources: Vec<OwnLight>,
}

impl Lights {
    /// Whether every light is at a place and shines finitely.
    pub fn check(&self) -> Result<(), RenderError> {
        let bad = |l: &PointLight| !l.position.is_finite() || !l.intensity.is_finite();
        if let Some(light) = self.points.iter().position(bad) {
            return Err(RenderError::Light { light });
        }
        for OwnLight { name, source } in &self.sources {
            source.check().map_err(|reason| RenderError::Source {
                name: name.clone(),
                reason,
            })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_of_view_spans_the_shorter_side() {
        let view = View::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 60.0, [200, 100]);
        let angle = |x, y| {
            view.direction(x, y)
                .angle_between(view.forward)
                .to_degrees()
        };
        assert!((angle(100.0, 0.0) - 30.0).abs() < 1e-3);
        assert!((angle(100.0, 100.0) - 30.0).abs() < 1e-3);
        // Twice the half width at the same distance.
        assert!(
            (angle(0.0, 50.0).to_radians().tan() - 2.0 * 30f32.to_radians().tan()).abs() < 1e-4
        );
        // Image x to the right, y down.
        assert!(view.direction(150.0, 50.0).x > 0.0);
        assert!(view.direction(100.0, 75.0).y < 0.0);
    }

    #[test]
    fn views_that_show_nothing_are_refused() {
        let good = View::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 60.0, [2, 1]);
        assert!(good.check().is_ok());
        let nan = Vec3::new(0.0, f32::NAN, 0.0);
        let views = [
            View::look_at(Vec3::ZERO, Vec3::ZERO, Vec3::Y, 60.0, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Y, Vec3::Y, 60.0, [2, 1]),
            View::look_at(nan, Vec3::Z, Vec3::Y, 60.0, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 180.0, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, f32::NAN, [2, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 60.0, [0, 1]),
            View::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 60.0, [1, 70_000]),
        ];
        for view in views {
            assert!(view.check().is_err(), "{view:?}");
        }
    }
}
