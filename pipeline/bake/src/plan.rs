//! What one round of a bake has to do: `RUN/rounds/000/plan.json`.

use crate::decide::Stop;
use crate::test_rows;
use rrf_extract::{Census, FirstPlan};
use rrf_field::tree::Tree;
use rrf_store::layout::TEST;
use rrf_train::Size;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A request for rows inside the box of a node of the tree, made once in a run. Nodes keep their
/// ids when the tree grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DrawPlan {
    /// Node whose box the rows lie in.
    pub node: u32,
    /// Rows wanted.
    pub rows: u32,
    /// Paths a row.
    pub paths: u32,
}

/// One file of samples: the rows of a draw that lie in the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartPlan {
    /// Number of the part within its cell.
    pub part: u32,
    /// Place in [`RoundPlan::draws`], which is the draw's stream.
    pub draw: u32,
    /// Cell and part of the round before that holds these rows among others.
    pub from: Option<[u32; 2]>,
}

/// One cell of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellPlan {
    /// The cell.
    pub cell: u32,
    /// Share of all valid (point, view, light) combinations, summing to 1 over the cells.
    pub measure: f64,
    /// Its samples, by part.
    pub parts: Vec<PartPlan>,
    /// Which nets it may get.
    pub size: Size,
    /// Round in which it is fitted: this one, or an earlier one whose fit stays.
    pub fitted: u32,
    /// The fit that this one goes on from.
    #[serde(default)]
    pub earlier: Option<Earlier>,
    /// Its net loses what it can do without, while its error grows by no more than this share.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prune: Option<f64>,
}

/// A fit of an earlier round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Earlier {
    /// Round that it was made in.
    pub round: u32,
    /// Its cell.
    pub cell: u32,
    /// Hash of what it was made from (see [`crate::task`]).
    pub task: String,
}

/// A whole round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoundPlan {
    /// Round, from 0.
    pub round: u32,
    /// Which cell a row belongs to.
    pub tree: Tree,
    /// The cells, by id.
    pub cells: Vec<CellPlan>,
    /// All draws of the run so far.
    pub draws: Vec<DrawPlan>,
    /// Rows of the whole domain that only judge, by part.
    #[serde(default)]
    pub tests: Vec<PartPlan>,
    /// Which materials of the scene are Lambertian, by material id.
    pub lambert: Vec<bool>,
    /// Mean luminance of the indirect radiance, W/(sr m^2), from the plan's pilot.
    pub mean_luminance: f32,
    /// Diagonal of the scene's bounds, m.
    pub diagonal: f32,
    /// Seconds of one core that a path should take.
    pub path_seconds: f64,
    /// Candidates of the first plan, accepted and left out.
    pub census: Census,
    /// Why the bake ends after this round, which only makes nets smaller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trims: Option<Stop>,
}

impl RoundPlan {
    /// Round 0: draws and a fit for every cell of the first tree.
    pub fn first(
        plan: FirstPlan,
        diagonal: f32,
        path_seconds: f64,
        paths: u32,
        size: &Size,
    ) -> RoundPlan {
        let mut draws = Vec::new();
        let cells = (0u32..).zip(plan.tree.leaves()).zip(&plan.cells);
        let cells = cells.map(|((cell, leaf), share)| CellPlan {
            cell,
            measure: share.measure,
            parts: draw_parts(&mut draws, leaf as u32, share.rows, paths, 0, MOST_ROWS),
            size: size.clone(),
            fitted: 0,
            earlier: None,
            prune: None,
        });
        let mut first = RoundPlan {
            round: 0,
            cells: cells.collect(),
            draws,
            tests: Vec::new(),
            tree: plan.tree,
            lambert: plan.lambert,
            mean_luminance: plan.mean_luminance,
            diagonal,
            path_seconds,
            census: plan.census,
            trims: None,
        };
        test_rows::keep_up(&mut first, paths, 0.0, None);
        first
    }

    /// What the tasks of a cell, or of [`TEST`], are about.
    pub(crate) fn cell(&self, cell: u32) -> Option<Cow<'_, CellPlan>> {
        match cell {
            TEST => Some(Cow::Owned(test_rows::as_cell(&self.tests))),
            _ => self.cells.get(cell as usize).map(Cow::Borrowed),
        }
    }

    /// Whether tree, cells and draws belong together.
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

/// Rows of one draw at the most: bounds what a task holds in memory, whatever the run's size.
pub(crate) const MOST_ROWS: u32 = 1 << 16;

/// New draws of `rows` rows together inside a node's box, each of `most` rows at the most, as parts from
/// number `first` on.
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

/// A first plan of one cell of 6,000 rows, for tests.
#[cfg(test)]
pub(crate) fn one_cell(paths: u32) -> RoundPlan {
    let first = FirstPlan {
        tree: Tree::single(),
        cells: vec![rrf_extract::CellShare {
            rows: 6000,
            measure: 1.0,
        }],
        lambert: vec![true],
        mean_luminance: 1.0,
        census: Census::default(),
    };
    RoundPlan::first(first, 1.0, 1e-6, paths, &Size::Hidden(vec![20, 10]))
}
