//! OpenEXR files: one part, 32-bit floats, layers by dotted channel names
//! (`R G B`, `direct.R …`, `indirect.R …`, `cell.id` as uint, `trust.Y`, `albedo.R …`, `normal.X …`,
//! `Z`), as tev and Nuke read them.
//! A frame's origin stands in the standard attribute `comments`, a line a fact.

use super::replace::replace_file;
use crate::error::RenderError;
use crate::frame::Frame;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, Text, WritableImage,
};
use glam::Vec3;
use std::io::Cursor;
use std::path::Path;

pub use super::exr_file::{Selection, read_exr, read_exr_frame, read_exr_layer, read_exr_part};

/// Scan lines in blocks of 16, deflated: what every reader knows.
const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// Writes a frame, whole or not at all.
pub fn write_exr(path: &Path, frame: &Frame) -> Result<(), RenderError> {
    let mut channels = Vec::new();
    push_layer(&mut channels, "", RGB, &frame.full);
    for (name, axes, layer) in [
        ("direct.", RGB, &frame.direct),
        ("indirect.", RGB, &frame.indirect),
        ("albedo.", RGB, &frame.albedo),
        ("normal.", ["X", "Y", "Z"], &frame.normal),
    ] {
        if let Some(layer) = layer {
            push_layer(&mut channels, name, axes, layer);
        }
    }
    let cell = frame.cell.clone().map(FlatSamples::U32);
    let trust = frame.trust.clone().map(FlatSamples::F32);
    let depth = frame.depth.clone().map(FlatSamples::F32);
    for (name, samples) in [("cell.id", cell), ("trust.Y", trust), ("Z", depth)] {
        channels.extend(samples.map(|samples| AnyChannel::new(text(name), samples)));
    }
    // One standard attribute: named ones of our own would be written in no fixed order.
    let facts = frame.attributes.iter();
    let facts = facts.map(|(name, value)| format!("{name}: {}\n", value.replace('\n', " ")));
    let attributes = LayerAttributes {
        comments: Some(text(&facts.collect::<String>())),
        ..LayerAttributes::default()
    };
    let size = (frame.width as usize, frame.height as usize);
    let covered = |c: &AnyChannel<FlatSamples>| c.sample_data.len() == size.0 * size.1;
    replace_file(path, || {
        if !channels.iter().all(covered) {
            return Err("a layer does not cover the frame".into());
        }
        let channels = AnyChannels::sort(channels.into());
        let image = Image::from_layer(Layer::new(size, attributes, ENCODING, channels));
        let mut bytes = Cursor::new(Vec::new());
        let written = image.write().to_buffered(&mut bytes);
        written.map_err(|e| e.to_string())?;
        Ok(bytes.into_inner())
    })
}

const RGB: [&str; 3] = ["R", "G", "B"];

fn push_layer(
    channels: &mut Vec<AnyChannel<FlatSamples>>,
    layer: &str,
    axes: [&str; 3],
    pixels: &[Vec3],
) {
    for (i, name) in axes.into_iter().enumerate() {
        let samples = pixels.iter().map(|p| p[i]).collect();
        let name = text(&format!("{layer}{name}"));
        channels.push(AnyChannel::new(name, FlatSamples::F32(samples)));
    }
}

/// OpenEXR text is Latin-1; other characters are written as Rust escapes.
fn text(value: &str) -> Text {
    let latin = |c: char| match u32::from(c) < 256 {
        true => c.to_string(),
        false => c.escape_unicode().to_string(),
    };
    let value: String = value.chars().map(latin).collect();
    Text::new_or_none(value).unwrap_or_default()
}
