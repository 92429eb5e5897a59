//! IES profiles (ANSI/IES LM-63): luminous intensity by direction, as lamp makers publish it.
//!
//! Read here: LM-63-1986, 1991, 1995, 2002 and 2019, `TILT=NONE` and `TILT=INCLUDE`, photometry
//! of types A, B and C. A reader of its own, because those published read type C alone or allocate
//! what a file's header claims.

mod read;
mod web;

pub use web::{IesProfile, Photometry};
