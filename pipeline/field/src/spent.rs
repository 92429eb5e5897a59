//! Where an evaluation's time goes.

use std::time::{Duration, Instant};

/// Time of an evaluation by stages.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Rows and lights taken to their cells.
    pub lookup: Duration,
    /// Inputs gathered, derived and scaled.
    pub inputs: Duration,
    /// Nets evaluated and summed over lights.
    pub nets: Duration,
}

impl Spent {
    /// Adds another evaluation's times.
    pub fn add(&mut self, other: &Spent) {
        self.lookup += other.lookup;
        self.inputs += other.inputs;
        self.nets += other.nets;
    }
}

/// A stop watch, or none: reading the clock costs about as much as a row of a net.
pub(crate) struct Watch {
    last: Option<Instant>,
    pub(crate) spent: Spent,
}

impl Watch {
    /// Starts, if anyone wants to know.
    pub(crate) fn new(wanted: bool) -> Watch {
        Watch {
            last: wanted.then(Instant::now),
            spent: Spent::default(),
        }
    }

    pub(crate) fn end_lookup(&mut self) {
        self.spent.lookup += lap(&mut self.last);
    }

    pub(crate) fn end_inputs(&mut self) {
        self.spent.inputs += lap(&mut self.last);
    }

    pub(crate) fn end_nets(&mut self) {
        self.spent.nets += lap(&mut self.last);
    }
}

/// Time since `last`, which becomes now.
#[inline]
fn lap(last: &mut Option<Instant>) -> Duration {
    last.as_mut().map_or(Duration::ZERO, |last| {
        let before = std::mem::replace(last, Instant::now());
        *last - before
    })
}
