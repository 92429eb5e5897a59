//! Formulas of inputs as nodes of a graph.

use super::graph::{Builder, Value};
use rrf_field::inputs::Number;
use std::cell::RefCell;
use std::ops::{Add, Mul, Sub};

/// A value whose arithmetic adds nodes to its graph.
#[derive(Clone, Copy)]
pub(super) struct Expression<'g> {
    pub graph: &'g RefCell<Builder>,
    pub value: Value,
}

impl<'g> Expression<'g> {
    fn with(self, value: impl FnOnce(&mut Builder) -> Value) -> Expression<'g> {
        let value = value(&mut self.graph.borrow_mut());
        Expression { value, ..self }
    }
}

impl<'g> Add for Expression<'g> {
    type Output = Expression<'g>;

    fn add(self, other: Expression<'g>) -> Expression<'g> {
        self.with(|g| g.op("Add", &[self.value, other.value]))
    }
}

impl<'g> Sub for Expression<'g> {
    type Output = Expression<'g>;

    fn sub(self, other: Expression<'g>) -> Expression<'g> {
        self.with(|g| g.op("Sub", &[self.value, other.value]))
    }
}

impl<'g> Mul for Expression<'g> {
    type Output = Expression<'g>;

    fn mul(self, other: Expression<'g>) -> Expression<'g> {
        self.with(|g| g.op("Mul", &[self.value, other.value]))
    }
}

impl<'g> Mul<f32> for Expression<'g> {
    type Output = Expression<'g>;

    fn mul(self, factor: f32) -> Expression<'g> {
        self.with(|g| {
            let factor = g.floats(&[1], &[factor]);
            g.op("Mul", &[self.value, factor])
        })
    }
}

impl Number for Expression<'_> {
    fn sqrt(self) -> Self {
        self.with(|g| g.op("Sqrt", &[self.value]))
    }

    fn reciprocal(self) -> Self {
        self.with(|g| {
            let (zero, one) = (g.floats(&[1], &[0.0]), g.floats(&[1], &[1.0]));
            let above = g.op("Greater", &[self.value, zero]);
            let inverse = g.op("Div", &[one, self.value]);
            g.op("Where", &[above, inverse, zero])
        })
    }
}
