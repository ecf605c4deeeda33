//! A network with fewer channels, or more.

use std::collections::BTreeSet;

use crate::error::{Error, Result};
use crate::graph::{Graph, Node, NodeId};
use crate::op::Op;
use crate::settings::check_width_mult;
use crate::shape::describe;

impl Graph {
    /// Returns the same network with `width_mult` times the channels in every convolution, linear and recurrent layer,
    /// rounded to the nearest number and at least 1: the width multiplier of Howard et al. (MobileNets, 2017). What
    /// decides how many values an output has stays as it is. Depthwise convolutions and slices of channels follow their
    /// inputs. Names of nodes and tensors stay, and fresh weights are drawn by the same rules.
    ///
    /// # Errors
    /// A multiplier that is not above 0 and at most 4; channels that do not fit together any more, such as a slice that
    /// would not end between two of them.
    pub fn with_width(&self, width_mult: f64) -> Result<Graph> {
        check_width_mult(width_mult)?;
        let scaled = |channels: usize| ((channels as f64 * width_mult).round() as usize).max(1);
        let heads = self.heads();
        let mut nodes: Vec<Node> = vec![];
        for (id, node) in self.nodes.iter().enumerate() {
            let channels =
                |among: &[Node]| node.inputs.first().and_then(|&input| among[input].shape.first().copied());
            let (old, new) = (channels(&self.nodes).unwrap_or(1), channels(&nodes).unwrap_or(1));
            let is_head = heads.contains(&id);
            let mut op = node.op.clone();
            match &mut op {
                Op::Conv { filters, groups, .. } if *groups > 1 && *groups == old => {
                    (*filters, *groups) = (*filters / old * new, new);
                }
                Op::Conv { filters: size, .. }
                | Op::Linear { outputs: size, .. }
                | Op::Lstm { hidden: size, .. }
                | Op::Gru { hidden: size, .. }
                    if !is_head =>
                {
                    *size = scaled(*size);
                }
                Op::Slice { start, len } => {
                    let share = |size: usize| (size * new).is_multiple_of(old).then_some(size * new / old);
                    let (Some(first), Some(size)) = (share(*start), share(*len)) else {
                        let reason = format!(
                            "channels {start} to {} of {} have no counterpart among {new}: try another width_mult",
                            *start + *len,
                            describe(&self.nodes[node.inputs[0]].shape),
                        );
                        return Err(Error::node(&node.name, reason));
                    };
                    (*start, *len) = (first, size);
                }
                _ => {}
            }
            nodes.push(node.resized(op, node.inputs.clone(), &nodes)?);
        }
        Graph::new(self.name.clone(), nodes, self.outputs.clone(), self.loss_weights.clone())
    }

    /// Finds the layers that decide how many values the outputs have: the first on every way back from an output.
    pub(crate) fn heads(&self) -> BTreeSet<NodeId> {
        let (mut heads, mut seen) = (BTreeSet::new(), BTreeSet::new());
        let mut open: Vec<NodeId> = self.outputs.iter().map(|(_, id)| *id).collect();
        while let Some(id) = open.pop() {
            let node = &self.nodes[id];
            match node.op {
                _ if !seen.insert(id) => {}
                Op::Conv { .. } | Op::Linear { .. } | Op::Lstm { .. } | Op::Gru { .. } => {
                    heads.insert(id);
                }
                _ => open.extend(&node.inputs),
            }
        }
        heads
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Conv, Fill, Graph, Init, Network, Pool};

    fn shapes(graph: &Graph) -> Vec<Vec<usize>> {
        graph.params().map(|param| param.shape.clone()).collect()
    }

