//! From rows to what cells answer.

mod local;
mod neighbours;
mod projection;
mod table;

pub use local::LocalConfig;
pub(crate) use local::{Combination, LocalFits, LocalScratch, Surroundings};
pub use projection::NetConfig;
pub(crate) use projection::{Samples, fit_net};
pub use table::RowTable;
