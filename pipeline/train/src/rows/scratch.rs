//! Raw rows in a file instead of in memory, written in any order, read in rising order.

use super::chunk::{Chunk, WIDTH};
use std::cell::{Cell, RefCell};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

/// Rows read at a time.
pub(crate) const WINDOW: usize = 4096;
/// Bytes a row.
const ROW: usize = 4 * WIDTH;

/// A file of raw rows, for one fit: made, read and forgotten on one machine.
pub(crate) struct Scratch<'a> {
    file: &'a File,
    rows: usize,
    /// Rows at hand and the first of them.
    held: RefCell<Option<(usize, Chunk)>>,
    failure: Cell<Option<io::Error>>,
}

impl<'a> Scratch<'a> {
    pub fn new(file: &'a File, rows: usize) -> Scratch<'a> {
        Scratch {
            file,
            rows,
            held: RefCell::new(None),
            failure: Cell::new(None),
        }
    }

    /// Writes one row at its place.
    pub fn write(&self, place: usize, row: &[f32; WIDTH]) -> io::Result<()> {
        let mut bytes = [0; ROW];
        for (bytes, x) in bytes.chunks_exact_mut(4).zip(row) {
            bytes.copy_from_slice(&x.to_le_bytes());
        }
        let mut file = self.file;
        file.seek(SeekFrom::Start((place * ROW) as u64))?;
        file.write_all(&bytes)
    }

    /// `count` rows from `first` on. Where they cannot be read they are NaN, so that a cost over
    /// them is no number and no step is taken; see [`Scratch::failure`].
    pub fn read(&self, first: usize, count: usize) -> Chunk {
        let mut bytes = vec![0; count * ROW];
        let mut file = self.file;
        let read = (file.seek(SeekFrom::Start((first * ROW) as u64)))
            .and_then(|_| file.read_exact(&mut bytes));
        let mut chunk = Chunk::default();
        if let Err(failure) = read {
            self.failure.set(Some(failure));
            (0..count).for_each(|_| chunk.push(&[f32::NAN; WIDTH]));
            return chunk;
        }
        for row in bytes.chunks_exact(ROW) {
            let mut numbers = [0.0; WIDTH];
            for (x, bytes) in numbers.iter_mut().zip(row.chunks_exact(4)) {
                *x = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            }
            chunk.push(&numbers);
        }
        chunk
    }

    /// Shows `count` rows from `first` on, at most a window, and where the first of them lies
    /// in what is shown.
    pub fn show<T>(&self, first: usize, count: usize, see: impl FnOnce(&Chunk, usize) -> T) -> T {
        let mut held = self.held.borrow_mut();
        let inside = |(start, rows): &(usize, Chunk)| {
            *start <= first && first + count <= *start + rows.len()
        };
        if !held.as_ref().is_some_and(inside) {
            // dropped before the next is read, so that there is never more than one
            *held = None;
        }
        let window = WINDOW.max(count).min(self.rows.saturating_sub(first));
        let (start, rows) = held.get_or_insert_with(|| (first, self.read(first, window)));
        see(rows, first - *start)
    }

    /// Whether rows could not be read.
    pub fn failed(&self) -> bool {
        let failure = self.failure.take();
        let failed = failure.is_some();
        self.failure.set(failure);
        failed
    }

    /// Why rows could not be read, if so.
    pub fn failure(&self) -> Option<io::Error> {
        self.failure.take()
    }
}
