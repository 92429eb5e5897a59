//! The tasks of a round: their inputs' hashes, what they should cost, and the shards that hold them.

use crate::error::BakeError;
use crate::plan::round::{CellPlan, DrawPlan, EarlierFit, PartPlan, RoundPlan};
use crate::plan::shard::{CellTasks, RoundFacts, SHARD_TASKS, ShardEntry, TaskShard, TreeBoxes};
use crate::plan::task::{Task, TaskKind};
use crate::policy::cost;
use crate::settings::BakeConfig;
use rrf_extract::{NarrowLight, Region};
use rrf_store::layout::TEST;
use rrf_store::manifest::RunManifest;
use rrf_store::task_table::TaskRow;
use rrf_train::TrainConfig;
use serde::Serialize;

/// What the outputs of a run's tasks depend on besides the round's plan.
#[derive(Clone, Copy)]
pub(crate) struct RunInputs<'a> {
    pub manifest: &'a RunManifest,
    pub config: &'a BakeConfig,
}

/// Program version: another one may compute other bits.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// All tasks of a round with their inputs: extractions first, by cell and part, test rows after the
/// cells'. Tasks whose output is kept from an earlier round are included.
pub(crate) fn entries(inputs: RunInputs, plan: &RoundPlan) -> Result<Vec<ShardEntry>, BakeError> {
    let (mut extract, mut train) = (Vec::new(), Vec::new());
    let (boxes, facts) = (TreeBoxes::new(&plan.tree), RoundFacts::of(plan));
    let config = &inputs.config.train;
    for (plan_of_cell, rows) in plan.cells.iter().zip(expected_rows(plan)) {
        let cell = boxes.cell_tasks(plan, plan_of_cell)?;
        let (parts, fit) = inputs.hashes(&facts, &cell)?;
        extract.append(&mut extractions(plan, &cell, parts)?);
        let task = Task {
            kind: TaskKind::Train,
            round: cell.plan.fitted,
            cell: cell.plan.cell,
            part: None,
            hash: fit,
            seconds: cost::fit_seconds(rows, plan_of_cell, config),
            memory: cost::train_memory(rows, &cell.plan.size, config),
            least_memory: cost::least_memory(rows, &cell.plan.size, config),
        };
        train.push(ShardEntry { task, cell });
    }
    for part in &plan.tests {
        let cell = boxes.cell_tasks(plan, &CellPlan::of_test_rows(&[*part]))?;
        let (parts, _) = inputs.hashes(&facts, &cell)?;
        extract.append(&mut extractions(plan, &cell, parts)?);
    }
    extract.append(&mut train);
    Ok(extract)
}

/// The extractions of a cell's parts.
fn extractions(
    plan: &RoundPlan,
    cell: &CellTasks,
    hashes: Vec<String>,
) -> Result<Vec<ShardEntry>, BakeError> {
    let entry = |(part, hash): (&PartPlan, String)| {
        let (draw, _) = cell.draw(plan.round, part)?;
        let task = Task {
            kind: TaskKind::Extract,
            round: plan.round,
            cell: cell.plan.cell,
            part: Some(part.part),
            hash,
            seconds: cost::extract_seconds(part, draw, plan.path_seconds),
            memory: cost::extract_memory(draw),
            least_memory: cost::extract_memory(draw),
        };
        let cell = cell.for_part(part);
        Ok(ShardEntry { task, cell })
    };
    cell.plan.parts.iter().zip(hashes).map(entry).collect()
}

/// The tasks of a round in shards that can be read alone.
pub(crate) fn shards(inputs: RunInputs, plan: &RoundPlan) -> Result<Vec<TaskShard>, BakeError> {
    let entries = entries(inputs, plan)?;
    let shards = (0u32..)
        .step_by(SHARD_TASKS)
        .zip(entries.chunks(SHARD_TASKS));
    let shard = |(first, of): (u32, &[ShardEntry])| TaskShard {
        scene_hash: inputs.manifest.scene_hash.clone(),
        seed: inputs.manifest.seed,
        tasks: entries.len() as u32,
        shared: RoundFacts::of(plan),
        first,
        entries: of.to_vec(),
    };
    Ok(shards.map(shard).collect())
}

