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

/// The name of a receiver: the random numbers of a light depend on it and on nothing that changes
/// from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceiverId {
    /// Patch or row that the point belongs to.
    pub owner: u64,
    /// Which of the owner's points it is: their samples are stratified together.
    pub point: u32,
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
    /// The way beyond a mirror, where it comes from one.
    pub beyond: Option<Leg>,
}

/// A straight piece of light's way that must be free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Where it begins, just off a surface.
    pub origin: Vec3,
    /// Unit direction toward the light.
    pub direction: Vec3,
    /// Its length, metres; infinite for the sun and the sky.
    pub distance: f32,
}

impl IncidentLight {
    /// Light that no mirror bends.
    pub fn straight(direction: Vec3, distance: f32, normal_irradiance: Vec3) -> IncidentLight {
        IncidentLight {
            direction,
            distance,
            normal_irradiance,
            beyond: None,
        }
    }
}

/// Lights of any kind, as what they send straight to a point.
pub trait DirectLight: Sync {
    /// The light that arrives at a point, nothing in its way, handed to `arrive` one direction at
    /// a time. `id` names the point: a light that has to choose directions or places chooses
    /// by it, so that a light which moves a little changes a little.
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight));

    /// Least and greatest corner of a box that all of its light comes from; `None` where it comes
    /// from afar or nobody knows.
    fn bounds(&self) -> Option<[Vec3; 2]> {
        None
    }

    /// Radiance [W/(sr m²)] that comes from a direction, of a light that surrounds the scene.
    fn surrounding(&self, _toward: Vec3) -> Option<Vec3> {
        None
    }
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
    fn arrivals(&self, at: &Receiver, _: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        let to = self.position - at.position;
        let distance = to.length();
        if distance > 0.0 {
            let normal_irradiance = self.intensity / (distance * distance);
            arrive(IncidentLight::straight(
                to / distance,
                distance,
                normal_irradiance,
            ));
        }
    }

    fn bounds(&self) -> Option<[Vec3; 2]> {
        Some([self.position; 2])
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
    fn arrivals(&self, _: &Receiver, _: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        arrive(IncidentLight::straight(
            self.toward,
            f32::INFINITY,
            self.irradiance,
        ));
    }
}

/// Several lights at once.
impl<L: DirectLight> DirectLight for Vec<L> {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        self.iter().for_each(|light| light.arrivals(at, id, arrive));
    }
}

impl<L: DirectLight + ?Sized> DirectLight for &L {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        (**self).arrivals(at, id, arrive);
    }

    fn bounds(&self) -> Option<[Vec3; 2]> {
        (**self).bounds()
    }

    fn surrounding(&self, toward: Vec3) -> Option<Vec3> {
        (**self).surrounding(toward)
    }
}

impl<L: DirectLight + ?Sized> DirectLight for Box<L> {
    fn arrivals(&self, at: &Receiver, id: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        (**self).arrivals(at, id, arrive);
    }

    fn bounds(&self) -> Option<[Vec3; 2]> {
        (**self).bounds()
    }

    fn surrounding(&self, toward: Vec3) -> Option<Vec3> {
        (**self).surrounding(toward)
    }
}
