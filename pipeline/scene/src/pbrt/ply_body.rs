//! Numbers of a PLY file's body.

use super::ply_header::{Element, Format, Scalar, Wrong, wrong};

/// The bytes after the header, taken number by number.
pub(super) struct Body<'a> {
    format: Format,
    rest: &'a [u8],
}

impl<'a> Body<'a> {
    /// The bytes after a header.
    pub(super) fn new(format: Format, rest: &'a [u8]) -> Self {
        Self { format, rest }
    }

    /// The next number, or `None` where the file ends or has none.
    pub(super) fn number(&mut self, scalar: Scalar) -> Option<f64> {
        if self.format == Format::Ascii {
            return self.word()?.parse::<f64>().ok();
        }
        Some(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    /// The next `N` bytes, the lowest first.
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        let mut bytes = *taken;
        if self.format == Format::Big {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn word(&mut self) -> Option<&str> {
        let start = self
            .rest
            .iter()
            .position(|byte| !byte.is_ascii_whitespace())?;
        let text = self.rest.get(start..)?;
        let end = text
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        std::str::from_utf8(word).ok()
    }

    /// The length of a list, then its numbers through `each`; false if the file ends.
    pub(super) fn list(
        &mut self,
        length: Scalar,
        scalar: Scalar,
        mut each: impl FnMut(f64),
    ) -> bool {
        let Some(length) = self.number(length).filter(|n| *n >= 0.0 && *n == n.trunc()) else {
            return false;
        };
        for _ in 0..length as u64 {
            match self.number(scalar) {
                Some(value) => each(value),
                None => return false,
            }
        }
        true
    }
}

/// The fault of an element whose data end or are no numbers.
pub(super) fn broken<T>(element: &Element, index: u64) -> Result<T, Wrong> {
    wrong(
        format!("{} {index}", element.name),
        format!(
            "its data end or are no numbers, of {} announced; is the file truncated?",
            element.count
        ),
    )
}
