//! A task with everything that it needs of its round's plan, and shards of a few hundred of these: a
//! worker reads as little of a plan of 100,000 cells as of one of ten.

use crate::error::BakeError;
use crate::plan::round::{CellPlan, DrawPlan, PartPlan, RoundPlan};
use crate::plan::task::Task;
use rrf_field::columns;
use rrf_field::tree::{Domain, Tree};
use serde::{Deserialize, Serialize};

/// Tasks in one shard.
pub const SHARD_TASKS: usize = 256;

/// One file, `rounds/000/tasks/00042.json`: tasks `first` to `first` + [`SHARD_TASKS`] of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TaskShard {
    /// blake3 of the scene, hexadecimal.
    pub scene_hash: String,
    /// Seed of the run.
    pub seed: u64,
    /// Number of tasks of the round.
    pub tasks: u32,
    /// Facts that all tasks of the round share.
    pub shared: RoundFacts,
    /// Id of the first task in this shard.
    pub first: u32,
    /// The tasks.
    pub entries: Vec<ShardEntry>,
}

/// A task and the plan of its cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ShardEntry {
    pub task: Task,
    #[serde(rename = "of_cell")]
    pub cell: CellTasks,
}

/// Facts that all tasks of a round share.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RoundFacts {
    pub round: u32,
    /// Whether a material of the scene is Lambertian, by material id.
    pub lambert: Vec<bool>,
    /// Channel mean of the indirect radiance [W·sr⁻¹·m⁻²].
    #[serde(rename = "mean_luminance")]
    pub mean_radiance: f32,
}

impl RoundFacts {
    /// The facts of a plan.
    pub fn of(plan: &RoundPlan) -> RoundFacts {
        RoundFacts {
            round: plan.round,
            lambert: plan.lambert.clone(),
            mean_radiance: plan.mean_radiance,
        }
    }
}

/// Facts that all tasks of a cell share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CellTasks {
    pub plan: CellPlan,
    /// The box of the cell.
    pub leaf: Bounds,
    /// Number, request and box of the draws that the parts of the cell belong to.
    pub draws: Vec<(u32, DrawPlan, Bounds)>,
}

impl CellTasks {
    /// The draw of a part and its box.
    pub fn draw(&self, round: u32, part: &PartPlan) -> Result<(&DrawPlan, &Bounds), BakeError> {
        let found = self.draws.iter().find(|(number, ..)| *number == part.draw);
        let found = found.map(|(_, draw, bounds)| (draw, bounds));
        found.ok_or_else(|| BakeError::missing_draw(round, part.draw))
    }

    /// The same for one part alone: a cell of thousands of parts has as many tasks.
    pub fn for_part(&self, part: &PartPlan) -> CellTasks {
        let draws = self.draws.iter();
        CellTasks {
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

/// A box as the list of its finite bounds: column, whether it is the upper one, bits of the number.
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

    /// The box. Columns that do not exist are ignored.
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

    /// All bounds as bits, since infinite ones have no JSON.
    pub fn bits(&self) -> Vec<u32> {
        let domain = self.domain();
        let all = domain.minimum.iter().chain(&domain.maximum);
        all.take(2 * columns::COUNT).map(|x| x.to_bits()).collect()
    }
}

/// The boxes of a tree's nodes, and the leaf of each cell.
pub(crate) struct TreeBoxes {
    nodes: Vec<Domain>,
    leaves: Vec<usize>,
}

impl TreeBoxes {
    pub fn new(tree: &Tree) -> TreeBoxes {
        TreeBoxes {
            nodes: tree.node_domains(),
            leaves: tree.leaves(),
        }
    }

    fn bounds(&self, node: Option<usize>) -> Bounds {
        let domain = self.nodes.get(node.unwrap_or(0)).unwrap_or(&Domain::ALL);
        Bounds::of(domain)
    }

    /// What the tasks of a cell share.
    pub fn cell_tasks(&self, plan: &RoundPlan, cell: &CellPlan) -> Result<CellTasks, BakeError> {
        let draws = cell.parts.iter().map(|part| {
            let draw = plan.draws.get(part.draw as usize);
            let draw = draw.ok_or_else(|| BakeError::missing_draw(plan.round, part.draw))?;
            Ok((part.draw, *draw, self.bounds(Some(draw.node as usize))))
        });
        Ok(CellTasks {
            plan: cell.clone(),
            leaf: self.bounds(self.leaves.get(cell.cell as usize).copied()),
            draws: draws.collect::<Result<Vec<_>, BakeError>>()?,
        })
    }
}

/// One task with its inputs, ready to be done on any machine.
#[derive(Clone, Debug)]
pub struct Job {
    /// The task.
    pub task: Task,
    pub(crate) facts: RoundFacts,
    pub(crate) cell: CellTasks,
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
            facts: RoundFacts::of(plan),
            cell: TreeBoxes::new(&plan.tree).cell_tasks(plan, &cell)?,
        })
    }
}
