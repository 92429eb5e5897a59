//! What a round is made of: tasks that can run anywhere, in any order, any number of times.
//!
//! A task reads files of the run, writes one file (or one fit) and is known by a hash of
//! everything that its output depends on. The output carries the hash: a task whose output is
//! there with the same hash is done.

use crate::cost;
use crate::error::BakeError;
use crate::plan::{CellPlan, DrawPlan, PartPlan, RoundPlan};
use crate::run::Run;
use rrf_field::tree::{Domain, Tree};
use rrf_store::layout::fit_folder;
use rrf_store::task_table::TaskRow;
use rrf_store::{model, parts};
use rrf_train::TrainConfig;
use serde::Serialize;

/// Stage of a task; the tasks of one stage do not wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Draws a part's rows, or takes them from a part of the round before.
    Extract,
    /// Fits a cell's net to its parts.
    Train,
}

impl Stage {
    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Extract => "extract",
            Stage::Train => "train",
        }
    }
}

/// One task of a round.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// What it does.
    pub stage: Stage,
    /// Round that its output belongs to.
    pub round: u32,
    /// For which cell.
    pub cell: u32,
    /// Part number, of an extraction.
    pub part: Option<u32>,
    /// blake3 of everything that the output depends on, 64 hexadecimal digits.
    pub hash: String,
    /// Seconds of one core that it should take (see [`crate::cost`]).
    pub seconds: f64,
    /// Bytes of memory that it should need at the most.
    pub memory: u64,
}

/// Program version: another one may compute other bits.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// All tasks of a round, extractions first, by cell and part. Those whose output stays from an
/// earlier round are among them, and done, unless it was lost.
pub fn tasks(run: &Run, plan: &RoundPlan) -> Result<Vec<Task>, BakeError> {
    let (mut extract, mut train) = (Vec::new(), Vec::new());
    let boxes = Boxes::new(&plan.tree);
    let rows = expected_rows(plan);
    for cell in &plan.cells {
        let hashes = cell
            .parts
            .iter()
            .map(|part| part_hash(run, plan, &boxes, cell, part))
            .collect::<Result<Vec<String>, _>>()?;
        for (part, hash) in cell.parts.iter().zip(&hashes) {
            let draw = draw(plan, part)?;
            extract.push(Task {
                stage: Stage::Extract,
                round: plan.round,
                cell: cell.cell,
                part: Some(part.part),
                hash: hash.clone(),
                seconds: cost::extract_seconds(part, draw),
                memory: cost::extract_memory(draw),
            });
        }
        let rows = rows.get(cell.cell as usize).copied().unwrap_or(0);
        train.push(Task {
            stage: Stage::Train,
            round: cell.fitted,
            cell: cell.cell,
            part: None,
            hash: fit_hash(run, plan, cell, &hashes)?,
            seconds: cost::train_seconds(rows, &cell.size, &run.config.train),
            memory: cost::train_memory(rows),
        });
    }
    extract.append(&mut train);
    Ok(extract)
}

/// The tasks as schedulers read them.
pub(crate) fn task_rows(run: &Run, plan: &RoundPlan) -> Result<Vec<TaskRow>, BakeError> {
    let row = |(id, task): (u32, Task)| TaskRow {
        task_id: id,
        stage: task.stage.name().into(),
        round: task.round,
        cell_id: task.cell,
        part: task.part,
        input_hash: task.hash,
        seconds: task.seconds,
        memory: task.memory,
    };
    Ok((0u32..).zip(tasks(run, plan)?).map(row).collect())
}

/// Beginnings of the names of the files that a task reads and writes, relative to the run: what a
/// worker on another machine needs.
pub fn files_of(plan: &RoundPlan, task: &Task) -> Vec<String> {
    let id = task.cell;
    let mut files = vec![format!("samples/cell={id:06}/")];
    match task.stage {
        Stage::Train => {
            let earlier = plan.cells.get(id as usize).and_then(|cell| cell.earlier);
            let fits = std::iter::once([task.round, id]).chain(earlier);
            files.extend(
                fits.map(|[round, cell]| format!("rounds/{round:03}/fits/cell={cell:06}/")),
            );
        }
        Stage::Extract => {
            let cell = plan.cells.get(id as usize);
            let parts = cell.into_iter().flat_map(|cell| &cell.parts);
            let from = parts
                .filter(|p| Some(p.part) == task.part)
                .filter_map(|p| p.from);
            files.extend(from.map(|[cell, _]| format!("samples/cell={cell:06}/")));
        }
    }
    files
}

