//! OpenEXR files: one part, 32-bit floats, layers by dotted channel names
//! (`R G B`, `direct.R …`, `indirect.R …`, `cell.id` as uint, `trust.Y`), as tev and Nuke read them.
//! What the frame says of its origin stands in the standard attribute `comments`, a line a fact.

use crate::error::RenderError;
use crate::frame::Frame;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, WritableImage,
};
use glam::Vec3;
use rrf_metrics::Picture;
use std::path::{Path, PathBuf};

/// Scan lines in blocks of 16, deflated: what every reader knows.
const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// Writes a frame, beside the target first and then renamed onto it: a failed write leaves
/// what was there.
pub fn write(path: &Path, frame: &Frame) -> Result<(), RenderError> {
    let failed = |reason: String| RenderError::Write {
        path: path.to_path_buf(),
        reason,
    };
    let mut channels = Vec::new();
    push_rgb(&mut channels, "", &frame.full);
    for (name, layer) in [("direct.", &frame.direct), ("indirect.", &frame.indirect)] {
        if let Some(layer) = layer {
            push_rgb(&mut channels, name, layer);
        }
    }
    if let Some(cell) = &frame.cell {
        let samples = FlatSamples::U32(cell.clone());
        channels.push(AnyChannel::new(text("cell.id"), samples));
    }
    if let Some(trust) = &frame.trust {
        let samples = FlatSamples::F32(trust.clone());
        channels.push(AnyChannel::new(text("trust.Y"), samples));
    }
    let size = (frame.width as usize, frame.height as usize);
    if channels
        .iter()
        .any(|c| c.sample_data.len() != size.0 * size.1)
    {
        return Err(failed("a layer does not cover the frame".to_string()));
    }
    // One standard attribute: named ones of our own would be written in no fixed order.
    let facts: String = frame
        .attributes
        .iter()
        .map(|(name, value)| format!("{name}: {}\n", value.replace('\n', " ")))
        .collect();
    let attributes = LayerAttributes {
        comments: Some(text(&facts)),
        ..LayerAttributes::default()
    };
    let channels = AnyChannels::sort(channels.into());
    let layer = Layer::new(size, attributes, ENCODING, channels);
    let staged = staged(path);
    Image::from_layer(layer)
        .write()
        .to_file(&staged)
        .map_err(|e| failed(e.to_string()))
        .and_then(|()| std::fs::rename(&staged, path).map_err(|e| failed(e.to_string())))
        .inspect_err(|_| {
            // Best effort: the first error is the one worth telling.
            let _ = std::fs::remove_file(&staged);
        })
}

/// Reads the channels R, G and B of an OpenEXR file, whatever their precision.
pub fn read(path: &Path) -> Result<Picture, RenderError> {
    read_layer(path, "")
}

/// Reads `<layer>.R`, `<layer>.G` and `<layer>.B`; the default layer's name is empty.
pub fn read_layer(path: &Path, layer: &str) -> Result<Picture, RenderError> {
    let prefix = if layer.is_empty() {
        String::new()
    } else {
        format!("{layer}.")
    };
    let file = read_all(path)?;
    let channels = &file.layer_data.channel_data.list;
    let find = |name: &str| {
        let wanted = format!("{prefix}{name}");
        channels
            .iter()
            .find(|c| c.name.to_string() == wanted)
            .map(|c| &c.sample_data)
            .ok_or_else(|| RenderError::Channel {
                path: path.to_path_buf(),
                wanted,
                found: names(channels),
            })
    };
    let (r, g, b) = (find("R")?, find("G")?, find("B")?);
    let pixels = r
        .values_as_f32()
        .zip(g.values_as_f32())
        .zip(b.values_as_f32())
        .map(|((r, g), b)| Vec3::new(r, g, b))
        .collect();
    let size = file.layer_data.size;
    Ok(Picture {
        width: size.0 as u32,
        height: size.1 as u32,
        pixels,
    })
}

/// Reads a frame that [`write`] wrote, with its layers and text attributes.
pub fn read_frame(path: &Path) -> Result<Frame, RenderError> {
    let full = read(path)?;
    let file = read_all(path)?;
    let channels = &file.layer_data.channel_data.list;
    let find = |name: &str| {
        channels
            .iter()
            .find(|c| c.name.to_string() == name)
            .map(|c| &c.sample_data)
    };
    let layer = |name: &str| match find(&format!("{name}.R")) {
        Some(_) => read_layer(path, name).map(|picture| Some(picture.pixels)),
        None => Ok(None),
    };
    let facts = match &file.layer_data.attributes.comments {
        Some(comments) => comments.to_string(),
        None => String::new(),
    };
    Ok(Frame {
        width: full.width,
        height: full.height,
        full: full.pixels,
        direct: layer("direct")?,
        indirect: layer("indirect")?,
        cell: find("cell.id").and_then(|samples| match samples {
            FlatSamples::U32(ids) => Some(ids.clone()),
            _ => None,
        }),
        trust: find("trust.Y").map(|samples| samples.values_as_f32().collect()),
        attributes: facts
            .lines()
            .filter_map(|line| line.split_once(": "))
            .map(|(name, value)| (name.to_string(), value.to_string()))
            .collect(),
    })
}

fn read_all(path: &Path) -> Result<Image<Layer<AnyChannels<FlatSamples>>>, RenderError> {
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|e| RenderError::Read {
            path: path.to_path_buf(),
            reason: e.to_string(),
        })
}

fn push_rgb(channels: &mut Vec<AnyChannel<FlatSamples>>, layer: &str, pixels: &[Vec3]) {
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        let samples = pixels.iter().map(|p| p[i]).collect();
        let name = text(&format!("{layer}{name}"));
        channels.push(AnyChannel::new(name, FlatSamples::F32(samples)));
    }
}

/// OpenEXR text is Latin-1; other characters are written as Rust escapes.
fn text(value: &str) -> Text {
    let latin = |c: char| -> String {
        if u32::from(c) < 256 {
            c.to_string()
        } else {
            c.escape_unicode().to_string()
        }
    };
    let value: String = value.chars().map(latin).collect();
    Text::new_or_none(value).unwrap_or_default()
}

fn names(channels: &[AnyChannel<FlatSamples>]) -> String {
    let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    names.join(", ")
}

/// The name under which a file is written before it is renamed.
pub(crate) fn staged(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    path.with_file_name(name)
}
