//! Options that say how a scene file is read.

use crate::settings::parse::{number, numbers, unit_interval};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rrf_scene::{LightUnits, LoadOptions, SkyOption, SkySource};

/// How a scene file is read.
#[derive(Args, Clone, Debug)]
pub struct SceneOptions {
    /// Reflectance of surfaces without a material.
    #[arg(long, value_name = "A", default_value_t = 0.7, value_parser = unit_interval)]
    pub default_albedo: f32,
    /// Unit of glTF light intensities, named as in Blender's exporter.
    #[arg(long, value_name = "UNITS", default_value = "spec", value_parser = light_units())]
    pub light_units: LightUnits,
    /// Sky of a scene whose file has none.
    #[command(flatten)]
    pub sky: SkyArgs,
}

/// A sky, as typed.
#[derive(Args, Clone, Debug, Default)]
pub struct SkyArgs {
    /// Sky where the file has none: a lat-long picture, +y up, or a radiance [W/(sr m²)].
    #[arg(long, value_name = "FILE.exr|r,g,b", value_parser = sky, allow_hyphen_values = true)]
    pub sky: Option<SkySource>,
    /// Angle in degrees that the picture of --sky is turned by, from -z towards +x.
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true, requires = "sky")]
    pub sky_rotate: Option<f32>,
}

impl SceneOptions {
    /// The options of the scene's reader.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions {
            default_albedo: self.default_albedo,
            light_units: self.light_units,
            sky: self.sky_option(),
        }
    }

    /// As [`SkyArgs::option`].
    pub fn sky_option(&self) -> Option<SkyOption> {
        self.sky.option()
    }
}

impl SkyArgs {
    /// The sky typed, its file by its whole path, so that a run finds it from elsewhere.
    pub fn option(&self) -> Option<SkyOption> {
        let source = match self.sky.clone()? {
            SkySource::Picture(path) => {
                SkySource::Picture(std::path::absolute(&path).unwrap_or(path))
            }
            constant => constant,
        };
        let rotate = self.sky_rotate.unwrap_or(0.0);
        Some(SkyOption { source, rotate })
    }
}

fn light_units() -> impl TypedValueParser<Value = LightUnits> {
    let value = |units: LightUnits| {
        PossibleValue::new(units.name()).help(match units {
            LightUnits::Spec => "Candela, as the specification says",
            LightUnits::Compat => "Radiometric, W/sr",
            LightUnits::Raw => "Blender's own watts",
        })
    };
    PossibleValuesParser::new(LightUnits::ALL.map(value)).map(|name| {
        let named = LightUnits::ALL
            .into_iter()
            .find(|units| units.name() == name);
        // the parser lets no other name pass
        named.unwrap_or_default()
    })
}

/// Three numbers, or else the name of a file.
fn sky(text: &str) -> Result<SkySource, String> {
    let is_number = |part: &str| part.trim().parse::<f32>().is_ok();
    if !text.split(',').all(is_number) {
        return Ok(SkySource::Picture(text.into()));
    }
    let radiance = numbers::<3>(text)?;
    if radiance.iter().any(|&x| x < 0.0) {
        return Err("a radiance cannot be negative".into());
    }
    Ok(SkySource::Constant(radiance))
}
