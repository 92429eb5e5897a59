//! Random numbers as a function of indices, and the sequences and samplers made of them.
//!
//! A [`Stream`] is named by (seed, [`Stage`], cell), and four words of it by (index, path, block).
//! They depend on nothing else, so any part of a run can be made again alone, in any order, on
//! any number of threads. [`sobol`] has the evenly spread points, [`warp`] the generic samplers,
//! each beside its density, and [`hash`] the one integer hash.
//!
//! ```
//! use rrf_sampling::{Stage, Stream, sobol};
//!
//! let stream = Stream::new(7, Stage::Frame, 0);
//! // four independent numbers in [0, 1) for the first bounce of path 5 of pixel 3
//! let units = stream.units(3, 5, 0);
//! assert_eq!(units, Stream::new(7, Stage::Frame, 0).units(3, 5, 0));
//! assert!(units.iter().all(|u| (0.0..1.0).contains(u)));
//!
//! // the same pixel's Sobol points: each half of the unit interval holds every other one
//! let scrambles = sobol::scrambles(stream, 3, 0);
//! let x = |k| sobol::scramble(sobol::reversed(k, 0), scrambles[0]);
//! assert_ne!(x(0) < 0.5, x(1) < 0.5);
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod hash;
mod philox;
mod roulette;
pub mod sobol;
mod stage;
mod stream;
pub mod warp;

pub use philox::{philox4x32, unit};
pub use roulette::roulette_tail;
pub use stage::Stage;
pub use stream::{Dimensions, Stream};
