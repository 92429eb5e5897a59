//! Extraction of one part: rows taken from an earlier part, or drawn and traced.

use crate::error::BakeError;
use crate::exec::context::SamplingContext;
use crate::plan::round::PartPlan;
use crate::plan::shard::Job;
use crate::run::folder::Run;
use rrf_extract::Draw;
use rrf_field::tree::Domain;
use rrf_store::layout::part_path;
use rrf_store::parts;
use rrf_store::samples::SampleTable;

/// Extracts the part of a task and writes it.
pub(crate) fn extract_part(
    run: &Run,
    job: &Job,
    context: Option<&SamplingContext>,
) -> Result<(), BakeError> {
    let cell = &job.cell.plan;
    let part = cell.parts.iter().find(|p| Some(p.part) == job.task.part);
    let part = part.ok_or_else(|| BakeError::Plan {
        round: job.facts.round,
        reason: format!(
            "cell {}: the part of a task is missing. Bake into a new folder",
            cell.cell
        ),
    })?;
    let table = match taken(run, job, part)? {
        Some(table) => table,
        None => drawn(run, job, context, part)?,
    };
    let table = within(table, &job.cell.leaf.domain(), job.task.cell);
    parts::write_part_of(&run.folder, part.part, &table, &run.facts(), &job.task.hash)?;
    Ok(())
}

/// The rows of the draw from the part that contains them, where that still exists.
fn taken(run: &Run, job: &Job, part: &PartPlan) -> Result<Option<SampleTable>, BakeError> {
    let Some([cell, number]) = part.from else {
        return Ok(None);
    };
    if !part_path(&run.folder, cell, number).exists() {
        return Ok(None);
    }
    let table = match parts::read_part(&run.folder, cell, number, &run.facts()) {
        Ok(table) => table,
        // the draw makes the same rows
        Err(error) if error.is_damage() => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let of_draw = |index: &u64| (index >> 32) as u32 == part.draw;
    if !table.index.iter().all(of_draw) {
        return Err(BakeError::Plan {
            round: job.facts.round,
            reason: format!(
                "part {number} of cell {cell} belongs to another draw. Bake into a new folder"
            ),
        });
    }
    Ok(Some(table))
}

/// The rows of the draw, sampled and traced.
fn drawn(
    run: &Run,
    job: &Job,
    context: Option<&SamplingContext>,
    part: &PartPlan,
) -> Result<SampleTable, BakeError> {
    let context = context.ok_or(BakeError::NoContext)?;
    let (request, bounds) = job.cell.draw(job.facts.round, part)?;
    let draw = Draw {
        stream: part.draw,
        domain: bounds.domain(),
        rows: request.rows,
        paths: request.paths,
        narrow: context.narrow,
    };
    let drawn = rrf_extract::extract(
        context.scene,
        context.tracer,
        &context.visibility,
        context.eyes.as_ref(),
        run.config.extract.light_box,
        run.manifest.seed,
        &draw,
    )?;
    Ok(SampleTable {
        cell_id: 0,
        paths: vec![request.paths; drawn.index.len()],
        index: drawn.index,
        columns: drawn.rows,
        material: drawn.material,
        halves: drawn.halves,
    })
}

/// The rows inside the box of a cell.
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
