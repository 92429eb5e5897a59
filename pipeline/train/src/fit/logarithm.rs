//! Another initialization for a net whose outputs are exponents.
//!
//! A net of zeros answers with the mean, and where most rows are black to the relative loss, the mean is
//! next to nothing for the others: exp(z) is flat there, weight decay takes what is left of the
//! slopes, and the fit ends as it began. The logarithm has no such plateau.

use crate::net::tile::{Batch, CHANNELS, Rows};
use rrf_metrics::channel_mean;

/// Rows whose targets are log(radiance + ε) in the net's units.
///
/// A channel weighs (its radiance + ε) / (channel mean + ε), what a change of its exponent comes to in the
/// relative loss. The noise of the targets passes a logarithm here: good for a start only.
pub(crate) struct Logarithms<R: Rows> {
    pub rows: R,
    /// ε in radiance.
    pub floor: f64,
}

impl<R: Rows> Rows for Logarithms<R> {
    fn len(&self) -> usize {
        self.rows.len()
    }

    fn held(&self) -> bool {
        self.rows.held()
    }

    fn halted(&self) -> bool {
        self.rows.halted()
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        self.rows.load(first, batch);
        for row in 0..batch.rows {
            let radiance: [f64; CHANNELS] =
                std::array::from_fn(|c| (batch.gain[c][row] * batch.target[c][row]).max(0.0));
            let mean = channel_mean(radiance);
            for (c, y) in radiance.into_iter().enumerate() {
                let gain = &mut batch.gain[c][row];
                if *gain > 0.0 {
                    batch.target[c][row] = ((y + self.floor) / *gain).ln();
                    *gain = (y + self.floor) / (mean + self.floor);
                }
            }
        }
    }
}
