//! What one task needs of its round's plan, and files of a few hundred of these each, so that a
//! worker reads as little of a plan of 100,000 cells as of one of ten.

use crate::error::BakeError;
use crate::plan::{CellPlan, DrawPlan, PartPlan, RoundPlan};
use crate::run::Run;
use crate::task::{Stage, Task, cell_hashes};
use rrf_field::columns;
use rrf_field::tree::{Domain, Tree};
use rrf_store::layout::cell_folder;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Tasks a file.
pub const CHAPTER: usize = 256;

/// One file, `rounds/000/tasks/00042.json`: tasks `first` to `first` + [`CHAPTER`] of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Chapter {
    /// blake3 of the scene, hexadecimal.
    pub scene_hash: String,
    /// Seed of the run.
    pub seed: u64,
    /// How many tasks the round has.
    pub tasks: u32,
    /// What all tasks share.
    pub shared: Shared,
    /// Task ids from here on.
    pub first: u32,
    /// The tasks.
    pub entries: Vec<Entry>,
}

/// A task and what it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Entry {
    pub task: Task,
    pub of_cell: OfCell,
}

/// What all tasks of a round share.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shared {
    pub round: u32,
    /// Which materials of the scene are Lambertian, by material id.
    pub lambert: Vec<bool>,
    /// Mean luminance of the indirect radiance, W/(sr m^2).
    pub mean_luminance: f32,
}

impl Shared {
    pub fn of(plan: &RoundPlan) -> Shared {
        Shared {
            round: plan.round,
            lambert: plan.lambert.clone(),
            mean_luminance: plan.mean_luminance,
        }
    }
}

/// What all tasks of a cell share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OfCell {
    pub plan: CellPlan,
    /// The cell's box.
    pub leaf: Bounds,
    /// The draws that its parts are of, by number, and their boxes.
    pub draws: Vec<(u32, DrawPlan, Bounds)>,
}

impl OfCell {
    /// The draw of a part and its box.
    pub fn draw(&self, round: u32, part: &PartPlan) -> Result<(&DrawPlan, &Bounds), BakeError> {
        let found = self.draws.iter().find(|(number, ..)| *number == part.draw);
        let found = found.map(|(_, draw, bounds)| (draw, bounds));
        found.ok_or_else(|| BakeError::Plan {
            round,
            reason: format!("draw {} is missing", part.draw),
        })
    }

    /// What the task that makes a part has to know: a cell of thousands of parts has as many of these.
    pub fn of_part(&self, part: &PartPlan) -> OfCell {
        let draws = self.draws.iter();
        OfCell {
            plan: CellPlan {
                cell: self.plan.cell,
                measure: self.plan.measure,
                parts: vec![*part],
                size: self.plan.size.clone(),
                fitted: self.plan.fitted,
                earlier: self.plan.earlier.clone(),
                prune: self.plan.prune,
            },
            leaf: self.leaf.clone(),
            draws: draws.filter(|d| d.0 == part.draw).cloned().collect(),
        }
    }
}

/// A box by its finite bounds: the column, whether it is the upper one, the bits of the number.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Bounds(Vec<(u8, bool, u32)>);

impl Bounds {
    fn of(domain: &Domain) -> Bounds {
        let sides = [(false, &domain.minimum), (true, &domain.maximum)];
        let listed = sides.into_iter().flat_map(|(upper, side)| {
            let finite = (0u8..).zip(side).filter(|(_, x)| x.is_finite());
            finite.map(move |(column, x)| (column, upper, x.to_bits()))
        });
        Bounds(listed.collect())
    }

    /// The box; columns that do not exist bound nothing.
    pub fn domain(&self) -> Domain {
        let mut domain = Domain::ALL;
        for &(column, upper, bits) in &self.0 {
            let side = match upper {
                true => &mut domain.maximum,
                false => &mut domain.minimum,
            };
            if let Some(x) = side.get_mut(usize::from(column)) {
                *x = f32::from_bits(bits);
            }
        }
        domain
    }

    /// All bounds, as bits: infinite ones have no JSON.
    pub fn bits(&self) -> Vec<u32> {
        let domain = self.domain();
        let all = domain.minimum.iter().chain(&domain.maximum);
        all.take(2 * columns::COUNT).map(|x| x.to_bits()).collect()
    }
}

/// Boxes of a tree's nodes, and the leaf of each cell.
pub(crate) struct Boxes {
    nodes: Vec<Domain>,
    leaves: Vec<usize>,
}

impl Boxes {
    pub fn new(tree: &Tree) -> Boxes {
        Boxes {
            nodes: tree.node_domains(),
            leaves: tree.leaves(),
        }
    }

    fn bounds(&self, node: Option<usize>) -> Bounds {
        let domain = self.nodes.get(node.unwrap_or(0)).unwrap_or(&Domain::ALL);
        Bounds::of(domain)
    }

