//! A cell made ready for training: rows split, scaled, and put in a random order.

mod inputs;
mod redundant;
mod scaling;

use crate::config::{Schedule, TrainConfig};
use crate::error::TrainError;
use crate::net::problem::Loss;
use crate::net::tile::CHANNELS;
use crate::rows::chunk::Chunk;
use crate::rows::order::{Order, OrderedRows, Uses};
use crate::rows::samples::Samples;
use crate::rows::units::{Input, Units};
use crate::rows::{CellRows, Halt};
use crate::start::Start;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_metrics::relative::{channel_mean, epsilon};
use rrf_sampling::{Stage, Stream};
use scaling::Noise;

/// Rows split, scaled and ready for nets of any shape.
pub(crate) struct Cell<'a> {
    pub id: u32,
    pub config: &'a TrainConfig,
    /// Raw rows: training rows, then validation rows.
    pub raw: OrderedRows<'a>,
    /// Rows that came in.
    pub rows: usize,
    /// First weights and the order of rows.
    pub stream: Stream,
    pub units: Units,
    pub loss: Loss,
    pub noise: Noise,
    /// ε, radiance.
    pub floor: f64,
    /// Rows in random order, so that any leading part stands for the whole.
    pub train: CellRows<'a>,
    pub validation: CellRows<'a>,
    /// Rows left out because a number in them is not finite, by place in the cell.
    pub quarantined: Vec<u32>,
    /// Inputs that the model does without, as places in `rrf_field::inputs::INPUTS`.
    pub dropped_inputs: Vec<u8>,
    /// A net to go on from.
    pub earlier: Option<&'a CellModel>,
    halt: Halt<'a>,
}

/// What is known of a cell before its rows are.
pub(crate) struct Preparation<'a> {
    id: u32,
    config: &'a TrainConfig,
    start: Start<'a>,
    stream: Stream,
    inputs: Vec<u8>,
    /// Inputs that cannot matter.
    dropped: Vec<u8>,
}

impl<'a> Preparation<'a> {
    /// Checks the settings.
    pub fn new(
        id: u32,
        start: Start<'a>,
        config: &'a TrainConfig,
    ) -> Result<Preparation<'a>, TrainError> {
        config.check()?;
        if config.kind == Kind::Probes && !config.divide_base {
            return Err(TrainError::Glossy);
        }
        let (inputs, dropped) = inputs::choose(config)?;
        Ok(Preparation {
            id,
            config,
            start,
            stream: Stream::in_counter(config.seed, Stage::Train, id),
            inputs,
            dropped,
        })
    }

    /// Before the first row.
    pub fn order(&self) -> Order {
        Order::new((self.config.mode == Schedule::Local).then_some(self.stream))
    }

    /// The cell's next rows.
    pub fn add(&self, samples: &Samples, order: &mut Order) {
        order.add(samples, &self.inputs, self.config.divide_base);
    }

    /// The cell, its rows in order.
    pub fn finish(self, raw: OrderedRows<'a>, uses: Uses) -> Cell<'a> {
        let Start { earlier, halt } = self.start;
        let config = self.config;
        let divide_base = config.divide_base;
        let (train, all) = (uses.train.len(), uses.train.len() + uses.validation.len());
        let (redundant, ids) = match config.drop_redundant {
            true => inputs::redundant(self.inputs, &raw, 0..train),
            false => (Vec::new(), self.inputs),
        };
        let (inputs, unvaried) = inputs::scale(&ids, &raw, 0..train, divide_base);
        let floor = floor(&raw, all, config);
        let seen = if train == 0 { 0..all } else { 0..train };
        let units = Units {
            inputs,
            output: scaling::outputs(&raw, seen.clone(), floor, divide_base, config.exponential),
            divide_base,
        };
        let noise = scaling::noise(&raw, seen, floor);
        let loss = match config.relative {
            true => Loss::Relative {
                floor,
                noise: noise.square,
            },
            false => Loss::Absolute,
        };
        Cell {
            id: self.id,
            train: CellRows::new(&raw, 0..train, &units, halt),
            validation: CellRows::new(&raw, train..all, &units, halt),
            rows: uses.rows,
            loss,
            noise,
            stream: self.stream,
            quarantined: uses.quarantined,
            dropped_inputs: [self.dropped, redundant, unvaried].concat(),
            earlier,
            halt,
            config,
            raw,
            units,
            floor,
        }
    }
}

impl<'a> Cell<'a> {
    /// Of rows in memory.
    pub fn new(
        id: u32,
        samples: Samples<'a>,
        start: Start<'a>,
        config: &'a TrainConfig,
    ) -> Result<Cell<'a>, TrainError> {
        samples.check()?;
        let preparation = Preparation::new(id, start, config)?;
        let mut order = preparation.order();
        preparation.add(&samples, &mut order);
        let uses = order.finish();
        let raw = Box::new(Chunk::gathered(&samples, uses.in_order()));
        Ok(preparation.finish(OrderedRows::Held(raw), uses))
    }

    /// Whether its fit should give up.
    pub fn is_halted(&self) -> bool {
        self.halt.is_some_and(|halt| halt())
    }

    /// Gives the cell other inputs.
    pub fn set_inputs(&mut self, inputs: Vec<Input>) {
        self.units.inputs = inputs;
        let (train, all) = (self.train.len(), self.train.len() + self.validation.len());
        self.train = CellRows::new(&self.raw, 0..train, &self.units, self.halt);
        self.validation = CellRows::new(&self.raw, train..all, &self.units, self.halt);
    }

    /// The shape with these hidden layers.
    pub fn shape(&self, hidden: &[usize]) -> Shape {
        let mut sizes = vec![self.units.inputs.len()];
        sizes.extend(hidden);
        sizes.push(CHANNELS);
        Shape { sizes }
    }

    /// Weights as they are stored and evaluated, in the cell's units.
    pub fn model(&self, kind: Kind, shape: Shape, weights: Vec<f32>) -> CellModel {
        let Units { inputs, output, .. } = &self.units;
        CellModel {
            cell: self.id,
            kind,
            inputs: inputs.iter().map(|i| i.id).collect(),
            input_offset: inputs.iter().map(|i| i.offset).collect(),
            input_scale: inputs.iter().map(|i| i.scale).collect(),
            shape,
            weights,
            output_scale: output.scale,
            output_offset: output.offset,
            divide_base: self.config.divide_base,
            exponential: self.config.exponential,
        }
    }
}

/// ε in radiance.
fn floor(raw: &OrderedRows, rows: usize, config: &TrainConfig) -> f64 {
    let own = || {
        let mut sum = 0.0;
        raw.each(0..rows, |chunk, rows| {
            rows.for_each(|row| sum += channel_mean(chunk.mean(row)));
        });
        sum / rows.max(1) as f64
    };
    let mean = config.mean_radiance.map_or_else(own, f64::from);
    epsilon(config.epsilon, mean)
}
