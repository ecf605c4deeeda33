//! A network with fewer residual blocks, dense layers or plain layers.

use std::collections::BTreeSet;

use crate::error::{Error, Result};
use crate::graph::{Graph, Node, NodeId};
use crate::op::Op;

/// Nodes that may be left out.
struct RemovableBlock {
    /// The last of them.
    end: NodeId,
    /// The node whose value takes its place when it is left out.
    start: NodeId,
    /// The others.
    body: BTreeSet<NodeId>,
}

impl Graph {
    /// Counts the blocks that hand on their input as it is: residual blocks with an identity shortcut (He et al., Deep
    /// Residual Learning, 2016) and dense layers, whose input stands beside their result (Huang et al., DenseNet,
    /// 2017).
    pub fn identity_blocks(&self) -> usize {
        (0..self.nodes.len()).filter(|&id| self.block(id).is_some()).count()
    }

    /// Returns the same network without the last `count` blocks that hand on their input. All other nodes and tensors
    /// keep their names; behind a dense layer they read fewer channels, and their fresh weights are drawn by the same
    /// rules.
    ///
    /// # Errors
    /// More blocks than there are.
    pub fn without_blocks(&self, count: usize) -> Result<Graph> {
        let last = |graph: &Graph| (0..graph.nodes.len()).rev().find_map(|id| graph.block(id));
        self.without_last(count, last)?.ok_or_else(|| {
            let reason =
                format!("the network has {} blocks with an identity shortcut", self.identity_blocks());
            Error::config("without_blocks", count, &reason)
        })
    }

    /// Counts the plain layers that could be left out one after another ([`Graph::without_layers`]).
    pub fn plain_layers(&self) -> usize {
        let next = |graph: &Graph| graph.last_layer().and_then(|layer| graph.without(&layer).ok());
        std::iter::successors(next(self), next).count()
    }

    /// Returns the same network without its last `count` plain layers: convolutions and linear layers, each with the
    /// normalisation, activation, dropout and pooling behind it. What follows reads what the layer read, and its fresh
    /// weights are drawn by the same rules. The first layer of every input stays, what decides how many values an
    /// output has, and what begins or ends where ways part or meet.
    ///
    /// # Errors
    /// More layers than there are; shapes that do not fit together any more.
    pub fn without_layers(&self, count: usize) -> Result<Graph> {
        self.without_last(count, Graph::last_layer)?.ok_or_else(|| {
            let reason = format!("the network has {} plain layers that can go", self.plain_layers());
            Error::config("without_layers", count, &reason)
        })
    }

    /// Returns the same network without what `last` finds in it, `count` times over; none where it finds nothing any
    /// more.
    fn without_last(
        &self,
        count: usize,
        last: impl Fn(&Graph) -> Option<RemovableBlock>,
    ) -> Result<Option<Graph>> {
        let mut graph = self.clone();
        for _ in 0..count {
            let Some(block) = last(&graph) else { return Ok(None) };
            graph = graph.without(&block)?;
        }
        Ok(Some(graph))
    }

    fn last_layer(&self) -> Option<RemovableBlock> {
        let heads = self.heads();
        (0..self.nodes.len()).rev().filter(|id| !heads.contains(id)).find_map(|id| self.layer(id))
    }

    /// Finds the plain layer that begins with `id`, if one does.
    fn layer(&self, id: NodeId) -> Option<RemovableBlock> {
        let is_layer =
            |op: &Op| matches!(op, Op::Conv { .. } | Op::Linear { .. } | Op::Lstm { .. } | Op::Gru { .. });
        let node = &self.nodes[id];
        let start = match node.op {
            Op::Conv { groups: 1, .. } | Op::Linear { .. } => node.inputs[0],
            _ => return None,
        };
        let is_first = !self.leading_to(start).iter().any(|&earlier| is_layer(&self.nodes[earlier].op));
        if is_first || self.only_reader(start) != Some(id) {
            return None;
        }
        let (mut end, mut body) = (id, BTreeSet::new());
        loop {
            let next = self.only_reader(end)?;
            match self.nodes[next].op {
                Op::BatchNorm { .. }
                | Op::LayerNorm { .. }
                | Op::Relu
                | Op::Activation(_)
                | Op::Dropout { .. }
                | Op::MaxPool(_)
                | Op::AveragePool { .. } => {
                    body.insert(end);
                    end = next;
                }
                Op::Add | Op::Concat | Op::SwitchScale => return None,
                _ => return Some(RemovableBlock { end, start, body }),
            }
        }
    }

