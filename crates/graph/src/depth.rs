//! A network with fewer residual blocks.

use std::collections::BTreeSet;

use crate::error::{Error, Result};
use crate::graph::{Graph, Node, NodeId};
use crate::op::Op;

/// A block that may be left out: a sum of a value and of what nodes of its own make of that value.
struct Block {
    /// The sum.
    add: NodeId,
    /// The value: what the sum becomes without the block.
    shortcut: NodeId,
    /// The nodes between.
    body: BTreeSet<NodeId>,
}

impl Graph {
    /// How many residual blocks have an identity shortcut (He et al., Deep Residual Learning, 2016): without any of them the
    /// others still fit together.
    pub fn identity_blocks(&self) -> usize {
        (0..self.nodes.len()).filter(|&id| self.block(id).is_some()).count()
    }

    /// The same network without its last `count` residual blocks that have an identity shortcut. All other nodes and tensors
    /// keep their names.
    ///
    /// # Errors
    /// More blocks than there are.
    pub fn without_blocks(&self, count: usize) -> Result<Graph> {
        let mut graph = self.clone();
        for _ in 0..count {
            let Some(block) = (0..graph.nodes.len()).rev().find_map(|id| graph.block(id)) else {
                let reason =
                    format!("the network has {} blocks with an identity shortcut", self.identity_blocks());
                return Err(Error::config("without_blocks", count, &reason));
            };
            graph = graph.without(&block)?;
        }
        Ok(graph)
    }

    /// The block that ends in the sum `id`, if one does and nobody else reads what is inside.
    fn block(&self, id: NodeId) -> Option<Block> {
        let (Op::Add, &[a, b]) = (&self.nodes[id].op, &self.nodes[id].inputs[..]) else { return None };
        let of = |main: NodeId, shortcut: NodeId| {
            let (above, before) = (self.leading_to(main), self.leading_to(shortcut));
            let body: BTreeSet<NodeId> = above.difference(&before).copied().collect();
            let reads = |node: &Node| node.inputs.iter().any(|input| body.contains(input));
            let outside = |(own, _): &(NodeId, &Node)| *own != id && !body.contains(own);
            let is_read = self.nodes.iter().enumerate().filter(outside).any(|(_, node)| reads(node));
            let is_given = body.iter().any(|&own| self.nodes[own].op == Op::Input);
            let is_output = self.outputs.iter().any(|(_, own)| body.contains(own));
            let is_block =
                above.contains(&shortcut) && !body.is_empty() && !(is_read || is_given || is_output);
            is_block.then_some(Block { add: id, shortcut, body })
        };
        of(a, b).or_else(|| of(b, a))
    }

    /// A node and all that it is made of.
    fn leading_to(&self, id: NodeId) -> BTreeSet<NodeId> {
        let (mut found, mut open) = (BTreeSet::new(), vec![id]);
        while let Some(id) = open.pop() {
            if found.insert(id) {
                open.extend(&self.nodes[id].inputs);
            }
        }
        found
    }

    fn without(&self, block: &Block) -> Result<Graph> {
        let mut nodes: Vec<Node> = vec![];
        // Where each node is now.
        let mut now = vec![0; self.nodes.len()];
        for (id, node) in self.nodes.iter().enumerate() {
            if id == block.add {
                now[id] = now[block.shortcut];
            } else if !block.body.contains(&id) {
                let inputs = node.inputs.iter().map(|&input| now[input]).collect();
                now[id] = nodes.len();
                nodes.push(node.again(node.op.clone(), inputs, &nodes)?);
            }
        }
        let outputs = self.outputs.iter().map(|(name, id)| (name.clone(), now[*id])).collect();
        Graph::new(self.name.clone(), nodes, outputs, self.loss_weights.clone())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Conv, Fill, Flow, Graph, Network};

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
    fn what_others_read_and_sums_of_two_ways_are_no_blocks() {
        let net = Network::new("own");
        let x = net.input("signal", &[3, 9]).conv("stem", Conv::new(4, 3)).relu();
        let main = x.conv("a", Conv::new(4, 3).pad(1));
        let seen = main.add(&x);
        let ways = seen.conv("left", Conv::new(4, 1)).add(&seen.conv("right", Conv::new(4, 1)));
        let logits = ways.concat(&main).global_average_pool().linear("fc", 3);
        assert_eq!(net.finish(&[("logits", logits)]).unwrap().identity_blocks(), 0);
        let net = Network::new("output");
        let x = net.input("signal", &[3, 9]);
        let main = x.conv("a", Conv::new(3, 3).pad(1));
        let graph = net.finish(&[("y", main.add(&x)), ("main", main)]).unwrap();
        assert_eq!(graph.identity_blocks(), 0);
    }
}