/// Whether a task's output is there.
///
/// # Errors
/// [`BakeError::Store`] for an output that is there and damaged or foreign.
pub fn is_done(run: &Run, task: &Task) -> Result<bool, BakeError> {
    let facts = run.facts();
    let found = match (task.stage, task.part) {
        (Stage::Extract, Some(part)) => parts::part_task(&run.folder, task.cell, part, &facts)?,
        _ => model::fit_task(&fit_folder(&run.folder, task.round, task.cell), &facts)?,
    };
    Ok(found.as_deref() == Some(task.hash.as_str()))
}

pub(crate) fn draw<'a>(plan: &'a RoundPlan, part: &PartPlan) -> Result<&'a DrawPlan, BakeError> {
    plan.draws
        .get(part.draw as usize)
        .ok_or_else(|| BakeError::Plan {
            round: plan.round,
            reason: format!("draw {} is missing", part.draw),
        })
}

/// Rows that each cell should have: its share, by measure, of the draws that it has part in.
pub(crate) fn expected_rows(plan: &RoundPlan) -> Vec<u64> {
    let mut shared = vec![0.0; plan.draws.len()];
    for cell in &plan.cells {
        for part in &cell.parts {
            if let Some(sum) = shared.get_mut(part.draw as usize) {
                *sum += cell.measure;
            }
        }
    }
    let rows = |cell: &CellPlan| -> f64 {
        let of = |part: &PartPlan| {
            let draw = part.draw as usize;
            let (drawn, sum) = (plan.draws.get(draw)?, shared.get(draw)?);
            (*sum > 0.0).then(|| f64::from(drawn.rows) * cell.measure / sum)
        };
        cell.parts.iter().filter_map(of).sum()
    };
    plan.cells.iter().map(|cell| rows(cell) as u64).collect()
}

/// Boxes of nodes, and the leaf of each cell.
struct Boxes {
    nodes: Vec<Domain>,
    leaves: Vec<usize>,
}

impl Boxes {
    fn new(tree: &Tree) -> Boxes {
        Boxes {
            nodes: tree.node_domains(),
            leaves: tree.leaves(),
        }
    }

    /// The bounds of a node, as bits: infinite ones have no JSON.
    fn bits(&self, node: usize) -> Vec<u32> {
        let bounds = self
            .nodes
            .get(node)
            .map(|d| d.minimum.iter().chain(&d.maximum));
        bounds.into_iter().flatten().map(|x| x.to_bits()).collect()
    }
}

#[derive(Serialize)]
struct PartInput<'a> {
    version: &'static str,
    scene: &'a str,
    seed: u64,
    light_box: [f32; 6],
    stream: u32,
    draw: &'a DrawPlan,
    /// The cell's box and the draw's.
    boxes: [Vec<u32>; 2],
}

fn part_hash(
    run: &Run,
    plan: &RoundPlan,
    boxes: &Boxes,
    cell: &CellPlan,
    part: &PartPlan,
) -> Result<String, BakeError> {
    let draw = draw(plan, part)?;
    let leaf = boxes.leaves.get(cell.cell as usize).copied();
    let input = PartInput {
        version: VERSION,
        scene: &run.manifest.scene_hash,
        seed: run.manifest.seed,
        light_box: run.manifest.light_box,
        stream: part.draw,
        draw,
        boxes: [leaf.unwrap_or(0), draw.node as usize].map(|node| boxes.bits(node)),
    };
    hash(plan.round, &input)
}

#[derive(Serialize)]
struct FitInput<'a> {
    version: &'static str,
    cell: u32,
    round: u32,
    earlier: Option<[u32; 2]>,
    parts: &'a [String],
    config: TrainConfig,
    lambert: &'a [bool],
}

fn fit_hash(
    run: &Run,
    plan: &RoundPlan,
    cell: &CellPlan,
    parts: &[String],
) -> Result<String, BakeError> {
    let input = FitInput {
        version: VERSION,
        cell: cell.cell,
        round: cell.fitted,
        earlier: cell.earlier,
        parts,
        config: fit_config(run, plan, cell),
        lambert: &plan.lambert,
    };
    hash(plan.round, &input)
}

/// The trainer's settings for one cell.
pub(crate) fn fit_config(run: &Run, plan: &RoundPlan, cell: &CellPlan) -> TrainConfig {
    TrainConfig {
        mean_luminance: Some(plan.mean_luminance),
        size: cell.size.clone(),
        ..run.config.train.clone()
    }
}

fn hash(round: u32, input: &impl Serialize) -> Result<String, BakeError> {
    let text = serde_json::to_vec(input).map_err(|e| BakeError::Plan {
        round,
        reason: e.to_string(),
    })?;
    Ok(blake3::hash(&text).to_hex().to_string())
}
