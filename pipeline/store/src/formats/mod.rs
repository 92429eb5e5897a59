//! Arrow IPC and Parquet files, read without trusting them.

mod arrow_check;
pub(crate) mod arrow_file;
pub(crate) mod expanded;
mod guard;
mod parquet_check;
pub(crate) mod parquet_file;

pub use guard::Limits;
