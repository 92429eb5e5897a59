//! Regression over rows elsewhere: local fits, and one net a cell with many linear outputs.

use crate::cell::Cell;
use crate::clock::cpu;
use crate::local::{self, Local};
use crate::net::Net;
use crate::setup::{Places, one_watt};
use crate::table::{Row, Table};
use crate::tree::Tree;
use crate::truth::Truth;
use glam::Vec3;
use ndarray::Array2;
use rayon::prelude::*;
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::{
    Basis, Ensemble, Entry, FlatMirrors, PatchConfig, Patches, Receivers, RowConfig, RowPoint,
    TransferRows, trace_rows,
};

/// What to try.
pub struct Plan {
    pub patches: usize,
    pub samples: u32,
    pub rows: usize,
    pub paths: u32,
    pub ensemble: usize,
    pub rank: usize,
    pub cell_rows: usize,
    pub hidden: usize,
    pub cell_rank: usize,
    pub ridge: f64,
    pub decay: f64,
    /// TransferRows where light falls steeply are this much more frequent.
    pub steep: f32,
    pub local: bool,
    pub nets: bool,
}

/// Everything that a plan's fits share.
struct Bench<'a> {
    plan: &'a Plan,
    truth: &'a Truth,
    table: Table,
    rows: TransferRows,
    /// Irradiance of the ensemble and of the truth's lights.
    ensemble: Ensemble,
    shone: Vec<Vec<Vec3>>,
    /// The mirrors' own part of the judged points.
    own: Vec<Vec3>,
    spent: f64,
}

pub fn run(scene: &Scene, tracer: &Tracer, places: &Places, truth: &Truth, plan: &Plan) {
    let bench = Bench::new(scene, tracer, places, truth, plan);
    if plan.local {
        bench.local();
    }
    if plan.nets {
        bench.nets();
    }
}

