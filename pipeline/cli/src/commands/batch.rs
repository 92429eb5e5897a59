//! `rrf run batch.toml`: many bakes from one file, safe under cron.

use super::bake::config;
use crate::args::RunArgs;
use crate::failure::{BadInput, exit_code, message};
use crate::progress::Bars;
use rrf_bake::{BakeConfig, Run, SamplingContext, Settings};
use rrf_scene::Scene;
use rrf_store::lock::FolderLock;
use rrf_trace::Tracer;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use toml::Table;

/// Most bytes of a batch file.
const MAX_BATCH: u64 = 16 << 20;

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Batch {
    /// Folder of the runs, from the file's folder.
    output: PathBuf,
    /// Settings of all bakes, as read by [`Settings::from_table`], and `seeds`.
    #[serde(default)]
    defaults: Table,
    /// The bakes.
    bake: Vec<Bake>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bake {
    /// Names the run folder: NAME-SEED.
    name: String,
    /// Scene file, from the file's folder.
    scene: PathBuf,
    /// Settings of this bake, which replace the defaults.
    #[serde(default)]
    settings: Table,
}

/// One run, valid as far as can be said before it starts.
struct Job {
    folder: PathBuf,
    scene: Scene,
    config: BakeConfig,
}

/// One line of the summary.
#[derive(Serialize)]
struct Outcome {
    run: PathBuf,
    /// 0 done, 1 failed, 2 bad input.
    code: u8,
    seconds: f64,
    relative_error: Option<f64>,
    relative_error_se: Option<f64>,
    message: String,
}

/// Validates everything, then bakes one after the other.
pub fn run(args: &RunArgs, quiet: bool) -> anyhow::Result<()> {
    let batch = read(&args.batch)?;
    let base = args.batch.parent().unwrap_or(Path::new(""));
    let output = base.join(&batch.output);
    let jobs = jobs(&batch, base, &output)
        .map_err(|faults| BadInput(format!("{}: {faults}", args.batch.display())))?;
    if args.dry_run {
        return jobs.iter().try_for_each(preview);
    }
    let _lock = FolderLock::take(&output)?;
    let mut log = Log::open(&output)?;
    log.line(&format!("{}: {} runs", args.batch.display(), jobs.len()))?;
    let watch = Bars::new(quiet, &args.bounds)?;
    let mut outcomes = Vec::new();
    for job in &jobs {
        let outcome = perform(job, &watch);
        log.line(&format!("{}: {}", outcome.run.display(), outcome.message))?;
        outcomes.push(outcome);
    }
    let summary = output.join("summary.json");
    let mut text = serde_json::to_vec_pretty(&outcomes)?;
    text.push(b'\n');
    rrf_store::atomic::atomic_write(&summary, &text)?;
    let failed = outcomes.iter().filter(|o| o.code != 0).count();
    println!(
        "{} of {} runs done: {}",
        outcomes.len() - failed,
        outcomes.len(),
        summary.display()
    );
    if failed == 0 {
        return Ok(());
    }
    let text = format!(
        "{failed} of {} runs failed, see {}",
        outcomes.len(),
        summary.display()
    );
    if outcomes.iter().any(|o| o.code == 1) {
        anyhow::bail!(text);
    }
    Err(BadInput(text).into())
}

fn read(path: &Path) -> anyhow::Result<Batch> {
    let unreadable = |e: String| BadInput(format!("{}: cannot read: {e}", path.display()));
    let bytes = rrf_files::read_regular(path, MAX_BATCH).map_err(|e| unreadable(e.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|e| unreadable(e.to_string()))?;
    let batch: Batch =
        toml::from_str(&text).map_err(|e| BadInput(format!("{}: {e}", path.display())))?;
    Ok(batch)
}

/// Every run of the batch, its scene loaded and its settings checked; all faults at once.
fn jobs(batch: &Batch, base: &Path, output: &Path) -> Result<Vec<Job>, BadInput> {
    let (mut jobs, mut faults) = (Vec::new(), Vec::new());
    let mut names = std::collections::BTreeSet::new();
    for bake in &batch.bake {
        let fine = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if bake.name.is_empty() || bake.name.starts_with('.') || !bake.name.chars().all(fine) {
            let rule = "letters, digits, - _ and . (not first)";
            faults.push(format!("name {:?}: a name is made of {rule}", bake.name));
        }
        if !names.insert(&bake.name) {
            faults.push(format!("name {:?} is there twice", bake.name));
        }
        match jobs_of(bake, &batch.defaults, base, output) {
            Ok(of) => jobs.extend(of),
            Err(error) => faults.push(format!("{}: {}", bake.name, message(&error))),
        }
    }
    match faults.is_empty() {
        true => Ok(jobs),
        false => Err(BadInput(faults.join("\n"))),
    }
}

fn jobs_of(bake: &Bake, defaults: &Table, base: &Path, output: &Path) -> anyhow::Result<Vec<Job>> {
    let mut table = defaults.clone();
    table.extend(bake.settings.clone());
    let seeds = seeds(&mut table)?;
    let mut settings = Settings::from_table(&table)?;
    let mut jobs = Vec::new();
    for seed in seeds {
        settings.seed = seed;
        let scene = crate::scene_file::load(&base.join(&bake.scene), &settings.scene)?;
        let config = config(&settings, &scene)?;
        config.validate(&scene)?;
        jobs.push(Job {
            folder: output.join(format!("{}-{seed}", bake.name)),
            scene,
            config,
        });
    }
    Ok(jobs)
}

/// Takes the list of seeds, one bake each, out of a table.
fn seeds(table: &mut Table) -> Result<Vec<u64>, BadInput> {
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

/// What the first round of a run would take.
fn preview(job: &Job) -> anyhow::Result<()> {
    let scene = job.scene.unlit();
    let tracer = Tracer::new(&scene)?;
    let tasks = rrf_bake::estimate(
        &job.config,
        &SamplingContext::new(&scene, &tracer, &job.config)?,
    )?;
    let seconds: f64 = tasks.iter().map(|task| task.seconds).sum();
    let memory = tasks.iter().map(|task| task.memory).max().unwrap_or(0);
    println!(
        "{}: {} tasks in the first of at most {} rounds, about {seconds:.0} core seconds, {} MiB a task at the most",
        job.folder.display(),
        tasks.len(),
        job.config.rounds,
        memory >> 20
    );
    Ok(())
}

fn perform(job: &Job, watch: &Bars) -> Outcome {
    let start = std::time::Instant::now();
    let result = Run::renew(&job.folder, &job.scene, &job.config)
        .and_then(|()| rrf_bake::bake(&job.scene, &job.config, &job.folder, true, watch));
    let seconds = start.elapsed().as_secs_f64();
    let run = job.folder.clone();
    match result {
        Ok(ended) => {
            let (error, se) = ended.evaluation.error();
            Outcome {
                run,
                code: 0,
                seconds,
                relative_error: Some(error),
                relative_error_se: Some(se),
                message: format!(
                    "relative error {:.2} % ± {:.2} %, {} rounds, {}",
                    100.0 * error,
                    100.0 * se,
                    ended.rounds,
                    ended.stop.text(ended.rounds)
                ),
            }
        }
        Err(error) => {
            let error = anyhow::Error::from(error);
            Outcome {
                run,
                code: exit_code(&error),
                seconds,
                relative_error: None,
                relative_error_se: None,
                message: message(&error),
            }
        }
    }
}

/// `log.txt`: lines with their time, appended.
struct Log(File);

impl Log {
    fn open(output: &Path) -> std::io::Result<Log> {
        let path = output.join("log.txt");
        fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map(Log)
    }

    fn line(&mut self, text: &str) -> std::io::Result<()> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let seconds = now.map_or(0, |d| d.as_secs());
        println!("{text}");
        writeln!(self.0, "{seconds} {text}")
    }
}
