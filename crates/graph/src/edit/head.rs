//! A network with another number of classes.

use crate::error::{Error, Result};
use crate::graph::{Graph, Node};
use crate::op::Op;

impl Graph {
    /// Returns the same network with `classes` values in each output: the last linear layer or convolution before it
    /// has as many outputs. All other nodes and tensors keep their names;
    /// [`Weights::start_from`](crate::Weights::start_from) takes over what fits.
    ///
    /// # Errors
    /// An output whose number of values no such layer decides.
    pub fn with_classes(&self, classes: usize) -> Result<Graph> {
        let mut ops: Vec<Op> = self.nodes.iter().map(|node| node.op.clone()).collect();
        for (output, id) in &self.outputs {
            let layer = self.head(*id).ok_or_else(|| self.unsized_head(output, classes))?;
            match &mut ops[layer] {
                Op::Linear { outputs, .. } => *outputs = classes,
                Op::Conv { filters, .. } => *filters = classes,
                _ => {}
            }
        }
        let mut nodes: Vec<Node> = vec![];
        for (node, op) in self.nodes.iter().zip(ops) {
            nodes.push(node.again(op, node.inputs.clone(), &nodes)?);
        }
        for (output, id) in &self.outputs {
            if nodes[*id].shape != [classes] {
                return Err(self.unsized_head(output, classes));
            }
        }
        Graph::new(self.name.clone(), nodes, self.outputs.clone(), self.loss_weights.clone())
    }

    /// Finds the layer that decides how many values an output has.
    fn head(&self, mut id: usize) -> Option<usize> {
        loop {
            match (&self.nodes[id].op, &self.nodes[id].inputs[..]) {
                (Op::Linear { .. } | Op::Conv { .. }, _) => return Some(id),
                (Op::Lstm { .. } | Op::Gru { .. } | Op::Slice { .. }, _) => return None,
                (_, [input]) => id = *input,
                _ => return None,
            }
        }
    }

    fn unsized_head(&self, output: &str, classes: usize) -> Error {
        let reason = format!(
            "output `{output}` cannot have {classes} classes: it has to end in a linear layer, or in a convolution and a mean"
        );
        Error::node(&self.name, reason)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Conv, Network, Scheme, Weights};

    #[test]
    fn the_last_layer_has_as_many_outputs_and_the_rest_stays() {
        let net = Network::new("own");
        let x = net.input("signal", &[3, 9]).conv_bn_relu("stem", Conv::new(4, 3)).global_average_pool();
        let graph =
            net.finish(&[("logits", x.linear("hidden", 6).relu().linear("fc", 5).dropout(0.2))]).unwrap();
        let two = graph.with_classes(2).unwrap();
        let shapes = |g: &crate::Graph| g.params().map(|p| p.shape.clone()).collect::<Vec<_>>();
        let (old, new) = (shapes(&graph), shapes(&two));
        let (last, rest) = (old.len() - 2, ..old.len() - 2);
        assert_eq!((&old[rest], &new[last..]), (&new[rest], &[vec![2, 6], vec![2]][..]));
        assert_eq!(graph.with_classes(5).unwrap(), graph);
        let mut weights = Weights::init(&two, Scheme::Pytorch, 0, "new");
        let start = Weights::init(&graph, Scheme::Pytorch, 1, "old");
        assert_eq!(weights.start_from(&two, &start, false).unwrap(), ["fc.weight", "fc.bias"]);
    }

    #[test]
    fn a_convolution_before_a_mean_is_a_head_and_other_ends_are_refused() {
        let net = Network::new("conv");
        let x = net.input("signal", &[3, 9]).conv("head", Conv::new(4, 3));
        assert_eq!(
            net.finish(&[("y", x.global_average_pool())]).unwrap().with_classes(2).unwrap().nodes()[2].shape,
            [2]
        );
        let ends: [fn(&crate::Flow) -> crate::Flow; 3] = [
            |x| x.lstm("lstm", 4),
            |x| x.conv("head", Conv::new(4, 3)).flatten(),
            |x| x.global_average_pool().linear("fc", 4).slice(0, 3),
        ];
        for end in ends {
            let net = Network::new("end");
            let x = end(&net.input("signal", &[3, 9]));
            let error = net.finish(&[("y", x)]).unwrap().with_classes(2).unwrap_err().to_string();
            assert!(error.contains("output `y` cannot have 2 classes"), "{error}");
        }
    }
}
