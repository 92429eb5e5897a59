//! `rrf doctor`: what this machine offers.

use anyhow::Context;
use clap::Args;
use rrf_store::manifest::Kernels;

/// Check what this machine offers: threads, vector instructions, a temporary folder that can be written.
#[derive(Args, Clone, Debug)]
pub struct DoctorArgs {
    /// Machine-readable output.
    #[arg(long)]
    pub json: bool,
}

/// Prints a line a check; fails on the first that does not hold.
pub fn run(args: &DoctorArgs) -> anyhow::Result<()> {
    let kernels = rrf_bake::kernels();
    let folder = std::env::temp_dir();
    let file = folder.join(format!("rrf-doctor-{}", std::process::id()));
    rrf_store::atomic::atomic_write(&file, b"rrf")?;
    std::fs::remove_file(&file)
        .with_context(|| format!("{}: cannot be removed", file.display()))?;
    let address_space = crate::memory::address_space();
    let enough = crate::memory::check_solver().is_ok();
    if args.json {
        let found = serde_json::json!({
            "version": env!("CARGO_PKG_VERSION"),
            "threads": rayon::current_num_threads(),
            "vectors": kernels.vectors,
            "linear_algebra": kernels.linear_algebra,
            "temporary_folder": folder,
            "address_space": address_space,
            "can_train": enough,
        });
        println!("{found}");
        return Ok(());
    }
    let slow = match kernels.vectors.as_str() {
        "SSE2" => " (nets will be several times slower than with AVX2)",
        _ => "",
    };
    println!("rrf {}", env!("CARGO_PKG_VERSION"));
    println!("worker threads: {}", rayon::current_num_threads());
    println!("vector instructions: {}{slow}", kernels.vectors);
    println!("linear algebra: {}", kernels.linear_algebra);
    println!("{}", same_bytes(&kernels));
    println!("temporary folder is writable: {}", folder.display());
    match (address_space, enough) {
        (Some(left), false) => println!(
            "address space left: {} MiB, too little to train (ulimit -v)",
            left >> 20
        ),
        _ => println!("all good"),
    }
    Ok(())
}

/// Where else bakes have the bytes that they have here.
fn same_bytes(kernels: &Kernels) -> &'static str {
    match kernels.vectors.as_str() != "SSE2" && kernels.linear_algebra.contains("Haswell") {
        true => {
            "bakes have the same bytes on every x86-64 processor with AVX2 and FMA, with this version of rrf \
             and of the linear algebra"
        }
        false => {
            "the same bytes come from the same version, vector instructions and linear algebra"
        }
    }
}
