//! `--method`: what a bake's settings become where cells are fitted by something else than nets.

use crate::args::{BakeSettings, Hidden, Method};
use crate::failure::BadInput;
use rrf_bake::BakeConfig;
use rrf_scene::Scene;
use rrf_train::{Kind, Size, TrainConfig};

/// Hidden units of the net that stands for the whole scene.
const GLOBAL_NET: [usize; 2] = [32, 16];

/// Sets what the method needs. Baselines have one round: later ones are about nets.
///
/// # Errors
/// For options that the method cannot follow.
pub fn set(config: &mut BakeConfig, args: &BakeSettings, scene: &Scene) -> Result<(), BadInput> {
    if let Some(Hidden(units)) = &args.hidden {
        config.train.size = Size::Hidden(units.clone());
    }
    if !matches!(args.method, Method::Nets | Method::LinearOutputs) {
        all_inputs(config);
    }
    match args.method {
        Method::Nets => return Ok(()),
        Method::LinearOutputs => {
            config.train.exponential = false;
            return Ok(());
        }
        Method::LinearRegression => {
            one_round(args)?;
            no_hidden(args)?;
            config.train.exponential = false;
            config.train.size = Size::Hidden(Vec::new());
        }
        Method::GlobalNet => {
            one_round(args)?;
            one_cell(config, args)?;
            if args.hidden.is_none() {
                config.train.size = Size::Hidden(GLOBAL_NET.to_vec());
            }
        }
        Method::QuadraticRegression => baseline(config, args, Kind::Quadratic)?,
        Method::Probes => {
            lambertian(scene)?;
            if args.inputs.is_some() {
                return Err(BadInput("--inputs: probes have their own".into()));
            }
            baseline(config, args, Kind::Probes)?;
            one_cell(config, args)?;
        }
        Method::Nearest => {
            baseline(config, args, Kind::Nearest)?;
            // the nearest may lie anywhere, and what is derived says twice what the raw columns say
            one_cell(config, args)?;
            config.train.inputs = rrf_field::columns::NAMES.map(String::from).to_vec();
        }
    }
    config.rounds = 1;
    Ok(())
}

/// Nets of large cells, and what is no net, have all that there is.
fn all_inputs(config: &mut BakeConfig) {
    config.train.inputs = TrainConfig::default().inputs;
    config.train.drop_redundant = false;
}

/// Probes know irradiance alone.
fn lambertian(scene: &Scene) -> Result<(), BadInput> {
    let glossy = |m: &&u32| {
        let material = scene.materials.get(**m as usize);
        material.is_some_and(|material| material.kind.depends_on_viewer)
    };
    let count = scene.triangle_material.iter().filter(glossy).count();
    match count {
        0 => Ok(()),
        _ => Err(BadInput(format!(
            "--method probes: irradiance probes know Lambertian surfaces only; {count} of {} triangles \
             are of other materials",
            scene.triangle_material.len()
        ))),
    }
}

fn baseline(config: &mut BakeConfig, args: &BakeSettings, kind: Kind) -> Result<(), BadInput> {
    one_round(args)?;
    no_hidden(args)?;
    config.train.kind = kind;
    config.train.exponential = false;
    config.train.size = Size::Hidden(Vec::new());
    config.trim = false;
    Ok(())
}

fn no_hidden(args: &BakeSettings) -> Result<(), BadInput> {
    match args.hidden {
        Some(_) => Err(BadInput(
            "--hidden: this method has no net with hidden units".into(),
        )),
        None => Ok(()),
    }
}

/// Sets one cell for the whole scene.
fn one_cell(config: &mut BakeConfig, args: &BakeSettings) -> Result<(), BadInput> {
    (config.extract.cells, config.most_cells) = (1, 1);
    match args.cells.or(args.most_cells).filter(|&cells| cells > 1) {
        Some(cells) => Err(BadInput(format!(
            "{cells} cells: this method has one for the whole scene; leave out --cells and --most-cells"
        ))),
        None => Ok(()),
    }
}

fn one_round(args: &BakeSettings) -> Result<(), BadInput> {
    match args.rounds.filter(|&rounds| rounds > 1) {
        Some(rounds) => Err(BadInput(format!(
            "--rounds {rounds}: rounds after the first split cells and grow nets; this method has one"
        ))),
        None => Ok(()),
    }
}
