//! The plan of one round of a bake: `RUN/rounds/000/plan.json`.

use crate::plan::stop::StopReason;
use rrf_extract::Census;
use rrf_field::tree::Tree;
use rrf_store::layout::TEST;
use rrf_train::Size;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Request for rows inside the box of a tree node, made once in a run. Nodes keep their ids when the
/// tree grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DrawPlan {
    /// Node whose box the rows lie in.
    pub node: u32,
    /// Number of rows.
    pub rows: u32,
    /// Paths for each row.
    pub paths: u32,
}

/// One file of samples: the rows of a draw that lie in the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartPlan {
    /// Number of the part within its cell.
    pub part: u32,
    /// Index into [`RoundPlan::draws`], which is also the random stream of the draw.
    pub draw: u32,
    /// Cell and part of the round before that contains these rows.
    pub from: Option<[u32; 2]>,
}

/// One cell of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellPlan {
    /// The cell.
    pub cell: u32,
    /// Share of all valid (point, view, light) combinations; the shares of all cells sum to 1.
    pub measure: f64,
    /// The samples of the cell, by part.
    pub parts: Vec<PartPlan>,
    /// Allowed sizes of the net.
    pub size: Size,
    /// Round of the fit: this one, or an earlier one whose fit is kept.
    pub fitted: u32,
    /// The fit whose net is the initial guess.
    #[serde(default)]
    pub earlier: Option<EarlierFit>,
    /// Compresses the net while its error grows by no more than this share.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prune: Option<f64>,
}

/// A fit of an earlier round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EarlierFit {
    /// Round of the fit.
    pub round: u32,
    /// Its cell.
    pub cell: u32,
    /// Hash of its task.
    pub task: String,
}

/// A whole round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoundPlan {
    /// Round, from 0.
    pub round: u32,
    /// The tree that maps a row to its cell.
    pub tree: Tree,
    /// The cells, by id.
    pub cells: Vec<CellPlan>,
    /// All draws of the run so far.
    pub draws: Vec<DrawPlan>,
    /// Test rows, over the whole domain, by part.
    #[serde(default)]
    pub tests: Vec<PartPlan>,
    /// Whether a material of the scene is Lambertian, by material id.
    pub lambert: Vec<bool>,
    /// Channel mean of the indirect radiance over the pilot rows of the first plan [W·sr⁻¹·m⁻²].
    #[serde(rename = "mean_luminance")]
    pub mean_radiance: f32,
    /// Diagonal of the scene's bounds \[m\].
    pub diagonal: f32,
    /// Predicted seconds of one core for one path.
    pub path_seconds: f64,
    /// Accepted and rejected candidates of the first plan.
    pub census: Census,
    /// Set in a compression pass: why the bake ends after it.
    #[serde(default, rename = "trims", skip_serializing_if = "Option::is_none")]
    pub compresses: Option<StopReason>,
}

impl CellPlan {
    /// The test rows in the form of a cell that covers the whole domain.
    pub(crate) fn of_test_rows(parts: &[PartPlan]) -> CellPlan {
        CellPlan {
            cell: TEST,
            measure: 1.0,
            parts: parts.to_vec(),
            size: Size::Hidden(Vec::new()),
            fitted: 0,
            earlier: None,
            prune: None,
        }
    }

    /// Refers to the fit of this cell, whose task has the given hash.
    pub(crate) fn as_earlier(&self, task: String) -> EarlierFit {
        EarlierFit {
            round: self.fitted,
            cell: self.cell,
            task,
        }
    }
}

impl RoundPlan {
    /// The plan of a cell, or of the test rows for [`TEST`].
    pub(crate) fn cell(&self, cell: u32) -> Option<Cow<'_, CellPlan>> {
        match cell {
            TEST => Some(Cow::Owned(CellPlan::of_test_rows(&self.tests))),
            _ => self.cells.get(cell as usize).map(Cow::Borrowed),
        }
    }

    /// A copy of the plan for the next round.
    pub(crate) fn next(&self) -> RoundPlan {
        RoundPlan {
            round: self.round + 1,
            ..self.clone()
        }
    }

    /// Cell and part number of every part, test rows included.
    pub(crate) fn part_ids(&self) -> impl Iterator<Item = [u32; 2]> {
        let of_cell = |cell: &CellPlan| {
            let id = cell.cell;
            let parts: Vec<[u32; 2]> = cell.parts.iter().map(|p| [id, p.part]).collect();
            parts
        };
        let tests = self.tests.iter().map(|p| [TEST, p.part]);
        self.cells.iter().flat_map(of_cell).chain(tests)
    }

    /// Checks that tree, cells and draws are consistent.
    pub fn check(&self) -> Result<(), String> {
        self.tree.check()?;
        let (cells, leaves) = (self.cells.len(), self.tree.cells());
        if cells != leaves {
            return Err(format!("{cells} cells, but {leaves} leaves"));
        }
        let nodes = self.tree.axis.len();
        if let Some(draw) = self.draws.iter().find(|d| d.node as usize >= nodes) {
            return Err(format!("a draw in node {}, of {nodes}", draw.node));
        }
        let drawn = |part: &PartPlan| (part.draw as usize) < self.draws.len();
        if let Some(part) = self.tests.iter().find(|part| !drawn(part)) {
            return Err(format!("test rows: draw {} is missing", part.draw));
        }
        for (id, cell) in (0u32..).zip(&self.cells) {
            if cell.cell != id || !cell.measure.is_finite() || cell.fitted > self.round {
                return Err(format!("cell {id}: id, measure or round is wrong"));
            }
            if let Some(part) = cell.parts.iter().find(|part| !drawn(part)) {
                return Err(format!("cell {id}: draw {} is missing", part.draw));
            }
        }
        Ok(())
    }
}

/// Maximum rows of one draw, which bounds the memory of a task whatever the size of the run.
pub(crate) const MAX_DRAW_ROWS: u32 = 1 << 16;

/// Adds draws of `rows` rows in total inside the box of a node, each of at most `most` rows, and
/// returns them as parts numbered from `first`.
pub(crate) fn draw_parts(
    draws: &mut Vec<DrawPlan>,
    node: u32,
    rows: u32,
    paths: u32,
    first: u32,
    most: u32,
) -> Vec<PartPlan> {
    let count = rows.div_ceil(most).max(1);
    let share = |i: u32| rows / count + u32::from(i < rows % count);
    (0..count)
        .map(|i| {
            let draw = draws.len() as u32;
            draws.push(DrawPlan {
                node,
                rows: share(i),
                paths,
            });
            PartPlan {
                part: first + i,
                draw,
                from: None,
            }
        })
        .collect()
}
