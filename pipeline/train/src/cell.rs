//! A cell made ready for training: rows split, scaled, and put in a random order.

use crate::chunk::Chunk;
use crate::config::{Mode, TrainConfig};
use crate::error::TrainError;
use crate::fit::FitReport;
use crate::end::FitEnd;
use crate::ordered::{Order, Ordered, Uses};
use crate::prepare::{self, Noise, Samples};
use crate::problem::Loss;
use crate::rows::{CellRows, TakenColumn, Units};
use crate::warm;
use rrf_field::columns::Columns;
use rrf_field::model::{self, CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::rng::{Stage, Stream};

/// Rows split, scaled and ready for nets of any shape.
pub(crate) struct Cell<'a> {
    pub config: &'a TrainConfig,
    /// Raw rows: training rows, then validation rows.
    pub raw: Ordered<'a>,
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
    pub report: FitReport,
    /// A net to go on from.
    pub earlier: Option<&'a CellModel>,
}

/// What is known of a cell before its rows are.
pub(crate) struct Prospect<'a> {
    config: &'a TrainConfig,
    stream: Stream,
    ids: Vec<u8>,
    /// Inputs that cannot matter.
    dropped: Vec<u8>,
}

impl<'a> Prospect<'a> {
    pub fn new(cell: u32, config: &'a TrainConfig) -> Result<Prospect<'a>, TrainError> {
        config.check()?;
        if config.kind == Kind::Probes && !config.divide_base {
            return Err(TrainError::Glossy);
        }
        let (ids, dropped) = prepare::choose_inputs(config)?;
        Ok(Prospect {
            config,
            stream: Stream::new(config.seed, Stage::Train, cell),
            ids,
            dropped,
        })
    }

    /// Before the first row.
    pub fn order(&self) -> Order {
        Order::new((self.config.mode == Mode::Local).then_some(self.stream))
    }

    /// The cell's next rows.
    pub fn add(&self, samples: &Samples, order: &mut Order) {
        order.add(samples, &self.ids, self.config.divide_base);
    }

    /// The cell, its rows in order.
    pub fn cell(self, raw: Ordered<'a>, uses: Uses) -> Cell<'a> {
        let config = self.config;
        let divide_base = config.divide_base;
        let (train, all) = (uses.train.len(), uses.train.len() + uses.validation.len());
        let (told, ids) = match config.told_by_place {
            true => prepare::told_by_place(self.ids, &raw, 0..train),
            false => (Vec::new(), self.ids),
        };
        let (inputs, unvaried) = prepare::scale_inputs(&ids, &raw, 0..train, divide_base);
        let floor = floor(&raw, all, config);
        let judged = if train == 0 { 0..all } else { 0..train };
        let output =
            prepare::scale_outputs(&raw, judged.clone(), floor, divide_base, config.exponential);
        let units = Units {
            inputs,
            output,
            divide_base,
        };
        let noise = prepare::noise(&raw, judged, floor);
        let loss = if config.relative {
            Loss::Relative {
                floor,
                noise: noise.square,
            }
        } else {
            Loss::Absolute
        };
        Cell {
            train: CellRows::new(&raw, 0..train, &units),
            validation: CellRows::new(&raw, train..all, &units),
            rows: uses.rows,
            loss,
            noise,
            stream: self.stream,
            report: FitReport {
                quarantined: uses.quarantined,
                dropped_inputs: [self.dropped, told, unvaried].concat(),
                ..FitReport::default()
            },
            earlier: None,
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
        cell: u32,
        samples: Samples<'a>,
        config: &'a TrainConfig,
    ) -> Result<Cell<'a>, TrainError> {
        samples.check()?;
        let prospect = Prospect::new(cell, config)?;
        let mut order = prospect.order();
        prospect.add(&samples, &mut order);
        let uses = order.finish();
        let raw = Ordered::Held(Box::new(Chunk::gathered(&samples, uses.in_order())));
        Ok(prospect.cell(raw, uses))
    }

    /// The same with the net that its fit goes on from, if there is one.
    pub fn going_on(self, earlier: Option<&'a CellModel>) -> Cell<'a> {
        Cell { earlier, ..self }
    }

    /// Why no net is needed, if so.
    pub fn trivial(&self) -> Option<FitEnd> {
        if self.train.len() == 0 {
            Some(FitEnd::NoRows)
        } else if self.units.output.constant || self.units.inputs.is_empty() {
            Some(FitEnd::Constant)
        } else {
            None
        }
    }

    /// Leaves a cell that only a constant can be fitted to.
    pub fn without_inputs(self) -> Cell<'a> {
        self.with_inputs(Vec::new())
    }

    /// The same with other inputs.
    pub fn with_inputs(mut self, inputs: Vec<prepare::Input>) -> Cell<'a> {
        self.units.inputs = inputs;
        let (train, all) = (self.train.len(), self.train.len() + self.validation.len());
        self.train = CellRows::new(&self.raw, 0..train, &self.units);
        self.validation = CellRows::new(&self.raw, train..all, &self.units);
        self
    }

    /// Takes an input out of all rows.
    pub fn take_input(&mut self, place: usize) -> TakenInput {
        TakenInput {
            input: self.units.inputs.remove(place),
            columns: [&mut self.train, &mut self.validation].map(|rows| rows.take_input(place)),
        }
    }

    /// Puts it back.
    pub fn put_input(&mut self, place: usize, taken: TakenInput) {
        self.units.inputs.insert(place, taken.input);
        let rows = [&mut self.train, &mut self.validation];
        for (rows, column) in rows.into_iter().zip(taken.columns) {
            rows.put_input(place, column);
        }
    }

    /// The shape with these hidden layers.
    pub fn shape(&self, hidden: &[usize]) -> Shape {
        let mut sizes = vec![self.units.inputs.len()];
        sizes.extend(hidden);
        sizes.push(crate::tile::CHANNELS);
        Shape { sizes }
    }

    /// First weights of a net of `shape` that goes on from the earlier one, if there is one
    /// that it can go on from.
    pub fn earlier_weights(&self, shape: &Shape) -> Option<Vec<f64>> {
        if self.train.len() == 0 {
            return None;
        }
        let mut one = Columns::default();
        let row = |chunk: &Chunk, at: usize| chunk.columns.row(at);
        one.push(self.raw.show(0, 1, row));
        let value = |id: u8| {
            let mut values = Vec::new();
            model::fill(id, &one, &mut values);
            values.first().copied().unwrap_or(f32::NAN)
        };
        let frame = warm::Frame {
            inputs: (self.units.inputs.iter())
                .map(|i| (i.id, i.offset, i.scale))
                .collect(),
            scale: self.units.output.scale,
            offset: self.units.output.offset,
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
    input: prepare::Input,
    columns: [TakenColumn; 2],
}

impl TakenInput {
    /// Place in `rrf_field::model::INPUTS`.
    pub fn id(&self) -> u8 {
        self.input.id
    }
}

/// ε in radiance.
fn floor(raw: &Ordered, rows: usize, config: &TrainConfig) -> f64 {
    let own = || {
        let mut sum = 0.0;
        raw.each(0..rows, |chunk, rows| {
            rows.for_each(|row| sum += prepare::luminance(chunk.mean(row)));
        });
        sum / rows.max(1) as f64
    };
    let mean = config.mean_luminance.map_or_else(own, f64::from);
    // Black cells: any positive number, the errors are then absolute.
    if mean > 0.0 {
        config.epsilon * mean
    } else {
        1.0
    }
}
