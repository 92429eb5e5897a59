//! The methods that cells can be fitted by.

use clap::ValueEnum;

/// Method that cells are fitted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Nets with exponential outputs.
    Nets,
    /// A direct-to-indirect transfer: one bake for lights of every kind, anywhere in free space.
    Transfer,
    /// Nets whose outputs are the radiance itself, as in Ren et al. 2013
    LinearOutputs,
    /// Linear regression on the same inputs.
    LinearRegression,
    /// Quadratic regression on the same inputs.
    QuadraticRegression,
    /// The eight nearest training rows, weighted by the inverse squared distance.
    Nearest,
    /// A grid of irradiance probes for a grid of light positions, for Lambertian scenes.
    Probes,
    /// One net for the whole scene.
    GlobalNet,
}
