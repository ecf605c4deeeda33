//! Recurrent layers as ONNX nodes, whose gates stand in another order than PyTorch's.

use taxel_graph::Tensor;

use super::emit::Emit;
use super::sink::{int, ints};
use crate::error::Cause;

impl Emit<'_> {
    /// Writes an LSTM: ONNX has i, o, f, g, PyTorch i, f, g, o.
    pub(super) fn lstm(&mut self, hidden: usize) -> Result<(), Cause> {
        self.recurrent("LSTM", "iofg", &[0, 3, 1, 2], hidden)
    }

    /// Writes a GRU: ONNX has z, r, n, PyTorch r, z, n; both reset what the hidden state gives after its product.
    pub(super) fn gru(&mut self, hidden: usize) -> Result<(), Cause> {
        self.recurrent("GRU", "zrn", &[1, 0, 2], hidden)
    }

    /// Writes a layer of ONNX's operation `op`, whose gates in PyTorch's order are `order`.
    fn recurrent(&mut self, op: &str, letters: &str, order: &[usize], hidden: usize) -> Result<(), Cause> {
        let mut stored = vec![];
        for at in 0..2 {
            let Tensor { shape, data } = self.tensor(at)?;
            let (shape, data) = ([&[1], &shape[..]].concat(), ordered(data, order, hidden * shape[1]));
            let name = format!("{}/{letters}", self.node.params[at].name);
            stored.push(self.sink.floats(&name, &shape, &data));
        }
        let mut biases = vec![];
        for at in 2..4 {
            biases.extend(ordered(&self.tensor(at)?.data, order, hidden));
        }
        let name = format!("{}/{letters}", self.node.params[2].name);
        stored.push(self.sink.floats(&name, &[1, biases.len()], &biases));
        let mut x = self.x.to_string();
        let rank = self.inputs[0].1.len();
        if rank > 2 {
            let between: Vec<i64> = (2..rank as i64).collect();
            let axes = self.sink.ints(&self.base("axes"), &between);
            x = self.step("Squeeze", &[&x, &axes], "sequence", vec![]);
        }
        let x = self.step("Transpose", &[&x], "steps", vec![ints("perm", vec![2, 0, 1])]);
        let part = op.to_lowercase();
        let (node, state) = (self.sink.fresh(&self.base(&part)), self.sink.fresh(&self.base("state")));
        let inputs = [&x, &stored[0], &stored[1], &stored[2]].map(String::as_str);
        let mut attributes = vec![int("hidden_size", hidden as i64)];
        if op == "GRU" {
            attributes.push(int("linear_before_reset", 1));
        }
        self.sink.put(op, &inputs, &node, attributes);
        if let Some(layer) = self.sink.nodes.last_mut() {
            // The hidden states of all steps are not asked for, the last one's are.
            layer.outputs = vec![String::new(), state.clone()];
        }
        let direction = self.sink.ints(&self.base("direction"), &[0]);
        self.end("Squeeze", &[&state, &direction], vec![]);
        Ok(())
    }
}

/// Brings gates of `each` values into this order.
fn ordered(data: &[f32], order: &[usize], each: usize) -> Vec<f32> {
    order.iter().flat_map(|gate| &data[gate * each..(gate + 1) * each]).copied().collect()
}
