//! From the bytes of an ONNX model to a graph and its weights.

use std::collections::HashMap;
use std::path::Path;

use bytes::Bytes;
use prost::Message;
use taxel_base::files::read_bytes;
use taxel_graph::{Activation, Graph, Op, Weights};

use super::attributes::Call;
use super::draft::Draft;
use super::stored::{StoredTensors, type_name};
use super::values::{AxisRole, AxisView, Fragment, Id, ImportedValue};
use super::work::Importer;
use super::{ints, nodes};
use crate::bounds;
use crate::error::{Cause, Error, Result};
use crate::export::{
    DISTANCE, PROBABILITIES, QUANTITIES, READINGS_DISTANCE, TEMPERATURE, UNKNOWN_BEYOND, VALUES,
};
use crate::proto::{self, ValueInfo, dtype};

/// Versions of ONNX's operations that are read.
const OPSETS: std::ops::RangeInclusive<i64> = 7..=26;

/// The most inputs, and the most outputs.
const MOST_PORTS: usize = 64;

/// A network that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The network.
    pub graph: Graph,
    /// Its tensors.
    pub weights: Weights,
    /// Notes for the user: nodes that were left out, names that were changed.
    pub notes: Vec<String>,
}

/// Reads an ONNX file; the network is called as the file.
///
/// # Errors
/// A file that is missing, damaged, or holds what no network of taxel can be: by node and operation.
pub fn read(path: &Path) -> Result<Imported> {
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let read = || from_bytes(read_bytes(path)?, &name, Some(path.parent().unwrap_or(Path::new(""))));
    read().map_err(|cause| Error::new(path, cause))
}

/// Reads the bytes of an ONNX model as a network called `name`; tensors kept in files of their own are looked for in
/// `folder`.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: Vec<u8>, name: &str, folder: Option<&Path>) -> std::result::Result<Imported, Cause> {
    bounds::check(&bytes).map_err(Cause::NotOnnx)?;
    let length = bytes.len();
    let model = proto::Model::decode(Bytes::from(bytes)).map_err(|e| Cause::NotOnnx(e.to_string()))?;
    let Some(mut graph) = model.graph else {
        return Err(Cause::NotOnnx("it holds no graph".into()));
    };
    version(&model.opsets)?;
    let mut notes = vec![];
    let says = |key: &str| model.facts.iter().any(|fact| fact.key.as_deref() == Some(key));
    if says(QUANTITIES) {
        leave_out(&mut graph, &[VALUES]);
    }
    if says(TEMPERATURE) || says(UNKNOWN_BEYOND) {
        let outputs: &[&str] = if says(TEMPERATURE) {
            &[PROBABILITIES, DISTANCE, READINGS_DISTANCE]
        } else {
            &[READINGS_DISTANCE]
        };
        leave_out(&mut graph, outputs);
        notes.push("temperature and gate are left out: fit or calibrate a model anew".into());
    }
    let mut stored = StoredTensors::new(folder, length);
    let tensors: Vec<proto::Tensor> = std::mem::take(&mut graph.initializers);
    let names: Vec<String> = tensors.iter().map(|tensor| tensor.name.clone().unwrap_or_default()).collect();
    let constants: Vec<ImportedValue> =
        tensors.into_iter().map(|tensor| ints::stored(&mut stored, tensor)).collect();
    let (draft, values) = (Draft::new(), HashMap::new());
    let mut work = Importer { draft, stored, values, uses: HashMap::new(), batch: None, notes };
    work.values.extend(names.iter().map(String::as_str).zip(constants));
    let reads = graph.nodes.iter().flat_map(|node| &node.inputs);
    for name in reads.chain(graph.outputs.iter().filter_map(|output| output.name.as_ref())) {
        *work.uses.entry(name).or_default() += 1;
    }
    if graph.outputs.len() > MOST_PORTS {
        return Err(Cause::NotOnnx(format!("it has more than {MOST_PORTS} outputs")));
    }
    inputs(&mut work, &graph.inputs)?;
    for node in &graph.nodes {
        nodes::node(&mut work, Call { node })?;
    }
    let outputs = outputs(&mut work, &graph.outputs)?;
    let Importer { draft, notes, .. } = work;
    let (graph, weights) = draft.finish(name, &outputs)?;
    weights.refuse_unsound()?;
    Ok(Imported { graph, weights, notes })
}

/// Takes away outputs that taxel's export adds behind the first one, with the steps to them.
fn leave_out(graph: &mut proto::Graph, added: &[&str]) {
    let is_of_them = |name: &String| {
        let is_behind = |output: &str| {
            name.strip_prefix(output).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        added.iter().any(|output| is_behind(output))
    };
    graph.nodes.retain(|node| !node.outputs.iter().any(is_of_them));
    graph.outputs.retain(|output| !output.name.as_ref().is_some_and(is_of_them));
}

fn version(opsets: &[proto::Opset]) -> std::result::Result<(), Cause> {
    let opset =
        opsets.iter().find(|opset| ["", "ai.onnx"].contains(&opset.domain.as_deref().unwrap_or_default()));
    match opset.and_then(|opset| opset.version) {
        Some(version) if OPSETS.contains(&version) => Ok(()),
        Some(version) => Err(Cause::Version(format!(
            "is of opset {version}; taxel reads {} to {}: export the network with another opset_version",
            OPSETS.start(),
            OPSETS.end()
        ))),
        None => Err(Cause::NotOnnx("it names no version of ONNX's operations".into())),
    }
}

/// Adds the inputs that are no constants.
fn inputs<'a>(work: &mut Importer<'a>, given: &'a [ValueInfo]) -> std::result::Result<(), Cause> {
    let mut open = vec![];
    for info in given {
        let name = info.name.as_deref().unwrap_or_default();
        if !work.values.contains_key(name) {
            open.push((name, shape(work, name, info)?));
            if open.len() > MOST_PORTS {
                return Err(Cause::NotOnnx(format!("it has more than {MOST_PORTS} inputs")));
            }
        }
    }
    let names = inputs_names(&open);
    for ((name, shape), chosen) in open.into_iter().zip(names) {
        if chosen != name {
            work.notes.push(format!("input `{name}` is called `{chosen}`"));
        }
        let rank = shape.len();
        let node = work.draft.input(&chosen, shape)?;
        work.values.insert(name, ImportedValue::Flow(AxisView::plain(node, rank)));
    }
    Ok(())
}

