//! Damaged and hostile files: never a panic, never much memory, never wrong values.
//!
//! An allocator counts: while a reader runs, no single request may exceed [`MOST`], however
//! small the file that asks for it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../tables/made.rs"]
mod made;

mod damage;
mod foreign;
mod forged;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The largest request that reading a file of a few kilobytes justifies: the decoders' own
/// buffers (zstd's window, a batch of 65,536 rows).
pub const MOST: usize = 32 << 20;

struct Counting;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn count(size: usize) {
    // At a thread's end its cell is gone; nothing is read then.
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(size)));
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size);
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs a reader and holds its requests against [`MOST`].
pub fn frugally<T>(what: &str, read: impl FnOnce() -> T) -> T {
    LARGEST.with(|largest| largest.set(0));
    let result = read();
    let largest = LARGEST.with(Cell::get);
    assert!(largest <= MOST, "{what}: one request of {largest} bytes");
    result
}
