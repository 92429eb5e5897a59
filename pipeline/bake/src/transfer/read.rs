//! A transfer out of its tables.

use super::part_rows::{finite, length, packed, part};
use super::summary::{TransferFacts, TransferTest};
use super::tables::{LEAF, PARTS, of_runs, structure};
use crate::error::BakeError;
use rrf_scene::Scene;
use rrf_store::StoreError;
use rrf_store::model::{
    TransferCellRow, TransferNodeRow, TransferPartRow, TransferRow, TransferTables, transfer_fault,
};
use rrf_store::schema::Table;
use rrf_transfer::{
    CellNode, LEAF_AXIS, LightRead, PatchConfig, PatchSizes, SurfaceCells, SurfaceKey,
    TransferCell, TransferModel,
};
use std::path::Path;

/// Coordinates that cells are cut by.
const AXES: i8 = 6;
/// Quarterings of a patch at most.
const MOST_LEVELS: u32 = 6;
/// Patches asked for at most.
const MOST_PATCHES: u32 = 1 << 22;

/// The model of the tables of a run in its scene, without own lights; `broad` as in
/// [`TransferModel`].
///
/// # Errors
/// [`StoreError::Model`] for tables that form none, or none of this scene.
pub(super) fn model(
    run: &Path,
    scene: &Scene,
    tables: TransferTables,
    broad: bool,
) -> Result<TransferModel, BakeError> {
    let fault =
        |table, place: String| move |reason: String| transfer_fault(run, table, place, reason);
    let whole = fault(Table::Transfer, "table".into());
    let mut model = frame(scene, &tables.whole, broad).map_err(whole)?;
    let count = tables.cells.len();
    let columns = model.columns.len();
    model.cells = cells(tables.cells, columns, tables.whole.sketch_rank)
        .map_err(|(id, reason)| fault(Table::TransferCells, format!("row {id}"))(reason))?;
    model.tree = tree(tables.nodes, count)
        .map_err(|(node, reason)| fault(Table::TransferTree, format!("row {node}"))(reason))?;
    for (row, own) in tables.parts.into_iter().enumerate() {
        place(&mut model.cells, own).map_err(fault(Table::TransferParts, format!("row {row}")))?;
    }
    Ok(model)
}

/// The facts of a transfer's table that are no part of the model.
pub(super) fn facts(row: &TransferRow) -> TransferFacts {
    TransferFacts {
        lights: row.lights,
        test: TransferTest {
            test_rows: row.test_rows,
            relative_error: row.relative_error,
            relative_error_se: row.relative_error_se,
            median_error: row.median_error,
            percentile_95: row.percentile_95,
            worst_share: row.worst_share,
            trusted_share: row.trusted_share,
            trusted_error: row.trusted_error,
        },
    }
}

/// All but tree and cells.
fn frame(scene: &Scene, row: &TransferRow, broad: bool) -> Result<TransferModel, String> {
    if row.size_levels.iter().any(|&level| level > MOST_LEVELS) {
        return Err(format!("size_levels are above {MOST_LEVELS}"));
    }
    let levels = row.size_levels.iter().map(|&level| level as u8);
    length("size_cubes", &row.size_cubes, 3 * row.size_levels.len())?;
    finite(&[
        ("sketch_scales", &row.sketch_scales),
        ("size_edge", &vec![row.size_edge]),
        ("patch_gloss", &vec![row.patch_gloss]),
    ])?;
    if row.patch_count > MOST_PATCHES || row.receiver_points == 0 {
        return Err("its patches or their points are too many or none".into());
    }
    let cubes = row.size_cubes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]);
    let sizes = PatchSizes {
        edge: row.size_edge,
        levels: cubes.zip(levels).collect(),
    };
    let config = PatchConfig {
        count: row.patch_count as usize,
        directions: row.patch_directions,
        gloss: row.patch_gloss,
    };
    let model = TransferModel::over(scene, config, sizes, broad);
    let model = model.map_err(|error| error.to_string())?;
    if structure(&model) != row.structure {
        return Err(
            "this program cuts the scene into other patches than the one that baked".into(),
        );
    }
    let columns: u64 = row.columns_in_use.iter().map(|&n| u64::from(n)).sum();
    if columns != model.patches.columns() as u64 {
        let expected = model.patches.columns();
        return Err(format!(
            "columns_in_use tells of {columns} columns, not {expected}"
        ));
    }
    let used = of_runs(&row.columns_in_use);
    let numbers = (row.sketch_scales.clone(), row.sketch_weights.clone());
    let columns = model.columns.len();
    let sketch = read(row.sketch_nodes.clone(), row.sketch_rank, numbers, columns)?;
    Ok(TransferModel {
        receiver_points: row.receiver_points,
        seed: row.numbers_seed,
        trust: row.trust,
        used,
        sketch,
        ..model
    })
}

