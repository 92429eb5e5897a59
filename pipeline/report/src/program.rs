//! The program `rrf` as a process: what a user would type is what is measured.

use crate::ReportError;
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// Path of the program and its number of threads.
#[derive(Clone, Debug)]
pub struct Program {
    /// The binary.
    pub path: PathBuf,
    /// `--threads`, where given.
    pub threads: Option<u32>,
}

/// A command of the program in the making.
#[derive(Clone, Debug)]
pub struct Call<'a> {
    program: &'a Program,
    arguments: Vec<OsString>,
}

/// A command that ended well.
#[derive(Clone, Copy, Debug)]
pub struct Finished {
    /// Wall time \[s\].
    pub seconds: f64,
    /// User and system time on all cores together \[s\].
    pub cpu_seconds: f64,
}

impl Program {
    /// Starts a command with its name and first argument.
    pub fn call(&self, name: &str, argument: impl AsRef<OsStr>) -> Call<'_> {
        Call {
            program: self,
            arguments: vec![name.into(), argument.as_ref().into()],
        }
    }
}

impl Call<'_> {
    /// Adds an option and its value.
    pub fn option(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.arguments.extend([name.into(), value.as_ref().into()]);
        self
    }

    /// Adds an option for each of the values.
    pub fn options(self, name: &str, values: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Self {
        let values = values.into_iter();
        values.fold(self, |call, value| call.option(name, value))
    }

    /// Runs it to its end. Nothing else may run beside it: the CPU time is that of all children
    /// that ended in between.
    ///
    /// # Errors
    /// [`ReportError::Run`] with the program's own words.
    pub fn run(self) -> Result<Finished, ReportError> {
        let path = &self.program.path;
        let threads = self.program.threads.map(|n| format!("--threads={n}"));
        let mut command = Command::new(path);
        command.args(&self.arguments).arg("--quiet").args(threads);
        let failed = |reason: String, bad_input: bool| {
            let words = self.arguments.iter().map(|a| a.to_string_lossy());
            let words: Vec<_> = words.collect();
            ReportError::Run {
                command: format!("rrf {}", words.join(" ")),
                reason,
                bad_input,
            }
        };
        let (start, cpu) = (Instant::now(), cpu_of_children());
        let output = command
            .output()
            .map_err(|e| failed(format!("{}: {e}", path.display()), false))?;
        let seconds = start.elapsed().as_secs_f64();
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let reason = format!("{}: {}", output.status, said.trim());
            return Err(failed(reason, output.status.code() == Some(2)));
        }
        Ok(Finished {
            seconds,
            cpu_seconds: cpu_of_children() - cpu,
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
