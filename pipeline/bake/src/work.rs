//! How a task is done.

use crate::error::BakeError;
use crate::fitting;
use crate::plan::{CellPlan, PartPlan, RoundPlan};
use crate::run::Run;
use crate::task::{Stage, Task, draw};
use rrf_extract::{Draw, Lookout};
use rrf_field::tree::{self, Tree};
use rrf_scene::Scene;
use rrf_store::layout::{list_parts, part_path};
use rrf_store::parts;
use rrf_store::samples::SampleTable;
use rrf_trace::Tracer;

/// A scene ready to be sampled. Training needs none.
pub struct Site<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    lookout: Lookout<'a>,
}

impl<'a> Site<'a> {
    /// Of a scene without its own lights.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer<'a>) -> Site<'a> {
        Site {
            scene,
            tracer,
            lookout: Lookout::new(scene, tracer),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Its tracer.
    pub fn tracer(&self) -> &'a Tracer<'a> {
        self.tracer
    }
}

/// Does a task: its output is there afterwards. A fit that would need more than `memory` bytes
/// keeps its rows in a file; its output is the same.
///
/// # Errors
/// [`BakeError::NoSite`] for an extraction without a site; whatever the stages find.
pub fn perform(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    task: &Task,
    memory: Option<u64>,
) -> Result<(), BakeError> {
    let cell = plan
        .cells
        .get(task.cell as usize)
        .ok_or(BakeError::NoSuchCell {
            cell: task.cell,
            last: plan.cells.len().saturating_sub(1) as u32,
        })?;
    match (task.stage, task.part) {
        (Stage::Extract, Some(number)) => {
            let part = cell.parts.iter().find(|p| p.part == number);
            let part = part.ok_or_else(|| BakeError::Plan {
                round: plan.round,
                reason: format!("cell {} has no part {number}", cell.cell),
            })?;
            extract(run, plan, site, cell, part, &task.hash)
        }
        _ => fitting::train(run, plan, cell, task, memory),
    }
}

fn extract(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    cell: &CellPlan,
    part: &PartPlan,
    hash: &str,
) -> Result<(), BakeError> {
    let table = match taken(run, plan, part)? {
        Some(table) => table,
        None => drawn(run, plan, site, part)?,
    };
    let table = within(table, &plan.tree, cell.cell);
    parts::write_part_of(&run.folder, part.part, &table, &run.facts(), hash)?;
    Ok(())
}

/// The draw's rows from the part that holds them, where it is still there and whole.
fn taken(run: &Run, plan: &RoundPlan, part: &PartPlan) -> Result<Option<SampleTable>, BakeError> {
    let Some([cell, number]) = part.from else {
        return Ok(None);
    };
    if !part_path(&run.folder, cell, number).exists() {
        return Ok(None);
    }
    let table = parts::read_part(&run.folder, cell, number, &run.facts())?;
    let of_draw = |index: &u64| (index >> 32) as u32 == part.draw;
    if !table.index.iter().all(of_draw) {
        return Err(BakeError::Plan {
            round: plan.round,
            reason: format!("part {number} of cell {cell} is of another draw"),
        });
    }
    Ok(Some(table))
}

fn drawn(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    part: &PartPlan,
) -> Result<SampleTable, BakeError> {
    let site = site.ok_or(BakeError::NoSite)?;
    let asked = draw(plan, part)?;
    let domain = plan.tree.node_domains().get(asked.node as usize).copied();
    let draw = Draw {
        stream: part.draw,
        domain: domain.unwrap_or(tree::Domain::EMPTY),
        rows: asked.rows,
        paths: asked.paths,
    };
    let light_box = run.config.extract.light_box;
    let drawn = rrf_extract::extract(
        site.scene,
        site.tracer,
        &site.lookout,
        light_box,
        run.manifest.seed,
        &draw,
    )?;
    Ok(SampleTable {
        cell_id: 0,
        paths: vec![asked.paths; drawn.index.len()],
        index: drawn.index,
        columns: drawn.rows,
        material: drawn.material,
        halves: drawn.halves,
    })
}

/// The rows that lie in a cell.
fn within(table: SampleTable, tree: &Tree, cell: u32) -> SampleTable {
    let cells = tree.find_all(&table.columns);
    let mut kept = SampleTable {
        cell_id: cell,
        ..SampleTable::default()
    };
    for (row, _) in cells.iter().enumerate().filter(|(_, c)| **c == cell) {
        kept.index.push(table.index[row]);
        kept.columns.push(table.columns.row(row));
        kept.material.push(table.material[row]);
        kept.halves[0].push(table.halves[0][row]);
        kept.halves[1].push(table.halves[1][row]);
        kept.paths.push(table.paths[row]);
    }
    kept
}

/// A cell's rows, its parts in the plan's order.
pub(crate) fn read_cell(run: &Run, cell: &CellPlan) -> Result<SampleTable, BakeError> {
    let mut whole = SampleTable {
        cell_id: cell.cell,
        ..SampleTable::default()
    };
    each_part(run, cell, &mut |table| whole.extend(table))?;
    Ok(whole)
}

/// Hands on a cell's rows, a part at a time, in the plan's order.
pub(crate) fn each_part(
    run: &Run,
    cell: &CellPlan,
    see: &mut dyn FnMut(&SampleTable),
) -> Result<(), BakeError> {
    // a stray file would stop every other reader of the dataset too: said here, by name
    list_parts(&run.folder, cell.cell)?;
    for part in &cell.parts {
        if !part_path(&run.folder, cell.cell, part.part).exists() {
            return Err(BakeError::NotExtracted {
                path: run.folder.clone(),
                cell: cell.cell,
            });
        }
        see(&parts::read_part(
            &run.folder,
            cell.cell,
            part.part,
            &run.facts(),
        )?);
    }
    Ok(())
}