/// The table of tasks that schedulers read.
pub(crate) fn task_rows(shards: &[TaskShard], seed: u64) -> Vec<TaskRow> {
    let row = |(id, ShardEntry { task, .. }): (u32, &ShardEntry)| TaskRow {
        task_id: id,
        stage: task.kind.name().into(),
        round: task.round,
        cell_id: (task.cell != TEST).then_some(task.cell),
        part: task.part,
        input_hash: task.hash.clone(),
        seed,
        seconds: task.seconds,
        memory: task.memory,
    };
    let entries = shards.iter().flat_map(|shard| &shard.entries);
    (0u32..).zip(entries).map(row).collect()
}

/// Expected rows of each cell: its share, by measure, of the draws that it has parts of.
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

/// The trainer's settings for one cell.
pub(crate) fn fit_config(config: &BakeConfig, mean_radiance: f32, cell: &CellPlan) -> TrainConfig {
    TrainConfig {
        mean_radiance: Some(mean_radiance),
        size: cell.size.clone(),
        prune: cell.prune.or(config.train.prune),
        ..config.train.clone()
    }
}

/// The hashes of a plan's fits.
pub(crate) struct FitHashes<'a> {
    inputs: RunInputs<'a>,
    plan: &'a RoundPlan,
    boxes: TreeBoxes,
    facts: RoundFacts,
}

impl<'a> FitHashes<'a> {
    pub fn new(inputs: RunInputs<'a>, plan: &'a RoundPlan) -> FitHashes<'a> {
        FitHashes {
            inputs,
            plan,
            boxes: TreeBoxes::new(&plan.tree),
            facts: RoundFacts::of(plan),
        }
    }

    /// The hash of a cell's fit.
    pub fn fit(&self, cell: &CellPlan) -> Result<String, BakeError> {
        let cell = self.boxes.cell_tasks(self.plan, cell)?;
        Ok(self.inputs.hashes(&self.facts, &cell)?.1)
    }
}

#[derive(Serialize)]
struct PartInput<'a> {
    version: &'static str,
    scene: &'a str,
    seed: u64,
    light_box: [f32; 6],
    #[serde(skip_serializing_if = "Option::is_none")]
    eye_box: Option<Region>,
    #[serde(skip_serializing_if = "NarrowLight::is_learned")]
    narrow: NarrowLight,
    stream: u32,
    draw: &'a DrawPlan,
    /// The boxes of the cell and of the draw.
    boxes: [Vec<u32>; 2],
}

#[derive(Serialize)]
struct FitInput<'a> {
    version: &'static str,
    cell: u32,
    round: u32,
    earlier: Option<&'a EarlierFit>,
    parts: &'a [String],
    config: TrainConfig,
    lambert: &'a [bool],
}

impl RunInputs<'_> {
    /// Hashes of a cell's parts and of its fit.
    pub fn hashes(
        self,
        facts: &RoundFacts,
        cell: &CellTasks,
    ) -> Result<(Vec<String>, String), BakeError> {
        let parts = cell.plan.parts.iter();
        let parts = parts
            .map(|part| self.part_hash(facts, cell, part))
            .collect::<Result<Vec<String>, _>>()?;
        let input = FitInput {
            version: VERSION,
            cell: cell.plan.cell,
            round: cell.plan.fitted,
            earlier: cell.plan.earlier.as_ref(),
            parts: &parts,
            config: fit_config(self.config, facts.mean_radiance, &cell.plan),
            lambert: &facts.lambert,
        };
        let fit = hash(facts.round, &input)?;
        Ok((parts, fit))
    }

    fn part_hash(
        self,
        facts: &RoundFacts,
        cell: &CellTasks,
        part: &PartPlan,
    ) -> Result<String, BakeError> {
        let (draw, bounds) = cell.draw(facts.round, part)?;
        let input = PartInput {
            version: VERSION,
            scene: &self.manifest.scene_hash,
            seed: self.manifest.seed,
            light_box: self.manifest.light_box,
            eye_box: self.config.extract.eye_box,
            narrow: self.config.extract.narrow,
            stream: part.draw,
            draw,
            boxes: [cell.leaf.bits(), bounds.bits()],
        };
        hash(facts.round, &input)
    }
}

fn hash(round: u32, input: &impl Serialize) -> Result<String, BakeError> {
    let text = serde_json::to_vec(input).map_err(|e| BakeError::Plan {
        round,
        reason: e.to_string(),
    })?;
    Ok(blake3::hash(&text).to_hex().to_string())
}
