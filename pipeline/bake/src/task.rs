//! What a round is made of: tasks that can run anywhere, in any order, any number of times.
//!
//! A task reads files of the run, writes one file (or one fit) and is known by a hash of
//! everything that its output depends on. The output carries the hash: a task whose output is
//! there with the same hash is done.

use crate::cost;
use crate::error::BakeError;
use crate::job::{Boxes, CHAPTER, Chapter, Entry, OfCell, Shared};
use crate::plan::{CellPlan, DrawPlan, Earlier, PartPlan, RoundPlan};
use crate::run::Run;
use crate::test_rows;
use rrf_extract::Region;
use rrf_store::layout::{TEST, fit_folder};
use rrf_store::task_table::TaskRow;
use rrf_store::{model, parts};
use rrf_train::TrainConfig;
use serde::{Deserialize, Serialize};

/// Stage of a task; the tasks of one stage do not wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// What it does.
    pub stage: Stage,
    /// Round that its output belongs to.
    pub round: u32,
    /// For which cell; [`TEST`] for rows that only judge.
    pub cell: u32,
    /// Part number, of an extraction.
    pub part: Option<u32>,
    /// blake3 of everything that the output depends on, 64 hexadecimal digits.
    pub hash: String,
    /// Seconds of one core that it should take (see [`crate::cost`]).
    pub seconds: f64,
    /// Bytes of memory that it should need at the most.
    pub memory: u64,
    /// Bytes that it can do with: a fit may keep its rows in a file.
    pub least_memory: u64,
}

/// Program version: another one may compute other bits.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// All tasks of a round, extractions first, by cell and part, test rows after the cells'. Those whose output stays from an
/// earlier round are among them, and done, unless it was lost.
pub fn tasks(run: &Run, plan: &RoundPlan) -> Result<Vec<Task>, BakeError> {
    Ok(entries(run, plan)?.into_iter().map(|e| e.task).collect())
}

/// The same with what each of them needs.
fn entries(run: &Run, plan: &RoundPlan) -> Result<Vec<Entry>, BakeError> {
    let (mut extract, mut train) = (Vec::new(), Vec::new());
    let (boxes, shared) = (Boxes::new(&plan.tree), Shared::of(plan));
    let rows = expected_rows(plan);
    for cell in &plan.cells {
        let of_cell = boxes.of_cell(plan, cell)?;
        let (hashes, fit) = cell_hashes(run, &shared, &of_cell)?;
        extract.append(&mut extractions(plan, &of_cell, hashes)?);
        let rows = rows.get(cell.cell as usize).copied().unwrap_or(0);
        let task = Task {
            stage: Stage::Train,
            round: cell.fitted,
            cell: cell.cell,
            part: None,
            hash: fit,
            seconds: cost::fit_seconds(rows, cell, &run.config.train),
            memory: cost::train_memory(rows, &cell.size, &run.config.train),
            least_memory: cost::least_memory(rows, &cell.size, &run.config.train),
        };
        train.push(Entry { task, of_cell });
    }
    for part in &plan.tests {
        let of_part = boxes.of_cell(plan, &test_rows::as_cell(&[*part]))?;
        let (hashes, _) = cell_hashes(run, &shared, &of_part)?;
        extract.append(&mut extractions(plan, &of_part, hashes)?);
    }
    extract.append(&mut train);
    Ok(extract)
}

/// The extractions of a cell's parts.
fn extractions(
    plan: &RoundPlan,
    of_cell: &OfCell,
    hashes: Vec<String>,
) -> Result<Vec<Entry>, BakeError> {
    let entry = |(part, hash): (&PartPlan, String)| {
        let (draw, _) = of_cell.draw(plan.round, part)?;
        let task = Task {
            stage: Stage::Extract,
            round: plan.round,
            cell: of_cell.plan.cell,
            part: Some(part.part),
            hash,
            seconds: cost::extract_seconds(part, draw, plan.path_seconds),
            memory: cost::extract_memory(draw),
            least_memory: cost::extract_memory(draw),
        };
        let of_cell = of_cell.of_part(part);
        Ok(Entry { task, of_cell })
    };
    of_cell.plan.parts.iter().zip(hashes).map(entry).collect()
}

