//! What the settings mean for a scene.

use super::{BakeConfig, Hidden, Method, Settings};
use crate::error::BakeError;
use rrf_extract::{ExtractError, NarrowLight, Region};
use rrf_scene::Scene;
use rrf_train::{Kind, Size, TrainConfig};

/// Hidden units of the net for the whole scene.
const GLOBAL_NET: [usize; 2] = [32, 16];

impl Settings {
    /// What the settings mean for a scene.
    ///
    /// # Errors
    /// [`BakeError::Setting`] for options that contradict each other or the scene,
    /// [`BakeError::Extract`] for a scene without surfaces.
    pub fn config(&self, scene: &Scene) -> Result<BakeConfig, BakeError> {
        if self.method == Method::Transfer {
            let reason = "the method transfer, the default, has no stages and tasks: `rrf bake` bakes it in one go. \
                          For stages and tasks give --method nets";
            return Err(wrong("--method", reason.into()));
        }
        let light_box = match self.light_box {
            Some(light_box) => light_box,
            None => middle(scene)?,
        };
        let mut config = BakeConfig::preset(self.preset, light_box, self.seed);
        config.target = self.target;
        config.default_albedo = self.scene.default_albedo;
        config.light_units = self.scene.light_units;
        config.sky = self.scene.sky_option();
        config.extract.eye_box = self.eye_box;
        config.extract.narrow = NarrowLight::of(scene);
        config.extract.rows = self.rows.unwrap_or(config.extract.rows);
        config.extract.paths = self.paths.unwrap_or(config.extract.paths);
        config.extract.cells = self.cells.unwrap_or(config.extract.cells);
        config.rounds = self.rounds.unwrap_or(config.rounds);
        let most_cells = config.most_cells.max(config.extract.cells);
        config.most_cells = self.most_cells.unwrap_or(most_cells);
        config.compress = self.trim;
        apply_method(&mut config, self, scene)?;
        if let Some(inputs) = &self.inputs {
            config.train.inputs.clone_from(inputs);
            config.train.drop_redundant = false;
        }
        Ok(config)
    }
}

/// The middle 80 % of the scene's bounds on each axis.
fn middle(scene: &Scene) -> Result<Region, ExtractError> {
    let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
    let inner = |i: usize, share: f32| bounds.min[i] + share * (bounds.max[i] - bounds.min[i]);
    Ok(Region {
        minimum: std::array::from_fn(|i| inner(i, 0.1)),
        maximum: std::array::from_fn(|i| inner(i, 0.9)),
    })
}

/// Applies a method. Baselines have one round: later rounds are about nets.
///
/// # Errors
/// [`BakeError::Setting`] for options that contradict the method.
fn apply_method(
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
