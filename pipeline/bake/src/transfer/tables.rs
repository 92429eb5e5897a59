//! A transfer as tables.

use super::part_rows::part_row;
use super::summary::TransferFacts;
use rrf_store::model::{
    TransferCellRow, TransferNodeRow, TransferPartRow, TransferRow, TransferTables,
};
use rrf_transfer::{LEAF_AXIS, SurfaceCells, TransferCell, TransferModel};

/// The axis of leaves in tables.
pub(super) const LEAF: i8 = -1;
/// Names of a cell's two parts.
pub(super) const PARTS: [&str; 2] = ["base", "constant"];

/// The tables of a model.
pub(super) fn tables(model: &TransferModel, facts: &TransferFacts) -> TransferTables {
    TransferTables {
        whole: whole(model, facts),
        nodes: node_rows(&model.tree),
        cells: cell_rows(&model.cells),
        parts: part_rows(&model.cells),
    }
}

/// Parts of cells as rows.
pub(super) fn part_rows(cells: &[TransferCell]) -> Vec<TransferPartRow> {
    let parts = (0u32..).zip(cells).flat_map(|(cell, own)| {
        let parts = PARTS.iter().zip(&own.parts);
        parts.filter_map(move |(name, part)| part_row(cell, name, part))
    });
    parts.collect()
}

/// Cells as rows.
pub(super) fn cell_rows(cells: &[TransferCell]) -> Vec<TransferCellRow> {
    let cells = (0u32..).zip(cells).map(|(id, cell)| TransferCellRow {
        cell_id: id,
        error: cell.error.is_finite().then_some(cell.error),
        rows: cell.rows,
        judged: cell.judged,
        rank: cell.read.rank() as u32,
        nodes: cell.read.nodes.clone(),
        weight_scales: cell.read.weights.scales.clone(),
        weights: cell.read.weights.values.clone(),
        sketch_scales: cell.sketch.scales.clone(),
        sketch: cell.sketch.values.clone(),
    });
    cells.collect()
}

fn whole(model: &TransferModel, facts: &TransferFacts) -> TransferRow {
    let (sizes, test) = (&model.sizes, facts.test);
    TransferRow {
        receiver_points: model.receiver_points,
        numbers_seed: model.seed,
        trust: model.trust,
        lights: facts.lights,
        test_rows: test.test_rows,
        relative_error: test.relative_error,
        relative_error_se: test.relative_error_se,
        median_error: test.median_error,
        percentile_95: test.percentile_95,
        worst_share: test.worst_share,
        trusted_share: test.trusted_share,
        trusted_error: test.trusted_error,
        patch_count: model.patch_config.count as u32,
        patch_directions: model.patch_config.directions,
        patch_gloss: model.patch_config.gloss,
        size_edge: sizes.edge,
        size_cubes: sizes.levels.keys().flatten().copied().collect(),
        size_levels: sizes.levels.values().map(|&l| u32::from(l)).collect(),
        columns_in_use: runs(&model.used),
        structure: structure(model),
        sketch_rank: model.sketch.rank() as u32,
        sketch_nodes: model.sketch.nodes.clone(),
        sketch_scales: model.sketch.weights.scales.clone(),
        sketch_weights: model.sketch.weights.values.clone(),
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

/// The trees over surfaces as rows.
pub(super) fn node_rows(tree: &SurfaceCells) -> Vec<TransferNodeRow> {
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
