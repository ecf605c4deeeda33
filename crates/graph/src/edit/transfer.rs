//! From one network's tensors to another's: starting from a checkpoint, stitching, and what training changed.

use std::collections::HashSet;

use crate::error::{Error, Result};
use crate::graph::Graph;
use crate::op::Op;
use crate::weights::Weights;

impl Weights {
    /// Returns the tensors that `graph` names, in its order; what is missing stays missing.
    pub fn only(&self, graph: &Graph) -> Weights {
        let mut weights = Weights::new();
        for param in graph.params() {
            if let Some(tensor) = self.get(&param.name) {
                weights.insert(&param.name, tensor.clone());
            }
        }
        weights
    }

    /// Puts a checkpoint's tensors in place of these, which are fresh ones of `graph`. A head made for another
    /// number of classes stays fresh, and so do all heads where `new_head` asks for it; returns the names of
    /// the tensors that stayed, so that it can be said.
    ///
    /// # Errors
    /// Any other tensor that is missing, extra or misshaped, by name; nothing is replaced then.
    pub fn start_from(&mut self, graph: &Graph, checkpoint: &Weights, new_head: bool) -> Result<Vec<String>> {
        let head = graph.head_tensors();
        let classes_differ = graph.params().filter(|p| head.contains(&p.name.as_str())).any(|param| {
            let got = checkpoint.get(&param.name).map(|t| t.shape.as_slice()).unwrap_or_default();
            got.len() == param.shape.len() && got[0] != param.shape[0] && got[1..] == param.shape[1..]
        });
        let fresh: HashSet<&str> =
            if classes_differ || new_head { head.into_iter().collect() } else { HashSet::new() };
        let mut merged = Weights::new();
        for (name, tensor) in checkpoint.iter() {
            let drawn = self.get(name).filter(|_| fresh.contains(name));
            merged.insert(name, drawn.unwrap_or(tensor).clone());
        }
        for &name in &fresh {
            if let Some(drawn) = self.get(name) {
                merged.insert(name, drawn.clone());
            }
        }
        merged.check(graph)?;
        *self = merged.only(graph);
        Ok(graph.params().filter(|p| fresh.contains(p.name.as_str())).map(|p| p.name.clone()).collect())
    }

    /// Takes the tensors of `graph` out of networks that were trained apart: `stream.…` is the tensor `…` of the parent
    /// of that name, `shared.…` is `…` of all of them, and must be the same in each. Every other tensor comes from
    /// `others`.
    ///
    /// # Errors
    /// A shared tensor that differs between parents, or one that is missing or misshaped, by name.
    pub fn stitched(
        graph: &Graph,
        parents: &[(&str, &Weights)],
        shared: &str,
        others: &Weights,
    ) -> Result<Weights> {
        let mut weights = Weights::new();
        for param in graph.params() {
            let (scope, name) = param.name.split_once('.').unwrap_or(("", &param.name));
            let mut found = parents.iter().filter(|(parent, _)| scope == shared || *parent == scope);
            let tensor = match found.next() {
                Some((_, parent)) => parent.get(name),
                None => others.get(&param.name),
            };
            let Some(tensor) = tensor else { continue };
            if let Some((other, _)) = found.find(|(_, parent)| parent.get(name) != Some(tensor)) {
                let reason = format!(
                    "shared tensor `{name}` is another in `{}` than in `{other}`; train both with the shared part frozen",
                    parents[0].0
                );
                return Err(Error::node(graph.name(), reason));
            }
            weights.insert(&param.name, tensor.clone());
        }
        weights.check(graph)?;
        Ok(weights)
    }

    /// Computes how much training changed every convolution of `graph`, in its order: the mean squared difference
    /// between the kernels in `self` and in `tuned`, both scaled to 0..1 (Rouhafzay et al. 2021, Figs. 3 and 4). A
    /// kernel whose values are all the same counts as zeros.
    ///
    /// # Errors
    /// Weights that do not fit the graph, by name.
    pub fn changes(&self, tuned: &Weights, graph: &Graph) -> Result<Vec<(String, f64)>> {
        self.check(graph)?;
        tuned.check(graph)?;
        let mut changes = vec![];
        for node in graph.nodes().iter().filter(|node| matches!(node.op, Op::Conv { .. })) {
            let name = &node.params[0].name;
            #[expect(clippy::expect_used, reason = "both were checked against the graph above")]
            let [before, after] =
                [self, tuned].map(|weights| weights.get(name).expect("a tensor of the graph"));
            let pairs = unit(&before.data).zip(unit(&after.data));
            let sum: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
            changes.push((node.name.clone(), sum / before.data.len() as f64));
        }
        Ok(changes)
    }
}

/// Scales values to 0..1.
fn unit(values: &[f32]) -> impl Iterator<Item = f64> {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v.into()), h.max(v.into())));
    let width = if high > low { high - low } else { 1.0 };
    values.iter().map(move |&v| (f64::from(v) - low) / width)
}
