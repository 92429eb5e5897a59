//! The watch of one run of a batch: that of the whole batch, with the run's own time limit.

use super::jobs::Job;
use super::log::Log;
use crate::clock::iso;
use crate::progress::Bars;
use rrf_bake::{Evaluation, Halt, TaskKind, TransferSummary, Watch};
use serde_json::{Value, json};
use std::error::Error;
use std::time::{Duration, Instant, SystemTime};

/// Watches one run.
pub struct RunWatch<'a> {
    batch: &'a Bars,
    job: &'a Job,
    log: &'a Log,
    start: Instant,
    /// Prints a line of JSON a round.
    json: bool,
}

impl<'a> RunWatch<'a> {
    /// From now on.
    pub fn new(batch: &'a Bars, job: &'a Job, log: &'a Log, json: bool) -> RunWatch<'a> {
        RunWatch {
            batch,
            job,
            log,
            start: Instant::now(),
            json,
        }
    }

    /// Prints and logs a line.
    fn tell(&self, mut line: Value) {
        let name = self.job.folder.file_name().unwrap_or_default();
        line["run"] = name.to_string_lossy().into();
        line["seconds"] = self.start.elapsed().as_secs_f64().into();
        if self.json {
            println!("{line}");
        }
        // the bake goes on: its own files hold the round, and a full disk ends it soon enough
        if let Err(error) = self.log.round(&line) {
            eprintln!("warning: rounds.jsonl cannot be written: {error}");
        }
    }

    fn own_left(&self) -> Option<Duration> {
        let limit = self.job.time_limit?;
        Some(limit.saturating_sub(self.start.elapsed()))
    }
}

impl Watch for RunWatch<'_> {
    fn begin(&self, kind: TaskKind, round: u32, total: u64) {
        self.batch.begin(kind, round, total);
    }

    fn advance(&self, steps: u64) {
        self.batch.advance(steps);
    }

    fn end(&self) {
        self.batch.end();
    }

    fn evaluated(&self, round: u32, evaluation: &Evaluation) {
        self.tell(round_line(round, evaluation, self.job.settings.target));
        self.batch.evaluated(round, evaluation);
    }

    fn transferred(&self, summary: &TransferSummary) {
        self.tell(transfer_line(summary, self.job.settings.target));
    }

    fn begin_stage(&self, name: &'static str, total: u64) {
        self.batch.begin_stage(name, total);
    }

    fn sync(&self) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.batch.sync()
    }

    fn memory(&self) -> Option<u64> {
        self.batch.memory()
    }

    fn left(&self) -> Option<Duration> {
        [self.batch.left(), self.own_left()]
            .into_iter()
            .flatten()
            .min()
    }

    fn halted(&self) -> Option<Halt> {
        let late = self.own_left().is_some_and(|left| left.is_zero());
        self.batch.halted().or(late.then_some(Halt::Time))
    }
}

/// A round as one line of JSON.
pub fn round_line(round: u32, evaluation: &Evaluation, target: f32) -> Value {
    let (error, se) = evaluation.error();
    json!({
        "time": iso(SystemTime::now()),
        "round": round,
        "cells": evaluation.cells.len(),
        "relative_error": error,
        "relative_error_se": se,
        "held_out_error": evaluation.relative_error,
        "target": target,
        "target_met": evaluation.meets(f64::from(target)),
    })
}

/// A transfer as one line of JSON: it has one round.
fn transfer_line(summary: &TransferSummary, target: f32) -> Value {
    let test = &summary.test;
    json!({
        "time": iso(SystemTime::now()),
        "round": 0,
        "cells": summary.cells,
        "relative_error": test.relative_error,
        "relative_error_se": test.relative_error_se,
        "held_out_error": summary.held_out_error,
        "trusted_share": test.trusted_share,
        "trusted_error": test.trusted_error,
        "target": target,
        "target_met": summary.meets(target),
    })
}
