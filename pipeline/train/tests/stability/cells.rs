//! Synthetic cells: a plane under a light, seen from anywhere.

use rrf_field::columns::{self, Columns};
use rrf_field::inputs;
use rrf_field::model::CellModel;
use rrf_field::net;
use rrf_sampling::{Stage, Stream};
use rrf_train::{CellFit, TrainConfig, fit_cell};

/// The columns that vary, all uniform in [−1, 1).
pub const INPUTS: [&str; 8] = ["px", "py", "vx", "vy", "vz", "lx", "ly", "lz"];

/// One cell's samples; every third row is kept back.
#[derive(Clone)]
pub struct Cell {
    pub columns: Columns,
    pub halves: [Vec<[f32; 3]>; 2],
    pub validation: Vec<bool>,
}

/// A row as `[px, py, vx, vy, vz, lx, ly, lz]`.
pub type Row = [f64; 8];

fn place(name: &str) -> usize {
    columns::NAMES.iter().position(|n| *n == name).unwrap()
}

impl Cell {
    /// `rows` rows of radiance `y`, each half with relative noise of standard deviation `noise`.
    pub fn new(rows: usize, noise: f64, y: impl Fn(&Row) -> [f64; 3]) -> Cell {
        let stream = Stream::new(7, Stage::Test, 0);
        let row = |i: usize| std::array::from_fn(|d| 2.0 * stream.f64(i as u64, d as u32) - 1.0);
        let rows: Vec<Row> = (0..rows).map(row).collect();
        Cell::of(&rows, noise, y)
    }

    /// The rows given.
    pub fn of(rows: &[Row], noise: f64, y: impl Fn(&Row) -> [f64; 3]) -> Cell {
        let stream = Stream::new(8, Stage::Test, 0);
        let mut columns = Columns::default();
        columns
            .columns
            .iter_mut()
            .for_each(|c| c.resize(rows.len(), 0.0));
        columns.columns[place("nz")].fill(1.0);
        let mut halves = [Vec::new(), Vec::new()];
        for (i, row) in rows.iter().enumerate() {
            for (name, x) in INPUTS.iter().zip(row) {
                columns.columns[place(name)][i] = *x as f32;
            }
            for (h, half) in halves.iter_mut().enumerate() {
                // a sum of twelve uniform numbers: variance 1
                let normal = |c: usize| {
                    let d = (h * 3 + c) as u32 * 12;
                    (0..12).map(|k| stream.f64(i as u64, d + k)).sum::<f64>() - 6.0
                };
                let value = y(row);
                half.push(std::array::from_fn(|c| {
                    (value[c] * (1.0 + noise * normal(c))) as f32
                }));
            }
        }
        Cell {
            columns,
            halves,
            validation: (0..rows.len()).map(|i| i % 3 == 2).collect(),
        }
    }

    pub fn column(&mut self, name: &str) -> &mut Vec<f32> {
        &mut self.columns.columns[place(name)]
    }

    /// Fits and checks what must always hold.
    pub fn fit(&self, config: &TrainConfig) -> CellFit {
        let [a, b] = [&self.halves[0], &self.halves[1]].map(Vec::as_slice);
        let fit = fit_cell(3, &self.columns, [a, b], &self.validation, config).unwrap();
        sound(&fit);
        fit
    }

    /// Relative RMS difference between the model and `y` over all rows, floor 0.05.
    pub fn error(&self, model: &CellModel, y: impl Fn(&Row) -> [f64; 3]) -> f64 {
        let rows = self.columns.len();
        let mut sum = 0.0;
        for i in 0..rows {
            let row = INPUTS.map(|name| f64::from(self.columns.columns[place(name)][i]));
            let (found, true_value) = (self.evaluate(model, i), y(&row));
            let divisor = (true_value.iter().sum::<f64>() / 3.0).max(0.05);
            sum += (0..3)
                .map(|c| ((found[c] - true_value[c]) / divisor).powi(2))
                .sum::<f64>();
        }
        (sum / (3 * rows) as f64).sqrt()
    }

    fn evaluate(&self, model: &CellModel, row: usize) -> [f64; 3] {
        let mut x = Vec::new();
        let mut column = Vec::new();
        for ((id, offset), scale) in
            (model.inputs.iter().zip(&model.input_offset)).zip(&model.input_scale)
        {
            inputs::fill(*id, &self.columns, &mut column);
            x.push(f64::from((column[row] - offset) * scale));
        }
        let w: Vec<f64> = model.weights.iter().map(|w| f64::from(*w)).collect();
        let out = net::evaluate(&model.shape, &w, &x);
        std::array::from_fn(|c| {
            out[c] * f64::from(model.output_scale[c]) + f64::from(model.output_offset[c])
        })
    }
}

/// Nothing stored is NaN or infinite.
fn sound(fit: &CellFit) {
    let model = &fit.model;
    let stored = [&model.weights, &model.input_offset, &model.input_scale];
    assert!(stored.into_iter().flatten().all(|x| x.is_finite()));
    assert!(
        model
            .output_scale
            .iter()
            .chain(&model.output_offset)
            .all(|x| x.is_finite())
    );
    assert_eq!(model.weights.len(), model.shape.weights());
    assert!(fit.train_error.square.is_finite() && fit.validation_error.square.is_finite());
    assert!(fit.alpha.is_finite() && fit.damping.is_finite());
    assert!(!fit.end.name().is_empty());
}

/// Raw columns only, the radiance itself (not over the base colour).
pub fn config() -> TrainConfig {
    TrainConfig {
        inputs: INPUTS.map(String::from).to_vec(),
        mean_radiance: Some(1.0),
        size: rrf_train::Size::Hidden(vec![12, 8]),
        ..TrainConfig::default()
    }
}

/// Relative error of the best constant on a cell of [`smooth`] radiance.
pub fn of_the_mean(cell: &Cell) -> f64 {
    let constant = TrainConfig {
        inputs: vec!["nz".into()],
        ..config()
    };
    cell.error(&cell.fit(&constant).model, smooth)
}

/// Names of inputs by their places.
pub fn names(ids: &[u8]) -> Vec<&'static str> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    ids.iter()
        .map(|&id| inputs::NAMES[usize::from(id)])
        .collect()
}

/// A smooth radiance without v.
pub fn smooth(x: &Row) -> [f64; 3] {
    let [px, py, _, _, _, lx, ly, _] = *x;
    let near = 0.3 + (px - lx).powi(2) + 0.5 * (py - ly).powi(2);
    [
        0.6 / near,
        0.3 / near + 0.2 * (1.0 + px),
        0.5 + 0.3 * (px * lx).sin(),
    ]
}
