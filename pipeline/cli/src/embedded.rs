//! The commands for a program that holds tables and frames itself: the Python package.
//!
//! Options are words of the command line, so that every name, bound and message is the same. What a
//! command would read from a table or write to a file is handed over in memory.

use crate::args::BakeArgs;
use crate::baked::Baked;
use crate::commands::query::{self, Asking};
use crate::commands::{Command, bake, render, trace};
use crate::progress::Bars;
use crate::{Cli, failure};
use arrow::array::RecordBatch;
use clap::FromArgMatches;
use rrf_bake::{Evaluation, Halt, TaskKind, Watch};
use rrf_render::Frame;
use rrf_store::Limits;
use rrf_store::points::points_of;
use std::error::Error;
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A command that failed.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct CommandError {
    /// As the command prints it.
    pub message: String,
    /// Its exit code: 1 where it could succeed if tried again, 2 for bad input.
    pub exit_code: u8,
}

impl From<anyhow::Error> for CommandError {
    fn from(error: anyhow::Error) -> CommandError {
        CommandError {
            message: failure::message(&error),
            exit_code: failure::exit_code(&error),
        }
    }
}

/// Runs a whole command line, the program's name first, as the program `rrf` does; its exit code.
pub fn run_command(words: Vec<OsString>) -> u8 {
    crate::run_words(words)
}

/// The command that words mean.
fn parsed(words: &[OsString]) -> Result<Command, CommandError> {
    let program = [OsString::from("rrf")];
    let matches = crate::command().try_get_matches_from(program.iter().chain(words));
    let cli = matches.and_then(|matches| Cli::from_arg_matches(&matches));
    cli.map(|cli| cli.command).map_err(|error| CommandError {
        message: error.render().to_string().trim_end().to_owned(),
        exit_code: 2,
    })
}

fn another(words: &[OsString]) -> CommandError {
    let name = words
        .first()
        .map(|word| word.to_string_lossy().into_owned());
    CommandError {
        message: format!("{}: not this command", name.unwrap_or_default()),
        exit_code: 2,
    }
}

/// What happens in a bake.
#[derive(Clone, Debug)]
pub enum BakeEvent {
    /// A stage begins.
    Stage {
        /// Its name.
        name: String,
        /// Its number of steps.
        total: u64,
    },
    /// More steps of the stage are done.
    Advance(u64),
    /// A round was evaluated.
    Round {
        /// Its number, from 0.
        round: u32,
        /// Number of cells.
        cells: usize,
        /// Relative error.
        error: f64,
        /// Its standard error.
        error_se: f64,
    },
}

/// Hears what happens, on any thread.
pub type Listener = Arc<dyn Fn(BakeEvent) + Send + Sync>;

/// Bakes by the words of `rrf bake`; the result as JSON. The bake stops where `interrupted` is set.
///
/// # Errors
/// As the command.
pub fn bake_scene(
    words: &[OsString],
    listener: &Listener,
    interrupted: &Arc<AtomicBool>,
) -> Result<String, CommandError> {
    let Command::Bake(args) = parsed(words)? else {
        return Err(another(words));
    };
    crate::memory::check_solver().map_err(anyhow::Error::from)?;
    let watching = |location| {
        let bars = Bars::stopped_by(interrupted.clone(), true, &args.bounds).keeping(location);
        let listener = listener.clone();
        Ok(Box::new(Heard { bars, listener }) as Box<dyn Watch>)
    };
    let args: &BakeArgs = &args;
    Ok(format!("{:#}", bake::baked(args, &watching)?))
}

/// A bake's observer that tells a listener.
struct Heard {
    bars: Bars,
    listener: Listener,
}

impl Watch for Heard {
    fn begin(&self, kind: TaskKind, round: u32, total: u64) {
        let name = format!("{} {round}", kind.name());
        (self.listener)(BakeEvent::Stage { name, total });
    }

    fn begin_stage(&self, name: &'static str, total: u64) {
        let name = name.to_owned();
        (self.listener)(BakeEvent::Stage { name, total });
    }

    fn advance(&self, steps: u64) {
        (self.listener)(BakeEvent::Advance(steps));
    }

    fn evaluated(&self, round: u32, evaluation: &Evaluation) {
        let (error, error_se) = evaluation.error();
        (self.listener)(BakeEvent::Round {
            round,
            cells: evaluation.cells.len(),
            error,
            error_se,
        });
    }

    fn sync(&self) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.bars.sync()
    }

    fn memory(&self) -> Option<u64> {
        self.bars.memory()
    }

    fn left(&self) -> Option<Duration> {
        self.bars.left()
    }

    fn halted(&self) -> Option<Halt> {
        self.bars.halted()
    }
}

/// A run that stays open.
pub struct OpenRun {
    baked: Baked,
}

impl OpenRun {
    /// Opens a run. Cells of a larger error than `trust_error` are not trusted.
    ///
    /// # Errors
    /// As `rrf query`.
    pub fn open(run: &Path, trust_error: f32) -> Result<OpenRun, CommandError> {
        let baked = Baked::open(run, trust_error)?;
        Ok(OpenRun { baked })
    }

    /// The rows of a points table with `r g b cell_id trusted` appended.
    ///
    /// # Errors
    /// As `rrf query`.
    pub fn query(&self, rows: RecordBatch, blend: bool) -> Result<RecordBatch, CommandError> {
        let place = Path::new("table");
        let table = points_of(rows, place, Limits::default()).map_err(anyhow::Error::from)?;
        Ok(query::answer(
            &self.baked,
            &table,
            place,
            &Asking {
                blend,
                ..Asking::default()
            },
        )?
        .batch)
    }

    /// The rows of a points table with `r g b r_se g_se b_se` appended, path traced in the run's scene; `words`
    /// are those of `rrf trace --points`.
    ///
    /// # Errors
    /// As `rrf trace`.
    pub fn trace(
        &self,
        rows: RecordBatch,
        words: &[OsString],
    ) -> Result<RecordBatch, CommandError> {
        let Command::Trace(args) = parsed(words)? else {
            return Err(another(words));
        };
        let place = Path::new("table");
        let table = points_of(rows, place, Limits::default()).map_err(anyhow::Error::from)?;
        Ok(trace::truth(&args, &self.baked.scene, &table, place, true)?)
    }

    /// A frame by the words of `rrf render`.
    ///
    /// # Errors
    /// As the command.
    pub fn render(&mut self, words: &[OsString]) -> Result<Frame, CommandError> {
        let Command::Render(args) = parsed(words)? else {
            return Err(another(words));
        };
        let relit = render::relit(&args, &self.baked.scene)?;
        let own = std::mem::replace(&mut self.baked.scene, relit);
        let frame = render::frame(&args, &self.baked);
        self.baked.scene = own;
        frame?.ok_or_else(|| another(words))
    }

    /// `run.json`.
    pub fn manifest(&self) -> Result<String, CommandError> {
        let text = serde_json::to_string(&self.baked.manifest);
        Ok(text.map_err(anyhow::Error::from)?)
    }
}
