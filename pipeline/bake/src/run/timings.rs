//! `rounds/RRR/seconds.json`: the wall time of a round's stages. It is the one file in which two runs
//! with one seed differ. No decision depends on it, except how much of the last round fits into a
//! time limit.

use crate::error::BakeError;
use crate::plan::timings::Timings;
use crate::run::folder::Run;
use crate::run::json::{read_json, write_json};
use std::time::Instant;

impl Run {
    /// The timings of a round, or none where nobody wrote them down.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub fn read_timings(&self, round: u32) -> Result<Option<Timings>, BakeError> {
        read_json(&self.round_file(round, "seconds.json"), &self.hash()?)
    }

    /// Writes the timings of a round.
    pub(crate) fn write_timings(&self, round: u32, timings: &Timings) -> Result<(), BakeError> {
        write_json(
            &self.round_file(round, "seconds.json"),
            timings,
            &self.hash()?,
        )
    }

    /// Adds the time since `start` to one stage of a round.
    pub(crate) fn add_time(
        &self,
        round: u32,
        stage: fn(&mut Timings) -> &mut f64,
        start: Instant,
    ) -> Result<(), BakeError> {
        if !self.exists() {
            return Ok(());
        }
        // for people: unreadable timings start again from zero
        let mut timings = self.read_timings(round).ok().flatten().unwrap_or_default();
        *stage(&mut timings) += start.elapsed().as_secs_f64();
        self.write_timings(round, &timings)
    }
}