/// The tasks with what they need, in files that can be read alone.
pub(crate) fn chapters(run: &Run, plan: &RoundPlan) -> Result<Vec<Chapter>, BakeError> {
    let (facts, shared) = (run.facts(), Shared::of(plan));
    let entries = entries(run, plan)?;
    let chapters = (0u32..).step_by(CHAPTER).zip(entries.chunks(CHAPTER));
    let chapter = |(first, of): (u32, &[Entry])| Chapter {
        scene_hash: facts.scene_hash.clone(),
        seed: facts.seed,
        tasks: entries.len() as u32,
        shared: shared.clone(),
        first,
        entries: of.to_vec(),
    };
    Ok(chapters.map(chapter).collect())
}

/// The tasks as schedulers read them.
pub(crate) fn task_rows(chapters: &[Chapter], seed: u64) -> Vec<TaskRow> {
    let row = |(id, task): (u32, &Task)| TaskRow {
        task_id: id,
        stage: task.stage.name().into(),
        round: task.round,
        cell_id: (task.cell != TEST).then_some(task.cell),
        part: task.part,
        input_hash: task.hash.clone(),
        seed,
        seconds: task.seconds,
        memory: task.memory,
    };
    let entries = chapters.iter().flat_map(|chapter| &chapter.entries);
    (0u32..)
        .zip(entries.map(|entry| &entry.task))
        .map(row)
        .collect()
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

#[derive(Serialize)]
struct PartInput<'a> {
    version: &'static str,
    scene: &'a str,
    seed: u64,
    light_box: [f32; 6],
    #[serde(skip_serializing_if = "Option::is_none")]
    eye_box: Option<Region>,
    stream: u32,
    draw: &'a DrawPlan,
    /// The cell's box and the draw's.
    boxes: [Vec<u32>; 2],
}

/// Hashes of a cell's parts and of its fit.
pub(crate) fn cell_hashes(
    run: &Run,
    shared: &Shared,
    cell: &OfCell,
) -> Result<(Vec<String>, String), BakeError> {
    let parts = cell.plan.parts.iter();
    let parts = parts
        .map(|part| part_hash(run, shared, cell, part))
        .collect::<Result<Vec<String>, _>>()?;
    let fit = fit_hash(run, shared, &cell.plan, &parts)?;
    Ok((parts, fit))
}

fn part_hash(
    run: &Run,
    shared: &Shared,
    cell: &OfCell,
    part: &PartPlan,
) -> Result<String, BakeError> {
    let (draw, bounds) = cell.draw(shared.round, part)?;
    let input = PartInput {
        version: VERSION,
        scene: &run.manifest.scene_hash,
        seed: run.manifest.seed,
        light_box: run.manifest.light_box,
        eye_box: run.config.extract.eye_box,
        stream: part.draw,
        draw,
        boxes: [cell.leaf.bits(), bounds.bits()],
    };
    hash(shared.round, &input)
}

#[derive(Serialize)]
struct FitInput<'a> {
    version: &'static str,
    cell: u32,
    round: u32,
    earlier: Option<&'a Earlier>,
    parts: &'a [String],
    config: TrainConfig,
    lambert: &'a [bool],
}

fn fit_hash(
    run: &Run,
    shared: &Shared,
    cell: &CellPlan,
    parts: &[String],
) -> Result<String, BakeError> {
    let input = FitInput {
        version: VERSION,
        cell: cell.cell,
        round: cell.fitted,
        earlier: cell.earlier.as_ref(),
        parts,
        config: fit_config(run, shared.mean_luminance, cell),
        lambert: &shared.lambert,
    };
    hash(shared.round, &input)
}

/// The trainer's settings for one cell.
pub(crate) fn fit_config(run: &Run, mean_luminance: f32, cell: &CellPlan) -> TrainConfig {
    TrainConfig {
        mean_radiance: Some(mean_luminance),
        size: cell.size.clone(),
        prune: cell.prune.or(run.config.train.prune),
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
