//! The runs of a batch, checked before anything starts.

use super::file::{Bake, Batch, take_seeds};
use super::outcome::{Ended, Outcome, State};
use crate::commands::bake::config;
use crate::failure::{BadInput, exit_code, message};
use crate::scene_file;
use rrf_bake::settings::Method;
use rrf_bake::{
    BakeConfig, BakeError, Run, SamplingContext, Settings, TransferBakeConfig, TransferRun, Watch,
    bake_scene_transfer,
};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// One run, valid as far as can be said before it starts.
pub struct Job {
    /// Its folder.
    pub folder: PathBuf,
    /// Its scene file.
    pub scene: PathBuf,
    /// What was asked for.
    pub settings: Settings,
    /// What that means for the scene.
    pub config: JobConfig,
    /// Time that it may take.
    pub time_limit: Option<Duration>,
}

/// Settings of a bake, by its method.
pub enum JobConfig {
    /// Nets that see the light, or a baseline in their place.
    Nets(Box<BakeConfig>),
    /// A transfer.
    Transfer(Box<TransferBakeConfig>),
}

impl JobConfig {
    /// Checks what settings mean for a scene.
    fn new(settings: &Settings, scene: &Scene) -> Result<JobConfig, BakeError> {
        if settings.method == Method::Transfer {
            let config = settings.transfer_config(scene)?;
            return Ok(JobConfig::Transfer(Box::new(config)));
        }
        let config = config(settings, scene)?;
        config.validate(scene)?;
        Ok(JobConfig::Nets(Box::new(config)))
    }
}

/// A run of a batch: one that can be baked, or what is wrong with it.
pub enum Listed {
    /// It can be baked.
    Ready(Box<Job>),
    /// It cannot.
    Faulty(Box<Outcome>),
}

impl Job {
    /// Its scene, read anew: a batch does not hold all of its scenes in memory.
    pub fn load(&self) -> anyhow::Result<Scene> {
        scene_file::load(&self.scene, &self.settings.scene)
    }

    /// Bakes it, or goes on where an earlier command was stopped.
    pub fn bake(&self, scene: &Scene, watch: &dyn Watch) -> Result<Ended, BakeError> {
        let folder = &self.folder;
        match &self.config {
            JobConfig::Nets(config) => {
                Run::renew(folder, scene, config)?;
                let ended = rrf_bake::bake(scene, config, folder, true, watch)?;
                let evaluation = &ended.evaluation;
                Ok(Ended {
                    error: evaluation.error(),
                    met: evaluation.meets(f64::from(config.target)),
                    cells: evaluation.cells.len(),
                    rounds: ended.rounds,
                    stop: ended.stop.text(ended.rounds),
                })
            }
            JobConfig::Transfer(config) => {
                TransferRun::renew(folder, scene, config)?;
                let ended = bake_scene_transfer(scene, config, folder, true, watch)?;
                let summary = ended.summary;
                Ok(Ended {
                    error: (summary.test.relative_error, summary.test.relative_error_se),
                    met: summary.meets(config.target),
                    cells: summary.cells,
                    rounds: 1,
                    stop: "a transfer is baked in one go".into(),
                })
            }
        }
    }

    /// What its first round would take.
    pub fn preview(&self) -> anyhow::Result<()> {
        let config = match &self.config {
            JobConfig::Nets(config) => config,
            JobConfig::Transfer(config) => {
                println!(
                    "{}: a transfer, in one go: {} rows of {} paths under {} lights and the scene's own",
                    self.folder.display(),
                    config.rows,
                    config.paths,
                    config.points + config.suns + config.skies
                );
                return Ok(());
            }
        };
        let scene = self.load()?.unlit();
        let tracer = Tracer::new(&scene)?;
        let context = SamplingContext::new(&scene, &tracer, config)?;
        let tasks = rrf_bake::estimate(config, &context)?;
        let seconds: f64 = tasks.iter().map(|task| task.seconds).sum();
        let memory = tasks.iter().map(|task| task.memory).max().unwrap_or(0);
        println!(
            "{}: {} tasks in the first of at most {} rounds, about {seconds:.0} core seconds, {} MiB a task at the most",
            self.folder.display(),
            tasks.len(),
            config.rounds,
            memory >> 20
        );
        Ok(())
    }
}

/// Every run of the batch, its scene read and its settings checked.
pub fn listed(batch: &Batch, base: &Path, output: &Path) -> Vec<Listed> {
    let mut names = BTreeSet::new();
    let mut all = Vec::new();
    for bake in batch.bakes() {
        let named = checked_name(&bake.name, &mut names);
        let jobs = named.map_err(anyhow::Error::from);
        match jobs.and_then(|()| jobs_of(&bake, base, output)) {
            Ok(jobs) => all.extend(jobs.into_iter().map(|job| Listed::Ready(Box::new(job)))),
            Err(error) => {
                let text = format!("{}: {}", bake.name, message(&error));
                let state = match exit_code(&error) {
                    2 => (2, State::BadInput),
                    code => (code, State::Failed),
                };
                let (folder, scene) = (output.join(&bake.name), base.join(&bake.scene));
                all.push(Listed::Faulty(Box::new(Outcome::without_work(
                    folder, scene, state, text,
                ))));
            }
        }
    }
    all
}

fn checked_name(name: &str, names: &mut BTreeSet<String>) -> Result<(), BadInput> {
    let fine = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(fine) {
        let rule = "letters, digits, - _ and . (not first)";
        return Err(BadInput(format!("a name is made of {rule}")));
    }
    if !names.insert(name.into()) {
        return Err(BadInput("the name is there twice".into()));
    }
    Ok(())
}

fn jobs_of(bake: &Bake, base: &Path, output: &Path) -> anyhow::Result<Vec<Job>> {
    let mut table = bake.settings.clone();
    let seeds = take_seeds(&mut table)?;
    let settings = Settings::from_table(&table)?;
    let time_limit = bake.time_limit.map(limit).transpose()?;
    let scene = base.join(&bake.scene);
    let loaded = scene_file::load(&scene, &settings.scene)?;
    let of_seed = |seed: u64| -> anyhow::Result<Job> {
        let settings = Settings {
            seed,
            ..settings.clone()
        };
        let config = JobConfig::new(&settings, &loaded)?;
        Ok(Job {
            folder: output.join(format!("{}-{seed}", bake.name)),
            scene: scene.clone(),
            settings,
            config,
            time_limit,
        })
    };
    seeds.into_iter().map(of_seed).collect()
}

fn limit(seconds: f64) -> Result<Duration, BadInput> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(limit) if !limit.is_zero() => Ok(limit),
        _ => Err(BadInput(format!(
            "time_limit = {seconds}: needs seconds, above 0"
        ))),
    }
}
