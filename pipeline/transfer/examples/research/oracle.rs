//! Raw rows against another renderer's tables: whether patches' irradiance suffices for a kind of light.

use crate::clock::cpu;
use glam::Vec3;
use rrf_lights::{DistantLight, LightSource, PointLight};
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::{
    DirectLight, FlatMirrors, PatchConfig, Patches, Receivers, RowConfig, RowPoint, SourceLight,
    finer_near_lamps, named_light, trace_rows,
};
use std::collections::BTreeMap;

/// Settings of a trial.
pub struct Plan {
    pub patches: usize,
    pub paths: u32,
    pub samples: u32,
    pub directions: u32,
    pub gloss: f32,
    /// Finer patches near lamps.
    pub finer: bool,
}

/// One row of a table: a points table as CSV, its columns `px` to `lz`, then `r g b` and their
/// standard errors, then the light and the material.
struct Known {
    at: RowPoint,
    light: (String, [u32; 3]),
    material: String,
    mean: Vec3,
    error: Vec3,
}

fn read(tracer: &Tracer, file: &str) -> Vec<Known> {
    let text = std::fs::read_to_string(file).expect("a table");
    let row = |line: &str| {
        let words: Vec<&str> = line.split(',').collect();
        let vector = |first: usize| {
            let x = |i: usize| words[first + i].parse::<f32>().expect("a number");
            Vec3::new(x(0), x(1), x(2))
        };
        Known {
            at: RowPoint {
                point: tracer.locate(vector(0), vector(3)).expect("on the surface"),
                viewer: vector(6),
            },
            light: (
                words[18].to_string(),
                vector(9).to_array().map(f32::to_bits),
            ),
            material: words[19].to_string(),
            mean: vector(12),
            error: vector(15),
        }
    };
    text.lines().skip(1).map(row).collect()
}

/// The light that a row names.
fn light_of(tracer: &Tracer, name: &str, at: Vec3, stream: Stream) -> Box<dyn DirectLight> {
    let scene = tracer.scene();
    let source: LightSource = match name {
        "point" => PointLight {
            position: at,
            intensity: Vec3::ONE,
        }
        .into(),
        "sun" => DistantLight::sun(at, Vec3::ONE).into(),
        own => {
            // a few lights a table: they may live on
            let scene: &'static Scene = Box::leak(Box::new(scene.clone()));
            return named_light(scene, own, stream).expect("a light of the scene");
        }
    };
    Box::new(SourceLight::new(Box::leak(Box::new(source)), stream))
}

/// Prints errors, noise of the table and of the rows taken out, as a whole and by material.
pub fn run(tracer: &Tracer, file: &str, plan: &Plan) {
    let known = read(tracer, file);
    let config = PatchConfig {
        count: plan.patches,
        directions: plan.directions,
        gloss: plan.gloss,
    };
    let edge = (tracer.area() / plan.patches as f64).sqrt() as f32;
    let finer = finer_near_lamps(tracer.scene(), edge);
    let size = |at: Vec3| if plan.finer { finer(at) } else { 1.0 };
    let patches = Patches::new(tracer.scene(), &config, &size).expect("patches");
    let points: Vec<RowPoint> = known.iter().map(|k| k.at).collect();
    let row_config = RowConfig {
        paths: plan.paths,
        ..RowConfig::default()
    };
    let stream = Stream::new(6, Stage::Test, 907);
    let start = cpu();
    let rows = trace_rows(tracer, &patches, &points, &row_config, stream, 0).expect("rows");
    let traced = cpu();
    let used = rows.used();
    let receivers = Receivers::new(tracer, &patches, plan.samples, Some(&used), stream.part(1));
    let mirrors = FlatMirrors::new(tracer);
    let mut by_light: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (row, of) in known.iter().enumerate() {
        by_light.entry(of.light.clone()).or_default().push(row);
    }
    let mut halves = vec![[Vec3::ZERO; 2]; known.len()];
    let lit = cpu();
    for ((name, at), of) in &by_light {
        let at = Vec3::from(at.map(f32::from_bits));
        let light = light_of(tracer, name, at, stream.part(2));
        let irradiance = receivers.irradiance(&mirrors.of(&light));
        let some: Vec<RowPoint> = of.iter().map(|&r| points[r]).collect();
        let own = mirrors.at_rows(&light, &some, 0);
        for (&row, own) in of.iter().zip(own) {
            let colour = tracer.material_at(&points[row].point).base_color;
            halves[row] = [0, 1].map(|h| rows.apply(row, h, &irradiance).coloured(colour) + own);
        }
    }
    println!(
        "{} patches, {} columns, {} rows ({:.1} CPU s), {} lights ({:.3} CPU s each)",
        patches.len(),
        patches.columns(),
        known.len(),
        traced - start,
        by_light.len(),
        (cpu() - lit) / by_light.len() as f64
    );
    let level = known
        .iter()
        .map(|k| k.mean.element_sum() / 3.0)
        .sum::<f32>()
        / known.len() as f32;
    let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (row, of) in known.iter().enumerate() {
        groups.entry("(all)").or_default().push(row);
        groups.entry(&of.material).or_default().push(row);
        if of.material != "brass" {
            groups.entry("(but brass)").or_default().push(row);
        }
    }
    worst(&known, &halves, level);
    for (name, of) in groups {
        report(name, &of, &known, &halves, level);
    }
}