    #[test]
    fn hidden_layers_have_half_the_channels_and_the_outputs_stay() {
        let net = Network::new("own");
        let x = net.input("signal", &[3, 9]).conv("stem", Conv::new(5, 3)).batch_norm("bn").relu();
        let x = x.conv("depthwise", Conv::new(10, 3).groups(5).no_bias()).global_average_pool();
        let graph =
            net.finish(&[("logits", x.linear("hidden", 6).relu().linear("fc", 4).dropout(0.2))]).unwrap();
        let half = graph.with_width(0.5).unwrap();
        let stem = [vec![3, 3, 3], vec![3], vec![3], vec![3], vec![3], vec![3]];
        let rest = [vec![6, 1, 3], vec![3, 6], vec![3], vec![4, 3], vec![4]];
        assert_eq!(shapes(&half), [&stem[..], &rest[..]].concat());
        assert_eq!(graph.with_width(1.0).unwrap(), graph);
        assert_eq!(shapes(&graph.with_width(0.01).unwrap())[0], [1, 3, 3]);
        for width_mult in [0.0, -1.0, 4.1, f64::NAN] {
            let error = graph.with_width(width_mult).unwrap_err().to_string();
            assert!(error.ends_with("must be above 0 and at most 4"), "{error}");
        }
    }

    #[test]
    fn a_narrow_network_is_what_the_builder_makes_of_narrow_layers() {
        let fills =
            [Fill::Pytorch, Fill::KaimingNormalFanIn, Fill::KaimingNormalFanOut, Fill::KaimingUniformFanOut];
        for fill in fills.into_iter().chain([Fill::Normal { sd: 0.01 }, Fill::Constant(0.5)]) {
            let built = |width: usize| {
                let net = Network::new("own");
                net.conv_init(fill, Fill::Constant(0.0));
                net.linear_init(fill, Fill::Pytorch);
                let x = net.input("image", &[1, 12, 12]).conv("a", Conv::new(width, 3)).relu();
                let x = x.add(&x.conv("b", Conv::new(width, 3).pad(1).no_bias())).max_pool(Pool::new(2));
                let half = x.slice(width / 2, width / 2).concat(&x.conv("c", Conv::new(width, 1)));
                let seen = half.channel_shuffle(3).scale("k", 2.0).flatten().linear("hidden", 2 * width);
                net.finish(&[("logits", seen.linear("fc", 3))]).unwrap()
            };
            assert_eq!(built(16).with_width(0.25).unwrap(), built(4), "{fill:?}");
        }
        let recurrent = |hidden: usize| {
            let net = Network::new("own");
            let signal = net.input("signal", &[2, 9]);
            let x = signal.lstm("lstm", hidden).concat(&signal.gru("gru", hidden));
            net.finish(&[("logits", x.linear("fc", 3))]).unwrap()
        };
        assert_eq!(recurrent(32).with_width(0.5).unwrap(), recurrent(16));
    }

    #[test]
    fn what_decides_an_output_stays_on_every_way_to_it_and_a_torn_slice_is_refused() {
        let net = Network::new("sum");
        let x = net.input("signal", &[3, 9]);
        let (a, b) = (x.global_average_pool().linear("a", 4), x.lstm("hidden", 8).linear("b", 4));
        let graph = net.finish(&[("logits", a.add(&b)), ("own", b)]).unwrap();
        let half = graph.with_width(0.5).unwrap();
        assert_eq!(half.nodes().last().unwrap().shape, [4]);
        assert_eq!(half.params().find(|param| param.name == "b.weight").unwrap().shape, [4, 4]);

        let net = Network::new("torn");
        let x = net.input("signal", &[3, 9]).conv("stem", Conv::new(6, 3)).slice(0, 2).global_average_pool();
        let graph = net.finish(&[("logits", x.linear("fc", 3))]).unwrap();
        let error = graph.with_width(0.75).unwrap_err().to_string();
        assert!(
            error.contains("channels 0 to 2 of channels 6 × length 7 have no counterpart among 5"),
            "{error}"
        );
        assert!(graph.with_width(0.5).is_ok());
        assert!(matches!(graph.params().next().unwrap().init, Init::Uniform { .. }));
    }
}
