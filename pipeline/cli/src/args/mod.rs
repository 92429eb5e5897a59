//! Options that several subcommands share, as plain structs.

mod bake;
mod camera;
mod gather;
mod parse;

pub use bake::*;
pub use camera::*;
pub use gather::*;

use clap::Args;

/// Options of every subcommand.
#[derive(Args, Clone, Debug)]
pub struct Globals {
    /// Worker threads (results do not depend on it).
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// No progress bars.
    #[arg(long, short, global = true)]
    pub quiet: bool,
}
