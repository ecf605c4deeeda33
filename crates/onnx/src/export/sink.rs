//! Nodes and stored tensors of an ONNX graph under construction.

use std::collections::HashSet;

use bytes::Bytes;

use crate::proto::{Attribute, Node, Tensor, dtype, kind};

/// The nodes and tensors that are written so far. Values and stored tensors share one space of names.
#[derive(Default)]
pub struct Sink {
    pub nodes: Vec<Node>,
    pub initializers: Vec<Tensor>,
    taken: HashSet<String>,
}

impl Sink {
    /// Takes a name, and returns whether it was free.
    pub fn take(&mut self, name: &str) -> bool {
        self.taken.insert(name.into())
    }

    /// Takes a name that nothing else has: `base`, or with a number.
    pub fn fresh(&mut self, base: &str) -> String {
        let mut name = base.to_string();
        for count in 2.. {
            if self.take(&name) {
                break;
            }
            name = format!("{base}_{count}");
        }
        name
    }

    /// Stores values under a name that is taken already.
    pub fn store(&mut self, name: &str, shape: &[usize], data: &[f32]) {
        self.initializers.push(Tensor {
            dims: sizes(shape),
            dtype: Some(dtype::FLOAT),
            name: Some(name.into()),
            raw: Some(data.iter().flat_map(|v| v.to_le_bytes()).collect()),
            ..Tensor::default()
        });
    }

    /// Stores values under a name made of `base`.
    pub fn floats(&mut self, base: &str, shape: &[usize], data: &[f32]) -> String {
        let name = self.fresh(base);
        self.store(&name, shape, data);
        name
    }

    /// Stores a list of integers under a name made of `base`.
    pub fn ints(&mut self, base: &str, values: &[i64]) -> String {
        let name = self.fresh(base);
        let raw: Bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.initializers.push(Tensor {
            dims: vec![values.len() as i64],
            dtype: Some(dtype::INT64),
            name: Some(name.clone()),
            raw: Some(raw),
            ..Tensor::default()
        });
        name
    }

    /// Adds a node whose output bears a name that is taken already; the node bears it too.
    pub fn put(&mut self, op: &str, inputs: &[&str], output: &str, attributes: Vec<Attribute>) {
        self.nodes.push(Node {
            inputs: inputs.iter().map(|name| name.to_string()).collect(),
            outputs: vec![output.into()],
            name: Some(output.into()),
            op: Some(op.into()),
            attributes,
            domain: None,
        });
    }

    /// Adds a node whose output gets a name made of `base`.
    pub fn step(&mut self, op: &str, inputs: &[&str], base: &str, attributes: Vec<Attribute>) -> String {
        let output = self.fresh(base);
        self.put(op, inputs, &output, attributes);
        output
    }
}

/// Returns sizes as ONNX counts them. A graph's are below 2^31.
pub fn sizes(values: &[usize]) -> Vec<i64> {
    values.iter().map(|&size| size as i64).collect()
}

/// Makes an integer attribute.
pub fn int(name: &str, value: i64) -> Attribute {
    Attribute { name: Some(name.into()), i: Some(value), kind: Some(kind::INT), ..Attribute::default() }
}

/// Makes an attribute that is a list of integers.
pub fn ints(name: &str, values: Vec<i64>) -> Attribute {
    Attribute { name: Some(name.into()), ints: values, kind: Some(kind::INTS), ..Attribute::default() }
}

/// Makes an attribute that is a number.
pub fn float(name: &str, value: f32) -> Attribute {
    Attribute { name: Some(name.into()), f: Some(value), kind: Some(kind::FLOAT), ..Attribute::default() }
}
