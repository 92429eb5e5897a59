//! Where a picture is taken from.

use crate::surface::Frame;
use glam::Vec3;
use rrf_scene::Camera;

/// A pinhole view. `right`, `up` and `forward` are unit and orthogonal; left-handed ones mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// World position of the eye.
    pub eye: Vec3,
    /// World direction of the picture's +x.
    pub right: Vec3,
    /// World direction of the picture's up.
    pub up: Vec3,
    /// World direction through the picture's middle.
    pub forward: Vec3,
    /// Full angle of the shorter side [degrees].
    pub fov: f32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl View {
    /// A right-handed view from `eye` to `target`, `up` upwards in the picture; `size` is
    /// width and height. Where the view has no direction it looks along -z; where `up` lies
    /// along it, some perpendicular direction is up.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, fov: f32, size: [u32; 2]) -> View {
        let forward = (target - eye).try_normalize().unwrap_or(Vec3::NEG_Z);
        let sideways = forward.cross(up.normalize_or_zero());
        let right = if sideways.length() > 1e-6 {
            sideways.normalize()
        } else {
            Frame::new(forward).x
        };
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

    /// Unit direction through a place in the picture, in pixels from its upper left corner.
    #[inline]
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        self.lens().direction(x, y)
    }

    /// What all of the view's rays share.
    pub fn lens(&self) -> Lens {
        let shorter = self.width.min(self.height) as f32;
        Lens {
            right: self.right,
            up: self.up,
            forward: self.forward,
            middle: [0.5 * self.width as f32, 0.5 * self.height as f32],
            pixel: 2.0 * (0.5 * self.fov.to_radians()).tan() / shorter,
        }
    }
}

/// A view's picture plane at distance 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the picture's width and height, in pixels.
    middle: [f32; 2],
    /// Width of a pixel on the plane.
    pixel: f32,
}

impl Lens {
    /// As [`View::direction`].
    #[inline(always)]
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let right = (x - self.middle[0]) * self.pixel;
        let up = (self.middle[1] - y) * self.pixel;
        (self.forward + self.right * right + self.up * up).normalize()
    }
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
