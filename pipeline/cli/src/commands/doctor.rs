//! `rrf doctor`: what this machine offers.

use anyhow::Context;
use clap::Args;

/// Check what this machine offers: threads, vector instructions, a temporary folder that can be written.
#[derive(Args, Clone, Debug)]
pub struct DoctorArgs {}

/// Prints a line a check; fails on the first that does not hold.
pub fn run() -> anyhow::Result<()> {
    println!("rrf {}", env!("CARGO_PKG_VERSION"));
    println!("worker threads: {}", rayon::current_num_threads());
    let kernels = rrf_bake::kernels();
    let slow = match kernels.vectors.as_str() {
        "SSE2" => " (nets will be several times slower than with AVX2)",
        _ => "",
    };
    println!("vector instructions: {}{slow}", kernels.vectors);
    println!("linear algebra: {}", kernels.linear_algebra);
    println!("the same bytes come from the same version, vector instructions and linear algebra");

    let folder = std::env::temp_dir();
    let file = folder.join(format!("rrf-doctor-{}", std::process::id()));
    rrf_store::atomic::atomic_write(&file, b"rrf")?;
    std::fs::remove_file(&file)
        .with_context(|| format!("{}: cannot be removed", file.display()))?;
    println!("temporary folder is writable: {}", folder.display());
    println!("all good");
    Ok(())
}
