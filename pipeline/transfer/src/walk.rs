//! Paths without a light, and what they deposit.

use crate::entry::{Entry, HalfRow};
use crate::patches::Patches;
use crate::row_config::RowConfig;
use crate::tracing::{
    self, DIMENSIONS, Hits, Rays, Scramble, Stream, SurfacePoint, Table, Tracer, scramble,
};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// Bounces whose directions come from the Sobol sequence, three dimensions each.
const STRATIFIED: u32 = 2;
/// Blocks from here on belong to a half, those below to a path's bounces.
const HALF_BLOCKS: u32 = 1 << 31;

/// One half of a row, still to be traced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    pub(crate) point: SurfacePoint,
    pub(crate) viewer: Vec3,
    pub(crate) index: u64,
    pub(crate) half: u32,
}

/// One live path.
#[derive(Clone, Copy)]
struct Path {
    /// Which start it belongs to, and its number there.
    start: u32,
    number: u32,
    point: SurfacePoint,
    /// Unit direction to where the path came from.
    viewer: Vec3,
    /// Product of f cos / pdf after the first step.
    rest: Vec3,
    /// The first step's weight for a base colour of 0, and what a base colour of 1 adds.
    constant: f32,
    base: f32,
    /// Largest channel of the whole throughput now and after the first step.
    throughput: f32,
    first: f32,
}

/// A thread's paths and their deposits.
pub(crate) struct Walker<'a> {
    tracer: &'a Tracer<'a>,
    patches: &'a Patches,
    stream: Stream,
    config: RowConfig,
    /// Paths a half.
    each: usize,
    table: Table,
    paths: Vec<Path>,
    next: Vec<Path>,
    rays: Rays,
    hits: Hits,
    /// Start, column and entry.
    deposits: Vec<(u32, u32, Entry)>,
    /// Sum of a start's columns, and which of them are not zero.
    sums: Vec<Entry>,
    touched: Vec<u32>,
}

