//! The subcommands. To add one: a file here with its arguments and `run`, and its lines below.

pub mod bake;
mod batch;
mod compare;
mod doctor;
mod export;
mod external;
pub mod groups;
pub mod query;
pub mod render;
mod scene;
mod shell;
mod tasks;
pub mod trace;
mod transfer;
mod verify;
mod view;

use crate::args::{self, Globals};
use clap::Subcommand;

/// A subcommand and its arguments.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake a scene's indirect light: from a scene file to a run folder.
    Bake(args::BakeArgs),
    /// The first stages of a bake of nets alone: load, plan, extract.
    Extract(args::ExtractArgs),
    /// The last stages of a bake of nets alone: train, judge.
    Train(args::TrainArgs),
    /// Bake everything that a file lists; again: only what changed.
    Run(args::RunArgs),
    /// Tasks of the next round of a bake of nets as a table, for schedulers.
    Plan(args::PlanArgs),
    /// Do one task of a plan; done ones are skipped.
    Task(args::TaskArgs),
    /// Check that a round's tasks are done, make their fits the model, plan the next round.
    Commit(args::CommitArgs),
    Render(render::RenderArgs),
    Trace(trace::TraceArgs),
    Query(query::QueryArgs),
    Export(export::ExportArgs),
    Compare(compare::CompareArgs),
    /// Show what a dataset, a model, a sweep or a table holds.
    Inspect(external::ExternalArgs),
    /// Draw error against time and size, of sweeps, or round by round, of runs.
    Chart(external::ExternalArgs),
    /// Bake every setting of a grid and measure each run.
    Sweep(external::ExternalArgs),
    /// Write all about one run on one HTML page.
    Report(external::ExternalArgs),
    Scene(scene::SceneArgs),
    Verify(verify::VerifyArgs),
    View(view::ViewPageArgs),
    Doctor(doctor::DoctorArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

impl Command {
    /// Whether the memory that it takes is bounded (`--memory`).
    pub fn bounds_memory(&self) -> bool {
        let bound = match self {
            Command::Bake(args) => args.bounds.memory,
            Command::Extract(args) => args.bake.bounds.memory,
            Command::Train(args) => args.bounds.memory,
            Command::Run(args) => args.bounds.memory,
            Command::Task(args) => args.memory,
            _ => None,
        };
        bound.is_some()
    }

    /// Does it; gives the exit code of what went well.
    pub fn run(&self, globals: &Globals) -> anyhow::Result<u8> {
        if let Command::Bake(_)
        | Command::Extract(_)
        | Command::Train(_)
        | Command::Run(_)
        | Command::Task(_) = self
        {
            crate::memory::check_solver()?;
        }
        match self {
            Command::Bake(args) => bake::bake(args, globals.quiet),
            Command::Extract(args) => bake::extract(args, globals.quiet),
            Command::Train(args) => bake::train(args, globals.quiet),
            Command::Run(args) => batch::run(args, globals.quiet),
            Command::Plan(args) => tasks::plan(args),
            Command::Task(args) => tasks::task(args),
            Command::Commit(args) => tasks::commit(args),
            Command::Render(args) => render::run(args),
            Command::Trace(args) => trace::run(args, globals.quiet),
            Command::Query(args) => query::run(args),
            Command::Export(args) => export::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Inspect(args) => return external::run("inspect", args, globals),
            Command::Chart(args) => return external::run("chart", args, globals),
            Command::Sweep(args) => return external::run("sweep", args, globals),
            Command::Report(args) => return external::run("report", args, globals),
            Command::Scene(args) => scene::run(args),
            Command::Verify(args) => verify::run(args),
            Command::View(args) => view::run(args),
            Command::Doctor(args) => doctor::run(args),
            Command::Completions(args) => {
                shell::completions(args);
                Ok(())
            }
            Command::Man(args) => shell::man(args),
        }?;
        Ok(0)
    }
}
