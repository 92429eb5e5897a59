//! Raw rows against another renderer's tables: whether patches' irradiance suffices for a kind of light.

use crate::clock::cpu;
use crate::setup::Places;
use glam::Vec3;
use rrf_lights::{DistantLight, LightSource, PointLight};
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::{
    ConditionPlan, DirectLight, FlatMirrors, LightConditions, PatchConfig, Patches, Receivers,
    RowConfig, RowPoint, SourceLight, TransferConfig, TransferModel, TransferQuery, bake_transfer,
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

/// A model for the scene's own lights, points, suns and skies.
pub fn bake(tracer: &Tracer, places: &Places, config: &TransferConfig) -> TransferModel {
    let scene = tracer.scene();
    let bounds = scene.bounds().expect("a surface");
    let plan = ConditionPlan::within([Vec3::from(bounds.min), Vec3::from(bounds.max)]);
    let stream = Stream::new(1, Stage::Transfer, 2);
    let free = |place: Vec3| places.is_free(place);
    let conditions = LightConditions::new(tracer, &free, &plan, stream);
    let mirrors = FlatMirrors::new(tracer);
    let own = scene.own_light_names();
    let own = own
        .iter()
        .filter_map(|name| named_light(scene, name, stream));
    let drawn = conditions.lights(stream).into_iter();
    let drawn = drawn.map(|group| Box::new(group) as Box<dyn DirectLight>);
    let lights: Vec<_> = drawn.chain(own).map(|light| mirrors.of(light)).collect();
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let draw = |_: u64, count: usize| -> Vec<RowPoint> { places.candidates(count, 2) };
    let start = cpu();
    let model = bake_transfer(tracer, &draw, &lights, config, &|| false).expect("a model");
    println!(
        "{} lights, {} cells, {:.2} MB: {:.1} CPU s",
        lights.len(),
        model.cells.len(),
        1e-6 * model.bytes() as f64,
        cpu() - start
    );
    model
}

/// Prints errors, noise of the table and of the rows taken out, as a whole and by material; those of
/// a model, where there is one, whose patches are taken then.
pub fn run(tracer: &Tracer, file: &str, plan: &Plan, model: Option<&TransferModel>) {
    println!("{file}");
    let known = read(tracer, file);
    let config = PatchConfig {
        count: plan.patches,
        directions: plan.directions,
        gloss: plan.gloss,
    };
    let edge = (tracer.area() / plan.patches as f64).sqrt() as f32;
    let finer = finer_near_lamps(tracer.scene(), edge);
    let size = |at: Vec3| if plan.finer { finer(at) } else { 1.0 };
    let patches = match model {
        Some(model) => model.patches.clone(),
        None => Patches::new(tracer.scene(), &config, &size).expect("patches"),
    };
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
    let mut answers = halves.clone();
    let (mut trusted, mut within, mut residual) = (0usize, 0usize, 0.0f32);
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
        let Some(model) = model else { continue };
        let irradiance = model.receivers(tracer).irradiance(&mirrors.of(&light));
        residual += model.residual(&irradiance).expect("columns") / by_light.len() as f32;
        let under = model.coefficients(&irradiance).expect("columns");
        let some: Vec<RowPoint> = of.iter().map(|&r| points[r]).collect();
        let queries: Vec<TransferQuery> = (some.iter())
            .map(|p| TransferQuery::of_row(tracer, p))
            .collect();
        let own = mirrors.at_rows(&light, &some, 0);
        let found = model.evaluate(&under, &queries);
        for ((&row, own), found) in of.iter().zip(own).zip(found) {
            answers[row] = [found.radiance.max(Vec3::ZERO) + own; 2];
            if found.trusted {
                let Known { mean, error, .. } = known[row];
                let off = (answers[row][0] - mean).length_squared() - error.length_squared();
                let level = mean.element_sum() / 3.0;
                let allowed = 3.0 * model.cells[found.cell as usize].error * level;
                trusted += 1;
                within += usize::from(off / 3.0 <= allowed * allowed);
            }
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
    if model.is_some() {
        println!(
            " the model: {:.0} % trusted, {:.1} % of them within three stated errors; residual {:.1} %",
            100.0 * trusted as f64 / known.len() as f64,
            100.0 * within as f64 / trusted.max(1) as f64,
            100.0 * residual,
        );
        for name in ["(all)", "(but brass)"] {
            report(name, &groups[name], &known, &answers, level);
        }
        println!(" rows");
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
