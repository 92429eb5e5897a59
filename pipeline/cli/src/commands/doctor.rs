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
    println!("vector instructions: {}", instructions());

    let folder = std::env::temp_dir();
    let file = folder.join(format!("rrf-doctor-{}", std::process::id()));
    rrf_store::atomic::atomic_write(&file, b"rrf")?;
    std::fs::remove_file(&file)
        .with_context(|| format!("{}: cannot be removed", file.display()))?;
    println!("temporary folder is writable: {}", folder.display());
    println!("all good");
    Ok(())
}

#[cfg(target_arch = "x86_64")]
fn instructions() -> &'static str {
    if is_x86_feature_detected!("avx512f") {
        "AVX-512"
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        "AVX2 and FMA"
    } else {
        "SSE2 (nets will be several times slower than with AVX2)"
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn instructions() -> &'static str {
    "what the compiler's baseline has"
}
