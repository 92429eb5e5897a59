//! The stages that draw random numbers.

/// A stage that draws random numbers. Part of every [`Stream`](crate::Stream), so that no two
/// stages share numbers. A number here is never given to another stage: old runs stay the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stage {
    /// Tests, benches and examples.
    Test = 0,
    /// Rows of a bake and their paths; the cell is the draw.
    Extract = 1,
    /// Ground truth at given points.
    Points = 2,
    /// The plan's pilot, which finds the mean radiance.
    Pilot = 3,
    /// First weights of the nets and the order of their rows.
    Train = 4,
    /// Path-traced frames; the cell is the light, or a part of the lamps' light.
    Frame = 5,
    /// Pixels that are traced because no net is trusted there; the cell is the light.
    Fallback = 6,
    /// Choice of lights and of points on them in frames.
    Direct = 7,
    /// Light that a lamp's proxy is fitted to; the cell is the lamp.
    LightProxy = 8,
    /// Rows and fits of a transfer model; the cell is 0 for rows, 1 for fits.
    Transfer = 9,
    /// Rays that frames follow; the cell is how many surfaces they have met.
    Followed = 10,
}
