//! Page headers of one column chunk (parquet-format, `PageHeader`).

use super::thrift::{Compact, I32, STRUCT};

/// No codec of the format gets more out of a byte: zstd codes 128 KiB of one value in 4 bytes.
const LARGEST_RATIO: u64 = 1 << 15;
/// Small pages are let be.
const SLACK: u64 = 1 << 16;
/// Encodings of the format (`Encoding`).
const DELTA_LENGTH_BYTE_ARRAY: i64 = 6;
const DELTA_BYTE_ARRAY: i64 = 7;

const DATA_PAGE: i64 = 0;
const INDEX_PAGE: i64 = 1;
const DICTIONARY_PAGE: i64 = 2;
const DATA_PAGE_V2: i64 = 3;

/// What the pages of a chunk hold.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Chunk {
    /// Values in data pages.
    pub values: u64,
    /// Decoded bytes of the dictionary page.
    pub dictionary: u64,
    /// Whether there is a page in DELTA_LENGTH_BYTE_ARRAY.
    pub delta_length: bool,
    /// Whether there is a page in DELTA_BYTE_ARRAY.
    pub delta: bool,
    /// Decoded bytes of the largest page.
    pub largest_page: u64,
    /// Decoded bytes of all pages.
    pub decoded: u64,
}

#[derive(Default)]
struct Header {
    kind: Option<i64>,
    decoded: Option<i64>,
    stored: Option<i64>,
    /// By kind of page.
    values: [Option<i64>; 4],
    encoding: [Option<i64>; 4],
}

/// Walks a chunk from its first page header to its last byte. `width` is the size of a value,
/// levels included, `None` for texts.
pub(super) fn walk(bytes: &[u8], width: Option<u64>) -> Result<Chunk, String> {
    let (mut chunk, mut at) = (Chunk::default(), 0);
    while at < bytes.len() {
        let rest = bytes.get(at..).unwrap_or_default();
        let page = page(rest, width).map_err(|reason| format!("byte {at}: {reason}"))?;
        match page.kind {
            DATA_PAGE | DATA_PAGE_V2 => chunk.values = chunk.values.saturating_add(page.values),
            DICTIONARY_PAGE if chunk.dictionary > 0 => return Err("two dictionaries".into()),
            DICTIONARY_PAGE => chunk.dictionary = page.decoded.max(1),
            _ => {}
        }
        chunk.delta_length |= page.encoding == Some(DELTA_LENGTH_BYTE_ARRAY);
        chunk.delta |= page.encoding == Some(DELTA_BYTE_ARRAY);
        chunk.largest_page = chunk.largest_page.max(page.decoded);
        chunk.decoded = chunk.decoded.saturating_add(page.decoded);
        at += page.length;
    }
    Ok(chunk)
}

struct Page {
    kind: i64,
    values: u64,
    encoding: Option<i64>,
    decoded: u64,
    /// Header and stored bytes.
    length: usize,
}

/// The page that begins here.
fn page(bytes: &[u8], width: Option<u64>) -> Result<Page, String> {
    let malformed = || "malformed page header".to_string();
    let (header, length) = header(bytes).ok_or_else(malformed)?;
    let kind = header.kind.ok_or_else(malformed)?;
    let number = |n: Option<i64>| n.and_then(|n| u64::try_from(n).ok()).ok_or_else(malformed);
    let (decoded, stored) = (number(header.decoded)?, number(header.stored)?);
    let of_kind = |numbers: [Option<i64>; 4]| {
        let place = usize::try_from(kind).ok();
        place
            .and_then(|place| numbers.get(place).copied())
            .flatten()
    };
    let values = match kind {
        DATA_PAGE | DATA_PAGE_V2 | DICTIONARY_PAGE => number(of_kind(header.values))?,
        INDEX_PAGE => 0,
        kind => return Err(format!("a page of unknown kind {kind}")),
    };
    let end = usize::try_from(stored)
        .ok()
        .and_then(|stored| length.checked_add(stored));
    let end = end.filter(|&end| end <= bytes.len());
    let length = end.ok_or_else(|| format!("a page of {stored} bytes goes beyond its column"))?;
    // Values of fixed width as they are; delta coding can take a little more.
    let plausible = width.map_or(u64::MAX, |width| values.saturating_mul(2 * width));
    let most = plausible.min(stored.saturating_mul(LARGEST_RATIO));
    if decoded > most.saturating_add(SLACK) {
        return Err(format!(
            "{stored} bytes and {values} values decode to {decoded} bytes"
        ));
    }
    // An entry takes a byte at least.
    if kind == DICTIONARY_PAGE && values > decoded {
        return Err(format!(
            "a dictionary of {values} entries in {decoded} bytes"
        ));
    }
    Ok(Page {
        kind,
        values,
        encoding: of_kind(header.encoding),
        decoded,
        length,
    })
}

