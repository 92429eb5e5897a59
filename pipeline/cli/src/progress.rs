//! Progress bars with time left, on a terminal only; time limit and signals.

use crate::args::Bounds;
use crate::heartbeat::Heartbeat;
use crate::run_location::RunLocation;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rrf_bake::{Evaluation, Halt, TaskKind, Watch};
use rrf_remote::RemoteError;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::borrow::Cow;
use std::error::Error;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Makes the observer of a bake, once the run has a folder.
pub type Watching<'a> = &'a dyn Fn(RunLocation) -> anyhow::Result<Box<dyn Watch>>;

/// One bar after another, as the stages of a bake begin and end; and when to stop.
pub struct Bars {
    quiet: bool,
    current: Mutex<ProgressBar>,
    deadline: Option<Instant>,
    memory: Option<u64>,
    interrupted: Arc<AtomicBool>,
    place: Option<RunLocation>,
    /// Where standard error is no terminal.
    lines: Option<Heartbeat>,
}

impl Bars {
    /// No bar yet. From now on the first SIGINT or SIGTERM stops the bake within a second, the tasks
    /// at hand unfinished, and the second at once.
    pub fn new(quiet: bool, bounds: &Bounds) -> io::Result<Bars> {
        let interrupted = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_default(signal, interrupted.clone())?;
            flag::register(signal, interrupted.clone())?;
        }
        Ok(Bars::stopped_by(interrupted, quiet, bounds))
    }

    /// No bar yet, and no signals: the bake stops where `interrupted` is set.
    pub fn stopped_by(interrupted: Arc<AtomicBool>, quiet: bool, bounds: &Bounds) -> Bars {
        let limit = bounds.time_limit.map(Duration::try_from_secs_f32);
        // a limit beyond the clock's range is none
        let deadline = limit
            .and_then(Result::ok)
            .and_then(|d| Instant::now().checked_add(d));
        let lines = !quiet && !io::stderr().is_terminal();
        Bars {
            quiet,
            current: Mutex::new(ProgressBar::hidden()),
            deadline,
            lines: lines.then(|| Heartbeat::new(deadline)),
            memory: bounds.memory,
            interrupted,
            place: None,
        }
    }

    /// Keeps an address up to date with the run's folder, task for task.
    pub fn keeping(self, place: RunLocation) -> Bars {
        Bars {
            place: Some(place),
            ..self
        }
    }

    /// A bake begins that ends at a relative error of `target`: from its rounds follows how long it will take.
    pub fn begin_bake(&self, target: f32) {
        if let Some(lines) = &self.lines {
            lines.begin_bake(target.into());
        }
    }

    /// Stores what changed, where the run has an address.
    pub fn push(&self) -> Result<(), RemoteError> {
        self.place.as_ref().map_or(Ok(()), RunLocation::push)
    }

    fn with(&self, act: impl FnOnce(&mut ProgressBar)) {
        // a poisoned lock only means that another thread stopped while drawing
        let mut current = self
            .current
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        act(&mut current);
    }
}

impl Watch for Bars {
    fn begin(&self, kind: TaskKind, round: u32, total: u64) {
        let what = format!("{} {round}", kind.name());
        if let Some(lines) = &self.lines {
            lines.begin(what.clone(), total);
        }
        self.with(|current| *current = bar(self.quiet, total, what));
    }

    fn begin_stage(&self, name: &'static str, total: u64) {
        if let Some(lines) = &self.lines {
            lines.begin(name.into(), total);
        }
        self.with(|current| *current = bar(self.quiet, total, name));
    }

    fn advance(&self, steps: u64) {
        if let Some(lines) = &self.lines {
            lines.advance(steps);
        }
        self.with(|current| current.inc(steps));
    }

    fn end(&self) {
        if let Some(lines) = &self.lines {
            lines.end();
        }
        self.with(|current| current.finish_and_clear());
    }

    fn evaluated(&self, round: u32, evaluation: &Evaluation) {
        if let Some(lines) = &self.lines {
            lines.evaluated(evaluation.error().0);
        }
        if !self.quiet {
            let (error, se) = evaluation.error();
            println!(
                "round {round}: {} cells, relative error {:.2} % ± {:.2} % ({:.2} % on held-out rows)",
                evaluation.cells.len(),
                100.0 * error,
                100.0 * se,
                100.0 * evaluation.relative_error
            );
        }
    }

    fn sync(&self) -> Result<(), Box<dyn Error + Send + Sync>> {
        Ok(self.push()?)
    }

    fn memory(&self) -> Option<u64> {
        self.memory
    }

    fn left(&self) -> Option<Duration> {
        let deadline = self.deadline?;
        Some(deadline.saturating_duration_since(Instant::now()))
    }

    fn halted(&self) -> Option<Halt> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Some(Halt::Interrupt);
        }
        let late = self.deadline.is_some_and(|d| Instant::now() >= d);
        late.then_some(Halt::Time)
    }
}

/// A bar of `length` steps, or a silent one where nobody watches.
pub fn bar(quiet: bool, length: u64, what: impl Into<Cow<'static, str>>) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
    }
    let style = ProgressStyle::with_template("{msg:>9} {wide_bar} {percent:>3}% {eta:>4} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length)
        .with_style(style)
        .with_message(what)
}
