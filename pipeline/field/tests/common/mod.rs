//! Random rows, trees and models, each a function of its seed.

use rrf_field::columns::{self, Columns};
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::{LEAF, Tree};
use rrf_sampling::{Dimensions, Stage, Stream};

/// Numbers in [-1, 1).
pub struct Numbers(Dimensions);

impl Numbers {
    pub fn new(seed: u64) -> Numbers {
        Numbers(Stream::new(seed, Stage::Test, 0).dimensions(0))
    }

    pub fn next(&mut self) -> f32 {
        2.0 * self.0.next_f32() - 1.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.0.next_u32() as usize % n
    }

    pub fn unit(&mut self) -> [f32; 3] {
        loop {
            let v = [self.next(), self.next(), self.next()];
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            if (0.1..1.0).contains(&length) {
                return v.map(|x| x / length);
            }
        }
    }
}

/// Points and lights in the cube [-1, 1]^3, unit normals and directions, material in [0, 1].
pub fn rows(count: usize, seed: u64) -> Columns {
    let mut numbers = Numbers::new(seed);
    let mut rows = Columns::default();
    for _ in 0..count {
        let mut row = [0.0; columns::COUNT];
        let point: [f32; 3] = std::array::from_fn(|_| numbers.next());
        let light: [f32; 3] = std::array::from_fn(|_| numbers.next());
        row[..3].copy_from_slice(&point);
        row[3..6].copy_from_slice(&numbers.unit());
        row[6..9].copy_from_slice(&numbers.unit());
        row[9..12].copy_from_slice(&light);
        for x in &mut row[12..] {
            *x = 0.5 + 0.5 * numbers.next();
        }
        rows.push(row);
    }
    rows
}

/// A model with weights of variance 1/(inputs of the layer), biases too.
pub fn model(cell: u32, inputs: &[u8], hidden: &[usize], numbers: &mut Numbers) -> CellModel {
    let sizes: Vec<usize> = [inputs.len()]
        .iter()
        .chain(hidden)
        .chain(&[3])
        .copied()
        .collect();
    let shape = Shape { sizes };
    let mut weights = Vec::new();
    for pair in shape.sizes.windows(2) {
        let spread = (3.0 / pair[0].max(1) as f32).sqrt();
        weights.extend((0..(pair[0] + 1) * pair[1]).map(|_| spread * numbers.next()));
    }
    CellModel {
        cell,
        kind: Kind::Net,
        inputs: inputs.to_vec(),
        input_offset: inputs.iter().map(|_| 0.3 * numbers.next()).collect(),
        input_scale: inputs.iter().map(|_| 1.5 + numbers.next()).collect(),
        shape,
        weights,
        output_scale: [0.3, 0.5, 0.7],
        output_offset: [0.1, -0.2, 0.05],
        divide_base: numbers.below(2) == 1,
        exponential: numbers.below(2) == 1,
    }
}

/// A tree grown by splitting random leaves on random columns.
pub fn tree(cells: usize, seed: u64) -> Tree {
    let mut numbers = Numbers::new(seed);
    let mut tree = Tree::single();
    for cell in 1..cells {
        let leaves: Vec<usize> = (0..tree.axis.len())
            .filter(|&n| tree.axis[n] == LEAF)
            .collect();
        let leaf = leaves[numbers.below(leaves.len())];
        let axis = numbers.below(columns::COUNT);
        tree.split(leaf, axis, 0.7 * numbers.next(), cell as u32);
    }
    tree
}
