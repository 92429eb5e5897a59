//! OpenEXR files of any program, read: several parts, data windows, any precision.
//!
//! A picture is what the display window shows. A part's data window may be smaller, and what
//! it leaves out is black; or larger, and what lies outside is cut off.

use crate::error::RenderError;
use crate::frame::Frame;
use exr::meta::MetaData;
use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, Layers, ReadChannels, ReadLayers};
use glam::Vec3;
use rrf_metrics::Picture;
use std::path::Path;

/// Longest side of a window in pixels.
const MAX_SIDE: u64 = 65_535;

/// Most bytes of the samples of all parts, read.
const MAX_BYTES: u64 = 8 << 30;

/// Most sample bytes of a file's byte: far beyond what a compression reaches on a picture of
/// one colour, far below what a damaged header claims.
const MAX_RATIO: u64 = 1 << 14;

/// Which picture of a file is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selection<'a> {
    /// Prefix of the channels, as in `direct.R`; the picture itself has none.
    pub layer: &'a str,
    /// The part by name or by number from 0; otherwise the first with these channels.
    pub part: Option<&'a str>,
}

/// Reads the channels R, G and B of an OpenEXR file, whatever their precision.
pub fn read_exr(path: &Path) -> Result<Picture, RenderError> {
    read_exr_part(path, Selection::default())
}

/// Reads `<layer>.R`, `<layer>.G` and `<layer>.B`; the default layer's name is empty.
pub fn read_exr_layer(path: &Path, layer: &str) -> Result<Picture, RenderError> {
    read_exr_part(path, Selection { layer, part: None })
}

/// Reads a layer of a part.
pub fn read_exr_part(path: &Path, selection: Selection) -> Result<Picture, RenderError> {
    let file = ExrFile::open(path)?;
    file.picture(file.part(selection)?, selection.layer)
}

/// Reads a frame that [`super::exr::write_exr`] wrote, with its layers and attributes.
pub fn read_exr_frame(path: &Path) -> Result<Frame, RenderError> {
    let file = ExrFile::open(path)?;
    let part = file.part(Selection::default())?;
    let full = file.picture(part, "")?;
    let layer = |name: &str| match channel(part, &format!("{name}.R")) {
        Some(_) => file.picture(part, name).map(|picture| Some(picture.pixels)),
        None => Ok(None),
    };
    let numbers =
        |name: &str| -> Option<Vec<f32>> { Some(channel(part, name)?.values_as_f32().collect()) };
    let comments = part.attributes.comments.as_ref();
    let facts = comments.map(ToString::to_string).unwrap_or_default();
    let facts = facts.lines().filter_map(|line| line.split_once(": "));
    Ok(Frame {
        width: full.width,
        height: full.height,
        full: full.pixels,
        direct: layer("direct")?,
        indirect: layer("indirect")?,
        cell: match channel(part, "cell.id") {
            Some(FlatSamples::U32(ids)) => Some(ids.clone()),
            _ => None,
        },
        trust: numbers("trust.Y"),
        albedo: layer("albedo")?,
        normal: vectors(["normal.X", "normal.Y", "normal.Z"].map(numbers)),
        depth: numbers("Z"),
        attributes: facts.map(|(a, b)| (a.to_string(), b.to_string())).collect(),
    })
}

/// Vectors of three columns, if all of them are there.
fn vectors([x, y, z]: [Option<Vec<f32>>; 3]) -> Option<Vec<Vec3>> {
    let rows = x?.into_iter().zip(y?).zip(z?);
    Some(rows.map(|((x, y), z)| Vec3::new(x, y, z)).collect())
}

type Part = Layer<AnyChannels<FlatSamples>>;

/// An open file's parts, with all channels.
struct ExrFile<'a> {
    path: &'a Path,
    image: Image<Layers<AnyChannels<FlatSamples>>>,
}

