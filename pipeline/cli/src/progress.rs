//! Progress bars with time left, on a terminal only.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rrf_bake::Watch;
use std::io::IsTerminal;
use std::sync::Mutex;

/// One bar after another, as the stages of a bake begin and end.
pub struct Bars {
    quiet: bool,
    current: Mutex<ProgressBar>,
}

impl Bars {
    /// No bar yet.
    pub fn new(quiet: bool) -> Bars {
        Bars {
            quiet,
            current: Mutex::new(ProgressBar::hidden()),
        }
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
    fn begin(&self, stage: &'static str, total: u64) {
        self.with(|current| *current = bar(self.quiet, total, stage));
    }

    fn advance(&self, steps: u64) {
        self.with(|current| current.inc(steps));
    }

    fn end(&self) {
        self.with(|current| current.finish_and_clear());
    }
}

/// A bar of `length` steps, or a silent one where nobody watches.
pub fn bar(quiet: bool, length: u64, what: &'static str) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
    }
    let style = ProgressStyle::with_template("{msg:>9} {wide_bar} {percent:>3}% {eta:>4} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length)
        .with_style(style)
        .with_message(what)
}
