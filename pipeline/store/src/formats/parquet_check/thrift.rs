//! A walk over Thrift's compact protocol, which Parquet's headers are written in: enough to look
//! at a few fields and step over the rest, allocating nothing. `None` is malformed input.
//!
//! Source: Apache Thrift, doc/specs/thrift-compact-protocol.md.

/// Structures within structures that are followed.
const DEPTH: usize = 16;

const TRUE: u8 = 1;
const FALSE: u8 = 2;
const I8: u8 = 3;
const I16: u8 = 4;
pub(super) const I32: u8 = 5;
const I64: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
pub(super) const LIST: u8 = 9;
const SET: u8 = 10;
const MAP: u8 = 11;
pub(super) const STRUCT: u8 = 12;
const UUID: u8 = 13;

/// A place in bytes.
pub(super) struct Compact<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Compact<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Compact<'a> {
        Compact { bytes, at: 0 }
    }

    /// Bytes walked so far.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// Calls `each` with id and type of every field of a structure; it must take the value.
    pub(super) fn fields(
        &mut self,
        mut each: impl FnMut(&mut Compact<'a>, i16, u8) -> Option<()>,
    ) -> Option<()> {
        let mut id = 0i16;
        loop {
            let head = self.byte()?;
            let (delta, kind) = (head >> 4, head & 15);
            if head == 0 {
                return Some(());
            }
            id = match delta {
                0 => i16::try_from(self.integer()?).ok()?,
                delta => id.checked_add(i16::from(delta))?,
            };
            each(self, id, kind)?;
        }
    }

    /// Length of a list and type of its items.
    pub(super) fn list(&mut self) -> Option<(u64, u8)> {
        let head = self.byte()?;
        let length = match head >> 4 {
            15 => self.varint()?,
            short => u64::from(short),
        };
        // An item takes a byte at least.
        (length <= (self.bytes.len() - self.at) as u64).then_some((length, head & 15))
    }

    /// A whole number of any width.
    pub(super) fn integer(&mut self) -> Option<i64> {
        let zigzag = self.varint()?;
        Some((zigzag >> 1) as i64 ^ -((zigzag & 1) as i64))
    }

    /// Steps over a value.
    pub(super) fn skip(&mut self, kind: u8) -> Option<()> {
        self.skip_to(kind, DEPTH)
    }

    fn skip_to(&mut self, kind: u8, depth: usize) -> Option<()> {
        let depth = depth.checked_sub(1)?;
        match kind {
            // The value is in the field's head.
            TRUE | FALSE => Some(()),
            I8 => self.step(1),
            I16 | I32 | I64 => self.varint().map(|_| ()),
            DOUBLE => self.step(8),
            UUID => self.step(16),
            BINARY => {
                let length = self.varint()?;
                self.step(length)
            }
            LIST | SET => {
                let (length, kind) = self.list()?;
                (0..length).try_for_each(|_| self.skip_item(kind, depth))
            }
            MAP => {
                let length = self.varint()?;
                if length == 0 {
                    return Some(());
                }
                let kinds = self.byte()?;
                (0..length).try_for_each(|_| {
                    self.skip_item(kinds >> 4, depth)?;
                    self.skip_item(kinds & 15, depth)
                })
            }
            STRUCT => self.fields(|this, _, kind| this.skip_to(kind, depth)),
            _ => None,
        }
    }

    /// An item of a list: there, a truth value takes a byte.
    fn skip_item(&mut self, kind: u8, depth: usize) -> Option<()> {
        match kind {
            TRUE | FALSE => self.step(1),
            kind => self.skip_to(kind, depth),
        }
    }

    fn step(&mut self, length: u64) -> Option<()> {
        let end = self.at.checked_add(usize::try_from(length).ok()?)?;
        (end <= self.bytes.len()).then(|| self.at = end)
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        varint(self.bytes, &mut self.at)
    }
}

/// A whole number in groups of seven bits, the lowest first.
pub(super) fn varint(bytes: &[u8], at: &mut usize) -> Option<u64> {
    let mut value = 0u64;
    for shift in (0..64).step_by(7) {
        let byte = *bytes.get(*at)?;
        *at += 1;
        value |= u64::from(byte & 127) << shift;
        if byte < 128 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Zigzag and varint examples of the specification.
    #[test]
    fn integers() {
        let cases: [(&[u8], i64); 6] = [
            (&[0], 0),
            (&[1], -1),
            (&[2], 1),
            (&[0x64], 50),
            (&[0xff, 0xff, 0xff, 0xff, 0x0f], i64::from(i32::MIN)),
            (&[0xfe, 0xff, 0xff, 0xff, 0x0f], i64::from(i32::MAX)),
        ];
        for (bytes, value) in cases {
            assert_eq!(Compact::new(bytes).integer(), Some(value));
        }
        assert_eq!(Compact::new(&[0x80; 20]).integer(), None);
        assert_eq!(Compact::new(&[0x80]).integer(), None);
    }

    #[test]
    fn fields_by_delta_and_by_id() {
        // 1: i32 5; 3: list of two i32; 40 (long form): true; stop.
        let bytes = [0x15, 10, 0x29, 0x25, 2, 4, 0x01, 80, 0];
        let mut seen = Vec::new();
        let mut walk = Compact::new(&bytes);
        walk.fields(|this, id, kind| {
            seen.push((id, kind));
            this.skip(kind)
        })
        .unwrap();
        assert_eq!(seen, [(1, I32), (3, LIST), (40, TRUE)]);
        assert_eq!(walk.position(), bytes.len());
    }

    /// Nothing malformed is stepped over: lengths beyond the end, endless nesting, open ends.
    #[test]
    fn malformed() {
        let nested = [0x1c; 64];
        let cases: [&[u8]; 4] = [
            &[0x18, 5, 1, 2],
            &nested,
            &[0x19, 0xf5, 0xff, 0x7f],
            &[0x15],
        ];
        for bytes in cases {
            let mut walk = Compact::new(bytes);
            assert_eq!(
                walk.fields(|this, _, kind| this.skip(kind)),
                None,
                "{bytes:?}"
            );
        }
    }
}
