//! How a transfer model is made.

use crate::patches::PatchConfig;
use crate::regression::{LocalConfig, NetConfig};
use crate::row_config::RowConfig;

/// Error that a trusted cell may state: by the rows of a furnished room, rays in place of cells that state less are
/// noisier than those are wrong.
pub const TRUST_ERROR: f32 = 0.5;

/// Which fits cells may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellChoice {
    /// Nets, and local fits at nodes where a net does not come to their error.
    #[default]
    Best,
    /// Nets everywhere.
    Nets,
    /// Local fits at nodes everywhere.
    Nodes,
}

/// How a transfer model is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferConfig {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Patches of the surface.
    pub patches: PatchConfig,
    /// What patches may get wrong before they are quartered: how much the light varies over them,
    /// relative to its mean, times how near surroundings are, relative to their width.
    pub patch_error: f32,
    /// How many patches may be added so, as a share of the count that is asked for.
    pub finer_patches: f32,
    /// Points that the largest patch's irradiance is asked at.
    pub receiver_points: u32,
    /// How many rows are traced.
    pub rows: usize,
    /// Paths of a row.
    pub paths: RowConfig,
    /// Surface points that are drawn for every row that is traced.
    pub pool: f32,
    /// Surface points that are looked at for every row that is traced.
    pub candidates: f32,
    /// Rows that a face of a surface gets at least, if it is seen at all.
    pub least_rows: usize,
    /// Rows that lights are weighted by before the others are traced.
    pub pilot_rows: usize,
    /// Rows of some surfaces that are in memory at a time, a surface's own at least.
    pub rows_at_once: usize,
    /// Rows of a cell at most.
    pub cell_rows: usize,
    /// Directions of a cell at most.
    pub cell_rank: usize,
    /// Share of the light that a cell's directions may leave out.
    pub cell_error: f64,
    /// Share of the light that clusters of patches may leave out at least.
    pub cluster_error: f64,
    /// What clusters and directions may leave out, as a share of the cell's own error.
    pub left_out: f64,
    /// One row of so many judges and is not fitted to.
    pub judging: u32,
    /// Further rounds of rows at most, beside rows of cells whose error is above the target.
    pub rounds: u32,
    /// Relative error that further rounds aim at.
    pub target: f32,
    /// Local fits.
    pub local: LocalConfig,
    /// Nets.
    pub net: NetConfig,
    /// Nodes of a cell at most.
    pub nodes: usize,
    /// Which fits cells may have.
    pub choice: CellChoice,
    /// A net may have this times the error of the local fits and still stand for them.
    pub patience: f32,
    /// Cells with a larger error are not trusted.
    pub trust: f32,
}

impl TransferConfig {
    /// Share of the light that the clusters, and again the directions, of a cell of some error may leave
    /// out: cells that are not trusted may leave out what the worst trusted ones do.
    pub(crate) fn left_out(&self, error: f32) -> f64 {
        let most = self.left_out * f64::from(self.trust);
        (self.left_out * f64::from(error))
            .min(most)
            .max(self.cluster_error)
    }
}

impl Default for TransferConfig {
    fn default() -> TransferConfig {
        TransferConfig {
            seed: 1,
            patches: PatchConfig {
                count: 2_000,
                ..PatchConfig::default()
            },
            patch_error: 0.1,
            finer_patches: 1.5,
            receiver_points: 8,
            rows: 20_000,
            paths: RowConfig {
                paths: 256,
                ..RowConfig::default()
            },
            pool: 16.0,
            candidates: 3.0,
            least_rows: 64,
            pilot_rows: 2_000,
            rows_at_once: 4_096,
            cell_rows: 400,
            cell_rank: 16,
            cell_error: 0.01,
            cluster_error: 0.003,
            left_out: 0.1,
            judging: 8,
            rounds: 1,
            target: 0.05,
            local: LocalConfig::default(),
            net: NetConfig::default(),
            nodes: 96,
            choice: CellChoice::Best,
            patience: 1.25,
            trust: TRUST_ERROR,
        }
    }
}
