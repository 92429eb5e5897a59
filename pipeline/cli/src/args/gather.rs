//! Rays in place of the model's answers, where those are not believed or everywhere.

use clap::{Args, ValueEnum};

/// Rays in place of the model's answers.
#[derive(Args, Clone, Copy, Debug)]
pub struct GatherArgs {
    /// Final gather: N rays from each broad surface, where direct light and the model answer in place of
    /// the model at the surface itself. Smaller errors for more time.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub gather: Option<u32>,
    /// Treatment of what is not trusted: by default a query of a transfer gathers, and all else is
    /// believed.
    #[arg(long, value_enum)]
    pub fallback: Option<Fallback>,
}

/// Treatment of what is not trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fallback {
    /// The model is believed.
    None,
    /// Rays go on from surface to surface, each with its direct light, to where the model is trusted.
    Gather,
    /// Path tracing, pixel by pixel.
    Trace,
}