/// A page header and its length. A field that is there twice, or of another type than the
/// format says, is malformed: a decoder could read it in another way.
fn header(bytes: &[u8]) -> Option<(Header, usize)> {
    let mut header = Header::default();
    let mut walk = Compact::new(bytes);
    walk.fields(|this, id, kind| match id {
        1 => number(this, kind, &mut header.kind),
        2 => number(this, kind, &mut header.decoded),
        3 => number(this, kind, &mut header.stored),
        5 => of_kind(this, kind, &mut header, DATA_PAGE, 2),
        7 => of_kind(this, kind, &mut header, DICTIONARY_PAGE, 2),
        8 => of_kind(this, kind, &mut header, DATA_PAGE_V2, 4),
        _ => this.skip(kind),
    })?;
    Some((header, walk.position()))
}

fn number(walk: &mut Compact, kind: u8, to: &mut Option<i64>) -> Option<()> {
    let fresh = kind == I32 && to.is_none();
    *to = Some(walk.integer().filter(|_| fresh)?);
    Some(())
}

/// Field 1 of the header of each kind of page is its number of values, `encoding` its encoding.
fn of_kind(
    walk: &mut Compact,
    kind: u8,
    header: &mut Header,
    page: i64,
    encoding: i16,
) -> Option<()> {
    let place = usize::try_from(page).ok().filter(|_| kind == STRUCT)?;
    let (to_values, to_encoding) = (
        header.values.get_mut(place)?,
        header.encoding.get_mut(place)?,
    );
    walk.fields(|this, id, kind| match id {
        1 => number(this, kind, to_values),
        id if id == encoding => number(this, kind, to_encoding),
        _ => this.skip(kind),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A data page's header and `stored` bytes: numbers below 64, so that a zigzag varint is one
    /// byte.
    fn data_page(decoded: &[u8], stored: u8, values: u8) -> Vec<u8> {
        let mut bytes = vec![0x15, 0, 0x15];
        bytes.extend(decoded);
        bytes.extend([0x15, 2 * stored, 0x2c, 0x15, 2 * values, 0x15, 0, 0, 0]);
        bytes.extend(vec![7; stored as usize]);
        bytes
    }

    #[test]
    fn pages_are_summed() {
        let mut bytes = data_page(&[40], 20, 5);
        bytes.extend(data_page(&[60], 30, 7));
        let chunk = walk(&bytes, Some(4)).unwrap();
        assert_eq!(
            (chunk.values, chunk.decoded, chunk.largest_page),
            (12, 50, 30)
        );
        assert_eq!(walk(&[], Some(4)).unwrap(), Chunk::default());
    }

    #[test]
    fn impossible_pages_are_refused() {
        // Decodes to 2^31 - 1 bytes; goes beyond the chunk; a negative size.
        let large = data_page(&[0xfe, 0xff, 0xff, 0xff, 0x0f], 20, 5);
        assert!(
            walk(&large, Some(4))
                .unwrap_err()
                .contains("decode to 2147483647")
        );
        assert!(
            walk(&large, None)
                .unwrap_err()
                .contains("decode to 2147483647")
        );
        let whole = data_page(&[40], 20, 5);
        for length in 1..whole.len() {
            assert!(walk(&whole[..length], Some(4)).is_err(), "{length}");
        }
        assert!(walk(&data_page(&[41], 20, 5), Some(4)).is_err());
        // A statistic of 2^60 bytes.
        let mut statistic = vec![0x15, 0, 0x15, 40, 0x15, 40, 0x2c, 0x15, 10, 0x4c, 0x18];
        statistic.extend([0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x10]);
        assert!(walk(&statistic, Some(4)).unwrap_err().contains("malformed"));
        // A dictionary of 60 entries in 20 bytes.
        let dictionary = [0x15, 4, 0x15, 40, 0x15, 0, 0x4c, 0x15, 120, 0x15, 0, 0, 0];
        assert!(
            walk(&dictionary, Some(4))
                .unwrap_err()
                .contains("60 entries")
        );
    }
}
