//! The `rrf` binary.

use std::process::ExitCode;

fn main() -> ExitCode {
    rrf_cli::main()
}
