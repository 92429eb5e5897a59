//! Lights that nets answer for.

/// An isotropic point light: position [m, world] and radiant intensity a channel [W/sr].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// World position.
    pub position: [f32; 3],
    /// Radiant intensity a channel.
    pub intensity: [f32; 3],
}
