//! MATLAB's layer numbers, by which Rouhafzay et al. 2021 name frozen layers.
//!
//! # Reference
//! Rouhafzay et al. 2021, Table 6: ranges of the 154 layers that MATLAB counts in `mobilenet-v2`.
//!
//! # Departures
//! The last two of these layers, softmax and classification, are no nodes here. Other networks are counted alike:
//! from 1, in order, dropout left out.
//!
//! ```
//! use taxel_graph::Architecture;
//! use taxel_visuotactile::{MobileNetV2Config, matlab};
//!
//! let graph = MobileNetV2Config::default().graph()?;
//! assert_eq!(matlab::layers(&graph).last().and_then(|(number, _)| number), Some(152));
//! assert_eq!(matlab::range(&graph, "1:4")?, ["features.0.0", "features.0.1"]);
//! # Ok::<(), taxel_graph::Error>(())
//! ```

use taxel_graph::{Error, Graph, Node, Op, Result};

/// MATLAB counts a softmax and a classification layer after the last node.
const AFTER: usize = 2;

/// Iterates over the nodes with their layer numbers; dropout has none.
pub fn layers(graph: &Graph) -> impl Iterator<Item = (Option<usize>, &Node)> {
    graph.nodes().iter().scan(0, |last, node| {
        let counts = !matches!(node.op, Op::Dropout { .. });
        *last += usize::from(counts);
        Some((counts.then_some(*last), node))
    })
}

/// Lists the names of the nodes with tensors within layers `first:last`, both ends included.
///
/// # Errors
/// No range within the layers, MATLAB's last two among them, or one without such a node.
pub fn range(graph: &Graph, range: &str) -> Result<Vec<String>> {
    let refuse = |reason: String| Error::node(graph.name(), format!("cannot freeze `{range}`: {reason}"));
    let count = layers(graph).filter_map(|(number, _)| number).max().unwrap_or(0) + AFTER;
    let ends =
        range.split_once(':').and_then(|(first, last)| Some((first.parse().ok()?, last.parse().ok()?)));
    let within = |&(first, last): &(usize, usize)| 1 <= first && first <= last && last <= count;
    let Some((first, last)) = ends.filter(within) else {
        return Err(refuse(format!("expected first:last within layers 1 to {count}")));
    };
    let inside = |number: Option<usize>| number.is_some_and(|number| (first..=last).contains(&number));
    let names: Vec<String> = layers(graph)
        .filter(|(number, node)| inside(*number) && !node.params.is_empty())
        .map(|(_, node)| node.name.clone())
        .collect();
    if names.is_empty() {
        return Err(refuse("no node with tensors is among them".into()));
    }
    Ok(names)
}

/// Returns `names` with the nodes of a range in place of every range; what has no colon is left as it is, for
/// [`Graph::covered`].
///
/// # Errors
/// As [`range`].
pub fn resolve(graph: &Graph, names: &[String]) -> Result<Vec<String>> {
    let mut resolved = vec![];
    for name in names {
        if name.contains(':') { resolved.extend(range(graph, name)?) } else { resolved.push(name.clone()) }
    }
    Ok(resolved)
}
