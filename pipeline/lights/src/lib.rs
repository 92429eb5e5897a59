//! Lights: emission, sampler and density of every kind beside each other.
//!
//! [`LightSource`] lists the kinds that are not part of the surface: points ([`PointLight`],
//! [`GoniometricLight`] by picture or IES profile, [`SpotLight`]), the sun ([`DistantLight`])
//! and the sky ([`Environment`]). Each is a file with a [`LightKind`] and a line in that list:
//! its samplers, power, hash, summary and Mitsuba export follow from it. Triangles that shine are
//! an [`AreaLight`] each group, chosen by [`EmittingTriangles`].
//!
//! Densities are with respect to solid angle [1/sr], or to area [1/m²] for triangles. This
//! crate knows neither scenes nor rays: readers make lights, a tracer asks for arrivals and sees
//! whether something stands in the way.
//!
//! ```
//! use glam::Vec3;
//! use rrf_lights::{DistantLight, LightKind, sky_direction};
//!
//! let sun = DistantLight::sun(sky_direction(90.0, 30.0), Vec3::ONE);
//! let arrival = sun.sample(Vec3::ZERO, [0.5, 0.5]).expect("the sun shines everywhere");
//! // a level plane gets sin 30° of what a plane facing the sun gets
//! let irradiance = arrival.irradiance * arrival.toward.y;
//! assert!((irradiance.x - 0.5).abs() < 0.01);
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod area;
mod distant;
mod environment;
mod error;
mod goniometric;
mod ies;
mod kind;
mod names;
mod point;
mod source;
mod spot;
mod warp;

pub use area::{AreaLight, EmittingPoint, EmittingTriangles};
pub use distant::{DistantLight, SUN_DIAMETER, azimuth_elevation, sky_direction};
pub use environment::{Environment, EnvironmentMap, Mapping, Portal};
pub use error::LightError;
pub use goniometric::{GoniometricLight, Profile};
pub use ies::{IesProfile, Photometry};
pub use kind::{Arrival, Leaving, LightKind, MitsubaLight, Panorama};
pub use names::{LightNames, RESERVED_NAMES, SKY};
pub use point::PointLight;
pub use source::{LightSource, OwnLight};
pub use spot::{Falloff, SpotLight};
pub use warp::{
    UNIFORM_SPHERE_DENSITY, about, spread_between, spread_of, uniform_cone, uniform_cone_density,
    uniform_sphere,
};
