//! The tables that there are.

/// Names the tables; `schemas/NAME.toml` is built in.
macro_rules! tables {
    ($($(#[$about:meta])* $table:ident = $name:literal,)*) => {
        /// The tables that the pipeline reads and writes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Table {
            $($(#[$about])* $table,)*
        }

        /// Every table.
        pub const TABLES: [Table; [$($name),*].len()] = [$(Table::$table),*];

        impl Table {
            /// The schema's name, `schemas/NAME.toml`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Table::$table => $name,)*
                }
            }

            /// The schema's text.
            pub fn text(self) -> &'static str {
                match self {
                    $(Table::$table => {
                        include_str!(concat!("../../../../schemas/", $name, ".toml"))
                    })*
                }
            }
        }
    };
}

tables! {
    /// Training samples, `samples/`.
    Samples = "samples",
    /// The kd-tree, `model/tree.arrow`.
    Tree = "tree",
    /// The nets, `model/weights.arrow`.
    Weights = "weights",
    /// How the fits went, `model/metrics.arrow`.
    Metrics = "metrics",
    /// Queries.
    Points = "points",
    /// Queries with path-traced radiance.
    Truth = "truth",
    /// Queries with the model's radiance.
    Answers = "answers",
    /// Tasks of a round, `rounds/000/tasks.parquet`.
    Tasks = "tasks",
    /// Runs of a sweep.
    Results = "results",
    /// The course of a fit, `rounds/000/fits/cell=000000/steps.arrow`.
    Steps = "steps",
    /// A transfer as a whole, `model/transfer.arrow`.
    Transfer = "transfer",
    /// A transfer's trees over surfaces, `model/transfer_tree.arrow`.
    TransferTree = "transfer_tree",
    /// Its cells, `model/transfer_cells.arrow`.
    TransferCells = "transfer_cells",
    /// Their parts, `model/transfer_parts.arrow`.
    TransferParts = "transfer_parts",
    /// How far a transfer is that is not finished, `model/transfer_progress.arrow`.
    TransferProgress = "transfer_progress",
}
