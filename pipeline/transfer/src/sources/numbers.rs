//! Random numbers of a light's samples: fixed a receiver, stratified over an owner's points.

use crate::lights::ReceiverId;
use crate::tracing::{DIMENSIONS, Scramble, Stream, Table, scramble};
use rrf_sampling::sobol::scrambles;

/// Points of the sequence that are kept; past them it starts again.
const KEPT: usize = 1024;

/// The numbers of one light.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    stream: Stream,
    table: Table,
    /// Samples a receiver.
    pub(super) each: u32,
}

/// The numbers of one receiver.
pub(super) struct Set<'a> {
    table: &'a Table,
    by: [Scramble; DIMENSIONS],
    first: usize,
}

impl Numbers {
    pub(super) fn new(stream: Stream, each: u32) -> Numbers {
        Numbers {
            stream,
            table: Table::new(if each > 0 { KEPT } else { 0 }),
            each,
        }
    }

    pub(super) fn of(&self, id: ReceiverId) -> Set<'_> {
        Set {
            table: &self.table,
            by: scrambles(self.stream, id.owner, 0),
            first: id.point as usize * self.each as usize,
        }
    }
}

impl Set<'_> {
    /// Dimensions of sample `k` from `first` on.
    #[inline]
    pub(super) fn take<const N: usize>(&self, k: u32, first: usize) -> [f32; N] {
        let point = self.table.reversed(self.first + k as usize);
        std::array::from_fn(|d| scramble(point[first + d], self.by[first + d]))
    }
}
