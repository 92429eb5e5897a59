//! The `rrf-report` binary.

use std::process::ExitCode;

fn main() -> ExitCode {
    rrf_report::main()
}
