//! Local fits: what the rows around a point say about it.
//!
//! A value at a point is a weighted least-squares fit over the nearest rows of the same surface,
//! linear in the tangent plane and in the normal (Cleveland 1979). It is linear in the rows, so that
//! one set of factors serves all columns of the transfer. Errors count relative to what a row
//! gets: near a contact light falls by ten over centimetres, and the dark end is what matters
//! there.

use super::neighbours::{Near, PlaceTree, PlaceVector};
use super::table::RowTable;
use crate::query::{SurfaceKey, TransferQuery};
use glam::Vec3;
use rayon::prelude::*;
use rrf_lm::Cholesky;
use std::collections::BTreeMap;

/// How local fits are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalConfig {
    /// Rows a fit.
    pub neighbours: usize,
    /// Metres that a turn of the normal by 1 is worth.
    pub turn: f32,
    /// Metres that a turn of the mirrored viewer by 1 is worth, for the parts that depend on it.
    pub view: f32,
    /// Rows below this level count no more; the mean level is 1.
    pub floor: f32,
}

impl Default for LocalConfig {
    fn default() -> LocalConfig {
        LocalConfig {
            neighbours: 32,
            turn: 0.2,
            view: 0.15,
            floor: 0.05,
        }
    }
}

/// Rows, ready to be asked for the neighbours of any point.
pub(crate) struct LocalFits<'a> {
    table: &'a RowTable,
    config: LocalConfig,
    /// Trees of each surface: places alone, and with viewers.
    trees: BTreeMap<SurfaceKey, [PlaceTree; 2]>,
    /// 1 / what each row gets, smoothed.
    pub(crate) weights: Vec<f32>,
    /// What surrounds each row.
    pub(crate) surroundings: Vec<Surroundings>,
}

/// Statistics of the rows around a row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Surroundings {
    /// Deviation of the logarithm of what they get.
    pub(crate) steepness: f32,
    /// Distance of the farthest, metres.
    pub(crate) radius: f32,
}

/// A linear combination of rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Combination {
    pub(crate) rows: Vec<u32>,
    /// Factors for the value, and for its slopes along the geometric normal's tangents.
    pub(crate) factors: [Vec<f32>; 3],
}

/// Working memory of one thread.
#[derive(Default)]
pub(crate) struct LocalScratch {
    near: Vec<Near>,
    cholesky: Cholesky,
}

/// Terms of a fit at most.
const TERMS: usize = 7;
/// Ridge on slopes, as a share of a fit's total weight.
const RIDGE: f64 = 1e-3;