impl<'a> Bench<'a> {
    fn new(
        scene: &Scene,
        tracer: &Tracer,
        places: &Places,
        truth: &'a Truth,
        plan: &'a Plan,
    ) -> Bench<'a> {
        let start = cpu();
        let config = PatchConfig {
            count: plan.patches,
            ..PatchConfig::default()
        };
        let patches = Patches::new(scene, &config, &|_: Vec3| 1.0).expect("patches");
        let stream = Stream::new(6, Stage::Test, 905);
        let points = draw(tracer, &patches, places, plan, stream);
        let config = RowConfig {
            paths: plan.paths,
            ..RowConfig::default()
        };
        let rows = trace_rows(tracer, &patches, &points, &config, stream, 0).expect("rows");
        let traced = cpu();
        let receivers = Receivers::new(
            tracer,
            &patches,
            plan.samples,
            Some(&rows.used()),
            stream.part(1),
        );
        let mirrors = FlatMirrors::new(tracer);
        let shine = |&l: &Vec3| receivers.irradiance(&mirrors.of(one_watt(l)));
        let trained: Vec<_> = places.lights(plan.ensemble, 77).iter().map(shine).collect();
        let ensemble = Ensemble::new(&trained);
        let spent = cpu() - start;
        println!(
            "{} patches, {} rows of {} paths ({:.1} CPU s, {:.0} entries a row), {} lights ({:.1} CPU s)",
            patches.len(),
            rows.len(),
            plan.paths,
            traced - start,
            rows.columns.len() as f64 / rows.len() as f64,
            plan.ensemble,
            spent - (traced - start)
        );
        let mut table = Table {
            rows: points.iter().map(|p| Row::new(scene, tracer, p)).collect(),
            judged: truth
                .points
                .iter()
                .map(|p| Row::new(scene, tracer, p))
                .collect(),
        };
        weigh(&mut table, &rows, &ensemble);
        let by_light: Vec<Vec<Vec3>> = (truth.lights.iter())
            .map(|&l| mirrors.at_rows(&one_watt(l), &truth.points, 0))
            .collect();
        let own = (0..truth.points.len()).flat_map(|p| by_light.iter().map(move |of| of[p]));
        Bench {
            plan,
            truth,
            table,
            ensemble,
            shone: truth.lights.iter().map(shine).collect(),
            own: own.collect(),
            rows,
            spent,
        }
    }

    fn report(&self, name: &str, predicted: &[Vec3], spent: f64) {
        let with: Vec<Vec3> = predicted
            .iter()
            .zip(&self.own)
            .map(|(p, o)| *p + *o)
            .collect();
        let squares = self.truth.squares(&with, &with);
        println!(
            "{name}: {} ({:.1} CPU s in all)",
            self.truth.summary(&squares),
            spent
        );
        if std::env::var_os("WORST").is_some() {
            self.worst(&with, &squares);
        }
    }

    /// The points that make most of the error.
    fn worst(&self, predicted: &[Vec3], squares: &[f32]) {
        let lights = self.truth.lights.len();
        let sum = |v: &[f32]| v.iter().sum::<f32>();
        let mut order: Vec<usize> = (0..self.table.judged.len()).collect();
        order.sort_by(|&a, &b| {
            let of = |p: usize| sum(&squares[p * lights..(p + 1) * lights]);
            of(b).total_cmp(&of(a))
        });
        for &p in order.iter().take(12) {
            let row = &self.table.judged[p];
            let mean =
                |v: &[Vec3]| v[p * lights..(p + 1) * lights].iter().sum::<Vec3>() / lights as f32;
            println!(
                "   share {:.2} at {:.2} n {:.1} object {} metal {} rough {:.2} colour {:.2}: {:.4} for {:.4}",
                sum(&squares[p * lights..(p + 1) * lights]) / sum(squares),
                row.position,
                row.normal,
                row.object,
                row.metal,
                row.roughness,
                row.colour,
                mean(predicted),
                mean(&self.truth.halves[0]),
            );
        }
    }

    fn local(&self) {
        let values: Vec<Vec<Entry>> = (0..self.rows.len())
            .map(|r| {
                let both = self.shone.iter().map(|e| {
                    let (a, b) = (self.rows.apply(r, 0, e), self.rows.apply(r, 1, e));
                    Entry {
                        base: (a.base + b.base) * 0.5,
                        constant: (a.constant + b.constant) * 0.5,
                    }
                });
                both.collect()
            })
            .collect();
        for (neighbours, order, relative) in [
            (1, 0, false),
            (4, 0, false),
            (12, 1, false),
            (24, 1, false),
            (24, 1, true),
            (48, 2, false),
            (48, 2, true),
        ] {
            let local = Local {
                neighbours,
                order,
                relative,
            };
            let start = cpu();
            let predicted = local::predict(&self.table, self.truth, &values, &local);
            let name = format!(
                "local, {neighbours} rows, order {order}{}",
                if relative { ", relative" } else { "" }
            );
            self.report(&name, &predicted, self.spent + cpu() - start);
        }
    }

    fn nets(&self) {
        let plan = self.plan;
        let start = cpu();
        let stream = Stream::new(8, Stage::Test, 906);
        let colours: Vec<Vec3> = self.table.rows.iter().map(|r| r.colour).collect();
        let some = self.rows.some(3_000);
        let few: Vec<Vec3> = some.1.iter().map(|&r| colours[r]).collect();
        let basis =
            Basis::new(&some.0, &few, &self.ensemble, plan.rank, 0.05, stream).expect("basis");
        let based = cpu();
        let projected: Vec<[Vec<Entry>; 2]> = (0..self.rows.len())
            .into_par_iter()
            .map(|r| [0, 1].map(|h| basis.project(&self.rows, r, h)))
            .collect();
        let seen = cpu();
        let lights = self.light_coefficients(&basis);
        let features: Vec<Vec<f32>> = (self.table.rows.iter().zip(&projected))
            .map(|(row, halves)| features(row, halves))
            .collect();
        let tree = Tree::new(&self.table.rows, &features, plan.cell_rows);
        let cut = cpu();
        let cells: Vec<Cell> = (tree.cells.par_iter().enumerate())
            .map(|(id, of)| {
                let weighted = &lights;
                Cell::new(
                    plan,
                    &self.table.rows,
                    &projected,
                    of,
                    weighted,
                    stream.part(id as u32 + 1),
                )
            })
            .collect();
        let fitted = cpu();
        let count = cells.len() as f64;
        let directions = cells.iter().map(|c| c.basis.rank as f64).sum::<f64>() / count;
        let weights: usize = cells
            .iter()
            .map(|c| c.nets.iter().map(Net::weights).sum::<usize>())
            .sum();
        println!(
            "basis of {} in {:.1} s, projections {:.1} s, {} cells of {:.1} directions in {:.1} s, {} weights in nets; left out by directions {:.2} %",
            basis.rank,
            based - start,
            seen - based,
            cells.len(),
            directions,
            fitted - cut,
            weights,
            100.0 * (cells.iter().map(|c| c.basis.error.powi(2)).sum::<f64>() / count).sqrt()
        );
        let shone: Vec<Vec<Vec3>> = self
            .shone
            .iter()
            .map(|e| basis.coefficients(e).expect("columns"))
            .collect();
        let predicted: Vec<Vec3> = (self.table.judged.iter())
            .flat_map(|row| cells[tree.find(row)].predict(row, &shone))
            .collect();
        self.report("nets", &predicted, self.spent + fitted - start);
    }

    /// Coefficients of the ensemble, lights weighted by what they send.
    fn light_coefficients(&self, basis: &Basis) -> Array2<f64> {
        let lights = self.ensemble.lights;
        let mut all = Array2::zeros((basis.rank, lights));
        for l in 0..lights {
            let e: Vec<Vec3> = (0..basis.columns)
                .map(|c| Vec3::splat(self.ensemble.irradiance[c * lights + l]))
                .collect();
            let c = basis.coefficients(&e).expect("columns");
            c.iter()
                .enumerate()
                .for_each(|(k, c)| all[[k, l]] = f64::from(c.x));
        }
        all
    }
}

