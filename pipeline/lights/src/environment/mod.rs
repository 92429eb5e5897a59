//! The environment: radiance from every direction, constant or by a map.

mod distribution;
mod map;
mod mapping;
mod portal;

pub use map::EnvironmentMap;
pub use mapping::Mapping;
pub use portal::Portal;

use crate::error::{LightError, check_colour};
use crate::kind::{Arrival, LightKind, MitsubaLight, hash_vectors, mitsuba_rgb, triple};
use crate::warp::{UNIFORM_SPHERE_DENSITY, uniform_sphere};
use glam::Vec3;
use std::f32::consts::PI;

/// Light from infinitely far away, from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Radiance [W/(sr m²)] of a constant sky; what a map is multiplied with.
    pub radiance: Vec3,
    /// The map, if the sky is not constant.
    pub map: Option<EnvironmentMap>,
    /// Rectangles that the sky is seen through: half of the samples go there, from all points
    /// that see one. They guide and hide nothing.
    pub portals: Vec<Portal>,
}

/// Share of the samples that go through portals.
const PORTAL_SHARE: f32 = 0.5;

impl Environment {
    /// A sky that is everywhere the same.
    pub fn constant(radiance: Vec3) -> Environment {
        Environment {
            radiance,
            map: None,
            portals: Vec::new(),
        }
    }

    /// A sky by a map.
    pub fn of_map(map: EnvironmentMap) -> Environment {
        Environment {
            map: Some(map),
            ..Environment::constant(Vec3::ONE)
        }
    }

    /// Solid angles of all portals from a point, added up.
    fn open(&self, at: Vec3) -> f64 {
        self.portals.iter().map(|p| p.solid_angle(at)).sum()
    }

    /// Density of the sampler that does not know portals.
    fn unguided_density(&self, toward: Vec3) -> f32 {
        match &self.map {
            Some(map) => map.density(toward),
            None => UNIFORM_SPHERE_DENSITY,
        }
    }

    fn density_through(&self, open: f64, at: Vec3, toward: Vec3) -> f32 {
        let unguided = self.unguided_density(toward);
        if open <= 0.0 {
            return unguided;
        }
        let met = self.portals.iter().filter(|p| p.hit(at, toward).is_some());
        let guided = met.count() as f32 / open as f32;
        PORTAL_SHARE * guided + (1.0 - PORTAL_SHARE) * unguided
    }

    /// A direction through a portal, portals by the solid angle that they cover.
    fn through_portal(&self, open: f64, at: Vec3, u: [f32; 2]) -> Option<Vec3> {
        let mut left = f64::from(u[0]) * open;
        for portal in &self.portals {
            let angle = portal.solid_angle(at);
            if left < angle {
                return Some(portal.sample(at, [(left / angle) as f32, u[1]])?.0);
            }
            left -= angle;
        }
        None
    }
}

impl LightKind for Environment {
    const NAME: &'static str = "environment";

    fn check(&self) -> Result<(), LightError> {
        check_colour("radiance", self.radiance)
    }

    /// By the map's light, or uniform over the sphere for a constant sky; where portals are in
    /// sight, half of the samples go through them.
    fn sample(&self, at: Vec3, u: [f32; 2]) -> Option<Arrival> {
        let open = self.open(at);
        let mut u = u;
        let toward = if open > 0.0 && u[0] < PORTAL_SHARE {
            self.through_portal(open, at, [u[0] / PORTAL_SHARE, u[1]])?
        } else {
            if open > 0.0 {
                u[0] = (u[0] - PORTAL_SHARE) / (1.0 - PORTAL_SHARE);
            }
            match &self.map {
                Some(map) => map.sample(u)?.0,
                None => uniform_sphere(u),
            }
        };
        let density = self.density_through(open, at, toward);
        (density > 0.0).then(|| Arrival {
            toward,
            distance: f32::INFINITY,
            irradiance: self.radiance(toward) / density,
            density: Some(density),
        })
    }

    fn radiance(&self, toward: Vec3) -> Vec3 {
        match &self.map {
            Some(map) => self.radiance * map.radiance(toward),
            None => self.radiance,
        }
    }

    fn is_visible(&self) -> bool {
        true
    }

    fn density(&self, at: Vec3, toward: Vec3) -> f32 {
        self.density_through(self.open(at), at, toward)
    }

    /// π R² ∫ L dω through a sphere of radius R.
    fn power(&self, scene_radius: f32) -> Vec3 {
        let all = match &self.map {
            Some(map) => map.integral(|_| 1.0),
            None => Vec3::splat(4.0 * PI),
        };
        self.radiance * all * (PI * scene_radius * scene_radius)
    }

    fn dimmed(&self, factor: Vec3) -> Environment {
        Environment {
            radiance: self.radiance * factor,
            ..self.clone()
        }
    }

    fn words(&self, sink: &mut dyn FnMut(u32)) {
        hash_vectors(&[self.radiance], sink);
        if let Some(map) = &self.map {
            map.words(sink);
        }
        for portal in &self.portals {
            hash_vectors(&portal.corners(), sink);
        }
    }

    fn summary(&self) -> String {
        let mut line = match &self.map {
            None => format!("constant, {} W/(sr m²)", triple(self.radiance)),
            Some(map) => {
                let [width, height] = map.size();
                let mean = map.integral(|_| 1.0) / (4.0 * PI) * self.radiance;
                format!("map of {width} x {height}, mean {} W/(sr m²)", triple(mean))
            }
        };
        if !self.portals.is_empty() {
            line += &format!(", {} portals", self.portals.len());
        }
        line
    }

    fn mitsuba(&self, picture: &str) -> MitsubaLight {
        match &self.map {
            None => MitsubaLight {
                xml: format!(
                    "<emitter type=\"constant\">\n{}</emitter>\n",
                    mitsuba_rgb("radiance", self.radiance)
                ),
                ..MitsubaLight::default()
            },
            Some(map) => MitsubaLight {
                xml: format!(
                    "<emitter type=\"envmap\">\n\
                     <string name=\"filename\" value=\"{picture}\"/>\n</emitter>\n"
                ),
                picture: Some(map.panorama(self.radiance)),
                note: None,
            },
        }
    }
}