    /// Finds the one node that reads `id`; none where several do, or where it is an output.
    fn only_reader(&self, id: NodeId) -> Option<NodeId> {
        let mut readers = (0..self.nodes.len()).filter(|&reader| self.nodes[reader].inputs.contains(&id));
        let only = readers.next().filter(|_| readers.next().is_none());
        only.filter(|_| self.outputs.iter().all(|(_, output)| *output != id))
    }

    /// Finds the block that ends in the sum `id`, or where `id` joins channels, if nobody else reads what is inside.
    fn block(&self, id: NodeId) -> Option<RemovableBlock> {
        let (Op::Add | Op::Concat, &[a, b]) = (&self.nodes[id].op, &self.nodes[id].inputs[..]) else {
            return None;
        };
        let of = |main: NodeId, shortcut: NodeId| {
            let (above, before) = (self.leading_to(main), self.leading_to(shortcut));
            let body: BTreeSet<NodeId> = above.difference(&before).copied().collect();
            let reads = |node: &Node| node.inputs.iter().any(|input| body.contains(input));
            let outside = |(other, _): &(NodeId, &Node)| *other != id && !body.contains(other);
            let is_read = self.nodes.iter().enumerate().filter(outside).any(|(_, node)| reads(node));
            let is_given = body.iter().any(|&node| self.nodes[node].op == Op::Input);
            let is_output = self.outputs.iter().any(|(_, output)| body.contains(output));
            let is_block =
                above.contains(&shortcut) && !body.is_empty() && !(is_read || is_given || is_output);
            is_block.then_some(RemovableBlock { end: id, start: shortcut, body })
        };
        of(a, b).or_else(|| of(b, a))
    }

    /// Returns a node and all that it is made of.
    fn leading_to(&self, id: NodeId) -> BTreeSet<NodeId> {
        let (mut found, mut open) = (BTreeSet::new(), vec![id]);
        while let Some(id) = open.pop() {
            if found.insert(id) {
                open.extend(&self.nodes[id].inputs);
            }
        }
        found
    }

    fn without(&self, block: &RemovableBlock) -> Result<Graph> {
        let mut nodes: Vec<Node> = vec![];
        // Where each node is now.
        let mut now = vec![0; self.nodes.len()];
        for (id, node) in self.nodes.iter().enumerate() {
            if id == block.end {
                now[id] = now[block.start];
            } else if !block.body.contains(&id) {
                let inputs = node.inputs.iter().map(|&input| now[input]).collect();
                now[id] = nodes.len();
                nodes.push(node.resized(node.op.clone(), inputs, &nodes)?);
            }
        }
        let outputs = self.outputs.iter().map(|(name, id)| (name.clone(), now[*id])).collect();
        Graph::new(self.name.clone(), nodes, outputs, self.loss_weights.clone())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Conv, Fill, Flow, Graph, Network, Node, Pool};

    fn block(x: &Flow, name: &str, is_first: bool) -> Flow {
        let main = x.conv(&format!("{name}.conv"), Conv::new(4, 3).pad(1)).batch_norm(&format!("{name}.bn"));
        let sum = if is_first { x.add(&main) } else { main.add(x) };
        sum.relu()
    }

    fn residual(blocks: usize) -> Graph {
        let net = Network::new("own");
        net.conv_init(Fill::KaimingNormalFanOut, Fill::Constant(0.0));
        let mut x = net.input("signal", &[3, 9]).conv("stem", Conv::new(4, 3)).relu();
        for i in 0..blocks {
            x = block(&x, &format!("block{i}"), i == 0);
        }
        net.finish(&[("logits", x.global_average_pool().linear("fc", 3))]).unwrap()
    }

    fn tensors(graph: &Graph) -> Vec<crate::Param> {
        graph.params().cloned().collect()
    }

    #[test]
    fn the_last_blocks_go_and_the_rest_stays_as_it_was_drawn() {
        let whole = residual(3);
        assert_eq!((whole.identity_blocks(), residual(0).identity_blocks()), (3, 0));
        for left in 0..3 {
            let less = whole.without_blocks(3 - left).unwrap();
            assert_eq!((tensors(&less), less.identity_blocks()), (tensors(&residual(left)), left));
            assert_eq!(less.cost().macs, residual(left).cost().macs);
        }
        assert_eq!(whole.without_blocks(0).unwrap(), whole);
        let error = whole.without_blocks(4).unwrap_err().to_string();
        assert_eq!(error, "without_blocks = 4: the network has 3 blocks with an identity shortcut");
    }