/// The rows that err most.
fn worst(known: &[Known], halves: &[[Vec3; 2]], level: f32) {
    let error = |row: usize| {
        let mean = (halves[row][0] + halves[row][1]) * 0.5;
        let weight = 1.0 / (known[row].mean.element_sum() / 3.0).max(0.05 * level);
        ((mean - known[row].mean) * weight).length_squared()
    };
    let mut order: Vec<usize> = (0..known.len()).collect();
    order.sort_by(|&a, &b| error(b).total_cmp(&error(a)));
    for &row in order.iter().take(8) {
        let Known {
            mean, at, material, ..
        } = &known[row];
        println!(
            "    {material} at {:.2} n {:.1}: {:.4} {:.4} for {mean:.4}",
            at.point.position, at.point.normal, halves[row][0], halves[row][1]
        );
    }
}

fn report(name: &str, of: &[usize], known: &[Known], halves: &[[Vec3; 2]], level: f32) {
    let square = |&row: &usize| {
        let Known { mean, error, .. } = known[row];
        let weight = 1.0 / (mean.element_sum() / 3.0).max(0.05 * level).powi(2);
        let [a, b] = halves[row].map(|h| h - mean);
        f64::from((a * b - error * error).element_sum() / 3.0 * weight)
    };
    let mut squares: Vec<f64> = of.iter().map(square).collect();
    let count = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / count;
    let spread = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>();
    let error = mean.max(0.0).sqrt();
    let deviation = (spread.sqrt() / count) / (2.0 * error).max(1e-9);
    squares.sort_by(f64::total_cmp);
    let worst: f64 = squares.iter().rev().take(squares.len() / 50 + 1).sum();
    let sums = of.iter().fold((0.0, 0.0, 0.0), |sum, &row| {
        let own = 0.5 * (halves[row][0] + halves[row][1]).element_sum();
        let mean = known[row].mean.element_sum();
        (
            sum.0 + own,
            sum.1 + mean,
            sum.2 + known[row].error.length_squared(),
        )
    });
    println!(
        "  {name:14} {:5} rows: error {:6.2} % ± {:.2} %, median {:5.2} %, worst 2 % make {:3.0} %; sum {:+.2} % ± {:.2} %",
        of.len(),
        100.0 * error,
        100.0 * deviation,
        100.0 * squares[squares.len() / 2].max(0.0).sqrt(),
        100.0 * worst / (mean * count).max(1e-12),
        100.0 * (sums.0 / sums.1 - 1.0),
        100.0 * sums.2.sqrt() / sums.1,
    );
}
