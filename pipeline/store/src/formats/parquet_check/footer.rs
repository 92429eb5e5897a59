//! The footer (parquet-format, `FileMetaData`): its length, and a schema that ends.

use super::thrift::{Compact, I32, LIST, STRUCT};
use crate::error::StoreError;
use crate::formats::guard::Guard;

const MAGIC: &[u8] = b"PAR1";
/// Columns of a points table take a hundred bytes each.
const LARGEST_FOOTER: usize = 16 << 20;
const DEEPEST_SCHEMA: usize = 16;
const MOST_COLUMNS: u64 = 10_000;

/// Field numbers in `FileMetaData` and `SchemaElement`.
const SCHEMA: i16 = 2;
const NUM_CHILDREN: i16 = 5;

/// Checks what must hold before the footer is decoded.
pub(crate) fn check_footer(guard: &Guard, bytes: &[u8]) -> Result<(), StoreError> {
    let tail = bytes.len().checked_sub(8).filter(|&tail| tail >= 4);
    let (Some(tail), true) = (tail, bytes.starts_with(MAGIC) && bytes.ends_with(MAGIC)) else {
        return Err(guard.corrupt("it does not begin and end with PAR1"));
    };
    let length = bytes.get(tail..tail + 4).and_then(|n| n.try_into().ok());
    let length = u32::from_le_bytes(length.unwrap_or([255; 4])) as usize;
    if length > LARGEST_FOOTER {
        let what = "the size of its footer in bytes";
        return Err(guard.too_large(what, length as u64, LARGEST_FOOTER as u64));
    }
    let footer = tail.checked_sub(length).and_then(|at| bytes.get(at..tail));
    let footer = footer.ok_or_else(|| guard.corrupt("its footer is longer than the file"))?;
    let mut schema = Schema::default();
    Compact::new(footer)
        .fields(|this, id, kind| match id {
            SCHEMA => schema.walk(this, kind),
            _ => this.skip(kind),
        })
        .filter(|()| schema.seen && schema.open.is_empty())
        .ok_or_else(|| guard.corrupt("malformed footer or schema"))
}

/// A schema is a tree in depth-first order, each element with its number of children.
#[derive(Default)]
struct Schema {
    seen: bool,
    /// Children still to come, a number a level.
    open: Vec<u64>,
}

impl Schema {
    fn walk(&mut self, walk: &mut Compact, kind: u8) -> Option<()> {
        if kind != LIST || self.seen {
            return None;
        }
        self.seen = true;
        let (length, kind) = walk.list()?;
        if kind != STRUCT || length > MOST_COLUMNS {
            return None;
        }
        for element in 0..length {
            let mut children = None;
            walk.fields(|this, id, kind| match id {
                NUM_CHILDREN if kind == I32 && children.is_none() => {
                    children = Some(u64::try_from(this.integer()?).ok()?);
                    Some(())
                }
                NUM_CHILDREN => None,
                _ => this.skip(kind),
            })?;
            self.take(element == 0, children.unwrap_or(0), length)?;
        }
        Some(())
    }

    fn take(&mut self, root: bool, children: u64, most: u64) -> Option<()> {
        if !root {
            // A place among its parent's children.
            let left = self.open.last_mut()?;
            *left = left.checked_sub(1)?;
        }
        if children > 0 {
            self.open.push(children);
        }
        while self.open.last() == Some(&0) {
            self.open.pop();
        }
        (children <= most && self.open.len() <= DEEPEST_SCHEMA).then_some(())
    }
}
