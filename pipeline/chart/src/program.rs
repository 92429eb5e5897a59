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

/// A run of the program that ended well.
#[derive(Clone, Debug)]
pub struct Done {
    /// Wall time [s].
    pub seconds: f64,
    /// User and system time on all cores together [s].
    pub cpu_seconds: f64,
    /// What it printed.
    pub output: String,
}

impl Program {
    /// Runs it to its end. Nothing else may run beside it: the CPU time is that of all children
    /// that ended in between.
    ///
    /// # Errors
    /// [`ChartError::Run`] with the program's own words.
    pub fn run(&self, arguments: &[OsString]) -> Result<Done, ChartError> {
        let mut command = Command::new(&self.path);
        command.args(arguments).arg("--quiet");
        if let Some(threads) = self.threads {
            command.args(["--threads", &threads.to_string()]);
        }
        let shown = || {
            let words = arguments.iter().map(|a| a.to_string_lossy());
            format!("rrf {}", words.collect::<Vec<_>>().join(" "))
        };
        let (start, cpu) = (Instant::now(), cpu_of_children());
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
        Ok(Done {
            seconds,
            cpu_seconds: cpu_of_children() - cpu,
            output: String::from_utf8_lossy(&output.stdout).into_owned(),
        })
    }
}

/// User and system time of all children that have ended [s].
fn cpu_of_children() -> f64 {
    // SAFETY: a rusage is plain numbers, for which zeros will do; the call fills ours in, and
    // leaves the zeros where it fails
    let usage = unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        libc::getrusage(libc::RUSAGE_CHILDREN, &raw mut usage);
        usage
    };
    let seconds = |t: libc::timeval| t.tv_sec as f64 + 1e-6 * t.tv_usec as f64;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}