/// Points of rows; with a `steep` plan, more of them where first rays are short.
fn draw(
    tracer: &Tracer,
    patches: &Patches,
    places: &Places,
    plan: &Plan,
    stream: Stream,
) -> Vec<RowPoint> {
    if plan.steep <= 1.0 {
        return places.points(plan.rows, 2);
    }
    let many = places.points((plan.rows as f32 * plan.steep) as usize, 2);
    let config = RowConfig {
        paths: 16,
        keep: 0.01,
    };
    let looked = trace_rows(tracer, patches, &many, &config, stream.part(3), 0).expect("rows");
    // one more row where distances are short, as often as the mean of 1 / distance says
    let near: Vec<f32> = looked.distance.iter().map(|d| 1.0 / d.max(0.02)).collect();
    let mean = near.iter().sum::<f32>() / near.len() as f32;
    let chance = |i: usize| (0.3 + 0.7 * (near[i] / mean).powi(2)).min(plan.steep);
    let total: f32 = (0..many.len()).map(chance).sum();
    let by = plan.rows as f32 / total;
    (0..many.len())
        .filter(|&i| stream.part(4).units(i as u64, 0, 0)[0] < by * chance(i))
        .map(|i| many[i])
        .collect()
}

/// Weights of rows from what the ensemble sends them.
fn weigh(table: &mut Table, rows: &TransferRows, ensemble: &Ensemble) {
    let columns = rows.width;
    let mean: Vec<Vec3> = (0..columns)
        .map(|c| {
            let of = &ensemble.irradiance[c * ensemble.lights..(c + 1) * ensemble.lights];
            Vec3::splat(of.iter().sum::<f32>() / ensemble.lights as f32)
        })
        .collect();
    let levels: Vec<f32> = (0..rows.len())
        .map(|r| {
            let colour = table.rows[r].colour;
            let half = |h| rows.apply(r, h, &mean).coloured(colour).element_sum() / 3.0;
            0.5 * (half(0) + half(1))
        })
        .collect();
    let least = 0.05 * levels.iter().sum::<f32>() / levels.len() as f32;
    for (row, level) in table.rows.iter_mut().zip(&levels) {
        row.weight = 1.0 / level.max(least);
    }
}

/// How much a row gets and of what kind, both relative.
fn features(row: &Row, halves: &[Vec<Entry>; 2]) -> Vec<f32> {
    let mut f = vec![1.5 * -row.weight.ln()];
    for (one, other) in halves[0].iter().zip(&halves[1]).take(6) {
        let both = one.coloured(row.colour) + other.coloured(row.colour);
        f.push(0.5 * both.element_sum() / 3.0 * row.weight);
    }
    f
}
