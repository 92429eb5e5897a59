//! How rows are made.

/// How rows are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowConfig {
    /// Paths a row, both halves together.
    pub paths: u32,
    /// From its second reflection on, a path goes on with this times its throughput, relative to
    /// the first one, as its probability (at most 1).
    pub keep: f32,
    /// Whether a row is that of its surface's broad part alone ([`rrf_materials::Bsdf::broad`]).
    pub broad: bool,
}

impl Default for RowConfig {
    fn default() -> RowConfig {
        RowConfig {
            paths: 512,
            keep: 1.5,
            broad: false,
        }
    }
}
