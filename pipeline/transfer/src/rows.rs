//! Rows of the transfer: what one unit of irradiance on each patch adds at a point.
//!
//! Paths leave the point toward the scene without any light. Each vertex after the point itself
//! would send on the direct light of its patch: it deposits in the patch's column what one unit
//! of irradiance there adds at the point toward its viewer. Light that reaches the point
//! itself straight from a light is left out, so that row times irradiance is the *indirect* light
//! (Hasan, Pellacini, Bala, *Direct-to-Indirect Transfer for Cinematic Relighting*, SIGGRAPH 2006;
//! the quantity is that of Ren et al. 2013, eq. 2). The estimate is unbiased but for the
//! irradiance being taken as even over a patch.

use crate::TransferError;
use crate::entry::{Entry, HalfRow};
use crate::patches::Patches;
use crate::row_config::RowConfig;
use crate::tracing::{Stream, SurfacePoint, Tracer, unless_halted};
use crate::walk::{Start, Walker};
use glam::Vec3;
use rayon::prelude::*;

/// Paths that travel together, at most one row's half more.
const BATCH: usize = 2048;

/// Where a row is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowPoint {
    /// Surface point.
    pub point: SurfacePoint,
    /// Unit direction to the viewer, world frame.
    pub viewer: Vec3,
}

/// Sparse rows, each as two independent half estimates.
#[derive(Clone, Debug, Default)]
pub struct TransferRows {
    /// Columns that the patches have.
    pub width: usize,
    /// First entry of each half (row 0's halves, row 1's, ...), and the number of all.
    pub starts: Vec<usize>,
    /// Column of each entry; growing within a half.
    pub columns: Vec<u32>,
    /// The entries.
    pub entries: Vec<Entry>,
    /// Harmonic mean of the distances that the first rays of each row travel, metres; infinite
    /// where all of them leave the scene (Ward, Rubinstein, Clear 1988).
    pub distance: Vec<f32>,
}

/// Traces the rows of points. Row i draws its numbers at index `first_index + i` of the stream,
/// whatever the batch that it stands in.
pub fn trace_rows(
    tracer: &Tracer,
    patches: &Patches,
    points: &[RowPoint],
    config: &RowConfig,
    stream: Stream,
    first_index: u64,
) -> Result<TransferRows, TransferError> {
    if config.paths == 0 || !config.paths.is_multiple_of(2) {
        return Err(TransferError::Paths {
            paths: config.paths,
        });
    }
    let each = config.paths as usize / 2;
    let starts: Vec<Start> = (points.iter().zip(first_index..))
        .flat_map(|(&RowPoint { point, viewer }, index)| {
            (0..2).map(move |half| Start {
                point,
                viewer,
                index,
                half,
            })
        })
        .collect();
    let at_once = (BATCH / each).max(1);
    let parts: Vec<Vec<HalfRow>> = starts
        .par_chunks(at_once)
        .map_init(
            || Walker::new(tracer, patches, stream, config, each),
            |walker, starts| walker.rows(starts),
        )
        .collect();
    unless_halted(tracer)?;
    Ok(TransferRows::gather(
        parts.into_iter().flatten(),
        patches.columns(),
    ))
}

impl TransferRows {
    fn gather(halves: impl Iterator<Item = HalfRow>, width: usize) -> TransferRows {
        let mut rows = TransferRows {
            width,
            starts: vec![0],
            ..TransferRows::default()
        };
        let mut nearness = Vec::new();
        for half in halves {
            rows.columns.extend(half.columns);
            rows.entries.extend(half.entries);
            rows.starts.push(rows.columns.len());
            nearness.push(half.nearness);
        }
        rows.distance = (nearness.chunks_exact(2))
            .map(|pair| 2.0 / (pair[0] + pair[1]))
            .collect();
        rows
    }

    /// Appends further rows over the same patches.
    pub fn append(&mut self, other: TransferRows) {
        let first = self.columns.len();
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.starts
            .extend(other.starts.iter().skip(1).map(|start| start + first));
        self.columns.extend(other.columns);
        self.entries.extend(other.entries);
        self.distance.extend(other.distance);
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1) / 2
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Columns and entries of one half of a row.
    pub fn half(&self, row: usize, half: usize) -> (&[u32], &[Entry]) {
        let at = 2 * row + half;
        let range = self.starts[at]..self.starts[at + 1];
        (&self.columns[range.clone()], &self.entries[range])
    }

    /// Which columns any row has an entry in.
    pub fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.width];
        self.columns.iter().for_each(|&c| used[c as usize] = true);
        used
    }

    /// One half of a row under an irradiance [W/m^2] a column: its two parts [W/(sr m^2)].
    pub fn apply(&self, row: usize, half: usize, irradiance: &[Vec3]) -> Entry {
        let (columns, entries) = self.half(row, half);
        let mut sum = Entry::default();
        for (&column, entry) in columns.iter().zip(entries) {
            let e = irradiance
                .get(column as usize)
                .copied()
                .unwrap_or(Vec3::ZERO);
            sum.base += entry.base * e;
            sum.constant += entry.constant * e;
        }
        sum
    }
}
