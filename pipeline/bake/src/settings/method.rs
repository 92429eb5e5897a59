//! The methods that cells can be fitted by, and what each makes of the settings.

use crate::error::BakeError;
use crate::settings::{BakeConfig, Hidden, Settings};
use clap::ValueEnum;
use rrf_scene::Scene;
use rrf_train::{Kind, Size, TrainConfig};

/// Hidden units of the net for the whole scene.
const GLOBAL_NET: [usize; 2] = [32, 16];

/// Method that cells are fitted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Nets with exponential outputs.
    Nets,
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

/// Applies a method. Baselines have one round: later rounds are about nets.
///
/// # Errors
/// [`BakeError::Setting`] for options that contradict the method.
pub(super) fn apply(
    config: &mut BakeConfig,
    settings: &Settings,
    scene: &Scene,
) -> Result<(), BakeError> {
    if let Some(Hidden(units)) = &settings.hidden {
        config.train.size = Size::Hidden(units.clone());
    }
    match settings.method {
        Method::Nets => return Ok(()),
        Method::LinearOutputs => {
            config.train.exponential = false;
            return Ok(());
        }
        _ => {}
    }
    // nets of large cells, and other methods, use all inputs
    config.train.inputs = TrainConfig::default().inputs;
    config.train.drop_redundant = false;
    config.rounds = 1;
    refuse_above(1, "--rounds", settings.rounds, "this method has one round")?;
    match settings.method {
        Method::GlobalNet => {
            one_cell(config, settings)?;
            if settings.hidden.is_none() {
                config.train.size = Size::Hidden(GLOBAL_NET.to_vec());
            }
            return Ok(());
        }
        Method::QuadraticRegression => baseline(config, Kind::Quadratic),
        Method::Probes => {
            lambertian(scene)?;
            refuse("--inputs", &settings.inputs, "probes have their own inputs")?;
            baseline(config, Kind::Probes);
            one_cell(config, settings)?;
        }
        Method::Nearest => {
            baseline(config, Kind::Nearest);
            one_cell(config, settings)?;
            // derived inputs would count twice what the raw columns say
            config.train.inputs = rrf_field::columns::NAMES.map(String::from).to_vec();
        }
        _ => {}
    }
    refuse(
        "--hidden",
        &settings.hidden,
        "this method has no hidden units",
    )?;
    config.train.exponential = false;
    config.train.size = Size::Hidden(Vec::new());
    Ok(())
}

fn baseline(config: &mut BakeConfig, kind: Kind) {
    config.train.kind = kind;
    config.compress = false;
}

/// Probes know irradiance alone.
fn lambertian(scene: &Scene) -> Result<(), BakeError> {
    let glossy = |m: &&u32| {
        let material = scene.materials.get(**m as usize);
        material.is_some_and(|material| material.kind.depends_on_viewer)
    };
    let count = scene.triangle_material.iter().filter(glossy).count();
    let all = scene.triangle_material.len();
    match count {
        0 => Ok(()),
        _ => Err(wrong(
            "--method probes",
            format!(
                "irradiance probes need Lambertian surfaces; {count} of {all} triangles have other materials"
            ),
        )),
    }
}

/// Sets one cell for the whole scene.
fn one_cell(config: &mut BakeConfig, settings: &Settings) -> Result<(), BakeError> {
    (config.extract.cells, config.most_cells) = (1, 1);
    let reason = "this method has one cell for the whole scene";
    refuse_above(1, "--cells", settings.cells, reason)?;
    refuse_above(1, "--most-cells", settings.most_cells, reason)
}

fn refuse_above(
    most: u32,
    option: &str,
    value: Option<u32>,
    reason: &str,
) -> Result<(), BakeError> {
    refuse(option, &value.filter(|&value| value > most), reason)
}

fn refuse<T>(option: &str, value: &Option<T>, reason: &str) -> Result<(), BakeError> {
    match value {
        Some(_) => Err(wrong(option, reason.into())),
        None => Ok(()),
    }
}

fn wrong(option: &str, reason: String) -> BakeError {
    BakeError::Setting {
        option: option.into(),
        reason,
    }
}
