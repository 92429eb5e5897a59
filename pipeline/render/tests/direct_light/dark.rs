//! A model without light.

use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_field::{Field, columns};

/// Nets of zeros: only direct light is looked at.
pub fn field() -> Field {
    let shape = Shape {
        sizes: vec![1, 1, 3],
    };
    let model = CellModel {
        cell: 0,
        kind: Kind::Net,
        inputs: vec![columns::P as u8],
        input_offset: vec![0.0],
        input_scale: vec![1.0],
        weights: vec![0.0; shape.weights()],
        shape,
        output_scale: [1.0; 3],
        output_offset: [0.0; 3],
        divide_base: false,
        exponential: false,
    };
    Field::new(Tree::single(), vec![model]).unwrap()
}
