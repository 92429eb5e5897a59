//! The baked field: a kd-tree whose leaves hold small neural nets, or what nets are compared with
//! ([`model::Kind`]).
//! Plain slices in, plain slices out; no files, no scene.
//!
//! A row is a query: surface point p, normal n, unit direction to the viewer v,
//! light position l, material parameters a. [`inputs`] describes these columns and what nets can
//! compute from them; a [`tree::Tree`] finds the row's cell, and [`Field::evaluate`] asks that cell's
//! net, [`Field::under`] for many lights at once.
//!
//! ```
//! use rrf_field::columns::{self, Columns};
//! use rrf_field::model::{CellModel, Kind};
//! use rrf_field::{Field, inputs, net::Shape, tree::Tree};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // one cell whose net has no hidden layer: three times 0.5 cos(n, d)
//! let model = CellModel {
//!     cell: 0,
//!     kind: Kind::Net,
//!     inputs: inputs::place("cos_light").into_iter().collect(),
//!     input_offset: vec![0.0],
//!     input_scale: vec![1.0],
//!     shape: Shape { sizes: vec![1, 3] },
//!     weights: vec![0.0, 0.5, 0.0, 0.5, 0.0, 0.5],
//!     output_scale: [1.0; 3],
//!     output_offset: [0.0; 3],
//!     divide_base: false,
//!     exponential: false,
//! };
//! let field = Field::new(Tree::single(), vec![model])?;
//!
//! // a floor at the origin, seen from above, under a light 2 m above it
//! let mut row = [0.0; columns::COUNT];
//! (row[columns::N + 1], row[columns::V + 1], row[columns::L + 1]) = (1.0, 1.0, 2.0);
//! let mut rows = Columns::default();
//! rows.push(row);
//!
//! let (mut radiance, mut cells) = (Default::default(), Vec::new());
//! field.evaluate(&rows, &mut radiance, &mut cells)?;
//! assert_eq!((radiance, cells), ([vec![0.5], vec![0.5], vec![0.5]], vec![0]));
//! # Ok(())
//! # }
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod baseline;
pub mod columns;
mod error;
mod evaluate;
pub mod inputs;
mod light;
pub mod model;
pub mod tree;

pub use baseline::{probes, quadratic};
pub use error::FieldError;
pub use evaluate::borders::{self, Borders};
pub use evaluate::{
    EXP_ERROR, EvaluationTimings, Field, LitField, MAX_EXPONENT, TANH_ERROR, Workspace,
    rational_tanh,
};
pub use light::Light;
pub use model::net;
