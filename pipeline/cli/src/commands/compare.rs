//! `rrf compare`: how far one frame is from another.

use crate::failure::BadInput;
use clap::Args;
use rrf_bake::settings::parse::number;
use rrf_metrics::compare;
use rrf_metrics::tone::Exposure;
use rrf_render::exr::{self, Selection};
use std::path::PathBuf;

/// Compare two EXR frames: relMSE, relative error, ΔE*ab, ΔE2000, FLIP.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// The frame to judge.
    pub a: PathBuf,
    /// The reference.
    pub b: PathBuf,
    /// Layer to compare (full, direct, indirect).
    #[arg(long, default_value = "full")]
    pub layer: String,
    /// Part of files that have several, by name or number from 0; by default the first with
    /// the layer.
    #[arg(long)]
    pub part: Option<String>,
    /// Exposure in stops for the colour differences; by default chosen from the reference.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = number)]
    pub exposure: Option<f32>,
    /// Machine-readable output.
    #[arg(long)]
    pub json: bool,
}

/// Prints every measure with its definition.
pub fn run(args: &CompareArgs) -> anyhow::Result<()> {
    // the picture itself stands in the default layer
    let layer = if args.layer == "full" {
        ""
    } else {
        &args.layer
    };
    let part = args.part.as_deref();
    let selection = Selection { layer, part };
    let test = exr::read_exr_part(&args.a, selection)?;
    let reference = exr::read_exr_part(&args.b, selection)?;
    let exposure = args.exposure.map(|ev| Exposure { ev });
    let comparison = compare(&reference, &test, exposure).map_err(|error| {
        let (a, b) = (args.a.display(), args.b.display());
        BadInput(format!("{a} (tested) against {b} (reference): {error}"))
    })?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&comparison)?);
        return Ok(());
    }
    println!(
        "{} against {}, layer {}, {} x {} pixels",
        args.a.display(),
        args.b.display(),
        args.layer,
        comparison.width,
        comparison.height
    );
    println!(
        "mean luminance {:.5} against {:.5}; exposure {:+.2} stops; ε {:.6}",
        comparison.test_luminance,
        comparison.reference_luminance,
        comparison.exposure.ev,
        comparison.epsilon
    );
    for measure in &comparison.measures {
        println!(
            "{:<21} {:>10.5}   {}",
            measure.name, measure.value, measure.definition
        );
    }
    Ok(())
}
