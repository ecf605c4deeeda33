//! Parts of a network: which nodes a name or a range of layers means, and the network up to a node.

use std::ops::RangeInclusive;

use crate::error::{Error, Result};
use crate::graph::{Graph, Node, NodeId};
use crate::op::Op;

/// MATLAB counts a softmax and a classification layer after the last node.
const AFTER: usize = 2;

impl Graph {
    /// Nodes with their layer numbers: from 1, in order, dropout without one.
    ///
    /// In `mobilenet-v2` these are the numbers of MATLAB's 154 layers, of which the last two, softmax and
    /// classification, are no nodes here (paper 001, Table 6).
    pub fn layers(&self) -> impl Iterator<Item = (Option<usize>, &Node)> {
        let number = |last: &mut usize, node| {
            let counts = !matches!(node, &Node { op: Op::Dropout { .. }, .. });
            *last += usize::from(counts);
            Some((counts.then_some(*last), node))
        };
        self.nodes.iter().scan(0, number)
    }

    /// Which nodes `names` cover: of each the node of that name, or all whose names start with it and a
    /// point (`stem` is every node `stem.…`), or a range of [`Graph::layers`], both ends included
    /// (`18:139`).
    ///
    /// # Errors
    /// A name or range without a node that has tensors.
    pub fn covered(&self, names: &[String]) -> Result<Vec<bool>> {
        let mut covered = vec![false; self.nodes.len()];
        for name in names {
            let range = self.range(name)?;
            let mut found = false;
            for (covered, (number, node)) in covered.iter_mut().zip(self.layers()) {
                let here = match &range {
                    Some(range) => number.is_some_and(|n| range.contains(&n)),
                    None => {
                        let rest = node.name.strip_prefix(name.as_str());
                        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
                    }
                };
                if here && !node.params.is_empty() {
                    (*covered, found) = (true, true);
                }
            }
            if !found {
                let reason = format!("cannot freeze `{name}`: no node with tensors has that name");
                return Err(Error::node(&self.name, reason));
            }
        }
        Ok(covered)
    }

    fn range(&self, name: &str) -> Result<Option<RangeInclusive<usize>>> {
        let Some((first, last)) = name.split_once(':') else { return Ok(None) };
        let count = self.layers().filter_map(|(number, _)| number).max().unwrap_or(0) + AFTER;
        match (first.parse::<usize>(), last.parse::<usize>()) {
            (Ok(first), Ok(last)) if 1 <= first && first <= last && last <= count => Ok(Some(first..=last)),
            _ => {
                let reason =
                    format!("cannot freeze `{name}`: expected first:last within layers 1 to {count}");
                Err(Error::node(&self.name, reason))
            }
        }
    }

    /// The network up to a node, which becomes its only output and gives it its name. All inputs stay.
    ///
    /// `node` is the name of a node, or of a block: then the last node whose name starts with it and a
    /// point, before anything that pools globally or flattens.
    ///
    /// # Errors
    /// No such node.
    pub fn cut(&self, node: &str) -> Result<Graph> {
        let exact = self.nodes.iter().position(|n| n.name == node);
        let ends = |op: &Op| {
            matches!(
                op,
                Op::GlobalAveragePool | Op::AdaptiveAveragePool { .. } | Op::Flatten | Op::Dropout { .. }
            )
        };
        let inside =
            |n: &Node| n.name.strip_prefix(node).is_some_and(|rest| rest.starts_with('.')) && !ends(&n.op);
        let Some(end) = exact.or_else(|| self.nodes.iter().rposition(inside)) else {
            let reason = format!("has no node `{node}`; `taxel cost {}` lists them", self.name);
            return Err(Error::node(&self.name, reason));
        };
        let mut kept: Vec<bool> = self.nodes.iter().map(|n| n.op == Op::Input).collect();
        kept[end] = true;
        for id in (0..=end).rev().filter(|&id| self.nodes[id].op != Op::Input) {
            if kept[id] {
                self.nodes[id].inputs.iter().for_each(|&input| kept[input] = true);
            }
        }
        let at = |id: NodeId| kept[..id].iter().filter(|kept| **kept).count();
        let moved = |(_, node): (&bool, &Node)| Node {
            inputs: node.inputs.iter().map(|&id| at(id)).collect(),
            ..node.clone()
        };
        Ok(Graph {
            name: self.name.clone(),
            nodes: kept.iter().zip(&self.nodes).filter(|(kept, _)| **kept).map(moved).collect(),
            inputs: self.inputs.iter().map(|&id| at(id)).collect(),
            outputs: vec![(self.nodes[end].name.clone(), at(end))],
            loss_weights: vec![1.0],
        })
    }

    /// Names of the tensors of the heads: of each output, those between the last convolution, linear or
    /// LSTM layer and the output, that layer's included.
    pub fn head_tensors(&self) -> Vec<&str> {
        let mut names = vec![];
        for &(_, output) in &self.outputs {
            let mut id = output;
            loop {
                let node = &self.nodes[id];
                names.extend(node.params.iter().map(|p| p.name.as_str()));
                let layer = matches!(node.op, Op::Conv { .. } | Op::Linear { .. } | Op::Lstm { .. });
                match node.inputs[..] {
                    [input] if !layer => id = input,
                    _ => break,
                }
            }
        }
        names
    }
}
