//! Where an evaluation's time goes.

use std::time::{Duration, Instant};

/// Time of an evaluation by stages.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EvaluationTimings {
    /// Rows and lights taken to their cells.
    pub lookup: Duration,
    /// Inputs gathered, derived and scaled.
    pub inputs: Duration,
    /// Nets evaluated and summed over lights.
    pub nets: Duration,
}

impl EvaluationTimings {
    /// Adds another evaluation's times.
    pub fn add(&mut self, other: &EvaluationTimings) {
        self.lookup += other.lookup;
        self.inputs += other.inputs;
        self.nets += other.nets;
    }
}

/// Every how many blocks the inputs and the net are timed apart: reading the clock costs about
/// as much as a row of a net.
const SAMPLED: usize = 8;

/// A stopwatch, or none. Lookup and evaluation are timed whole; how evaluation divides into
/// inputs and nets is timed at one block in [`SAMPLED`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Stopwatch {
    last: Option<Instant>,
    /// Since when the block is timed, if it is.
    block: Option<Instant>,
    blocks: usize,
    /// What the timed blocks took so far, over all evaluations.
    inputs: Duration,
    nets: Duration,
    pub(crate) timings: EvaluationTimings,
}

impl Stopwatch {
    /// Starts, if anyone wants to know.
    pub(crate) fn start(&mut self, wanted: bool) {
        self.last = wanted.then(Instant::now);
        self.timings = EvaluationTimings::default();
    }

    pub(crate) fn end_lookup(&mut self) {
        self.timings.lookup += restart(&mut self.last);
    }

    /// A block begins.
    pub(crate) fn block(&mut self) {
        self.blocks += 1;
        let timed = self.last.is_some() && self.blocks.is_multiple_of(SAMPLED);
        self.block = timed.then(Instant::now);
    }

    /// The block's inputs are there.
    pub(crate) fn end_inputs(&mut self) {
        self.inputs += restart(&mut self.block);
    }

    /// The block's net is done.
    pub(crate) fn end_nets(&mut self) {
        self.nets += restart(&mut self.block);
    }

    /// All is evaluated: the time since the lookup is shared out.
    pub(crate) fn end(&mut self) -> EvaluationTimings {
        let both = restart(&mut self.last);
        let timed = self.inputs + self.nets;
        if !timed.is_zero() {
            let share = self.inputs.as_secs_f64() / timed.as_secs_f64();
            self.timings.inputs += both.mul_f64(share.clamp(0.0, 1.0));
        }
        self.timings.nets += both.saturating_sub(self.timings.inputs);
        self.timings
    }
}

/// Time since `last`, which becomes now.
#[inline]
fn restart(last: &mut Option<Instant>) -> Duration {
    last.as_mut().map_or(Duration::ZERO, |last| {
        let before = std::mem::replace(last, Instant::now());
        *last - before
    })
}
