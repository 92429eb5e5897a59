//! A transfer as tables.

use super::part_rows::part_row;
use rrf_store::model::{TransferCellRow, TransferNodeRow, TransferRow, TransferTables};
use rrf_transfer::{LEAF_AXIS, SurfaceCells, TransferModel};

/// The axis of leaves in tables.
pub(super) const LEAF: i8 = -1;
/// Names of a cell's two parts.
pub(super) const PARTS: [&str; 2] = ["base", "constant"];

/// The tables of a model that was fitted to so many lights.
pub(super) fn tables(model: &TransferModel, lights: u32) -> TransferTables {
    let parts = (0u32..).zip(&model.cells).flat_map(|(cell, own)| {
        let parts = PARTS.iter().zip(&own.parts);
        parts.filter_map(move |(name, part)| part_row(cell, name, part))
    });
    let cells = (0u32..)
        .zip(&model.cells)
        .map(|(id, cell)| TransferCellRow {
            cell_id: id,
            error: cell.error.is_finite().then_some(cell.error),
            rows: cell.rows,
            judged: cell.judged,
            rank: cell.read.rank as u32,
            nodes: cell.read.nodes.clone(),
            weights: cell.read.weights.clone(),
            sketch: cell.sketch.clone(),
        });
    TransferTables {
        whole: whole(model, lights),
        nodes: nodes(&model.tree),
        cells: cells.collect(),
        parts: parts.collect(),
    }
}

fn whole(model: &TransferModel, lights: u32) -> TransferRow {
    let sizes = &model.sizes;
    TransferRow {
        receiver_points: model.receiver_points,
        numbers_seed: model.seed,
        trust: model.trust,
        lights,
        patch_count: model.patch_config.count as u32,
        patch_directions: model.patch_config.directions,
        patch_gloss: model.patch_config.gloss,
        size_edge: sizes.edge,
        size_cubes: sizes.levels.keys().flatten().copied().collect(),
        size_levels: sizes.levels.values().map(|&l| u32::from(l)).collect(),
        columns_in_use: runs(&model.used),
        structure: structure(model),
        sketch_rank: model.sketch.rank as u32,
        sketch_nodes: model.sketch.nodes.clone(),
        sketch_weights: model.sketch.weights.clone(),
    }
}

/// A hash of the numbers that cells name nodes and columns by.
pub(super) fn structure(model: &TransferModel) -> String {
    let mut hasher = blake3::Hasher::new();
    model.structure(&mut |word| {
        hasher.update(&word.to_le_bytes());
    });
    hasher.finalize().to_hex().to_string()
}

/// Lengths of runs of equal values, the first of `false`.
fn runs(values: &[bool]) -> Vec<u32> {
    let (mut lengths, mut current) = (vec![0], false);
    for &value in values {
        if value != current {
            lengths.push(0);
            current = value;
        }
        if let Some(last) = lengths.last_mut() {
            *last += 1;
        }
    }
    lengths
}

/// Undoes [`runs`].
pub(super) fn of_runs(lengths: &[u32]) -> Vec<bool> {
    let values = [false, true].into_iter().cycle().zip(lengths);
    values
        .flat_map(|(value, &length)| std::iter::repeat_n(value, length as usize))
        .collect()
}

fn nodes(tree: &SurfaceCells) -> Vec<TransferNodeRow> {
    let node = |(id, node): (u32, &rrf_transfer::CellNode)| {
        let leaf = node.axis == LEAF_AXIS;
        TransferNodeRow {
            node_id: id,
            axis: if leaf { LEAF } else { node.axis as i8 },
            threshold: (!leaf).then_some(node.at),
            below: (!leaf).then_some(node.below),
            above: (!leaf).then_some(node.above),
            cell_id: leaf.then_some(node.below),
            ..TransferNodeRow::default()
        }
    };
    let mut rows: Vec<TransferNodeRow> = (0u32..).zip(&tree.nodes).map(node).collect();
    for &(key, root) in &tree.roots {
        if let Some(row) = rows.get_mut(root as usize) {
            row.object = Some(key.object);
            row.material = Some(key.material);
            row.back = Some(key.back);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_come_back() {
        for text in ["", "0", "1", "0011101", "110"] {
            let values: Vec<bool> = text.bytes().map(|b| b == b'1').collect();
            let lengths = runs(&values);
            assert_eq!(of_runs(&lengths), values, "{text}");
            assert!(lengths.iter().skip(1).all(|&length| length > 0));
        }
    }
}
