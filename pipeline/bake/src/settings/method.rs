//! The methods that cells can be fitted by.

use clap::ValueEnum;

/// Method that a scene is baked by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Direct-to-indirect transfer: one bake for lights of every kind, anywhere in free space.
    #[default]
    Transfer,
    /// Nets that have the light as an input, as in Ren et al. 2013: for point lights in a box.
    Nets,
    /// Such nets whose outputs are the radiance itself, as in Ren et al. 2013
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

impl Method {
    /// Its name on the command line.
    pub fn name(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_string())
    }
}
