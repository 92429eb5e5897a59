//! Rows that a cell's part is fitted to.

use super::directions::Directions;
use super::smooth::Smoothed;

/// One of a cell's two parts on the rows that it is fitted to.
pub(super) struct PartRows<'a> {
    /// Rows of the table.
    pub(super) rows: &'a [u32],
    /// Their smoothed values.
    pub(super) smoothed: &'a Smoothed,
    /// Those that the values are combinations of.
    pub(super) directions: &'a Directions,
    /// Number of the part.
    pub(super) part: usize,
    /// Whether it depends on the viewer.
    pub(super) view: bool,
}
