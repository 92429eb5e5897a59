//! Why a field or a batch was refused.

/// A model, tree or batch whose parts do not agree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// The tree's columns do not form a binary tree.
    #[error("kd-tree: {reason}; the run's tree table is damaged, bake again")]
    Tree {
        /// The fault found.
        reason: String,
    },
    /// The leaves and the models do not match one to one.
    #[error(
        "the kd-tree has {cells} cells but there are {models} models; \
         tree and weights are of different runs, or training has not finished"
    )]
    Count {
        /// Leaves of the tree.
        cells: usize,
        /// Models given.
        models: usize,
    },
    /// A model contradicts itself.
    #[error("the model of cell {cell}: {reason}; the run's weights table is damaged, bake again")]
    Model {
        /// Its place among the models.
        cell: usize,
        /// The fault found.
        reason: String,
    },
    /// A batch whose columns differ in length.
    #[error("column {column} has {found} rows, the others {expected}")]
    Ragged {
        /// Name of the column.
        column: &'static str,
        /// Rows it should have.
        expected: usize,
        /// Rows it has.
        found: usize,
    },
    /// More rows than a 32-bit row id can name.
    #[error("{rows} rows in one batch, at most 4294967294 are possible; split the batch")]
    TooManyRows {
        /// Rows given.
        rows: usize,
    },
}