    /// What the tasks of a cell share.
    pub fn of_cell(&self, plan: &RoundPlan, cell: &CellPlan) -> Result<OfCell, BakeError> {
        let draws = cell.parts.iter().map(|part| {
            let draw = plan.draws.get(part.draw as usize);
            let draw = draw.ok_or_else(|| BakeError::Plan {
                round: plan.round,
                reason: format!("draw {} is missing", part.draw),
            })?;
            Ok((part.draw, *draw, self.bounds(Some(draw.node as usize))))
        });
        Ok(OfCell {
            plan: cell.clone(),
            leaf: self.bounds(self.leaves.get(cell.cell as usize).copied()),
            draws: draws.collect::<Result<Vec<_>, BakeError>>()?,
        })
    }
}

/// One task, ready to be done wherever it is.
#[derive(Clone, Debug)]
pub struct Job {
    /// The task.
    pub task: Task,
    pub(crate) shared: Shared,
    pub(crate) of_cell: OfCell,
}

impl Job {
    /// A task of a plan.
    ///
    /// # Errors
    /// [`BakeError::NoSuchCell`], [`BakeError::Plan`].
    pub fn of(plan: &RoundPlan, task: &Task) -> Result<Job, BakeError> {
        let cell = plan.cell(task.cell).ok_or(BakeError::NoSuchCell {
            cell: task.cell,
            last: plan.cells.len().saturating_sub(1) as u32,
        })?;
        Ok(Job {
            task: task.clone(),
            shared: Shared::of(plan),
            of_cell: Boxes::new(&plan.tree).of_cell(plan, &cell)?,
        })
    }

    /// A task of a round by its id, read from its file; beyond the last the number of tasks.
    ///
    /// # Errors
    /// [`BakeError::Plan`] for a file that is missing, damaged, of another run or of another
    /// version of the program; [`BakeError::Store`].
    pub fn read(run: &Run, round: u32, id: u32) -> Result<Result<Job, u32>, BakeError> {
        let wrong = |reason: &str| BakeError::Plan {
            round,
            reason: format!("task {id}: {reason}. Write the plan anew with `rrf plan RUN`"),
        };
        let chapter = |id: u32| run.read_chapter(round, id / CHAPTER as u32);
        let Some(found) = chapter(id)? else {
            // beyond the last file, or lost
            let tasks = chapter(0)?.map(|first| first.tasks);
            return match tasks {
                Some(tasks) if id >= tasks => Ok(Err(tasks)),
                _ => Err(wrong("the plan's file is missing")),
            };
        };
        if id >= found.tasks {
            return Ok(Err(found.tasks));
        }
        let at = id.checked_sub(found.first).map(|at| at as usize);
        let entry = at.and_then(|at| found.entries.get(at));
        let Some(Entry { task, of_cell }) = entry.cloned() else {
            return Err(wrong("the plan's file does not have it"));
        };
        let facts = run.facts();
        let same_run = (found.seed, &found.scene_hash) == (facts.seed, &facts.scene_hash);
        let job = Job {
            task,
            shared: found.shared,
            of_cell,
        };
        let (parts, fit) = cell_hashes(run, &job.shared, &job.of_cell)?;
        let hash = match job.task.stage {
            Stage::Train => Some(&fit),
            Stage::Extract => {
                let numbers = job.of_cell.plan.parts.iter().map(|p| Some(p.part));
                let mut hashed = numbers.zip(&parts);
                hashed.find(|(n, _)| *n == job.task.part).map(|(_, h)| h)
            }
        };
        if !same_run || hash != Some(&job.task.hash) {
            return Err(wrong("it is not one of this run any more"));
        }
        Ok(Ok(job))
    }

    /// Beginnings of the names of the files that the task reads and writes, relative to the run:
    /// what a worker on another machine needs.
    pub fn files(&self) -> Vec<String> {
        let (task, id) = (&self.task, self.task.cell);
        let parts_of = |cell| format!("{}/", cell_folder(Path::new(""), cell).display());
        let mut files = vec![parts_of(id)];
        match task.stage {
            Stage::Train => {
                let earlier = self.of_cell.plan.earlier.as_ref();
                let earlier = earlier.map(|fit| [fit.round, fit.cell]);
                let fits = std::iter::once([task.round, id]).chain(earlier);
                files.extend(
                    fits.map(|[round, cell]| format!("rounds/{round:03}/fits/cell={cell:06}/")),
                );
            }
            Stage::Extract => {
                let parts = self.of_cell.plan.parts.iter();
                let from = parts
                    .filter(|p| Some(p.part) == task.part)
                    .filter_map(|p| p.from);
                files.extend(from.map(|[cell, _]| parts_of(cell)));
            }
        }
        files
    }
}
