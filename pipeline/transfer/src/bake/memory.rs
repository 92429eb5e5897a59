//! The memory of a bake.

use super::config::TransferConfig;
use super::lighting::Lighting;
use super::watch::TransferWatch;
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::entry::Entry;
use crate::model::SKETCHES;
use crate::rows::TransferRows;

/// Bytes of a number.
const NUMBER: usize = size_of::<f32>();
/// Share by which rows may have more entries than those of the pilot.
const MARGIN: f64 = 1.25;

/// The memory of a bake beyond the scene, before any row of a surface is traced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemoryNeed {
    /// Bytes that are held all the time, and by all threads for their cells.
    fixed: f64,
    /// Bytes of a row.
    row: f64,
    /// Bytes that there are; none for no limit.
    given: Option<u64>,
}

impl MemoryNeed {
    pub(crate) fn new(
        pilot: &TransferRows,
        lighting: &Lighting,
        columns: &ColumnTree,
        config: &TransferConfig,
        watch: &dyn TransferWatch,
    ) -> MemoryNeed {
        let (lights, judges) = (lighting.ensemble.lights, lighting.judges.len());
        let (count, nodes) = (columns.columns(), columns.len());
        let some = lighting.some.len();
        // sparse entries twice: parts are joined; under the ensemble twice: and smoothed
        let entries = pilot.entries.len() as f64 / pilot.len().max(1) as f64;
        let sparse = 2.0 * MARGIN * entries * (size_of::<Entry>() + NUMBER) as f64;
        let lit = 2 * 6 * lights * NUMBER + 6 * judges * NUMBER;
        let held =
            count * (lights + some + 6 * judges + SKETCHES + 6) + nodes * (some + 3 * judges);
        // of each thread: dense reads and their combinations, and every node's answers
        let own = count * (2 * config.cell_rank + 4) + nodes * 4 * some;
        let smoothed = config.cell_rows * (6 * lights + 9 * config.cell_rank * 3);
        let threads = rayon::current_num_threads();
        MemoryNeed {
            fixed: (NUMBER * (held + threads * (own + smoothed))) as f64,
            row: sparse + lit as f64,
            given: watch.memory(),
        }
    }

    /// Whether so many rows may be held at a time.
    pub(crate) fn allows(&self, rows: usize) -> bool {
        self.given.is_none_or(|given| self.of(rows) <= given)
    }

    /// # Errors
    /// [`TransferError::Memory`] where so many rows may not be held at a time.
    pub(crate) fn check(&self, rows: usize) -> Result<(), TransferError> {
        match self.given {
            Some(memory) if self.of(rows) > memory => Err(TransferError::Memory {
                needed: self.of(rows),
                memory,
            }),
            _ => Ok(()),
        }
    }

    fn of(&self, rows: usize) -> u64 {
        (self.fixed + self.row * rows as f64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused() {
        let need = |given| MemoryNeed {
            fixed: 100.0,
            row: 2.0,
            given,
        };
        assert!(need(None).allows(1_000) && need(None).check(1_000).is_ok());
        assert!(need(Some(120)).allows(10) && !need(Some(120)).allows(11));
        let refused = need(Some(120)).check(20);
        assert_eq!(
            refused,
            Err(TransferError::Memory {
                needed: 140,
                memory: 120
            })
        );
    }
}
