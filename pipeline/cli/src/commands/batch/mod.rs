//! `rrf run batch.toml`: many bakes from one file, safe under cron.

mod file;
mod gauges;
mod jobs;
mod log;
mod outcome;
mod watch;

use crate::args::RunArgs;
use crate::clock::{iso, unix_seconds};
use crate::failure::{BadInput, TargetMissed, exit_code, message};
use crate::progress::Bars;
use file::{Batch, Command};
use jobs::{Job, Listed};
use log::Log;
use outcome::{Outcome, State, Summary, worst};
use rrf_bake::{BakeError, Watch};
use rrf_store::atomic::atomic_write;
use rrf_store::lock::FolderLock;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};
use watch::RunWatch;

/// Checks everything, then bakes one after the other.
pub fn run(args: &RunArgs, quiet: bool) -> anyhow::Result<()> {
    let batch = Batch::read(&args.batch)?;
    let base = args.batch.parent().unwrap_or(Path::new(""));
    let output = base.join(&batch.output);
    let listed = jobs::listed(&batch, base, &output);
    let faulty = |listed: &Listed| match listed {
        Listed::Faulty(outcome) => Some(outcome.message.clone()),
        Listed::Ready(_) => None,
    };
    let faults: Vec<String> = listed.iter().filter_map(faulty).collect();
    if !faults.is_empty() && !args.keep_going {
        let faults = faults.join("\n");
        let text = format!(
            "{}: {faults}\n(--keep-going bakes the others)",
            args.batch.display()
        );
        return Err(BadInput(text).into());
    }
    if args.dry_run {
        faults.iter().for_each(|fault| eprintln!("{fault}"));
        let ready = listed.iter().filter_map(|listed| match listed {
            Listed::Ready(job) => Some(job),
            Listed::Faulty(_) => None,
        });
        return ready.into_iter().try_for_each(|job| job.preview());
    }
    let _lock = FolderLock::take(&output)?;
    let metrics = batch.metrics.as_ref().map(|file| base.join(file));
    let mut work = Work {
        args,
        log: Log::open(&output, quiet || args.json)?,
        watch: Bars::new(quiet || args.json, &args.bounds)?,
        metrics: metrics.unwrap_or_else(|| output.join("metrics.prom")),
        output,
        start: (Instant::now(), SystemTime::now()),
        outcomes: Vec::new(),
    };
    work.bake(listed)?;
    let code = work.finish(batch.on_finish.as_ref())?;
    work.end(code)
}

/// A batch at work.
struct Work<'a> {
    args: &'a RunArgs,
    output: PathBuf,
    metrics: PathBuf,
    log: Log,
    watch: Bars,
    start: (Instant, SystemTime),
    outcomes: Vec<Outcome>,
}

