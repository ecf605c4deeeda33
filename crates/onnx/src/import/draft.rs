//! The network while its nodes are read: what has been added may still get a bias, and what nobody reads is left out.

use std::collections::{HashMap, HashSet};

use taxel_graph::{Error, Flow, Graph, Network, Op, Tensor, Weights};

use super::values::Id;

/// The most nodes of a network; the largest ones of torchvision have a thousand.
const MOST_NODES: usize = 20_000;
/// The most bytes of a name before its number: names are made of names.
const LONGEST_NAME: usize = 240;

/// Nodes so far.
pub struct Draft {
    /// Infers shapes.
    net: Network,
    nodes: Vec<Drafted>,
    taken: HashSet<String>,
    /// How often a name was asked for.
    counts: HashMap<String, usize>,
}

/// One node.
pub struct Drafted {
    pub name: String,
    pub op: Op,
    pub inputs: Vec<Id>,
    pub shape: Vec<usize>,
    /// Tensors by their full names.
    pub tensors: Vec<(String, Tensor)>,
    flow: Flow,
}

impl Draft {
    pub fn new() -> Self {
        Draft { net: Network::new("draft"), nodes: vec![], taken: HashSet::new(), counts: HashMap::new() }
    }

    /// Returns a node of the draft.
    pub fn node(&self, id: Id) -> &Drafted {
        &self.nodes[id]
    }

    /// Adds an input.
    pub fn input(&mut self, name: &str, shape: Vec<usize>) -> Result<Id, Error> {
        let name = self.name(name);
        // A network reports what does not fit when it ends.
        let flow = Network::new("input").input(&name, &shape);
        if flow.shape() != shape {
            let reason = format!("an input needs 1 to 4 axes of at least 1, got {shape:?}");
            return Err(Error::Node { node: name, reason });
        }
        let flow = self.net.input(&name, &shape);
        let node = Drafted { name, op: Op::Input, inputs: vec![], shape, tensors: vec![], flow };
        Ok(self.keep(node))
    }

    /// Adds a node that does `op`, under a name that [`Draft::name`] gave; tensors are called `name.…`, or as the node
    /// where nothing follows.
    pub fn add(
        &mut self,
        name: String,
        op: Op,
        inputs: &[Id],
        tensors: Vec<(&str, Tensor)>,
    ) -> Result<Id, Error> {
        if self.nodes.len() >= MOST_NODES {
            let reason = format!("is one of more than {MOST_NODES} nodes");
            return Err(Error::Node { node: name, reason });
        }
        let flows: Vec<&Flow> = inputs.iter().map(|&input| &self.nodes[input].flow).collect();
        let flow = self.net.operation(&name, op.clone(), &flows)?;
        let full = |(suffix, tensor): (&str, Tensor)| match suffix {
            "" => (name.clone(), tensor),
            suffix => (format!("{name}.{suffix}"), tensor),
        };
        let tensors = tensors.into_iter().map(full).collect();
        let shape = flow.shape();
        Ok(self.keep(Drafted { name, op, inputs: inputs.to_vec(), shape, tensors, flow }))
    }

    /// Adds a node without tensors, named after its first input.
    pub fn then(&mut self, op: Op, inputs: &[Id]) -> Result<Id, Error> {
        let first = inputs.first().map_or("", |&input| &self.nodes[input].name);
        let name = self.name(&format!("{first}/{}", op.kind()));
        self.add(name, op, inputs, vec![])
    }

    /// Gives a node another operation of the same shape and one more tensor.
    pub fn amend(&mut self, id: Id, op: Op, suffix: &str, tensor: Tensor) {
        let node = &mut self.nodes[id];
        let name = format!("{}.{suffix}", node.name);
        node.op = op;
        node.tensors.retain(|(other, _)| *other != name);
        node.tensors.push((name, tensor));
    }

    /// Checks whether a standardising node has no deviations yet.
    pub fn divides_by_one(&self, id: Id) -> bool {
        let mut tensors = self.nodes[id].tensors.iter().filter(|(name, _)| name.ends_with(".std"));
        tensors.all(|(_, tensor)| tensor.data.iter().all(|v| *v == 1.0))
    }

    /// Makes the network that computes `outputs`, and its tensors.
    pub fn finish(mut self, name: &str, outputs: &[(String, Id)]) -> Result<(Graph, Weights), Error> {
        let mut needed: Vec<bool> = self.nodes.iter().map(|node| node.op == Op::Input).collect();
        outputs.iter().for_each(|(_, id)| needed[*id] = true);
        for id in (0..self.nodes.len()).rev().filter(|&id| self.nodes[id].op != Op::Input) {
            if needed[id] {
                self.nodes[id].inputs.iter().for_each(|&input| needed[input] = true);
            }
        }
        let net = Network::new(name);
        let (mut flows, mut weights) = (HashMap::new(), Weights::new());
        for (id, node) in self.nodes.iter_mut().enumerate().filter(|(id, _)| needed[*id]) {
            let flow = match &node.op {
                Op::Input => net.input(&node.name, &node.shape),
                op => {
                    let inputs: Vec<&Flow> = node.inputs.iter().map(|input| &flows[input]).collect();
                    net.operation(&node.name, op.clone(), &inputs)?
                }
            };
            flows.insert(id, flow);
            node.tensors.drain(..).for_each(|(name, tensor)| weights.insert(&name, tensor));
        }
        let outputs: Vec<(&str, Flow)> =
            outputs.iter().map(|(name, id)| (name.as_str(), flows[id].clone())).collect();
        let graph = net.finish(&outputs)?;
        weights.check(&graph)?;
        let weights = weights.only(&graph);
        Ok((graph, weights))
    }

    fn keep(&mut self, node: Drafted) -> Id {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Takes a name that no node has: `base`, or with a number.
    pub fn name(&mut self, base: &str) -> String {
        let base = &base[..base.floor_char_boundary(LONGEST_NAME)];
        let count = self.counts.entry(base.into()).or_default();
        loop {
            *count += 1;
            let name = if *count == 1 { base.to_string() } else { format!("{base}{count}") };
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }
}
