//! Camera and film.

use super::fault::{Place, Read, fault};
use super::params::Params;
use super::reader::Reader;
use super::state::{Film, Version};
use crate::Camera;
use glam::DVec3;

impl Reader {
    /// `Camera`: world from camera is the inverse of the current transform; +x to the right,
    /// +y up, looking along +z.
    pub fn camera(&mut self, name: &str, at: Place, params: &Params) -> Read<()> {
        let world_from_camera = self.state.ctm.inverse();
        if !world_from_camera.is_finite() {
            return fault(params.place, "the camera's transform has no inverse");
        }
        self.systems.insert("camera".to_owned(), world_from_camera);
        match name {
            "perspective" => {}
            "orthographic" | "environment" | "spherical" | "realistic" => {
                self.warn(
                    at,
                    format!("Camera \"{name}\" is left out: only \"perspective\" is read"),
                );
                return Ok(());
            }
            _ => return fault(at, format!("unknown camera \"{name}\"")),
        }
        params.ignore(&["shutteropen", "shutterclose", "focaldistance"]);
        let fov = params.float("fov")?;
        let half = params.float("halffov")?.map(|half| 2.0 * half);
        let fov = fov.or(half).unwrap_or(90.0);
        if !(fov > 0.0 && fov < 180.0) {
            return fault(
                params.place,
                format!("a fov of {fov} degrees; it must lie between 0 and 180"),
            );
        }
        for ignored in ["screenwindow", "frameaspectratio"] {
            if let Some(place) = params.place_of(ignored) {
                self.warn(
                    place,
                    format!("\"{ignored}\" of the camera is not followed"),
                );
            }
        }
        if params.float("lensradius")?.unwrap_or(0.0) != 0.0 {
            self.warn(
                params.place,
                "the camera's lens is left out: everything is in focus",
            );
        }
        self.check_unused(params)?;
        let axis = |axis: DVec3| {
            world_from_camera
                .transform_vector3(axis)
                .normalize_or_zero()
        };
        let forward = axis(DVec3::Z);
        let up = axis(DVec3::Y);
        let right = axis(DVec3::X);
        let skew = forward
            .dot(up)
            .abs()
            .max(forward.dot(right).abs())
            .max(up.dot(right).abs());
        if skew > 1e-4 {
            self.warn(params.place, "the camera's transform is not a rotation with even scale: its axes are made square");
        }
        let up = (up - forward * forward.dot(up)).normalize_or_zero();
        let right = (right - forward * forward.dot(right) - up * up.dot(right)).normalize_or_zero();
        self.scene.cameras.push(Camera {
            name: format!("camera {}", self.scene.cameras.len() + 1),
            eye: world_from_camera.transform_point3(DVec3::ZERO).as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            fov: fov as f32,
            width: 0,
            height: 0,
        });
        Ok(())
    }

    /// `Film`: only the picture's size; `image` is version 3's word.
    pub fn film(&mut self, name: &str, params: &Params) -> Read<()> {
        match name {
            "image" => self.sees(Version::V3),
            "rgb" | "gbuffer" | "spectral" => self.sees(Version::V4),
            _ => return fault(params.place, format!("unknown film \"{name}\"")),
        }
        if let Some(place) = params.place_of("cropwindow") {
            self.warn(
                place,
                "\"cropwindow\" is not followed: the whole picture is made",
            );
        }
        let (width, height) = self.default_size();
        let size = |name: &str, default: u32| match params.integer(name)? {
            None => Ok(default),
            Some(pixels @ 1..=65_536) => Ok(pixels as u32),
            Some(pixels) => fault(
                params.place,
                format!("\"{name}\" is {pixels}; it must lie between 1 and 65536"),
            ),
        };
        let (width, height) = (size("xresolution", width)?, size("yresolution", height)?);
        self.film = Some(Film { width, height });
        Ok(())
    }

    /// pbrt's own picture sizes.
    fn default_size(&self) -> (u32, u32) {
        match self.version() {
            Version::V3 => (640, 480),
            Version::V4 => (1280, 720),
        }
    }

    /// Gives the cameras the film's size, which may stand after them.
    pub fn finish_cameras(&mut self) {
        let (width, height) = self.default_size();
        let film = self.film.unwrap_or(Film { width, height });
        for camera in &mut self.scene.cameras {
            (camera.width, camera.height) = (film.width, film.height);
        }
    }
}
