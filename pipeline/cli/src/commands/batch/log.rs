//! Files that a batch adds lines to.

use crate::clock::iso;
use serde_json::Value;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::time::SystemTime;

/// `log.txt`, a line an event with its time, and `rounds.jsonl`, a line of JSON a round.
pub struct Log {
    events: File,
    rounds: File,
    quiet: bool,
}

impl Log {
    /// Opens both; without `quiet` events are printed too.
    pub fn open(output: &Path, quiet: bool) -> std::io::Result<Log> {
        let open = |name| {
            let options = OpenOptions::new().create(true).append(true).clone();
            options.open(output.join(name))
        };
        Ok(Log {
            events: open("log.txt")?,
            rounds: open("rounds.jsonl")?,
            quiet,
        })
    }

    /// Adds an event.
    pub fn line(&self, text: &str) -> std::io::Result<()> {
        if !self.quiet {
            println!("{text}");
        }
        let line = format!("{} {text}\n", iso(SystemTime::now()));
        (&self.events).write_all(line.as_bytes())
    }

    /// Adds a round.
    pub fn round(&self, round: &Value) -> std::io::Result<()> {
        (&self.rounds).write_all(format!("{round}\n").as_bytes())
    }
}
