//! The program `rrf` as a process: what a user would type is what is measured.

use crate::ChartError;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// Where the program is, and how many threads it gets.
#[derive(Clone, Debug)]
pub struct Program {
    /// The binary.
    pub path: PathBuf,
    /// `--threads`, where given.
    pub threads: Option<u32>,
}

impl Program {
    /// Runs it to its end; wall seconds and what it printed.
    ///
    /// # Errors
    /// [`ChartError::Run`] with the program's own words.
    pub fn run(&self, arguments: &[OsString]) -> Result<(f64, String), ChartError> {
        let mut command = Command::new(&self.path);
        command.args(arguments).arg("--quiet");
        if let Some(threads) = self.threads {
            command.args(["--threads", &threads.to_string()]);
        }
        let shown = || {
            let words = arguments.iter().map(|a| a.to_string_lossy());
            format!("rrf {}", words.collect::<Vec<_>>().join(" "))
        };
        let start = Instant::now();
        let output = command.output().map_err(|e| ChartError::Run {
            command: shown(),
            reason: format!("{}: {e}", self.path.display()),
            bad_input: false,
        })?;
        let seconds = start.elapsed().as_secs_f64();
        if !output.status.success() {
            return Err(ChartError::Run {
                command: shown(),
                reason: format!(
                    "{}: {}",
                    output.status,
                    String::from_utf8_lossy(&output.stderr).trim()
                ),
                bad_input: output.status.code() == Some(2),
            });
        }
        Ok((
            seconds,
            String::from_utf8_lossy(&output.stdout).into_owned(),
        ))
    }
}