impl<'a> LocalFits<'a> {
    pub(crate) fn new(
        table: &'a RowTable,
        config: LocalConfig,
        leave_out: &[bool],
        halted: &(dyn Fn() -> bool + Sync),
    ) -> LocalFits<'a> {
        let mut places: BTreeMap<SurfaceKey, Vec<u32>> = BTreeMap::new();
        for (row, query) in table.queries.iter().enumerate() {
            if !leave_out.get(row).copied().unwrap_or(false) {
                places.entry(query.surface).or_default().push(row as u32);
            }
        }
        let trees = places.into_par_iter().map(|(key, rows)| {
            let tree = |view: bool| {
                let place = |&row: &u32| (place(&table.queries[row as usize], &config, view), row);
                PlaceTree::new(&rows.iter().map(place).collect::<Vec<_>>())
            };
            (key, [tree(false), tree(true)])
        });
        let mut fits = LocalFits {
            table,
            config,
            trees: trees.collect(),
            weights: Vec::new(),
            surroundings: Vec::new(),
        };
        (fits.weights, fits.surroundings) = fits.smoothed_weights(halted).into_iter().unzip();
        fits
    }

    /// 1 / the level around each row, never below the floor, and how that changes. A row's own noise takes no part, so
    /// that a row which is too low by chance does not count for more. Rows after a halt weigh nothing.
    fn smoothed_weights(&self, halted: &(dyn Fn() -> bool + Sync)) -> Vec<(f32, Surroundings)> {
        let levels = &self.table.levels;
        let own = |row: usize| levels[row];
        let least = self.config.floor;
        let around = |scratch: &mut LocalScratch, row: usize| {
            if halted() {
                return (0.0, Surroundings::default());
            }
            let query = &self.table.queries[row];
            self.find(
                query,
                false,
                self.config.neighbours / 2,
                Some(row as u32),
                scratch,
            );
            let near = &scratch.near;
            let sum: f32 = near.iter().map(|n| own(n.1 as usize)).sum();
            let level = if near.is_empty() {
                own(row)
            } else {
                sum / near.len() as f32
            };
            let logarithms = near.iter().map(|n| own(n.1 as usize).max(least).ln());
            let (mut sum, mut squares) = (0.0f32, 0.0f32);
            for logarithm in logarithms {
                sum += logarithm;
                squares += logarithm * logarithm;
            }
            let count = near.len().max(1) as f32;
            let variance = squares / count - (sum / count).powi(2);
            let surroundings = Surroundings {
                steepness: variance.max(0.0).sqrt(),
                radius: near.last().map_or(0.0, |n| n.0.sqrt()),
            };
            (1.0 / level.max(least).max(f32::MIN_POSITIVE), surroundings)
        };
        let rows = (0..levels.len()).into_par_iter();
        rows.map_init(LocalScratch::default, around).collect()
    }

    /// Neighbours into the scratch: of the same surface, facing alike.
    fn find(
        &self,
        query: &TransferQuery,
        view: bool,
        count: usize,
        without: Option<u32>,
        scratch: &mut LocalScratch,
    ) {
        scratch.near.clear();
        let Some(trees) = self.trees.get(&query.surface) else {
            return;
        };
        let at = place(query, &self.config, view);
        let queries = &self.table.queries;
        let alike = |row: u32| {
            without != Some(row) && queries[row as usize].geometric.dot(query.geometric) > 0.5
        };
        trees[usize::from(view)].nearest(&at, count, alike, &mut scratch.near);
    }

    /// The fit at a point, without one of the rows if asked; none where no row is near.
    pub(crate) fn at(
        &self,
        query: &TransferQuery,
        view: bool,
        without: Option<u32>,
        scratch: &mut LocalScratch,
    ) -> Option<Combination> {
        self.find(query, view, self.config.neighbours, without, scratch);
        let LocalScratch { near, cholesky } = scratch;
        let last = near.last()?;
        let reach = last.0.sqrt() * 1.05 + 1e-9;
        let (x, y) = query.geometric.any_orthonormal_pair();
        let terms = if view { 7 } else { 5 };
        let rows = near.iter().map(|&(squared, row)| {
            let other = &self.table.queries[row as usize];
            let fall = (1.0 - squared / (reach * reach)).max(0.02);
            let weight = self.weights[row as usize];
            let row = polynomial(query, other, reach, [x, y]);
            (row, f64::from(fall) * f64::from(weight).powi(2))
        });
        let rows: Vec<([f64; TERMS], f64)> = rows.collect();
        let total: f64 = rows.iter().map(|r| r.1).sum();
        let mut gram = vec![0.0; terms * terms];
        for (row, weight) in &rows {
            for i in 0..terms {
                for j in i..terms {
                    gram[i * terms + j] += weight * row[i] * row[j];
                }
            }
        }
        let mut ridge = vec![RIDGE * total; terms];
        ridge[0] = 1e-9 * total;
        let enough = rows.len() >= 2 * terms && cholesky.factor(&gram, &ridge).is_ok();
        let mut factors: [Vec<f32>; 3] = Default::default();
        for (k, factors) in factors.iter_mut().enumerate() {
            let mut unit = vec![0.0; terms];
            unit[k] = 1.0;
            if enough && cholesky.solve(&mut unit).is_ok() {
                let scale = if k == 0 { 1.0 } else { 1.0 / f64::from(reach) };
                factors.extend(rows.iter().map(|(row, weight)| {
                    let sum: f64 = row.iter().zip(&unit).map(|(a, b)| a * b).sum();
                    (sum * weight * scale) as f32
                }));
            } else if k == 0 {
                factors.extend(rows.iter().map(|r| (r.1 / total) as f32));
            } else {
                factors.resize(rows.len(), 0.0);
            }
        }
        Some(Combination {
            rows: near.iter().map(|n| n.1).collect(),
            factors,
        })
    }
}

impl Combination {
    /// The combination of one part of the rows, shape [3, lights]; `which` is 0 for the value, 1
    /// and 2 for slopes.
    pub(crate) fn apply(&self, table: &RowTable, part: usize, which: usize) -> Vec<f32> {
        let mut sum = vec![0.0f32; table.stride()];
        for (&row, &factor) in self.rows.iter().zip(&self.factors[which]) {
            let values = table.part(row as usize, part);
            sum.iter_mut()
                .zip(values)
                .for_each(|(s, v)| *s += factor * v);
        }
        sum
    }
}

/// Where a query lies among others.
fn place(query: &TransferQuery, config: &LocalConfig, view: bool) -> PlaceVector {
    let (p, n) = (query.position, query.shading * config.turn);
    let r = if view {
        query.reflected() * config.view
    } else {
        Vec3::ZERO
    };
    [p.x, p.y, p.z, n.x, n.y, n.z, r.x, r.y, r.z]
}

/// 1, the way in the tangent plane, the turn of the normal, that of the mirrored viewer.
fn polynomial(
    own: &TransferQuery,
    other: &TransferQuery,
    reach: f32,
    [x, y]: [Vec3; 2],
) -> [f64; TERMS] {
    let d = (other.position - own.position) / reach;
    let n = (other.shading - own.shading) * 0.5;
    let r = (other.reflected() - own.reflected()) * 0.5;
    let way = |v: Vec3| [f64::from(v.dot(x)), f64::from(v.dot(y))];
    let ([a, b], [c, e], [f, g]) = (way(d), way(n), way(r));
    [1.0, a, b, c, e, f, g]
}
