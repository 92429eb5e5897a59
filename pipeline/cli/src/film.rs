//! Frames of a camera's path: a numbered picture each, and a sheet of all.

use crate::failure::BadInput;
use anyhow::Context;
use clap::ValueEnum;
use rrf_metrics::tone::Exposure;
use rrf_render::{Frame, exr, png};
use std::path::{Path, PathBuf};

/// Longest side of a picture on the contact sheet.
const THUMBNAIL: u32 = 192;

/// A format of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FrameFormat {
    /// OpenEXR, linear, with every layer but `trust`.
    Exr,
    /// 8-bit sRGB, tone-mapped.
    Png,
}

/// A folder that fills with frames.
pub struct Film {
    folder: PathBuf,
    formats: Vec<FrameFormat>,
    /// One for all frames: an automatic one a frame would flicker.
    exposure: Option<Exposure>,
    thumbnails: Vec<png::Shown>,
}

impl Film {
    /// Makes the folder, which has to be empty: frames of another path must not stay among these.
    pub fn new(
        folder: &Path,
        formats: &[FrameFormat],
        exposure: Option<Exposure>,
    ) -> anyhow::Result<Film> {
        let place = || folder.display();
        rrf_store::atomic::create_folder(folder)?;
        let mut entries =
            std::fs::read_dir(folder).with_context(|| format!("{}: cannot be read", place()))?;
        if entries.next().is_some() {
            let told = format!(
                "{}: is not empty; give a new folder for the frames",
                place()
            );
            return Err(BadInput(told).into());
        }
        Ok(Film {
            folder: folder.to_path_buf(),
            formats: formats.to_vec(),
            exposure,
            thumbnails: Vec::new(),
        })
    }

    /// Writes the next frame.
    pub fn add(&mut self, frame: &Frame) -> anyhow::Result<()> {
        let picture = frame.picture();
        let automatic = || Exposure::automatic(&picture);
        let exposure = *self.exposure.get_or_insert_with(automatic);
        let shown = png::tone_mapped(&picture, exposure);
        let name = format!("frame-{:05}", self.thumbnails.len());
        for format in &self.formats {
            match format {
                FrameFormat::Exr => {
                    exr::write_exr(&self.folder.join(name.clone() + ".exr"), frame)?
                }
                FrameFormat::Png => {
                    png::write_png(&self.folder.join(name.clone() + ".png"), &shown)?;
                }
            }
        }
        self.thumbnails.push(png::thumbnail(&shown, THUMBNAIL));
        Ok(())
    }

    /// Writes the contact sheet.
    pub fn finish(self) -> anyhow::Result<()> {
        let count = self.thumbnails.len();
        let columns = (count as f64).sqrt().ceil() as u32;
        let sheet = png::contact_sheet(&self.thumbnails, columns);
        png::write_png(&self.folder.join("contact-sheet.png"), &sheet)?;
        println!(
            "{}: {count} frames, exposure {:+.2} stops, sRGB",
            self.folder.display(),
            self.exposure.unwrap_or_default().ev
        );
        Ok(())
    }
}
