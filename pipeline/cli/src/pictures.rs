//! Frames to files.

use crate::args::{Part, ViewArgs};
use crate::failure::BadInput;
use rrf_metrics::tone::Exposure;
use rrf_render::{Frame, exr, png};
use std::path::{Path, PathBuf};

/// Refuses endings that no picture has, before any work is done.
pub fn check_endings(outputs: &[PathBuf]) -> Result<(), BadInput> {
    match outputs
        .iter()
        .find(|path| !["exr", "png"].contains(&ending(path).as_str()))
    {
        None => Ok(()),
        Some(path) => Err(BadInput(format!(
            "{}: unknown picture format (known: .exr, .png)",
            path.display()
        ))),
    }
}

/// Writes the part asked for into each file; EXR files get every layer beside it.
pub fn write(mut frame: Frame, args: &ViewArgs, outputs: &[PathBuf]) -> anyhow::Result<()> {
    let part = match args.part {
        Part::Full => None,
        Part::Direct => frame.direct.clone(),
        Part::Indirect => frame.indirect.clone(),
    };
    frame.full = part.unwrap_or(frame.full);
    for path in outputs {
        if ending(path) == "exr" {
            exr::write(path, &frame)?;
            println!("{}", path.display());
            continue;
        }
        let picture = frame.picture();
        let exposure = args
            .exposure
            .map_or_else(|| Exposure::automatic(&picture), |ev| Exposure { ev });
        png::write(path, &png::tone_mapped(&picture, exposure))?;
        println!(
            "{}: exposure {:+.2} stops, sRGB",
            path.display(),
            exposure.ev
        );
    }
    Ok(())
}

fn ending(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}
