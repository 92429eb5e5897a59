//! Columns of a tile: where its paths are, the light that they look for, where they go.

use super::tile::Surfaces;
use rrf_materials::{Lane, Lane3, TILE};

/// Path vertices of a tile.
pub(crate) struct Vertices {
    pub(crate) surfaces: Surfaces,
    /// Unit directions to where the path came from.
    pub(crate) viewer: Lane3,
    /// Product of f cos / pdf up to here.
    pub(crate) throughput: Lane3,
    /// Largest channel of the throughput after the first scattering.
    pub(crate) first: Lane,
    /// Density of having arrived here, with respect to area.
    pub(crate) density: Lane,
    /// Density with which a mirror would have led here.
    pub(crate) mirror_density: Lane,
    /// Point light of the lane's path.
    pub(crate) light: Lane3,
    /// Its intensity toward the vertex, over the probability of its choice [W/sr].
    pub(crate) intensity: Lane3,
    /// Inverse density of its own rays toward the vertex [sr].
    pub(crate) solid_angle: Lane,
}

/// The points that a point light's own ray met, or that mirrors show it by.
pub(crate) struct Lit {
    /// Seen from the light.
    pub(crate) surfaces: Surfaces,
    /// Unit direction to the light.
    pub(crate) toward: Lane3,
    /// Irradiance at normal incidence, 1 / distance^2 for 1 W/sr; zero where the ray missed.
    pub(crate) falloff: Lane,
    /// Intensity toward the point, over the probability of the light's choice [W/sr].
    pub(crate) intensity: Lane3,
    /// Density of the point with respect to area, by the light's ray and by a mirror together.
    pub(crate) density: Lane,
}

/// Points on lamps, one for each path of a tile.
pub(crate) struct LampLanes {
    pub(crate) position: Lane3,
    /// Unit normal on the path's side.
    pub(crate) normal: Lane3,
    pub(crate) lift: Lane,
    /// Radiance emitted toward the path.
    pub(crate) radiance: Lane3,
    /// Density of the point with respect to area.
    pub(crate) density: Lane,
}

/// Light from afar, one direction for each path of a tile.
pub(crate) struct FarLanes {
    /// Unit direction to it.
    pub(crate) toward: Lane3,
    /// Irradiance on a surface that faces it, over the probability of the light's choice.
    pub(crate) irradiance: Lane3,
    /// Density of the direction with respect to solid angle; zero for a light of one direction.
    pub(crate) density: Lane,
}

/// Where the paths go next.
pub(crate) struct Departures {
    pub(crate) throughput: Lane3,
    pub(crate) origin: Lane3,
    pub(crate) direction: Lane3,
    /// Density with respect to solid angle; zero where the path ends.
    pub(crate) density: Lane,
}

impl Vertices {
    pub(crate) const ZERO: Vertices = Vertices {
        surfaces: Surfaces::ZERO,
        viewer: Lane3::ZERO,
        throughput: Lane3::ZERO,
        first: [0.0; TILE],
        density: [0.0; TILE],
        mirror_density: [0.0; TILE],
        light: Lane3::ZERO,
        intensity: Lane3::ZERO,
        solid_angle: [0.0; TILE],
    };
}

impl Lit {
    pub(crate) const ZERO: Lit = Lit {
        surfaces: Surfaces::ZERO,
        toward: Lane3::ZERO,
        falloff: [0.0; TILE],
        intensity: Lane3::ZERO,
        density: [0.0; TILE],
    };
}

impl LampLanes {
    pub(crate) const ZERO: LampLanes = LampLanes {
        position: Lane3::ZERO,
        normal: Lane3::ZERO,
        lift: [0.0; TILE],
        radiance: Lane3::ZERO,
        density: [0.0; TILE],
    };
}

impl FarLanes {
    pub(crate) const ZERO: FarLanes = FarLanes {
        toward: Lane3::ZERO,
        irradiance: Lane3::ZERO,
        density: [0.0; TILE],
    };
}

impl Departures {
    pub(crate) const ZERO: Departures = Departures {
        throughput: Lane3::ZERO,
        origin: Lane3::ZERO,
        direction: Lane3::ZERO,
        density: [0.0; TILE],
    };
}
