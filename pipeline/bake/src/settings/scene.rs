//! Options that say how a scene file is read.

use crate::settings::parse::unit_interval;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rrf_scene::{LightUnits, LoadOptions};

/// How a scene file is read.
#[derive(Args, Clone, Debug)]
pub struct SceneOptions {
    /// Reflectance of surfaces without a material.
    #[arg(long, value_name = "A", default_value_t = 0.7, value_parser = unit_interval)]
    pub default_albedo: f32,
    /// Unit of glTF light intensities, named as in Blender's exporter.
    #[arg(long, value_name = "UNITS", default_value = "spec", value_parser = light_units())]
    pub light_units: LightUnits,
}

impl SceneOptions {
    /// The options of the scene's reader.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions {
            default_albedo: self.default_albedo,
            light_units: self.light_units,
        }
    }
}

fn light_units() -> impl TypedValueParser<Value = LightUnits> {
    let named = |name: &'static str, help: &'static str| PossibleValue::new(name).help(help);
    PossibleValuesParser::new([
        named("spec", "Candela, as the specification says"),
        named("compat", "Radiometric, W/sr"),
        named("raw", "Blender's own watts"),
    ])
    .map(|name| match name.as_str() {
        "compat" => LightUnits::Compat,
        "raw" => LightUnits::Raw,
        _ => LightUnits::Spec,
    })
}
