//! How a task is done.

use crate::config::BakeConfig;
use crate::error::BakeError;
use crate::fitting;
use crate::job::Job;
use crate::plan::{CellPlan, MOST_ROWS, PartPlan, RoundPlan};
use crate::run::Run;
use crate::task::{Stage, Task};
use rrf_extract::{Draw, Eyes, VisibilityQueries};
use rrf_field::tree::Domain;
use rrf_scene::Scene;
use rrf_store::layout::{list_parts, part_path};
use rrf_store::part_reader::PartReader;
use rrf_store::parts;
use rrf_store::samples::SampleTable;
use rrf_trace::Tracer;

/// A scene ready to be sampled. Training needs none.
pub struct Site<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    visibility: VisibilityQueries<'a>,
    eyes: Option<Eyes>,
}

impl<'a> Site<'a> {
    /// Of a scene without its own lights, and the settings of its bake.
    ///
    /// # Errors
    /// Where no eye has a place to look from.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a Tracer<'a>,
        config: &BakeConfig,
    ) -> Result<Site<'a>, BakeError> {
        let visibility = VisibilityQueries::new(scene, tracer);
        let eyes = config
            .extract
            .eye_box
            .map(|eye_box| Eyes::new(&visibility, eye_box));
        Ok(Site {
            scene,
            tracer,
            eyes: eyes.transpose()?,
            visibility,
        })
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

/// Does a task of a plan; see [`perform_job`].
///
/// # Errors
/// As [`perform_job`]; [`BakeError::NoSuchCell`].
pub fn perform(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    task: &Task,
    memory: Option<u64>,
) -> Result<(), BakeError> {
    perform_job(run, &Job::of(plan, task)?, site, memory)
}

/// Does a task: its output is there afterwards. A fit that would need more than `memory` bytes
/// keeps its rows in a file; its output is the same.
///
/// # Errors
/// [`BakeError::NoSite`] for an extraction without a site, [`BakeError::Gone`]; whatever the stages find.
pub fn perform_job(
    run: &Run,
    job: &Job,
    site: Option<&Site>,
    memory: Option<u64>,
) -> Result<(), BakeError> {
    run.unless_gone(Ok(()))?;
    let cell = &job.of_cell.plan;
    let done = match (job.task.stage, job.task.part) {
        (Stage::Extract, Some(number)) => {
            let part = cell.parts.iter().find(|p| p.part == number);
            let part = part.ok_or_else(|| BakeError::Plan {
                round: job.shared.round,
                reason: format!("cell {} has no part {number}", cell.cell),
            })?;
            extract(run, job, site, part)
        }
        _ => fitting::train(run, job, memory),
    };
    run.unless_gone(done)
}

fn extract(run: &Run, job: &Job, site: Option<&Site>, part: &PartPlan) -> Result<(), BakeError> {
    let table = match taken(run, job, part)? {
        Some(table) => table,
        None => drawn(run, job, site, part)?,
    };
    let table = within(table, &job.of_cell.leaf.domain(), job.task.cell);
    parts::write_part_of(&run.folder, part.part, &table, &run.facts(), &job.task.hash)?;
    Ok(())
}

/// The draw's rows from the part that holds them, where it is still there and whole.
fn taken(run: &Run, job: &Job, part: &PartPlan) -> Result<Option<SampleTable>, BakeError> {
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
            round: job.shared.round,
            reason: format!("part {number} of cell {cell} is of another draw"),
        });
    }
    Ok(Some(table))
}

fn drawn(
    run: &Run,
    job: &Job,
    site: Option<&Site>,
    part: &PartPlan,
) -> Result<SampleTable, BakeError> {
    let site = site.ok_or(BakeError::NoSite)?;
    let (asked, bounds) = job.of_cell.draw(job.shared.round, part)?;
    let draw = Draw {
        stream: part.draw,
        domain: bounds.domain(),
        rows: asked.rows,
        paths: asked.paths,
    };
    let light_box = run.config.extract.light_box;
    let drawn = rrf_extract::extract(
        site.scene,
        site.tracer,
        &site.visibility,
        site.eyes.as_ref(),
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

/// The rows that lie in a cell's box.
fn within(table: SampleTable, leaf: &Domain, cell: u32) -> SampleTable {
    let mut kept = SampleTable {
        cell_id: cell,
        ..SampleTable::default()
    };
    let inside = |row: &usize| leaf.contains(&table.columns.row(*row));
    for row in (0..table.len()).filter(inside) {
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

/// Rows of a cell for a decision about it: whole parts, in the plan's order, until there are as
/// many as one draw has at the most; and how many the cell has. What a decision holds in memory
/// does not grow with the cell.
pub(crate) fn read_some(run: &Run, cell: &CellPlan) -> Result<(SampleTable, u32), BakeError> {
    let mut some = SampleTable {
        cell_id: cell.cell,
        ..SampleTable::default()
    };
    let mut rows = 0;
    for part in &cell.parts {
        let path = part_path(&run.folder, cell.cell, part.part);
        if some.len() < MOST_ROWS as usize {
            let table = parts::read_part(&run.folder, cell.cell, part.part, &run.facts())?;
            some.extend(&table);
            rows += table.len();
        } else {
            rows += PartReader::open(&path, cell.cell, part.part, &run.facts())?.rows();
        }
    }
    Ok((some, u32::try_from(rows).unwrap_or(u32::MAX)))
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
