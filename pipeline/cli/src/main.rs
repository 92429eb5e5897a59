//! The `rrf` binary.

mod allocator;

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: allocator::Exiting = allocator::Exiting;

fn main() -> ExitCode {
    rrf_cli::main()
}