impl Work<'_> {
    fn bake(&mut self, listed: Vec<Listed>) -> anyhow::Result<()> {
        let total = listed.len();
        self.log
            .line(&format!("{}: {total} runs", self.args.batch.display()))?;
        for listed in listed {
            let outcome = match listed {
                Listed::Faulty(outcome) => *outcome,
                Listed::Ready(job) => self.perform(&job)?,
            };
            self.log
                .line(&format!("{}: {}", outcome.run.display(), outcome.message))?;
            self.outcomes.push(outcome);
            self.write_summary(None)?;
        }
        Ok(())
    }

    /// One run, unless there is a reason not to begin it.
    fn perform(&self, job: &Job) -> anyhow::Result<Outcome> {
        let mut outcome = match self.watch.halted() {
            Some(why) => {
                let text = format!("not begun: stopped by {}", why.text());
                let state = (1, State::NotBegun);
                Outcome::without_work(job.folder.clone(), job.scene.clone(), state, text)
            }
            None => {
                self.log.line(&format!("{}: begun", job.folder.display()))?;
                self.bake_one(job)
            }
        };
        outcome.preset = Some(job.settings.preset);
        outcome.seed = Some(job.settings.seed);
        outcome.target = Some(job.settings.target);
        Ok(outcome)
    }

    fn bake_one(&self, job: &Job) -> Outcome {
        let done = (0, State::Done);
        let (folder, scene) = (job.folder.clone(), job.scene.clone());
        let mut outcome = Outcome::without_work(folder, scene, done, String::new());
        let start = Instant::now();
        self.watch.begin_bake(job.settings.target);
        let watch = RunWatch::new(&self.watch, job, &self.log, self.args.json);
        let result = job.load().and_then(|scene| Ok(job.bake(&scene, &watch)?));
        outcome.seconds = start.elapsed().as_secs_f64();
        outcome.measure();
        match result {
            Ok(ended) => {
                outcome.take(&ended);
                if !ended.met {
                    outcome.state = State::TargetMissed;
                    outcome.code = if self.args.require_target { 3 } else { 0 };
                }
                let (error, se) = ended.error;
                outcome.message = format!(
                    "relative error {:.2} % ± {:.2} %, target {:.2} % {}, {} rounds, {}",
                    100.0 * error,
                    100.0 * se,
                    100.0 * job.settings.target,
                    if ended.met { "met" } else { "missed" },
                    ended.rounds,
                    ended.stop
                );
            }
            Err(error) => {
                let halted = matches!(
                    error.downcast_ref(),
                    Some(BakeError::Halted { .. } | BakeError::TransferHalted { .. })
                );
                outcome.code = exit_code(&error);
                outcome.message = message(&error);
                outcome.state = match outcome.code {
                    _ if halted => State::Stopped,
                    2 => State::BadInput,
                    _ => State::Failed,
                };
            }
        }
        outcome
    }

    /// Writes the summary and the measurements; `code` once all runs are done.
    fn write_summary(&self, code: Option<u8>) -> anyhow::Result<()> {
        let summary = Summary {
            version: format!("rrf {}", env!("CARGO_PKG_VERSION")),
            batch: &self.args.batch,
            started: iso(self.start.1),
            seconds: self.start.0.elapsed().as_secs_f64(),
            unfinished: code.is_none(),
            code,
            runs: &self.outcomes,
        };
        let mut text = serde_json::to_vec_pretty(&summary)?;
        text.push(b'\n');
        atomic_write(&self.summary(), &text)?;
        if let Some(code) = code {
            if self.args.json {
                println!("{}", serde_json::to_string(&summary)?);
            }
            let now = unix_seconds(SystemTime::now());
            let text = gauges::text(&self.outcomes, now, code);
            atomic_write(&self.metrics, text.as_bytes())?;
        }
        Ok(())
    }

    fn summary(&self) -> PathBuf {
        self.output.join("summary.json")
    }

    /// The last summary, and the command that the file wants to run then; the exit code.
    fn finish(&self, command: Option<&Command>) -> anyhow::Result<u8> {
        let code = worst(&self.outcomes);
        self.write_summary(Some(code))?;
        let Some(command) = command else {
            return Ok(code);
        };
        let words = match command {
            Command::Words(words) => words.clone(),
            Command::Line(line) => ["sh", "-c", line].map(String::from).to_vec(),
        };
        let ended = words.split_first().map(|(program, words)| {
            std::process::Command::new(program)
                .args(words)
                .current_dir(&self.output)
                .env("RRF_SUMMARY", std::path::absolute(self.summary())?)
                .env("RRF_METRICS", std::path::absolute(&self.metrics)?)
                .env("RRF_EXIT_CODE", code.to_string())
                .stdin(std::process::Stdio::null())
                .status()
        });
        let failed = match ended {
            Some(Ok(status)) if status.success() => return Ok(code),
            Some(Ok(status)) => status.to_string(),
            Some(Err(error)) => error.to_string(),
            None => "it has no words".into(),
        };
        self.log.line(&format!("on_finish: {failed}"))?;
        // what was baked stands; that nobody was told may be mended by another try
        Ok(if code == 0 { 1 } else { code })
    }

    /// The last line, and the error that the exit code follows from.
    fn end(&self, code: u8) -> anyhow::Result<()> {
        let done = self.outcomes.iter().filter(|o| o.code == 0).count();
        let (total, summary) = (self.outcomes.len(), self.summary());
        self.log.line(&format!(
            "{done} of {total} runs done, exit code {code}: {}",
            summary.display()
        ))?;
        let text = match total - done {
            0 => format!(
                "on_finish failed, see {}",
                self.output.join("log.txt").display()
            ),
            failed => format!("{failed} of {total} runs failed, see {}", summary.display()),
        };
        match code {
            0 => Ok(()),
            2 => Err(BadInput(text).into()),
            3 => Err(TargetMissed(text).into()),
            _ => anyhow::bail!(text),
        }
    }
}
