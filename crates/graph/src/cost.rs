//! The cost of a network, independent of any machine.
//!
//! A MAC is one multiply–accumulate of a convolution, linear or recurrent layer; batch norm,
//! activations and pools are not counted. FLOPs are `2 · MAC` plus one addition per bias and output value
//! (in an LSTM or GRU, per bias, gate and step).

use crate::graph::{Graph, Node, Param, TensorKind};
use crate::op::Op;

/// Cost of one node, or of a whole network, for one sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Cost {
    /// Trained values.
    pub parameters: u64,
    /// Values kept by the network: running statistics.
    pub buffers: u64,
    /// Multiply–accumulates.
    pub macs: u64,
    /// Floating point operations: `2 · macs` + bias additions.
    pub flops: u64,
    /// Values of the output.
    pub activations: u64,
}

impl Cost {
    /// Returns the bytes of the tensors on disk, all in f32.
    pub fn bytes(&self) -> u64 {
        4 * (self.parameters + self.buffers)
    }

    /// Returns the bytes of the output of one sample in f32.
    pub fn activation_bytes(&self) -> u64 {
        4 * self.activations
    }
}

impl std::ops::Add for Cost {
    type Output = Cost;

    fn add(self, other: Cost) -> Cost {
        Cost {
            parameters: self.parameters + other.parameters,
            buffers: self.buffers + other.buffers,
            // Of a node they fit by the limit on its values; of many they might not.
            macs: self.macs.saturating_add(other.macs),
            flops: self.flops.saturating_add(other.flops),
            activations: self.activations + other.activations,
        }
    }
}

impl std::iter::Sum for Cost {
    fn sum<I: Iterator<Item = Cost>>(costs: I) -> Cost {
        costs.fold(Cost::default(), |a, b| a + b)
    }
}

impl Node {
    /// Computes the cost of this node for one sample.
    pub fn cost(&self) -> Cost {
        let count = |kind| self.params.iter().filter(|p| p.kind == kind).map(|p| p.len() as u64).sum();
        let outputs: u64 = self.shape.iter().product::<usize>() as u64;
        let (macs, bias) = match &self.op {
            // Every output value meets one row of the weight tensor.
            Op::Conv { bias, .. } | Op::Linear { bias, .. } => {
                let row: usize = self.params.first().map_or(0, |w: &Param| w.shape[1..].iter().product());
                (outputs * row as u64, if *bias { outputs } else { 0 })
            }
            // Every step meets both weight tensors and both biases once.
            Op::Lstm { steps, .. } | Op::Gru { steps, .. } => {
                let [weights, biases] = [&self.params[..2], &self.params[2..]]
                    .map(|params| params.iter().map(Param::len).sum::<usize>());
                ((steps * weights) as u64, (steps * biases) as u64)
            }
            _ => (0, 0),
        };
        Cost {
            parameters: count(TensorKind::Parameter),
            buffers: count(TensorKind::Buffer),
            macs,
            flops: 2 * macs + bias,
            activations: outputs,
        }
    }
}

impl Graph {
    /// Computes the sum over all nodes.
    pub fn cost(&self) -> Cost {
        self.nodes().iter().map(Node::cost).sum()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Conv, Cost, Flow, Network};

    /// Returns the costs of a network from `input` through `body`: all of it, and its last node.
    fn costs(input: &[usize], body: impl Fn(&Flow) -> Flow) -> [Cost; 2] {
        let net = Network::new("costs");
        let y = body(&net.input("x", input));
        let graph = net.finish(&[("y", y)]).unwrap();
        [graph.cost(), graph.nodes().last().unwrap().cost()]
    }

    fn cost([parameters, buffers, macs, flops, activations]: [u64; 5]) -> Cost {
        Cost { parameters, buffers, macs, flops, activations }
    }

    #[test]
    fn layers_counted_by_hand() {
        // 4 filters of 3 x 3 x 3 over 8 x 8 places; a bias each.
        let [_, conv] = costs(&[3, 8, 8], |x| x.conv("c", Conv::new(4, 3).same()));
        assert_eq!(conv, cost([112, 0, 6912, 14_080, 256]));
        let [_, no_bias] = costs(&[3, 8, 8], |x| x.conv("c", Conv::new(4, 3).same().no_bias()));
        assert_eq!(no_bias, cost([108, 0, 6912, 13_824, 256]));
        let [_, linear] = costs(&[7], |x| x.linear("fc", 5));
        assert_eq!(linear, cost([40, 0, 35, 75, 5]));
        // 4 gates of 6 hidden values from 3 channels and 6 hidden values, two biases, 10 steps.
        let [_, lstm] = costs(&[3, 10], |x| x.lstm("lstm", 6));
        assert_eq!(lstm, cost([264, 0, 2160, 4800, 6]));
        // 3 gates, likewise.
        let [_, gru] = costs(&[3, 1, 10], |x| x.gru("gru", 6));
        assert_eq!(gru, cost([198, 0, 1620, 3600, 6]));
        // Weight and bias are learned, running mean and variance are kept.
        let [_, norm] = costs(&[5], |x| x.batch_norm("bn"));
        assert_eq!([norm.parameters, norm.macs, norm.flops, norm.activations], [10, 0, 0, 5]);
        assert!(norm.buffers >= 10);
    }

    #[test]
    fn a_network_is_its_layers_and_a_value_has_four_bytes() {
        let [all, last] = costs(&[7], |x| x.linear("a", 5).batch_norm("bn").linear("b", 3));
        assert_eq!(
            [all.parameters, all.macs, all.flops, all.activations],
            [40 + 10 + 18, 50, 75 + 33, 7 + 5 + 5 + 3]
        );
        assert!(all.buffers >= 10);
        assert_eq!(last, cost([18, 0, 15, 33, 3]));
        assert_eq!(all.bytes(), 4 * (68 + all.buffers));
        assert_eq!((last.bytes(), last.activation_bytes()), (72, 12));
    }
}
