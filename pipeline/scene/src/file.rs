//! The one door through which files are opened: whole, unpacked, as text.

use crate::SceneError;
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::io::{self, Read};
use std::path::Path;

/// Most bytes of a file, unpacked: more than any scene that fits into memory.
const MAX_BYTES: u64 = 8 << 30;

/// The bytes of a regular file, unpacked where they are gzip. Devices and pipes, which may
/// never end, are refused.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let found = path.metadata()?;
    if !found.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    if found.len() > MAX_BYTES {
        return Err(io::Error::other("more than 8 GiB"));
    }
    let bytes = std::fs::read(path)?;
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    unpacked(&bytes, MAX_BYTES)
}

/// [`read`], failing with the path.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    read(path).map_err(|source| SceneError::Io {
        path: path.to_path_buf(),
        source,
    })
}

/// The content of gzip's members, one after another.
fn unpacked(bytes: &[u8], limit: u64) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(limit + 1);
    decoder
        .read_to_end(&mut content)
        .map_err(|error| io::Error::other(format!("gzip: {error}; is it truncated?")))?;
    if content.len() as u64 > limit {
        let message = format!("gzip: more than {limit} bytes when unpacked");
        return Err(io::Error::other(message));
    }
    Ok(content)
}

/// A file's bytes as text.
///
/// Marks of byte order are taken off, and UTF-16 with such a mark is decoded. Otherwise the
/// text is UTF-8, and a byte that is none stands for the character of its number (Latin-1):
/// names in any old code page stay apart, as their bytes do.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => text_without_mark(rest),
        [0xff, 0xfe, rest @ ..] => wide_text(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide_text(rest, u16::from_be_bytes),
        _ => text_without_mark(bytes),
    }
}

fn text_without_mark(bytes: &[u8]) -> Cow<'_, str> {
    if let Ok(text) = std::str::from_utf8(bytes) {
        return text.into();
    }
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().copied().map(char::from));
    }
    text.into()
}

fn wide_text(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Cow<'_, str> {
    let (units, _) = bytes.as_chunks::<2>();
    char::decode_utf16(units.iter().copied().map(unit))
        .map(|decoded| decoded.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect::<String>()
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn packed(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn text_is_decoded_whatever_wrote_it() {
        assert_eq!(text("é".as_bytes()), "é");
        assert_eq!(text(b"\xef\xbb\xbfv 1"), "v 1");
        assert_eq!(text(b"\xff\xfev\0\xe9\0"), "vé");
        assert_eq!(text(b"\xfe\xff\0v\0\xe9"), "vé");
        assert_eq!(text(b"\xd1\xf2\xe5\xed\xe0 \xc3\xa9"), "Ñòåíà é");
    }

    #[test]
    fn gzip_is_unpacked_within_bounds() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj.gz");
        let two_members = [packed(b"v 0 0 0\n"), packed(b"v 1 0 0\n")].concat();
        std::fs::write(&path, two_members).unwrap();
        assert_eq!(read(&path).unwrap(), b"v 0 0 0\nv 1 0 0\n");
        let bomb = packed(&vec![0; 1 << 20]);
        assert_eq!(unpacked(&bomb, 1 << 20).unwrap().len(), 1 << 20);
        let error = unpacked(&bomb, (1 << 20) - 1).unwrap_err().to_string();
        assert!(error.contains("more than 1048575 bytes"), "{error}");
        for cut in 2..bomb.len() {
            assert!(unpacked(&bomb[..cut], 1 << 20).is_err(), "{cut}");
        }
    }
}
