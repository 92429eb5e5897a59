//! The system's allocator, which ends the program with a message where memory runs out.
//!
//! Rust aborts there, with a signal and a backtrace that asks for more memory. What a run holds on the
//! disk survives either end; a batch system sees exit code 1: could succeed if tried again.

use std::alloc::{GlobalAlloc, Layout, System};

/// [`System`], but for allocations that fail: they end the program with exit code 1.
pub struct Exiting;

// SAFETY: every call is handed on to `System`, and what it gives is given on.
unsafe impl GlobalAlloc for Exiting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is the same.
        there(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is the same.
        there(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's promise is the same.
        there(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is the same.
        unsafe { System.dealloc(block, layout) }
    }
}

fn there(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null() {
        end(size);
    }
    block
}

/// Says how much was asked for and ends the program. Nothing here takes memory, and nothing that other
/// threads may hold is waited for.
#[cold]
fn end(size: usize) -> ! {
    const START: &[u8] = b"rrf: out of memory: ";
    const END: &[u8] = b" bytes more are not there; raise the limit (ulimit -v), or ask for less: \
          `--memory`, `--threads`, a smaller scene or picture\n";
    let mut line = [0u8; START.len() + 20 + END.len()];
    let mut digits = [0u8; 20];
    let mut first = digits.len();
    let mut rest = size;
    loop {
        first -= 1;
        digits[first] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    let mut length = 0;
    for part in [START, &digits[first..], END] {
        line[length..length + part.len()].copy_from_slice(part);
        length += part.len();
    }
    exit(&line[..length])
}

#[cfg(unix)]
fn exit(line: &[u8]) -> ! {
    // SAFETY: the bytes are valid for their length; `_exit` runs no code of others.
    unsafe {
        libc::write(libc::STDERR_FILENO, line.as_ptr().cast(), line.len());
        libc::_exit(1)
    }
}

#[cfg(not(unix))]
fn exit(_line: &[u8]) -> ! {
    std::process::abort()
}
