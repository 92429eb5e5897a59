//! A cell made ready for training: rows split, scaled, and put in a random order.

use crate::config::{Mode, TrainConfig};
use crate::error::TrainError;
use crate::fit::FitReport;
use crate::lm::Stop;
use crate::prepare::{self, Input, Noise, OutputScale, Samples};
use crate::problem::Loss;
use crate::rows::MemoryRows;
use crate::warm;
use rrf_field::columns::Columns;
use rrf_field::model::{self, CellModel};
use rrf_field::net::Shape;
use rrf_field::rng::{Stage, Stream};

/// Rows split, scaled and ready for nets of any shape.
pub(crate) struct Cell<'a> {
    pub samples: Samples<'a>,
    pub config: &'a TrainConfig,
    /// First weights and the order of rows.
    pub stream: Stream,
    pub inputs: Vec<Input>,
    pub output: OutputScale,
    pub loss: Loss,
    pub noise: Noise,
    /// ε, radiance.
    pub floor: f64,
    /// Rows in random order, so that any leading part stands for the whole.
    pub train_ids: Vec<u32>,
    pub validation_ids: Vec<u32>,
    pub train: MemoryRows,
    pub validation: MemoryRows,
    pub report: FitReport,
    /// A net to go on from.
    pub earlier: Option<&'a CellModel>,
}

impl<'a> Cell<'a> {
    pub fn new(
        cell: u32,
        samples: Samples<'a>,
        config: &'a TrainConfig,
    ) -> Result<Cell<'a>, TrainError> {
        samples.check()?;
        config.check()?;
        let divide = config.divide_base;
        let stream = Stream::new(config.seed, Stage::Train, cell);
        let (ids, mut dropped_inputs) = prepare::choose_inputs(config)?;
        let mut inputs = prepare::compute_inputs(&ids, samples.rows);
        let quarantined = prepare::quarantine(&samples, &inputs, divide);
        let shuffle = (config.mode == Mode::Local).then_some(&stream);
        let (train_ids, validation_ids) = split(&samples, &quarantined, shuffle);
        dropped_inputs.extend(prepare::scale_inputs(&mut inputs, &train_ids));
        let floor = floor(&samples, &train_ids, &validation_ids, config);
        let ids = if train_ids.is_empty() {
            &validation_ids
        } else {
            &train_ids
        };
        let output = prepare::scale_outputs(&samples, ids, floor, divide, config.exponential);
        let memory = |ids: &[u32]| MemoryRows::new(&samples, ids, &inputs, &output, divide);
        let noise = prepare::noise(&samples, ids, floor);
        let loss = if config.relative {
            Loss::Relative {
                floor,
                noise: noise.square,
            }
        } else {
            Loss::Absolute
        };
        Ok(Cell {
            train: memory(&train_ids),
            validation: memory(&validation_ids),
            loss,
            noise,
            stream,
            report: FitReport {
                quarantined,
                dropped_inputs,
                ..FitReport::default()
            },
            earlier: None,
            samples,
            config,
            inputs,
            output,
            floor,
            train_ids,
            validation_ids,
        })
    }

    /// Why no net is needed, if so.
    pub fn trivial(&self) -> Option<Stop> {
        if self.train_ids.is_empty() {
            Some(Stop::NoRows)
        } else if self.output.constant || self.inputs.is_empty() {
            Some(Stop::Constant)
        } else {
            None
        }
    }

    /// Leaves a cell that only a constant can be fitted to.
    pub fn without_inputs(mut self) -> Cell<'a> {
        self.inputs.clear();
        let divide = self.config.divide_base;
        let memory = |ids: &[u32]| MemoryRows::new(&self.samples, ids, &[], &self.output, divide);
        (self.train, self.validation) = (memory(&self.train_ids), memory(&self.validation_ids));
        self
    }

    /// Takes an input out of all rows.
    pub fn take_input(&mut self, place: usize) -> TakenInput {
        TakenInput {
            input: self.inputs.remove(place),
            columns: [&mut self.train, &mut self.validation].map(|rows| rows.x.remove(place)),
        }
    }

    /// Puts it back.
    pub fn put_input(&mut self, place: usize, taken: TakenInput) {
        self.inputs.insert(place, taken.input);
        for (rows, column) in [&mut self.train, &mut self.validation]
            .into_iter()
            .zip(taken.columns)
        {
            rows.x.insert(place, column);
        }
    }

    /// The shape with these hidden layers.
    pub fn shape(&self, hidden: &[usize]) -> Shape {
        let mut sizes = vec![self.inputs.len()];
        sizes.extend(hidden);
        sizes.push(crate::tile::CHANNELS);
        Shape { sizes }
    }

    /// First weights of a net of `shape` that goes on from the earlier one, if there is one
    /// that it can go on from.
    pub fn earlier_weights(&self, shape: &Shape) -> Option<Vec<f64>> {
        let row = *self.train_ids.first()? as usize;
        let value = |id: u8| {
            let mut one = Columns::default();
            one.push(self.samples.rows.row(row));
            let mut values = Vec::new();
            model::fill(id, &one, &mut values);
            values.first().copied().unwrap_or(f32::NAN)
        };
        let frame = warm::Frame {
            inputs: self
                .inputs
                .iter()
                .map(|i| (i.id, i.offset, i.scale))
                .collect(),
            scale: self.output.scale,
            offset: self.output.offset,
            divide_base: self.config.divide_base,
            exponential: self.config.exponential,
            value: &value,
        };
        warm::weights(self.earlier?, &frame, shape, &self.first_weights(shape, 0))
    }

    /// First weights: uniform with variance 1 / inputs (LeCun et al. 1998), biases uniform in
    /// ±1 so that the units' thresholds spread over the standardised inputs.
    pub fn first_weights(&self, shape: &Shape, start: u64) -> Vec<f64> {
        let mut w = Vec::with_capacity(shape.weights());
        for layer in shape.sizes.windows(2) {
            let range = (3.0 / layer[0].max(1) as f64).sqrt();
            for _ in 0..layer[1] {
                for input in 0..=layer[0] {
                    let u = 2.0 * self.stream.f64(start, w.len() as u32) - 1.0;
                    w.push(if input == 0 { u } else { range * u });
                }
            }
        }
        w
    }
}

