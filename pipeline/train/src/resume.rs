//! A net under way as numbers, for [`crate::checkpoint`].

use crate::checkpoint::{Reader, Words, stop_of};
use crate::descent::{Descent, NetSteps};
use crate::fit::HistoryRow;
use crate::judge::Judge;
use crate::lm::{Levenberg, Stop};

/// Where a leg is.
#[derive(Clone, Copy)]
pub(crate) struct At {
    /// Steps taken.
    pub taken: usize,
    /// Steps since the error was last bettered.
    pub since: usize,
}

/// A net under way, without what follows from its cell.
struct State {
    alpha: f64,
    gamma: f64,
    residuals: f64,
    error: f64,
    w: Vec<f64>,
    best: Vec<f64>,
    lm: Levenberg,
    history: Vec<HistoryRow>,
}

fn read_history(iteration: u64, words: &mut Reader) -> Option<HistoryRow> {
    Some(HistoryRow {
        iteration: iteration as usize,
        residuals: words.take()? as usize,
        cost: words.float()?,
        validation: words.float()?,
        mu: words.float()?,
        gain: words.float()?,
    })
}

/// What goes on from leg to leg, and from step to step within one, as numbers.
impl Descent<'_> {
    pub fn write(&self, words: &mut Words) {
        for x in [self.alpha, self.gamma, self.residuals, self.error] {
            words.float(x);
        }
        words.floats(&self.w);
        words.floats(&self.best);
        self.lm.write(words);
        words.push(self.history.len() as u64);
        for row in &self.history {
            words.push(row.residuals as u64);
            for x in [row.cost, row.validation, row.mu, row.gain] {
                words.float(x);
            }
        }
    }

    /// What [`Descent::write`] wrote; none where it is of another net.
    fn read(&self, words: &mut Reader) -> Option<State> {
        let n = self.w.len();
        Some(State {
            alpha: words.float()?,
            gamma: words.float()?,
            residuals: words.float()?,
            error: words.float()?,
            w: words.floats(n)?,
            best: words.floats(n)?,
            lm: self.lm.read(words)?,
            history: (1..=words.take()?)
                .map(|iteration| read_history(iteration, words))
                .collect::<Option<Vec<HistoryRow>>>()?,
        })
    }

    fn set(&mut self, state: State) {
        (self.alpha, self.gamma) = (state.alpha, state.gamma);
        (self.residuals, self.error) = (state.residuals, state.error);
        (self.w, self.best) = (state.w, state.best);
        (self.lm, self.history) = (state.lm, state.history);
    }

    /// Takes the outcome of a leg as its own.
    pub fn take_outcome(&mut self, outcome: &Words) -> Option<Stop> {
        let mut words = outcome.reader();
        let stop = stop_of(words.take()?)?;
        let state = self.read(&mut words)?;
        self.set(state);
        Some(stop)
    }

    /// The state inside a leg.
    pub fn inside(&self, at: At, problem: &impl NetSteps, judge: &Judge) -> Words {
        let mut words = Words::default();
        words.push(at.taken as u64);
        words.push(at.since as u64);
        self.write(&mut words);
        judge.write(&mut words);
        problem.write(&mut words);
        words
    }

    /// Takes back the state inside a leg.
    pub fn go_back(
        &mut self,
        begun: &Words,
        problem: &mut impl NetSteps,
        judge: &mut Judge,
    ) -> Option<At> {
        let mut words = begun.reader();
        let at = At {
            taken: words.take()? as usize,
            since: words.take()? as usize,
        };
        let state = self.read(&mut words)?;
        let renewed = judge.read(&mut words)?;
        problem.read(&mut words)?;
        // from here on nothing fails: all of it is taken back, or nothing
        if let Some((share, w)) = renewed {
            judge.renew(&w, share);
        }
        self.set(state);
        Some(at)
    }
}