    #[test]
    fn a_dense_layer_goes_and_what_follows_reads_fewer_channels() {
        let dense = |layers: usize| {
            let net = Network::new("own");
            let mut x = net.input("signal", &[3, 9]).conv("stem", Conv::new(4, 3)).relu();
            for i in 0..layers {
                x = x.concat(&x.conv_bn_relu(&format!("dense{i}"), Conv::new(2, 3).pad(1)));
            }
            let x = x.conv("transition", Conv::new(5, 1)).global_average_pool();
            net.finish(&[("logits", x.linear("fc", 3))]).unwrap()
        };
        assert_eq!((dense(2).identity_blocks(), dense(2).without_blocks(2).unwrap()), (2, dense(0)));
        assert_eq!(dense(2).without_blocks(1).unwrap(), dense(1));
    }

    /// Makes a network of as many convolutions with all that belongs to them as there are filters, and hidden units if
    /// there are any.
    fn plain(filters: &[usize], hidden: Option<usize>) -> Graph {
        let net = Network::new("own");
        let mut x = net.input("image", &[1, 16, 16]);
        for (i, filters) in filters.iter().enumerate() {
            let conv = Conv::new(*filters, 3).same();
            x = x.conv_bn_relu(&format!("convs.{i}"), conv).max_pool(Pool::new(2));
        }
        x = x.flatten();
        if let Some(hidden) = hidden {
            x = x.linear("hidden", hidden).relu().dropout(0.5);
        }
        net.finish(&[("logits", x.linear("fc", 3))]).unwrap()
    }

    #[test]
    fn the_last_layers_go_with_all_that_belongs_to_them() {
        let whole = plain(&[4, 8, 6], Some(10));
        assert_eq!(whole.plain_layers(), 3);
        let less = [plain(&[4, 8, 6], None), plain(&[4, 8], None), plain(&[4], None)];
        // All but the names of nodes without tensors, which stay as they were.
        let made = |graph: &Graph| {
            let one = |node: &Node| (node.op.clone(), node.inputs.clone(), node.params.clone());
            graph.nodes().iter().map(one).collect::<Vec<_>>()
        };
        for (count, want) in (1..).zip(&less) {
            assert_eq!(made(&whole.without_layers(count).unwrap()), made(want));
        }
        let error = whole.without_layers(4).unwrap_err().to_string();
        assert_eq!(error, "without_layers = 4: the network has 3 plain layers that can go");
    }

    #[test]
    fn where_ways_part_or_meet_and_in_outputs_no_layer_goes() {
        let net = Network::new("own");
        let stem = net.input("signal", &[3, 9]).conv("stem", Conv::new(4, 3)).relu();
        let (left, right) = (stem.conv("left", Conv::new(4, 1)), stem.conv("right", Conv::new(4, 1)));
        let joined = left.add(&right.conv("meets", Conv::new(4, 1)));
        let logits = joined.global_average_pool().linear("hidden", 5).linear("fc", 3);
        let graph = net.finish(&[("logits", logits), ("stem", stem)]).unwrap();
        let shown = |graph: &Graph| graph.nodes().iter().map(|node| node.name.clone()).collect::<Vec<_>>();
        let less = graph.without_layers(1).unwrap();
        assert_eq!((graph.plain_layers(), shown(&less).contains(&"hidden".to_string())), (1, false));
    }

    #[test]
    fn what_others_read_and_sums_of_two_ways_are_no_blocks() {
        let net = Network::new("own");
        let x = net.input("signal", &[3, 9]).conv("stem", Conv::new(4, 3)).relu();
        let main = x.conv("a", Conv::new(4, 3).pad(1));
        let seen = main.add(&x);
        let ways = seen.conv("left", Conv::new(4, 1)).add(&seen.conv("right", Conv::new(4, 1)));
        let logits = ways.concat(&main.relu()).global_average_pool().linear("fc", 3);
        assert_eq!(net.finish(&[("logits", logits)]).unwrap().identity_blocks(), 0);
        let net = Network::new("output");
        let x = net.input("signal", &[3, 9]);
        let main = x.conv("a", Conv::new(3, 3).pad(1));
        let graph = net.finish(&[("y", main.add(&x)), ("main", main)]).unwrap();
        assert_eq!(graph.identity_blocks(), 0);
    }
}
