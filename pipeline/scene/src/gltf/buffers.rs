//! Binary data: the `.glb`'s chunk, `data:` URIs, files beside the scene.

use super::document::{Chunk, content, place};
use crate::{SceneError, resolve};
use ::gltf::buffer;
use ::gltf::json::Root;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The bytes of every buffer, cut to the declared length.
pub(super) fn read<'a>(
    path: &Path,
    root: &Root,
    mut chunk: Chunk<'a>,
) -> Result<Vec<Cow<'a, [u8]>>, SceneError> {
    let mut buffers = Vec::with_capacity(root.buffers.len());
    for (index, buffer) in root.buffers.iter().enumerate() {
        let place = || place("buffer", index, buffer.name.as_deref());
        let bytes = match &buffer.uri {
            Some(uri) => Cow::Owned(read_uri(path, uri, place)?),
            // glTF 2.0, section 4.4.3.3: only the first buffer may be the chunk.
            None if index == 0 => chunk.take().ok_or_else(|| {
                content(
                    path,
                    place(),
                    "no uri and no BIN chunk: the .glb has lost its data",
                )
            })?,
            None => return Err(content(path, place(), "no uri")),
        };
        let declared = buffer.byte_length.0;
        let has = bytes.len();
        let bytes = usize::try_from(declared)
            .ok()
            .and_then(|length| cut(bytes, length))
            .ok_or_else(|| {
                let message = format!("declared as {declared} bytes, has {has}: truncated");
                content(path, place(), message)
            })?;
        buffers.push(bytes);
    }
    Ok(buffers)
}

fn cut(bytes: Cow<'_, [u8]>, length: usize) -> Option<Cow<'_, [u8]>> {
    match bytes {
        Cow::Borrowed(bytes) => bytes.get(..length).map(Cow::Borrowed),
        Cow::Owned(mut bytes) => (length <= bytes.len()).then(|| {
            bytes.truncate(length);
            Cow::Owned(bytes)
        }),
    }
}

/// The bytes behind a URI: `data:` with base64, or a file relative to the scene's folder.
pub(super) fn read_uri(
    path: &Path,
    uri: &str,
    place: impl Fn() -> String,
) -> Result<Vec<u8>, SceneError> {
    if uri.starts_with("data:") {
        // The crate's own decoder; it pads to a multiple of four bytes.
        return buffer::Data::from_source(buffer::Source::Uri(uri), None)
            .map(|data| data.0)
            .map_err(|error| content(path, place(), format!("data URI: {error}")));
    }
    crate::file::read_bytes(&file_of(path, uri, place)?)
}

/// The file that a URI names. A blank is `%20` there, but some exporters write names as they
/// are, whatever signs are in them.
fn file_of(path: &Path, uri: &str, place: impl Fn() -> String) -> Result<PathBuf, SceneError> {
    if uri.contains("://") {
        let message = format!("{uri:?}: only data: URIs and files are read here");
        return Err(content(path, place(), message));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = urlencoding::decode(uri)
        .map_err(|error| content(path, place(), format!("uri {uri:?}: {error}")))?;
    let decoded = resolve::find(&[folder], &name).path;
    let raw = resolve::find(&[folder], uri).path;
    Ok(if !decoded.is_file() && raw.is_file() {
        raw
    } else {
        decoded
    })
}