/// Returns taxel's names of the inputs, by their axes; two of one name keep the names of the file.
fn inputs_names(open: &[(&str, Vec<usize>)]) -> Vec<String> {
    const NAMES: [&str; 4] = ["signal", "signal", "image", "tensor"];
    let by_axes = |shape: &[usize]| NAMES[(shape.len() - 1).min(3)];
    let name = |(name, shape): &(&str, Vec<usize>)| {
        let by_layout = by_axes(shape);
        let is_only = open.iter().filter(|(_, other)| by_axes(other) == by_layout).count() == 1;
        let known = NAMES.contains(name);
        if is_only && !known { by_layout.to_string() } else { name.to_string() }
    };
    open.iter().map(name).collect()
}

/// Returns the shape of an input, the samples' axis left out.
fn shape(work: &mut Importer, name: &str, info: &ValueInfo) -> std::result::Result<Vec<usize>, Cause> {
    let refuse = |reason: String| Cause::Port { role: "input", name: name.into(), reason };
    let tensor = info.kind.as_ref().and_then(|kind| kind.tensor.as_ref());
    let tensor = tensor.ok_or_else(|| refuse("is no tensor".into()))?;
    let kind = tensor.dtype.unwrap_or_default();
    if ![dtype::FLOAT, dtype::FLOAT16, dtype::DOUBLE, dtype::BFLOAT16].contains(&kind) {
        return Err(refuse(format!("is {}; taxel's networks read numbers with a fraction", type_name(kind))));
    }
    let dims = tensor.shape.as_ref().map_or(&[][..], |shape| &shape.dims);
    let [samples, rest @ ..] = dims else {
        return Err(refuse("has no axes; taxel reads samples first".into()));
    };
    let sizes: Option<Vec<usize>> =
        rest.iter().map(|dim| usize::try_from(dim.size?).ok().filter(|size| *size > 0)).collect();
    match sizes {
        Some(sizes) if (1..=4).contains(&sizes.len()) => {
            work.batch = work.batch.or(samples.size.filter(|size| *size > 0));
            Ok(sizes)
        }
        Some(sizes) => Err(refuse(format!(
            "has {} axes after the samples; taxel reads 1 (features) to 4 (channels × rows × columns × frames)",
            sizes.len()
        ))),
        None => Err(refuse(
            "has an axis of no fixed size after the samples; export the network for the shape of your samples, with the \
             batch alone dynamic"
                .into(),
        )),
    }
}

/// Returns the outputs by name: logits, where the file gives probabilities beside them or alone.
fn outputs(work: &mut Importer, given: &[ValueInfo]) -> std::result::Result<Vec<(String, Id)>, Cause> {
    let mut found: Vec<(String, Id)> = vec![];
    let mut softmaxes = vec![];
    for info in given {
        let name = info.name.as_deref().unwrap_or_default();
        let refuse = |reason: &str| Cause::Port { role: "output", name: name.into(), reason: reason.into() };
        match work.values.get(name) {
            Some(ImportedValue::Flow(view)) => {
                let rank = work.draft.node(view.node).shape.len();
                let units = if rank == 1 { view.units() } else { 0 };
                if !view.is_plain(rank, units) || !view.pad.is_empty() || view.axes.contains(&AxisRole::Step)
                {
                    return Err(refuse("has axes that are not samples, channels and space, in this order"));
                }
                found.push((name.into(), view.node));
            }
            Some(ImportedValue::Part(Fragment::Probabilities, view)) => softmaxes.push((name, view.node)),
            Some(_) => return Err(refuse("is a constant, or of an operation that taxel does not have")),
            None => {
                return Err(refuse("is given by no node, or is a second output that taxel does not have"));
            }
        }
    }
    for (name, node) in softmaxes {
        if !found.iter().any(|(_, other)| *other == node) {
            work.notes.push(format!("output `{name}` is taken before its softmax, which taxel does itself"));
            found.push((name.into(), node));
        }
    }
    // The sigmoid of another output is its probability.
    let squashed = |id: Id| {
        let node = work.draft.node(id);
        let sigmoid = node.op == Op::Activation(Activation::Sigmoid);
        sigmoid && found.iter().any(|(_, other)| node.inputs.contains(other))
    };
    let mut kept: Vec<(String, Id)> = found.iter().filter(|(_, id)| !squashed(*id)).cloned().collect();
    if let [(name, _)] = &mut kept[..] {
        *name = "logits".into();
    }
    Ok(kept)
}