impl<'a> Walker<'a> {
    pub(crate) fn new(
        tracer: &'a Tracer<'a>,
        patches: &'a Patches,
        stream: Stream,
        config: &RowConfig,
        each: usize,
    ) -> Walker<'a> {
        Walker {
            tracer,
            patches,
            stream,
            config: *config,
            each,
            table: Table::new(each),
            paths: Vec::new(),
            next: Vec::new(),
            rays: Rays::default(),
            hits: Hits::default(),
            deposits: Vec::new(),
            sums: vec![Entry::default(); patches.columns()],
            touched: Vec::new(),
        }
    }

    /// Traces all paths of a few halves; some or none of them where the tracer is halted.
    pub(crate) fn rows(&mut self, starts: &[Start]) -> Vec<HalfRow> {
        self.deposits.clear();
        if self.tracer.is_halted() {
            return Vec::new();
        }
        let scrambles: Vec<_> = starts.iter().map(|s| self.scrambles(s)).collect();
        let nearness = self.first_step(starts, &scrambles);
        for bounce in 1.. {
            self.travel();
            if self.paths.is_empty() || self.tracer.is_halted() {
                break;
            }
            self.step(starts, &scrambles, bounce);
        }
        // stable: a column's deposits stay in their order
        self.deposits.sort_by_key(|deposit| deposit.0);
        (0..starts.len())
            .map(|start| HalfRow {
                nearness: nearness[start],
                ..self.collect(start as u32)
            })
            .collect()
    }

    /// Sends all paths off from their rows' points; gives the mean of 1 / distance of a start.
    fn first_step(&mut self, starts: &[Start], scrambles: &[[Scramble; DIMENSIONS]]) -> Vec<f32> {
        self.rays.clear();
        self.next.clear();
        for (id, start) in starts.iter().enumerate() {
            let facing = start.point.normal.dot(start.viewer);
            let side = if facing < 0.0 {
                -start.point.normal
            } else {
                start.point.normal
            };
            let (n, bsdf) = self.tracer.shading_at(&start.point, start.viewer);
            let Some(bsdf) = (match self.config.broad {
                true => bsdf.broad(),
                false => Some(bsdf),
            }) else {
                continue;
            };
            for number in 0..self.each as u32 {
                let u = self.numbers(start, &scrambles[id], number, 0);
                let step = tracing::first_step(&bsdf, n, start.viewer, [u[0], u[1], u[2]]);
                let Some(step) = step.filter(|s| side.dot(s.direction) > 0.0) else {
                    continue;
                };
                let throughput = step.weight.max_element();
                self.send(start.point, step.direction);
                self.next.push(Path {
                    start: id as u32,
                    number,
                    point: start.point,
                    viewer: -step.direction,
                    rest: Vec3::ONE,
                    constant: step.constant,
                    base: step.base,
                    throughput,
                    first: throughput.max(f32::MIN_POSITIVE),
                });
            }
        }
        self.tracer.closest(&self.rays, &mut self.hits);
        let mut nearness = vec![0.0; starts.len()];
        for ((path, &t), &triangle) in self.next.iter().zip(&self.hits.t).zip(&self.hits.triangle) {
            if triangle != rrf_scene::INVALID {
                nearness[path.start as usize] +=
                    1.0 / (t.max(f32::MIN_POSITIVE) * self.each as f32);
            }
        }
        nearness
    }

    /// Moves the paths to what their rays met; those that leave the scene end.
    fn travel(&mut self) {
        self.paths.clear();
        for (i, path) in self.next.iter().enumerate() {
            let triangle = self.hits.triangle[i];
            if triangle != rrf_scene::INVALID {
                self.paths.push(Path {
                    point: self.tracer.point(triangle, self.hits.barycentrics[i]),
                    ..*path
                });
            }
        }
    }

    /// Deposits at every path's vertex and sends on those that go on.
    fn step(&mut self, starts: &[Start], scrambles: &[[Scramble; DIMENSIONS]], bounce: u32) {
        self.rays.clear();
        self.next.clear();
        for i in 0..self.paths.len() {
            let path = self.paths[i];
            let start = &starts[path.start as usize];
            let back = path.point.normal.dot(path.viewer) < 0.0;
            let side = if back {
                -path.point.normal
            } else {
                path.point.normal
            };
            let Some(patch) = self.patches.patch(&path.point) else {
                continue;
            };
            let (n, bsdf) = self.tracer.shading_at(&path.point, path.viewer);
            let u = self.numbers(start, &scrambles[path.start as usize], path.number, bounce);
            let lambert = tracing::is_lambert(&bsdf);
            if lambert {
                let column = self.patches.column(patch, back, n, n);
                self.deposit(&path, column, bsdf.base_color * FRAC_1_PI);
            }
            let step = tracing::step(&bsdf, n, path.viewer, [u[0], u[1], u[2]]);
            let Some((direction, weight)) = step.filter(|(l, _)| side.dot(*l) > 0.0) else {
                continue;
            };
            if !lambert {
                // light is taken as even over each of the directions that the patch tells apart
                let column = self.patches.column(patch, back, n, direction);
                let directions = self.patches.directions(patch).pow(2) as f32;
                self.deposit(&path, column, weight * (directions / PI));
            }
            let throughput = path.throughput * weight.max_element();
            let keep = self.config.keep * rrf_sampling::roulette_tail(bounce);
            let survival = (keep * throughput / path.first).min(1.0);
            if u[3] >= survival || throughput < f32::MIN_POSITIVE {
                continue;
            }
            self.send(path.point, direction);
            self.next.push(Path {
                viewer: -direction,
                rest: path.rest * weight / survival,
                throughput: throughput / survival,
                ..path
            });
        }
        self.tracer.closest(&self.rays, &mut self.hits);
    }

    fn send(&mut self, from: SurfacePoint, direction: Vec3) {
        let origin = self.tracer.lift(from.triangle, from.position, direction);
        self.rays.push(origin, direction, f32::INFINITY);
    }

    #[inline]
    fn deposit(&mut self, path: &Path, column: u32, reflectance: Vec3) {
        let value = path.rest * reflectance;
        let entry = Entry {
            base: value * path.base,
            constant: value * path.constant,
        };
        self.deposits.push((path.start, column, entry));
    }

    /// The mean over a start's paths, by column; each column's sum in the order of the deposits.
    fn collect(&mut self, start: u32) -> HalfRow {
        let first = self.deposits.partition_point(|d| d.0 < start);
        let own = self.deposits[first..].iter().take_while(|d| d.0 == start);
        for &(_, column, entry) in own {
            let sum = &mut self.sums[column as usize];
            if *sum == Entry::default() {
                self.touched.push(column);
            }
            sum.base += entry.base;
            sum.constant += entry.constant;
        }
        self.touched.sort_unstable();
        self.touched.dedup();
        let mut row = HalfRow::default();
        let share = 1.0 / self.each as f32;
        for &column in &self.touched {
            let sum = std::mem::take(&mut self.sums[column as usize]);
            row.columns.push(column);
            row.entries.push(Entry {
                base: sum.base * share,
                constant: sum.constant * share,
            });
        }
        self.touched.clear();
        row
    }

    /// Four numbers of a path's bounce, the first three stratified over a half's paths at first.
    fn numbers(
        &self,
        start: &Start,
        by: &[Scramble; DIMENSIONS],
        number: u32,
        bounce: u32,
    ) -> [f32; 4] {
        let path = start.half * self.each as u32 + number;
        let mut u = self.stream.units(start.index, path, bounce);
        if bounce < STRATIFIED {
            let point = self.table.reversed(number as usize);
            for (d, u) in u.iter_mut().take(3).enumerate() {
                let d = 3 * bounce as usize + d;
                *u = scramble(point[d], by[d]);
            }
        }
        u
    }

    /// The scrambles of one half: the other's are independent of them.
    fn scrambles(&self, start: &Start) -> [Scramble; DIMENSIONS] {
        let mut all = [[0; 2]; DIMENSIONS];
        for (block, pair) in all.chunks_mut(2).enumerate() {
            let words = (self.stream).block(start.index, start.half, HALF_BLOCKS + block as u32);
            for (scramble, word) in pair.iter_mut().zip(words.chunks(2)) {
                scramble.copy_from_slice(word);
            }
        }
        all
    }
}
