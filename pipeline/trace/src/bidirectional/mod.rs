//! Paths from both ends: bidirectional path tracing (Lafortune and Willems 1993; Veach and Guibas
//! 1994), weighted by the balance heuristic (Veach and Guibas 1995).
//!
//! A path from the query's point and up to three vertices of a light subpath are joined in every
//! way. Light by way of chrome, brass and lamps beside a wall is found from the lights' end, all else
//! from the point's. A flat mirror's vertex may be drawn from the mirror image of the light too
//! ([`crate::mirrors`]): light that a mirror shows the query's own point is found in no other way.
//!
//! Notation: x_0 is the query's point, x_j the vertices from there; z_0 is the point on a light or
//! the direction to one from afar, z_k the vertices from there. Sums of the densities of all other
//! ways to make a path, relative to the way that made it, are carried along either subpath (as in
//! Georgiev, Křivánek, Davidovič and Slusallek, *Light Transport Simulation with Vertex Connection and
//! Merging*, 2012).

mod beams;
mod connect;
mod emit;
mod eye;
mod light;
mod run;
mod subpath;
mod travel;

use crate::wave::{Part, Row};
use emit::Lights;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rrf_sampling::sobol::Table;
use run::Joined;

/// Paths that travel together.
const BATCH: usize = 256;

/// Mean of `each` paths at every row, two reflections or more. A row's bits depend on the row and on how many
/// of its replicates come together, not on other rows.
pub(crate) fn estimate(part: &Part, rows: &[Row], each: usize) -> Vec<Vec3> {
    let table = Table::new(each);
    let queries: Vec<&[Row]> = rows.chunk_by(|a, b| a.index == b.index).collect();
    let values: Vec<Vec<Vec3>> = queries
        .into_par_iter()
        .map_init(
            || Joined::new(part.tracer),
            |joined, rows| query(joined, part, rows, (each, &table)),
        )
        .collect();
    values.concat()
}

/// All replicates of a query.
fn query(
    joined: &mut Joined,
    part: &Part,
    rows: &[Row],
    (each, table): (usize, &Table),
) -> Vec<Vec3> {
    let openings = part.openings(rows, each, &mut joined.stack);
    let mean = |row: &Row| {
        let lights = Lights::new(part, row, openings.as_ref());
        let mut sum = DVec3::ZERO;
        for first in (0..each).step_by(BATCH) {
            if part.tracer.is_halted() {
                break;
            }
            let numbers = first..each.min(first + BATCH);
            sum += joined.run((part, &lights), row, numbers, (each, table));
        }
        (sum / each as f64).as_vec3()
    };
    rows.iter().map(mean).collect()
}