impl ExrFile<'_> {
    fn open(path: &Path) -> Result<ExrFile<'_>, RenderError> {
        let unreadable = |reason: String| RenderError::Read {
            path: path.to_path_buf(),
            reason,
        };
        check_claims(path).map_err(unreadable)?;
        let channels = || {
            exr::prelude::read()
                .no_deep_data()
                .largest_resolution_level()
                .all_channels()
        };
        let all = channels().all_layers().all_attributes().from_file(path);
        let image = all.or_else(|error| {
            // A part of deep pixels is none for a picture: the first flat one may do.
            let first = channels().first_valid_layer().all_attributes();
            let first = first.from_file(path).map_err(|_| error)?;
            let layers = Layers::from_iter([first.layer_data]);
            Ok(Image::new(first.attributes, layers))
        });
        match image {
            Ok(image) => Ok(ExrFile { path, image }),
            Err(error) => {
                let error: exr::error::Error = error;
                Err(unreadable(error.to_string()))
            }
        }
    }

    /// The part named, or the first that has the layer.
    fn part(&self, selection: Selection) -> Result<&Part, RenderError> {
        let parts = &self.image.layer_data;
        let wanted = channel_name(selection.layer, "R");
        let Some(named) = selection.part else {
            let found = parts.iter().find(|part| channel(part, &wanted).is_some());
            return found.ok_or_else(|| self.no_channel(parts, wanted));
        };
        let by_name = parts.iter().find(|part| part_name(part) == named);
        let by_number = || parts.get(named.parse::<usize>().ok()?);
        by_name.or_else(by_number).ok_or_else(|| {
            let found = parts.iter().enumerate();
            let found = found.map(|(i, part)| format!("{i} \"{}\"", part_name(part)));
            RenderError::Part {
                path: self.path.to_path_buf(),
                wanted: named.to_owned(),
                found: found.collect::<Vec<_>>().join(", "),
            }
        })
    }

    fn no_channel(&self, parts: &[Part], wanted: String) -> RenderError {
        let channels = parts.iter().flat_map(|part| &part.channel_data.list);
        RenderError::Channel {
            path: self.path.to_path_buf(),
            found: (channels.map(|c| c.name.to_string()))
                .collect::<Vec<_>>()
                .join(", "),
            wanted,
        }
    }

    /// The display window of a part's layer.
    fn picture(&self, part: &Part, layer: &str) -> Result<Picture, RenderError> {
        let find = |name: &str| {
            let wanted = channel_name(layer, name);
            channel(part, &wanted)
                .ok_or_else(|| self.no_channel(std::slice::from_ref(part), wanted))
        };
        let (r, g, b) = (find("R")?, find("G")?, find("B")?);
        let size = part.size;
        if [r, g, b]
            .iter()
            .any(|channel| channel.len() != size.0 * size.1)
        {
            return Err(RenderError::Read {
                path: self.path.to_path_buf(),
                reason: "its channels are subsampled; write all at full resolution".into(),
            });
        }
        let rg = r.values_as_f32().zip(g.values_as_f32());
        let rgb = rg.zip(b.values_as_f32());
        let data: Vec<Vec3> = rgb.map(|((r, g), b)| Vec3::new(r, g, b)).collect();
        let window = self.image.attributes.display_window;
        let origin = part.attributes.layer_position;
        let (left, top) = (
            i64::from(origin.0) - i64::from(window.position.0),
            i64::from(origin.1) - i64::from(window.position.1),
        );
        let (width, height) = (window.size.0, window.size.1);
        if (left, top) == (0, 0) && (width, height) == (size.0, size.1) {
            return Ok(Picture {
                width: width as u32,
                height: height as u32,
                pixels: data,
            });
        }
        let mut pixels = vec![Vec3::ZERO; width * height];
        for (row, line) in (top..).zip(data.chunks(size.0.max(1))) {
            let row = usize::try_from(row).ok().filter(|&row| row < height);
            let Some(target) = row.and_then(|row| pixels.get_mut(row * width..(row + 1) * width))
            else {
                continue;
            };
            for (column, &pixel) in (left..).zip(line) {
                let slot = usize::try_from(column).ok();
                if let Some(slot) = slot.and_then(|column| target.get_mut(column)) {
                    *slot = pixel;
                }
            }
        }
        Ok(Picture {
            width: width as u32,
            height: height as u32,
            pixels,
        })
    }
}

fn channel_name(layer: &str, name: &str) -> String {
    let dot = if layer.is_empty() { "" } else { "." };
    format!("{layer}{dot}{name}")
}

fn channel<'a>(part: &'a Part, name: &str) -> Option<&'a FlatSamples> {
    let channels = &part.channel_data.list;
    let channel = channels.iter().find(|c| c.name.to_string() == name)?;
    Some(&channel.sample_data)
}

fn part_name(part: &Part) -> String {
    let name = part.attributes.layer_name.as_ref();
    name.map(ToString::to_string).unwrap_or_default()
}

/// Holds what the headers claim against the file's size before memory is taken for it.
fn check_claims(path: &Path) -> Result<(), String> {
    let found = path.metadata().map_err(|error| error.to_string())?;
    if !found.is_file() {
        return Err("not a regular file".into());
    }
    let headers = MetaData::read_from_file(path, false).map_err(|error| error.to_string())?;
    let mut bytes = 0_u64;
    for header in &headers.headers {
        let display = header.shared_attributes.display_window.size;
        for (what, size) in [("data", header.layer_size), ("display", display)] {
            let (width, height) = (size.0 as u64, size.1 as u64);
            if width.max(height) > MAX_SIDE {
                return Err(format!(
                    "its {what} window has {width} x {height} pixels; each side may have {MAX_SIDE}"
                ));
            }
            if what == "display" && width * height * 12 > MAX_BYTES {
                return Err(format!(
                    "its display window of {width} x {height} is too large"
                ));
            }
        }
        // 32 bits a sample at most, and once more as the picture's own.
        let pixels = header.layer_size.0 as u64 * header.layer_size.1 as u64;
        bytes = bytes.saturating_add(pixels * (4 * header.channels.list.len() as u64 + 12));
    }
    if bytes > MAX_BYTES {
        return Err(format!(
            "it has {bytes} bytes of samples; {MAX_BYTES} are read"
        ));
    }
    if bytes > MAX_RATIO.saturating_mul(found.len()) {
        return Err(format!(
            "it claims {bytes} bytes of samples in a file of {}: truncated or damaged",
            found.len()
        ));
    }
    Ok(())
}