/// An input taken out of a cell.
pub(crate) struct TakenInput {
    input: Input,
    columns: [Vec<f32>; 2],
}

impl TakenInput {
    /// Place in `rrf_field::model::INPUTS`.
    pub fn id(&self) -> u8 {
        self.input.id
    }
}

/// Index of the stream that rows are ordered by; starts of nets count from 0.
const ORDER: u64 = 1 << 63;

/// Training and validation rows, each as they come in or, with a stream, in an order that is
/// random but depends on nothing except (seed, cell, row).
fn split(samples: &Samples, quarantined: &[u32], shuffle: Option<&Stream>) -> (Vec<u32>, Vec<u32>) {
    let key = |row: u32| shuffle.map_or(0, |s| s.block(ORDER | u64::from(row), 0)[0]);
    let mut usable = vec![true; samples.rows.len()];
    for &row in quarantined {
        usable[row as usize] = false;
    }
    let mut order: Vec<(u32, u32)> = (0..samples.rows.len() as u32)
        .filter(|&row| usable[row as usize])
        .map(|row| (key(row), row))
        .collect();
    order.sort_unstable();
    let rows = order.into_iter().map(|(_, row)| row);
    rows.partition(|&row| !samples.validation[row as usize])
}

/// ε in radiance.
fn floor(samples: &Samples, train: &[u32], validation: &[u32], config: &TrainConfig) -> f64 {
    let rows = || train.iter().chain(validation);
    let own = || {
        let sum: f64 = rows()
            .map(|&r| prepare::luminance(samples.mean(r as usize)))
            .sum();
        sum / rows().count().max(1) as f64
    };
    let mean = config.mean_luminance.map_or_else(own, f64::from);
    // Black cells: any positive number, the errors are then absolute.
    if mean > 0.0 {
        config.epsilon * mean
    } else {
        1.0
    }
}
