//! `rrf compare`: how far one frame is from another.

use crate::args::CompareArgs;
use rrf_metrics::compare;
use rrf_metrics::tone::Exposure;
use rrf_render::exr;

/// Prints every measure with its definition.
pub fn run(args: &CompareArgs) -> anyhow::Result<()> {
    // the picture itself stands in the default layer
    let layer = if args.layer == "full" {
        ""
    } else {
        &args.layer
    };
    let test = exr::read_layer(&args.a, layer)?;
    let reference = exr::read_layer(&args.b, layer)?;
    let comparison = compare(&reference, &test, args.exposure.map(|ev| Exposure { ev }))?;
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
