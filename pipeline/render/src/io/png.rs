//! PNG pictures to look at: tone-mapped frames, cell maps, contact sheets.

use super::replace::replace_file;
use crate::error::RenderError;
use crate::frame::Frame;
use image::{ImageFormat, Rgb, RgbImage};
use rrf_metrics::Picture;
use rrf_metrics::tone::{Exposure, srgb8};
use std::io::Cursor;
use std::path::Path;

/// An 8-bit sRGB picture.
pub type Shown = RgbImage;

/// The picture at a stated exposure.
pub fn tone_mapped(picture: &Picture, exposure: Exposure) -> Shown {
    let (width, height) = (picture.width, picture.height);
    Shown::from_fn(width, height, |x, y| {
        let at = y as usize * width as usize + x as usize;
        let pixel = picture.pixels.get(at).copied().unwrap_or_default();
        Rgb(srgb8(pixel, exposure))
    })
}

/// False colours of the cells; black where no net lit the pixel.
pub fn cell_map(frame: &Frame) -> Shown {
    Shown::from_fn(frame.width, frame.height, |x, y| {
        let at = y as usize * frame.width as usize + x as usize;
        let cell = frame.cell.as_ref().and_then(|cells| cells.get(at));
        Rgb(cell.map_or([0; 3], |&cell| cell_color(cell)))
    })
}

/// A color for a cell id: hues a golden angle apart, so that neighbouring ids differ,
/// in three brightnesses.
pub fn cell_color(cell: u32) -> [u8; 3] {
    if cell == u32::MAX {
        return [0; 3];
    }
    let hue = 6.0 * (f64::from(cell) * 0.618_033_988_749_895).fract();
    let value = [1.0, 0.75, 0.55][(cell / 8 % 3) as usize];
    [5.0, 3.0, 1.0].map(|n: f64| {
        let k = (n + hue) % 6.0;
        let chroma = 0.65 * k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - chroma)).round() as u8
    })
}

/// Writes a picture, whole or not at all.
pub fn write_png(path: &Path, shown: &Shown) -> Result<(), RenderError> {
    replace_file(path, || {
        let mut bytes = Cursor::new(Vec::new());
        let saved = shown.write_to(&mut bytes, ImageFormat::Png);
        saved.map_err(|e| e.to_string())?;
        Ok(bytes.into_inner())
    })
}

/// A small version, at most `side` pixels wide and high.
pub fn thumbnail(shown: &Shown, side: u32) -> Shown {
    let longest = shown.width().max(shown.height());
    if longest <= side {
        return shown.clone();
    }
    let scaled = |length: u32| (u64::from(length) * u64::from(side) / u64::from(longest)).max(1);
    let (width, height) = (scaled(shown.width()), scaled(shown.height()));
    image::imageops::thumbnail(shown, width as u32, height as u32)
}

/// Pictures side by side, `columns` in a row from the top left, on mid grey with a margin.
pub fn contact_sheet(pictures: &[Shown], columns: u32) -> Shown {
    const MARGIN: u32 = 8;
    let columns = columns.max(1);
    let rows = (pictures.len() as u32).div_ceil(columns);
    let columns = columns.min(pictures.len() as u32);
    let width = pictures.iter().map(|p| p.width()).max().unwrap_or(0);
    let height = pictures.iter().map(|p| p.height()).max().unwrap_or(0);
    let mut sheet = Shown::from_pixel(
        MARGIN + columns * (width + MARGIN),
        MARGIN + rows * (height + MARGIN),
        Rgb([96; 3]),
    );
    for (i, picture) in (0u32..).zip(pictures) {
        let x = MARGIN + i % columns * (width + MARGIN);
        let y = MARGIN + i / columns * (height + MARGIN);
        image::imageops::replace(&mut sheet, picture, i64::from(x), i64::from(y));
    }
    sheet
}
