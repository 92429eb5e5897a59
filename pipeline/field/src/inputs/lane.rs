//! One column of a block of rows.

/// Rows of a block. The activations of two 20-unit layers fill a third of a 32 KiB L1 cache.
pub const BLOCK: usize = 64;

/// One block of one column, aligned to a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Lane(pub [f32; BLOCK]);

impl Lane {
    /// All zeros.
    pub const ZERO: Lane = Lane([0.0; BLOCK]);
}
