//! Frames to files.

use crate::args::ViewArgs;
use crate::failure::BadInput;
use rrf_metrics::tone::Exposure;
use rrf_render::{Frame, Part, exr, png};
use std::path::{Path, PathBuf};

/// Refuses endings that no picture has, and files that cannot be written, before any work is done.
pub fn check_endings(outputs: &[PathBuf]) -> anyhow::Result<()> {
    let is_picture = |path: &PathBuf| ["exr", "png"].contains(&ending(path).as_str());
    match outputs.iter().find(|path| !is_picture(path)) {
        None => {}
        Some(path) => {
            let reason = "unknown picture format; name it .exr or .png";
            return Err(BadInput(format!("{}: {reason}", path.display())).into());
        }
    }
    for path in outputs {
        rrf_store::atomic::check_writable(path)?;
    }
    Ok(())
}

/// Writes the part asked for into each file; EXR files get every layer beside it.
pub fn write(mut frame: Frame, args: &ViewArgs, outputs: &[PathBuf]) -> anyhow::Result<()> {
    let part = match args.part() {
        Part::Full => None,
        Part::Direct => frame.direct.clone(),
        Part::Indirect => frame.indirect.clone(),
    };
    frame.full = part.unwrap_or(frame.full);
    for path in outputs {
        if ending(path) == "exr" {
            exr::write_exr(path, &frame)?;
            println!("{}", path.display());
            continue;
        }
        let picture = frame.picture();
        let exposure = args
            .exposure()
            .unwrap_or_else(|| Exposure::automatic(&picture));
        png::write_png(path, &png::tone_mapped(&picture, exposure))?;
        println!(
            "{}: exposure {:+.2} stops, sRGB",
            path.display(),
            exposure.ev
        );
    }
    Ok(())
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_ascii_lowercase()
}
