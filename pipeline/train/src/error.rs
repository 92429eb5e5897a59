//! Errors of a fit that are found before it starts.

/// A fit cannot start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// Columns, halves and validation marks differ in length.
    #[error("{what} has {found} rows, the columns have {expected}; all must be of one length")]
    Length {
        /// Which argument.
        what: &'static str,
        /// Its rows.
        found: usize,
        /// Rows of the columns.
        expected: usize,
    },
    /// An input that does not exist.
    #[error("no input is called {name:?}; known are {known}")]
    Input {
        /// The name asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// Asked of a baseline what only nets can do.
    #[error(
        "online and recursive modes, pruning and exponential outputs are of nets; \
         this run's method is {kind}"
    )]
    NoNet {
        /// The kind of model.
        kind: &'static str,
    },
    /// Irradiance does not tell what a glossy surface reflects.
    #[error("irradiance probes know Lambertian surfaces only, and some rows lie on others")]
    Glossy,
    /// It was told to give up ([`crate::Start::halt`]).
    #[error("stopped on request")]
    Halted,
    /// A number of the configuration is out of its range.
    #[error("{name} is {value}, must be {range}")]
    Config {
        /// The field.
        name: &'static str,
        /// What it was set to.
        value: String,
        /// What is allowed.
        range: &'static str,
    },
}
