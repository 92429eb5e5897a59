//! Trust in a model's answers.

use rrf_field::tree::Domain;
use rrf_store::model::{CellMetrics, ModelTree};
use std::collections::BTreeSet;

/// Standard errors by which a cell's error has to be above the limit.
const CERTAIN: f64 = 2.0;

/// Cells whose relative error on rows held out is above `most`, for certain, lose their domain: no row of
/// theirs is trusted any more.
pub fn distrust(tree: &mut ModelTree, metrics: &[CellMetrics], most: f64) {
    let known = metrics
        .iter()
        .filter_map(|m| Some((m.cell_id, m.validation?)));
    let poor: BTreeSet<u32> = known
        .filter(|(_, error)| error.mean - CERTAIN * error.se > most * most)
        .map(|(cell, _)| cell)
        .collect();
    for (node, cell) in tree.leaves().collect::<Vec<_>>() {
        if poor.contains(&cell) {
            tree.domains[node] = None;
        }
    }
}

/// The box that the rows of each cell span, by cell.
pub fn spans(tree: &ModelTree) -> Vec<Option<Domain>> {
    let mut spans = vec![None; tree.tree.cells()];
    for (node, cell) in tree.leaves() {
        if let (Some(span), Some(domain)) = (spans.get_mut(cell as usize), tree.domains.get(node)) {
            *span = *domain;
        }
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_field::columns::{COUNT, Columns};
    use rrf_field::tree::Tree;
    use rrf_metrics::estimate::SquareError;

    fn metrics(cell_id: u32, mean: f64, se: f64) -> CellMetrics {
        CellMetrics {
            cell_id,
            validation: Some(SquareError { mean, se }),
            ..CellMetrics::default()
        }
    }

    #[test]
    fn cells_that_are_certainly_too_bad_are_not_trusted() {
        let mut tree = Tree::single();
        tree.split(0, 0, 0.0, 1);
        let whole = Domain {
            minimum: [-1.0; COUNT],
            maximum: [1.0; COUNT],
        };
        let mut rows = Columns::default();
        rows.push([-0.5; COUNT]);
        rows.push([0.5; COUNT]);
        let found = |first: CellMetrics, most: f64| {
            let mut model = ModelTree::new(tree.clone());
            model.domains.fill(Some(whole));
            distrust(&mut model, &[first, metrics(1, 0.01, 0.001)], most);
            model.trusted(&rows)
        };
        assert_eq!(found(metrics(0, 0.26, 0.004), 0.5), [false, true]);
        // within two standard errors of the limit
        assert_eq!(found(metrics(0, 0.26, 0.006), 0.5), [true, true]);
        assert_eq!(found(metrics(0, 0.26, 0.004), 0.05), [false, false]);
        let unknown = CellMetrics {
            validation: None,
            ..metrics(0, 9.0, 0.0)
        };
        assert_eq!(found(unknown, 0.5), [true, true]);
    }
}
