//! OpenEXR files: one part, 32-bit floats, layers by dotted channel names
//! (`R G B`, `direct.R …`, `indirect.R …`, `cell.id` as uint, `trust.Y`), as tev and Nuke read them.
//! A frame's origin stands in the standard attribute `comments`, a line a fact.

use super::replace::replace_file;
use crate::error::RenderError;
use crate::frame::Frame;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, WritableImage,
};
use glam::Vec3;
use rrf_metrics::Picture;
use std::path::Path;

/// Scan lines in blocks of 16, deflated: what every reader knows.
const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// Writes a frame, whole or not at all.
pub fn write_exr(path: &Path, frame: &Frame) -> Result<(), RenderError> {
    let mut channels = Vec::new();
    push_rgb(&mut channels, "", &frame.full);
    for (name, layer) in [("direct.", &frame.direct), ("indirect.", &frame.indirect)] {
        if let Some(layer) = layer {
            push_rgb(&mut channels, name, layer);
        }
    }
    let cell = frame.cell.clone().map(FlatSamples::U32);
    let trust = frame.trust.clone().map(FlatSamples::F32);
    for (name, samples) in [("cell.id", cell), ("trust.Y", trust)] {
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
    replace_file(path, |staged| {
        if !channels.iter().all(covered) {
            return Err("a layer does not cover the frame".into());
        }
        let channels = AnyChannels::sort(channels.into());
        let image = Image::from_layer(Layer::new(size, attributes, ENCODING, channels));
        image.write().to_file(staged).map_err(|e| e.to_string())
    })
}

/// Reads the channels R, G and B of an OpenEXR file, whatever their precision.
pub fn read_exr(path: &Path) -> Result<Picture, RenderError> {
    read_exr_layer(path, "")
}

/// Reads `<layer>.R`, `<layer>.G` and `<layer>.B`; the default layer's name is empty.
pub fn read_exr_layer(path: &Path, layer: &str) -> Result<Picture, RenderError> {
    ExrFile::open(path)?.picture(layer)
}

/// Reads a frame that [`write_exr`] wrote, with its layers and attributes.
pub fn read_exr_frame(path: &Path) -> Result<Frame, RenderError> {
    let file = ExrFile::open(path)?;
    let full = file.picture("")?;
    let layer = |name: &str| match file.channel(&format!("{name}.R")) {
        Some(_) => file.picture(name).map(|picture| Some(picture.pixels)),
        None => Ok(None),
    };
    let comments = file.image.layer_data.attributes.comments.as_ref();
    let facts = comments.map(ToString::to_string).unwrap_or_default();
    let facts = facts.lines().filter_map(|line| line.split_once(": "));
    Ok(Frame {
        width: full.width,
        height: full.height,
        full: full.pixels,
        direct: layer("direct")?,
        indirect: layer("indirect")?,
        cell: match file.channel("cell.id") {
            Some(FlatSamples::U32(ids)) => Some(ids.clone()),
            _ => None,
        },
        trust: (file.channel("trust.Y")).map(|samples| samples.values_as_f32().collect()),
        attributes: facts.map(|(a, b)| (a.to_string(), b.to_string())).collect(),
    })
}

/// An open file's first layer, with all channels.
struct ExrFile<'a> {
    path: &'a Path,
    image: Image<Layer<AnyChannels<FlatSamples>>>,
}

impl ExrFile<'_> {
    fn open(path: &Path) -> Result<ExrFile<'_>, RenderError> {
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .map_err(|e| RenderError::Read {
                path: path.to_path_buf(),
                reason: e.to_string(),
            })?;
        Ok(ExrFile { path, image })
    }

    fn channel(&self, name: &str) -> Option<&FlatSamples> {
        let channels = &self.image.layer_data.channel_data.list;
        let channel = channels.iter().find(|c| c.name.to_string() == name)?;
        Some(&channel.sample_data)
    }

    fn picture(&self, layer: &str) -> Result<Picture, RenderError> {
        let dot = if layer.is_empty() { "" } else { "." };
        let find = |name: &str| {
            let wanted = format!("{layer}{dot}{name}");
            self.channel(&wanted).ok_or_else(|| {
                let channels = &self.image.layer_data.channel_data.list;
                let found = channels.iter().map(|c| c.name.to_string());
                RenderError::Channel {
                    path: self.path.to_path_buf(),
                    found: found.collect::<Vec<_>>().join(", "),
                    wanted,
                }
            })
        };
        let (r, g, b) = (find("R")?, find("G")?, find("B")?);
        let rg = r.values_as_f32().zip(g.values_as_f32());
        let rgb = rg.zip(b.values_as_f32());
        let size = self.image.layer_data.size;
        Ok(Picture {
            width: size.0 as u32,
            height: size.1 as u32,
            pixels: rgb.map(|((r, g), b)| Vec3::new(r, g, b)).collect(),
        })
    }
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
    let latin = |c: char| match u32::from(c) < 256 {
        true => c.to_string(),
        false => c.escape_unicode().to_string(),
    };
    let value: String = value.chars().map(latin).collect();
    Text::new_or_none(value).unwrap_or_default()
}
