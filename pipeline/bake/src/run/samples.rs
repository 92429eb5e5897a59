//! The samples of a run: rows of a cell and test rows, read part by part.

use crate::error::BakeError;
use crate::plan::round::{CellPlan, MAX_DRAW_ROWS};
use crate::policy::held_out::is_held_out;
use crate::run::folder::Run;
use rrf_field::columns::Columns;
use rrf_store::layout::{list_parts, part_path};
use rrf_store::part_reader::PartReader;
use rrf_store::parts;
use rrf_store::samples::SampleTable;

/// Rows of a part in memory at a time.
const STRETCH: usize = 4096;

/// All rows of a cell, its parts in the order of the plan.
pub(crate) fn read_cell(run: &Run, cell: &CellPlan) -> Result<SampleTable, BakeError> {
    let mut whole = SampleTable {
        cell_id: cell.cell,
        ..SampleTable::default()
    };
    each_part(run, cell, &mut |table| whole.extend(table))?;
    Ok(whole)
}

/// Rows of a cell to decide from, and how many it has: whole parts, in the order of the plan, until
/// they have as many rows as the largest draw. Memory does not grow with the cell.
pub(crate) fn read_some(run: &Run, cell: &CellPlan) -> Result<(SampleTable, u32), BakeError> {
    let mut some = SampleTable {
        cell_id: cell.cell,
        ..SampleTable::default()
    };
    let mut rows = 0;
    for part in &cell.parts {
        let path = part_path(&run.folder, cell.cell, part.part);
        if some.len() < MAX_DRAW_ROWS as usize {
            let table = parts::read_part(&run.folder, cell.cell, part.part, &run.facts())?;
            some.extend(&table);
            rows += table.len();
        } else {
            rows += PartReader::open(&path, cell.cell, part.part, &run.facts())?.rows();
        }
    }
    Ok((some, u32::try_from(rows).unwrap_or(u32::MAX)))
}

/// Calls `see` with the rows of a cell, a part at a time, in the order of the plan.
pub(crate) fn each_part(
    run: &Run,
    cell: &CellPlan,
    see: &mut dyn FnMut(&SampleTable),
) -> Result<(), BakeError> {
    // a stray file would stop every other reader of the dataset too: named here
    list_parts(&run.folder, cell.cell)?;
    let facts = run.facts();
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
            &facts,
        )?);
    }
    Ok(())
}

/// The first `most` held-out rows of a cell, from its newest part on. The newest parts are the
/// largest, as they were drawn for the cell as it is and not for its ancestors.
pub(crate) fn held_out_rows(run: &Run, cell: &CellPlan, most: usize) -> Result<Columns, BakeError> {
    let (mut rows, facts) = (Columns::default(), run.facts());
    for part in cell.parts.iter().rev() {
        if rows.len() >= most {
            break;
        }
        let part = [cell.cell, part.part];
        parts::each_stretch(&run.folder, part, &facts, STRETCH, &mut |table| {
            let held_out = table.index.iter().map(|&i| is_held_out(facts.seed, i));
            for (row, _) in held_out.enumerate().filter(|&(_, held_out)| held_out) {
                let row = table.columns.row(row);
                if rows.len() < most && row.iter().all(|x| x.is_finite()) {
                    rows.push(row);
                }
            }
        })?;
    }
    Ok(rows)
}

#[cfg(test)]
mod tests;
