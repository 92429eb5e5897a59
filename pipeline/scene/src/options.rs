//! Choices of a reader of scene files.

/// Choices that a scene file leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOptions {
    /// Reflectance of a surface for which the file gives no material, in [0, 1]. pbrt has a
    /// default of its own, 0.5.
    pub default_albedo: f32,
    /// Unit of glTF's point lights.
    pub light_units: LightUnits,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            default_albedo: 0.7,
            light_units: LightUnits::Spec,
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
