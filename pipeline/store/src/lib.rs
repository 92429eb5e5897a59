//! Files of a run and tables of points: what is in them, how they are written, and how they are
//! read without being trusted.
//!
//! A sample's journey through this crate:
//!
//! - [`schema`] builds `schemas/*.toml` into the program: the one place where a column has its
//!   name, type, unit, frame and meaning;
//! - [`manifest`] says in `RUN/run.json` which scene and seed a run belongs to; every table
//!   repeats these facts, and readers refuse a table of another run;
//! - [`samples::SampleTable`] holds a cell's samples in memory, [`parts`] writes them as
//!   `RUN/samples/cell=000042/part-00000.parquet` and reads them back, whole or batch by batch
//!   ([`part_reader`]); [`layout`] knows the names;
//! - [`model`] writes and reads `RUN/model/{tree,weights,metrics}.arrow`;
//! - [`points`] reads tables of queries and writes them again with answers appended;
//! - [`atomic`] makes every file appear whole or not at all, and [`lock`] keeps a second process
//!   from working on a run.
//!
//! Files may be damaged or hostile. [`Limits`] say how much one may ask for, claims are checked
//! before the decoders of arrow and parquet believe them, a panic of theirs becomes an error, and
//! a content hash finds bits that flipped inside values. [`error::StoreError`] carries the place,
//! what was expected and found, and what to do.
//!
//! ```
//! use rrf_store::{manifest::RunFacts, parts, samples::SampleTable};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let run = tempfile::tempdir()?;
//! let facts = RunFacts { scene_hash: "0".repeat(64), seed: 1 };
//! let table = SampleTable { cell_id: 42, ..SampleTable::default() };
//! parts::write_part(run.path(), 0, &table, &facts)?;
//! assert_eq!(parts::read_cell(run.path(), 42, &facts)?.table, table);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod atomic;
mod content;
pub mod error;
mod facts;
mod formats;
pub mod layout;
pub mod lock;
pub mod manifest;
pub mod model;
pub mod ours;
pub mod points;
pub mod samples;
pub mod schema;
pub mod table;
pub mod task_table;

pub use error::StoreError;
pub use formats::Limits;
pub use samples::{part_reader, parts};