/// A read of a column tree with `last` nodes.
fn read(
    nodes: Vec<u32>,
    rank: u32,
    numbers: (Vec<f32>, Vec<i8>),
    last: usize,
) -> Result<LightRead, String> {
    if let Some(node) = nodes.iter().find(|&&node| node as usize >= last) {
        return Err(format!("node {node}; the column tree has {last}"));
    }
    let weights = packed("weights", numbers, (nodes.len(), rank as usize))?;
    Ok(LightRead { nodes, weights })
}

/// Cells that read a column tree of so many nodes; the error is a row and what is wrong.
pub(super) fn cells(
    rows: Vec<TransferCellRow>,
    columns: usize,
    sketches: u32,
) -> Result<Vec<TransferCell>, (u32, String)> {
    let rows = (0u32..).zip(rows);
    rows.map(|(id, row)| cell(row, id, columns, sketches).map_err(|reason| (id, reason)))
        .collect()
}

fn cell(
    row: TransferCellRow,
    id: u32,
    columns: usize,
    sketches: u32,
) -> Result<TransferCell, String> {
    if row.cell_id != id {
        return Err(format!("its cell_id is {}", row.cell_id));
    }
    finite(&[
        ("weight_scales", &row.weight_scales),
        ("sketch_scales", &row.sketch_scales),
        ("error", &row.error.into_iter().collect()),
    ])?;
    let sketch = (row.sketch_scales, row.sketch);
    Ok(TransferCell {
        read: read(
            row.nodes,
            row.rank,
            (row.weight_scales, row.weights),
            columns,
        )?,
        parts: Default::default(),
        error: row.error.unwrap_or(f32::INFINITY),
        rows: row.rows,
        judged: row.judged,
        sketch: packed("sketch", sketch, (sketches as usize, row.rank as usize))?,
    })
}

/// Gives a cell its part.
pub(super) fn place(own: &mut [TransferCell], row: TransferPartRow) -> Result<(), String> {
    let name = PARTS.iter().position(|name| *name == row.part);
    let name = name.ok_or_else(|| format!("part {:?} is not known", row.part))?;
    let cells = own.len();
    let id = row.cell_id;
    let cell = own.get_mut(id as usize);
    let cell = cell.ok_or_else(|| format!("cell {id}; there are {cells}"))?;
    cell.parts[name] = part(row, cell.read.rank())?;
    Ok(())
}

/// The trees, each of which ends at cells that there are; the error is a node and what is wrong.
pub(super) fn tree(
    rows: Vec<TransferNodeRow>,
    cells: usize,
) -> Result<SurfaceCells, (usize, String)> {
    let mut tree = SurfaceCells::default();
    let count = rows.len();
    for (id, row) in rows.into_iter().enumerate() {
        let fail = |reason: &str| (id, reason.to_string());
        if row.node_id as usize != id {
            return Err((id, format!("its node_id is {}", row.node_id)));
        }
        match (row.object, row.material, row.back) {
            (Some(object), Some(material), Some(back)) => {
                let key = SurfaceKey {
                    object,
                    material,
                    back,
                };
                if tree.roots.last().is_some_and(|last| last.0 >= key) {
                    return Err(fail("its surface comes after a later one"));
                }
                tree.roots.push((key, id as u32));
            }
            (None, None, None) => {}
            _ => return Err(fail("half of a surface's name")),
        }
        let after = |node: u32| (node as usize) > id && (node as usize) < count;
        tree.nodes.push(
            match (row.axis, row.threshold, row.below, row.above, row.cell_id) {
                (LEAF, None, None, None, Some(cell)) if (cell as usize) < cells => CellNode {
                    axis: LEAF_AXIS,
                    at: 0.0,
                    below: cell,
                    above: 0,
                },
                (axis, Some(at), Some(below), Some(above), None)
                    if (0..AXES).contains(&axis)
                        && after(below)
                        && after(above)
                        && !at.is_nan() =>
                {
                    CellNode {
                        axis: axis as u8,
                        at,
                        below,
                        above,
                    }
                }
                _ => {
                    return Err(fail(
                        "neither a branch with later children nor a leaf with a cell",
                    ));
                }
            },
        );
    }
    Ok(tree)
}

/// Whether an error is of a table and not of the scene.
pub(super) fn is_damage(error: &BakeError) -> bool {
    matches!(error, BakeError::Store(error) if StoreError::is_damage(error))
}
