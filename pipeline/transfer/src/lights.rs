//! Direct light at surface points: the only thing that the transfer is told about a light.

use glam::Vec3;

/// A surface point that light may reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Position just off the surface, world frame, metres.
    pub position: Vec3,
    /// Unit geometric normal of the lit side.
    pub geometric: Vec3,
    /// Unit shading normal of the lit side.
    pub shading: Vec3,
}

/// Light that arrives at a point from one direction if nothing lies in its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IncidentLight {
    /// Unit direction to where it comes from, world frame.
    pub direction: Vec3,
    /// How far that is, metres; infinite for the sun and the sky.
    pub distance: f32,
    /// Irradiance on a plane that faces it, a channel [W/m^2].
    pub normal_irradiance: Vec3,
}

/// Lights of any kind, as what they send straight to a point.
pub trait DirectLight: Sync {
    /// The light that arrives at a point, nothing in its way, handed to `arrive` one direction at
    /// a time. `sample` names the point: a light that has to choose directions or places chooses
    /// by it, never by anything that changes from frame to frame.
    fn arrivals(&self, at: &Receiver, sample: u64, arrive: &mut dyn FnMut(IncidentLight));
}

/// An isotropic point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSource {
    /// Position, world frame, metres.
    pub position: Vec3,
    /// Radiant intensity a channel [W/sr].
    pub intensity: Vec3,
}

impl DirectLight for PointSource {
    fn arrivals(&self, at: &Receiver, _: u64, arrive: &mut dyn FnMut(IncidentLight)) {
        let to = self.position - at.position;
        let distance = to.length();
        if distance > 0.0 {
            arrive(IncidentLight {
                direction: to / distance,
                distance,
                normal_irradiance: self.intensity / (distance * distance),
            });
        }
    }
}

/// A light so far away that it comes from one direction everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantSource {
    /// Unit direction to it, world frame.
    pub toward: Vec3,
    /// Irradiance on a plane that faces it, a channel [W/m^2].
    pub irradiance: Vec3,
}

impl DirectLight for DistantSource {
    fn arrivals(&self, _: &Receiver, _: u64, arrive: &mut dyn FnMut(IncidentLight)) {
        arrive(IncidentLight {
            direction: self.toward,
            distance: f32::INFINITY,
            normal_irradiance: self.irradiance,
        });
    }
}

impl<F> DirectLight for F
where
    F: Fn(&Receiver, u64, &mut dyn FnMut(IncidentLight)) + Sync,
{
    fn arrivals(&self, at: &Receiver, sample: u64, arrive: &mut dyn FnMut(IncidentLight)) {
        self(at, sample, arrive);
    }
}
