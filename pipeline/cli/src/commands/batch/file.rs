//! The batch file: what is baked, with which settings.

use crate::failure::BadInput;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Most bytes of a batch file.
const MAX_BATCH: u64 = 16 << 20;

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Batch {
    /// Folder of the runs, from the file's folder.
    pub output: PathBuf,
    /// Settings of all bakes, as read by [`rrf_bake::Settings::from_table`], and `seeds`.
    #[serde(default)]
    defaults: Table,
    /// Seconds that each bake may take.
    #[serde(default)]
    time_limit: Option<f64>,
    /// The bakes.
    #[serde(default)]
    bake: Vec<Bake>,
    /// Scenes, each with every preset and seed.
    #[serde(default)]
    matrix: Option<Matrix>,
    /// A command that runs at the end.
    #[serde(default)]
    pub on_finish: Option<Command>,
    /// File of measurements for monitoring, from the file's folder; by default `metrics.prom` in the output.
    #[serde(default)]
    pub metrics: Option<PathBuf>,
}

/// A command: words, or a line for the shell.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Command {
    /// Program and arguments.
    Words(Vec<String>),
    /// Line for `sh -c`.
    Line(String),
}

/// A bake as the file describes it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bake {
    /// Names the run folder: NAME-SEED.
    pub name: String,
    /// Scene file, from the file's folder.
    pub scene: PathBuf,
    /// Seconds that it may take.
    #[serde(default)]
    pub time_limit: Option<f64>,
    /// Settings of this bake, which replace the defaults.
    #[serde(default)]
    pub settings: Table,
}

/// Bakes of every scene with every preset and seed.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Matrix {
    /// Scene files by the names that their runs begin with.
    scenes: BTreeMap<String, PathBuf>,
    /// Presets; by default that of the defaults.
    #[serde(default)]
    presets: Vec<String>,
    /// Seeds; by default those of the defaults.
    #[serde(default)]
    seeds: Option<Value>,
}

impl Batch {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Batch, BadInput> {
        let wrong = |e: String| BadInput(format!("{}: {e}", path.display()));
        let bytes = rrf_files::read_regular(path, MAX_BATCH);
        let bytes = bytes.map_err(|e| wrong(format!("cannot read: {e}")))?;
        let text = String::from_utf8(bytes).map_err(|e| wrong(format!("cannot read: {e}")))?;
        let batch: Batch = toml::from_str(&text).map_err(|e| wrong(e.to_string()))?;
        if batch.bake.is_empty() && batch.matrix.is_none() {
            return Err(wrong("it has no [[bake]] and no [matrix]".into()));
        }
        Ok(batch)
    }

    /// Every bake, those of the matrix last, with its settings complete.
    pub fn bakes(&self) -> Vec<Bake> {
        let listed = self.bake.iter().cloned();
        let all = listed.chain(self.matrix.iter().flat_map(Matrix::bakes));
        all.map(|bake| {
            let mut settings = self.defaults.clone();
            settings.extend(bake.settings);
            Bake {
                settings,
                time_limit: bake.time_limit.or(self.time_limit),
                ..bake
            }
        })
        .collect()
    }
}

impl Matrix {
    fn bakes(&self) -> Vec<Bake> {
        let presets: Vec<Option<&String>> = match self.presets.as_slice() {
            [] => vec![None],
            presets => presets.iter().map(Some).collect(),
        };
        let pairs = self.scenes.iter();
        let pairs = pairs.flat_map(|scene| presets.iter().map(move |preset| (scene, preset)));
        pairs
            .map(|((name, scene), preset)| {
                let mut settings = Table::new();
                let preset = preset.cloned();
                if let Some(preset) = &preset {
                    settings.insert("preset".into(), Value::String(preset.clone()));
                }
                if let Some(seeds) = &self.seeds {
                    settings.insert("seeds".into(), seeds.clone());
                }
                Bake {
                    name: match preset {
                        Some(preset) => format!("{name}-{preset}"),
                        None => name.clone(),
                    },
                    scene: scene.clone(),
                    time_limit: None,
                    settings,
                }
            })
            .collect()
    }
}

/// Takes the list of seeds, one bake each, out of a table.
pub fn take_seeds(table: &mut Table) -> Result<Vec<u64>, BadInput> {
    if table.contains_key("seed") {
        return Err(BadInput("seed: a batch has a list, seeds = [1, 2]".into()));
    }
    let Some(seeds) = table.remove("seeds") else {
        return Ok(vec![1]);
    };
    let seeds: Vec<u64> = seeds
        .try_into()
        .map_err(|e| BadInput(format!("seeds: {e}")))?;
    let different: std::collections::BTreeSet<u64> = seeds.iter().copied().collect();
    if seeds.is_empty() || different.len() < seeds.len() {
        let reason = "seeds: one number or more is needed, each once, as in seeds = [1, 2]";
        return Err(BadInput(reason.into()));
    }
    Ok(seeds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(text: &str) -> Batch {
        toml::from_str(text).unwrap()
    }

    /// Two scenes, two presets and two seeds are eight runs of four bakes.
    #[test]
    fn a_matrix_is_every_scene_with_every_preset() {
        let batch = batch(
            "output = 'runs'\ntime_limit = 60\n[defaults]\ntarget = 0.1\n[matrix]\n\
             scenes = { box = 'box.pbrt', hall = 'hall.glb' }\npresets = ['preview', 'standard']\nseeds = [1, 2]",
        );
        let bakes = batch.bakes();
        let names: Vec<&str> = bakes.iter().map(|bake| bake.name.as_str()).collect();
        let expected = [
            "box-preview",
            "box-standard",
            "hall-preview",
            "hall-standard",
        ];
        assert_eq!(names, expected);
        for mut bake in bakes {
            assert_eq!(take_seeds(&mut bake.settings).unwrap(), [1, 2]);
            assert_eq!(bake.settings["target"].as_float(), Some(0.1));
            assert_eq!(bake.time_limit, Some(60.0));
        }
    }

    #[test]
    fn a_bake_goes_before_the_defaults() {
        let batch = batch(
            "output = 'runs'\ntime_limit = 60\n[defaults]\ntarget = 0.1\n\
             [[bake]]\nname = 'a'\nscene = 'a.obj'\ntime_limit = 5\nsettings = { target = '5%' }",
        );
        let [bake] = batch.bakes().try_into().unwrap();
        assert_eq!(bake.time_limit, Some(5.0));
        assert_eq!(bake.settings["target"].as_str(), Some("5%"));
    }
}
