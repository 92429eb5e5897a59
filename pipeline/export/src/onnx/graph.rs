//! A graph under construction: operators return the names of their results.

use super::format::{
    Attribute, Dimension, FLOAT, Graph, INT64, Node, Shape, Tensor, TensorType, Type, ValueInfo,
};

/// A value in the graph.
#[derive(Clone, Copy)]
pub(super) enum Value {
    /// What the graph is given.
    Input,
    /// Result of a node, by its place.
    Result(usize),
    /// A constant, by its place.
    Constant(usize),
}

impl Value {
    fn name(self) -> String {
        match self {
            Value::Input => INPUT.into(),
            Value::Result(node) => format!("v{node}"),
            Value::Constant(place) => format!("c{place}"),
        }
    }
}

/// Name of the graph's input.
pub(super) const INPUT: &str = "raw";

#[derive(Default)]
pub(super) struct Builder {
    nodes: Vec<Node>,
    constants: Vec<Tensor>,
}

impl Builder {
    /// Result of an operator with one output.
    pub(super) fn op(&mut self, op: &str, inputs: &[Value]) -> Value {
        self.op_with(op, inputs, Vec::new())
    }

    /// Result of an operator with an integer attribute.
    pub(super) fn op_int(&mut self, op: &str, inputs: &[Value], name: &str, i: i64) -> Value {
        let attribute = Attribute {
            name: name.into(),
            i,
            t: None,
            kind: 2,
        };
        self.op_with(op, inputs, vec![attribute])
    }

    /// A tensor of zeros whose shape is another's value.
    pub(super) fn zeros(&mut self, shape: Value, data_type: i32) -> Value {
        let size = if data_type == INT64 { 8 } else { 4 };
        let attribute = Attribute {
            name: "value".into(),
            i: 0,
            t: Some(Tensor {
                dims: vec![1],
                data_type,
                name: String::new(),
                raw_data: vec![0; size],
            }),
            kind: 4,
        };
        self.op_with("ConstantOfShape", &[shape], vec![attribute])
    }

    fn op_with(&mut self, op: &str, inputs: &[Value], attribute: Vec<Attribute>) -> Value {
        let output = Value::Result(self.nodes.len());
        self.nodes.push(Node {
            input: inputs.iter().map(|v| v.name()).collect(),
            output: vec![output.name()],
            op_type: op.into(),
            attribute,
        });
        output
    }

    /// Gives a value the name of an output.
    pub(super) fn name(&mut self, value: Value, name: &str) {
        self.nodes.push(Node {
            input: vec![value.name()],
            output: vec![name.into()],
            op_type: "Identity".into(),
            attribute: Vec::new(),
        });
    }

    pub(super) fn floats(&mut self, shape: &[usize], values: &[f32]) -> Value {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.constant(shape, FLOAT, bytes)
    }

    pub(super) fn ints(&mut self, shape: &[usize], values: &[i64]) -> Value {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.constant(shape, INT64, bytes)
    }

    fn constant(&mut self, shape: &[usize], data_type: i32, raw_data: Vec<u8>) -> Value {
        let constant = Value::Constant(self.constants.len());
        self.constants.push(Tensor {
            dims: shape.iter().map(|&n| n as i64).collect(),
            data_type,
            name: constant.name(),
            raw_data,
        });
        constant
    }

    pub(super) fn finish(self, input: ValueInfo, output: Vec<ValueInfo>) -> Graph {
        Graph {
            node: self.nodes,
            name: "radiance regression functions".into(),
            initializer: self.constants,
            input: vec![input],
            output,
        }
    }
}

/// A tensor of `rows` by the fixed sizes.
pub(super) fn value_info(name: &str, elem_type: i32, sizes: &[usize]) -> ValueInfo {
    let rows = Dimension {
        value: None,
        param: Some("rows".into()),
    };
    let fixed = sizes.iter().map(|&n| Dimension {
        value: Some(n as i64),
        param: None,
    });
    let dim = std::iter::once(rows).chain(fixed).collect();
    ValueInfo {
        name: name.into(),
        kind: Some(Type {
            tensor: Some(TensorType {
                elem_type,
                shape: Some(Shape { dim }),
            }),
        }),
    }
}
