//! Choices of a reader of scene files.

use std::path::PathBuf;

/// Choices that a scene file leaves open.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Reflectance of a surface for which the file gives no material, in [0, 1]. pbrt has a
    /// default of its own, 0.5.
    pub default_albedo: f32,
    /// Unit of glTF's lights.
    pub light_units: LightUnits,
    /// Sky of a scene whose file has none.
    pub sky: Option<SkyOption>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            default_albedo: 0.7,
            light_units: LightUnits::Spec,
            sky: None,
        }
    }
}

/// Units of the intensities in a glTF file, named as in Blender's exporter.
///
/// A Blender point light of 100 W is written as 5435 (`Spec`), 7.96 (`Compat`) or 100 (`Raw`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightUnits {
    /// As KHR_lights_punctual says: candela, with 683 lm/W.
    #[default]
    Spec,
    /// Radiant intensity [W/sr].
    Compat,
    /// Radiant power \[W\] over the whole sphere: 4 pi times the intensity.
    Raw,
}

impl LightUnits {
    /// All of them.
    pub const ALL: [LightUnits; 3] = [LightUnits::Spec, LightUnits::Compat, LightUnits::Raw];

    /// Name of the choice on the command line.
    pub fn name(self) -> &'static str {
        match self {
            LightUnits::Spec => "spec",
            LightUnits::Compat => "compat",
            LightUnits::Raw => "raw",
        }
    }
}

/// A sky that a user gives a scene, with +y up.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SkyOption {
    /// Its light.
    #[serde(flatten)]
    pub source: SkySource,
    /// Angle that the picture is turned by about +y, from -z towards +x \[degrees\].
    pub rotate: f32,
}

/// Light of a sky.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SkySource {
    /// Radiance [W/(sr m²)], everywhere the same.
    Constant([f32; 3]),
    /// A lat-long picture: column 0 at -z, a quarter of the width at +x, row 0 at the zenith.
    Picture(PathBuf),
}
