//! From a graph and its weights to the bytes of an ONNX model.

use std::collections::HashSet;
use std::path::Path;

use prost::Message;
use taxel_graph::{Graph, Loss, Op, Weights};

use super::emit::Emit;
use super::front::Front;
use super::gate::{GatePlace, distance};
use super::readings::ReadingsPlace;
use super::sink::{Sink, int};
use super::value::info;
use crate::error::{Cause, Error, Result};
use crate::proto::{self, Entry, Opset, ValueInfo};

/// Version of ONNX's operations that is written: the first with all that taxel needs and a state of the art.
pub const OPSET: i64 = 17;
/// Version of the file format that belongs to it.
pub const IR_VERSION: i64 = 8;

/// Name of the output that follows from the logits and the loss.
pub const PROBABILITIES: &str = "probabilities";
/// Name of the output that holds the values of a network that learned values.
pub const VALUES: &str = "values";
/// Key of the fact that says the quantities of these values, with their units.
pub const QUANTITIES: &str = "taxel.quantities";
/// Key of the fact that says the temperature of the probabilities; a file without it has those of its loss.
pub const TEMPERATURE: &str = "taxel.temperature";

/// Largest model: protobuf's limit, in bytes.
const LARGEST: usize = i32::MAX as usize;

/// A network with what is to be written beside it.
#[derive(Debug, Clone)]
pub struct Export<'a> {
    /// The network.
    pub graph: &'a Graph,
    /// Its tensors, which fit it.
    pub weights: &'a Weights,
    /// The loss that its first output was trained for: a second one, `probabilities`, follows from it. Default none.
    pub loss: Option<Loss>,
    /// How many of the first output's values answer: a second output, [`VALUES`], holds them. Default none.
    pub values: Option<usize>,
    /// Divides the logarithms of the probabilities, above 0; none where they are those of the loss.
    pub temperature: Option<f64>,
    /// Classes of each attribute, whose outputs lie one after the other. Default none: all outputs are of one.
    pub sizes: Vec<usize>,
    /// The gate of each attribute behind the first output, whose output is [`DISTANCE`](super::DISTANCE). Default none.
    pub gate: Vec<GatePlace>,
    /// The gate of raw readings, whose output is [`READINGS_DISTANCE`](super::READINGS_DISTANCE); the first input has to take them. Default none.
    pub readings_gate: Option<ReadingsPlace>,
    /// Of each input, how raw readings become it; none, and past the end, where it is taken as it is.
    pub readings: Vec<Option<Front>>,
    /// Text for people.
    pub about: String,
    /// Facts by key, for programs (`metadata_props`).
    pub facts: Vec<(String, String)>,
}

impl<'a> Export<'a> {
    /// Makes an export of the bare network.
    pub fn new(graph: &'a Graph, weights: &'a Weights) -> Self {
        Export {
            graph,
            weights,
            loss: None,
            values: None,
            temperature: None,
            sizes: vec![],
            gate: vec![],
            readings_gate: None,
            readings: vec![],
            about: String::new(),
            facts: vec![],
        }
    }
}

/// Writes the model, under a temporary name first: a reader never sees half a file. Equal networks give equal bytes.
///
/// # Errors
/// As [`to_bytes`], and a folder that is missing or cannot be written.
pub fn write(path: &Path, export: &Export) -> Result<()> {
    let write = || taxel_base::files::write_whole(path, &to_bytes(export)?).map_err(Cause::Write);
    write().map_err(|cause| Error::new(path, cause))
}

/// Returns the bytes of an ONNX model.
///
/// # Errors
/// Weights that do not fit the graph, readings that do not become its inputs, more than 2 GiB.
pub fn to_bytes(export: &Export) -> std::result::Result<Vec<u8>, Cause> {
    export.weights.check(export.graph)?;
    let entry =
        |(key, value): &(String, String)| Entry { key: Some(key.clone()), value: Some(value.clone()) };
    let model = proto::Model {
        ir_version: Some(IR_VERSION),
        producer_name: Some("taxel".into()),
        producer_version: Some(env!("CARGO_PKG_VERSION").into()),
        doc: Some(export.about.clone()).filter(|about| !about.is_empty()),
        graph: Some(graph(export)?),
        opsets: vec![Opset { domain: Some(String::new()), version: Some(OPSET) }],
        facts: export.facts.iter().map(entry).collect(),
    };
    match model.encoded_len() {
        ..=LARGEST => Ok(model.encode_to_vec()),
        bytes => {
            let reason = format!("takes {bytes} bytes, ONNX files hold {LARGEST} at most");
            Err(taxel_graph::Error::Node { node: export.graph.name().into(), reason }.into())
        }
    }
}

fn graph(export: &Export) -> std::result::Result<proto::Graph, Cause> {
    let Export { graph, weights, .. } = export;
    let mut sink = Sink::default();
    let outputs = graph.outputs();
    // Names that stay as they are come first: those of tensors, inputs and outputs.
    for name in graph.params().map(|param| &param.name) {
        sink.take(name);
    }
    let nodes = graph.nodes();
    let mut values = inputs(export, &mut sink)?;
    for (name, _) in outputs {
        if !sink.take(name) {
            let reason = "a tensor or input has this name too".to_string();
            return Err(Cause::Port { role: "output", name: name.clone(), reason });
        }
    }
    let mut given = HashSet::new();
    for (id, node) in nodes.iter().enumerate().filter(|(_, node)| node.op != Op::Input) {
        let output = outputs.iter().find(|(_, of)| *of == id).map(|(name, _)| name.clone());
        given.extend(output.clone());
        values[id] = output.unwrap_or_else(|| sink.fresh(&node.name));
        let read = node.inputs.iter().map(|&input| (values[input].as_str(), nodes[input].shape.as_slice()));
        let (inputs, output) = (read.collect::<Vec<_>>(), values[id].as_str());
        let x = inputs.first().map_or("", |(name, _)| name);
        Emit { sink: &mut sink, node, x, inputs, output, weights }.emit()?;
    }
    // An input that is an output, or one value under two names.
    for (name, id) in outputs.iter().filter(|(name, _)| !given.contains(name)) {
        sink.put("Identity", &[&values[*id]], name, vec![]);
    }
    let mut infos: Vec<ValueInfo> =
        outputs.iter().map(|(name, id)| info(name, &nodes[*id].shape, None)).collect();
    infos.extend(probabilities(export, &mut sink));
    infos.extend(answered(export, &mut sink));
    infos.extend(outputs.first().and_then(|(logits, _)| distance(&export.gate, logits, &mut sink)));
    let raw = graph.inputs().next().filter(|_| export.readings.first().is_some_and(Option::is_some));
    infos.extend(raw.and_then(|raw| export.readings_gate.as_ref()?.emit(&raw.name, &mut sink)));
    Ok(proto::Graph {
        nodes: sink.nodes,
        name: Some(graph.name().into()),
        initializers: sink.initializers,
        inputs: graph
            .inputs()
            .enumerate()
            .map(|(at, node)| {
                let reading = export.readings.get(at).and_then(Option::as_ref);
                let (shape, what) = match reading {
                    Some(reading) => (&reading.shape, "raw readings"),
                    None => (&node.shape, "as the network reads it"),
                };
                info(&node.name, shape, Some(what))
            })
            .collect(),
        outputs: infos,
    })
}

/// Adds the inputs, raw readings encoded, and returns the names of their values, by node.
fn inputs(export: &Export, sink: &mut Sink) -> std::result::Result<Vec<String>, Cause> {
    let nodes = export.graph.nodes();
    let mut values = vec![String::new(); nodes.len()];
    for node in export.graph.inputs() {
        if !sink.take(&node.name) {
            let reason = "a tensor has this name too".to_string();
            return Err(Cause::Port { role: "input", name: node.name.clone(), reason });
        }
    }
    let ids = (0..nodes.len()).filter(|&id| nodes[id].op == Op::Input);
    for (at, id) in ids.enumerate() {
        values[id] = match export.readings.get(at).and_then(Option::as_ref) {
            Some(reading) => reading.emit(sink, &nodes[id].name, &nodes[id].shape)?,
            None => nodes[id].name.clone(),
        };
    }
    Ok(values)
}

/// Adds the output that follows from the first one and the loss, if that has one value per class.
fn probabilities(export: &Export, sink: &mut Sink) -> Option<ValueInfo> {
    let (logits, id) = export.graph.outputs().first()?;
    let shape = &export.graph.nodes()[*id].shape;
    let loss = export.loss.filter(|_| shape.len() == 1)?;
    if !sink.take(PROBABILITIES) {
        return None;
    }
    let plain = match export.temperature {
        Some(_) => sink.fresh(&format!("{PROBABILITIES}/plain")),
        None => PROBABILITIES.into(),
    };
    let outputs = shape.iter().product();
    let sizes = if export.sizes.is_empty() { vec![outputs] } else { export.sizes.clone() };
    match loss {
        Loss::CumulativeLogits => {
            let sums = sink.floats("probabilities/sums", &[outputs, outputs], &cumulative(&sizes));
            let summed = sink.step("MatMul", &[logits, &sums], "probabilities/summed", vec![]);
            softmax(&sizes, &summed, &plain, sink);
        }
        Loss::SoftmaxCrossEntropy => sink.put("Softmax", &[logits], &plain, vec![int("axis", 1)]),
        Loss::MultiLabelSoftMargin | Loss::Hinge => sink.put("Sigmoid", &[logits], &plain, vec![]),
        // Of classes: the losses of values alone have no probabilities.
        _ => {
            let [low, high] = [0.0, 1.0].map(|end| sink.floats("probabilities/end", &[], &[end]));
            sink.put("Clip", &[logits, &low, &high], &plain, vec![]);
        }
    }
    if let Some(temperature) = export.temperature {
        temper(temperature, &sizes, &plain, sink);
    }
    Some(info(PROBABILITIES, shape, None))
}

/// Adds the output of the values that answer, those first in a row of the first output.
fn answered(export: &Export, sink: &mut Sink) -> Option<ValueInfo> {
    let (outputs, id) = export.graph.outputs().first()?;
    let count = export.values.filter(|_| sink.take(VALUES))?;
    if count == export.graph.nodes()[*id].shape.iter().product::<usize>() {
        sink.put("Identity", &[outputs], VALUES, vec![]);
    } else {
        let [start, end, axis] = [("start", 0), ("end", count as i64), ("axis", 1)]
            .map(|(part, at)| sink.ints(&format!("{VALUES}/{part}"), &[at]));
        sink.put("Slice", &[outputs, &start, &end, &axis], VALUES, vec![]);
    }
    Some(info(VALUES, &[count], None))
}

/// Returns the matrix `[outputs, outputs]` that sums the outputs 1 to k of each attribute into its output k.
fn cumulative(sizes: &[usize]) -> Vec<f32> {
    let outputs: usize = sizes.iter().sum();
    let mut matrix = vec![0.0; outputs * outputs];
    let mut first = 0;
    for size in sizes {
        for from in first + 1..first + size {
            matrix[from * outputs..][from..first + size].fill(1.0);
        }
        first += size;
    }
    matrix
}

/// Divides the logarithms of probabilities by the temperature, attribute by attribute.
fn temper(temperature: f64, sizes: &[usize], plain: &str, sink: &mut Sink) {
    let name = |part: &str| format!("{PROBABILITIES}/{part}");
    let least = sink.floats(&name("least"), &[], &[f32::MIN_POSITIVE]);
    let inverse = sink.floats(&name("inverse"), &[], &[(1.0 / temperature) as f32]);
    let above = sink.step("Clip", &[plain, &least], &name("above"), vec![]);
    let logarithm = sink.step("Log", &[&above], &name("logarithm"), vec![]);
    let scaled = sink.step("Mul", &[&logarithm, &inverse], &name("scaled"), vec![]);
    softmax(sizes, &scaled, PROBABILITIES, sink);
}

/// Takes the softmax of each attribute.
fn softmax(sizes: &[usize], from: &str, to: &str, sink: &mut Sink) {
    let name = |part: &str| format!("{PROBABILITIES}/{part}");
    if sizes.len() == 1 {
        return sink.put("Softmax", &[from], to, vec![int("axis", 1)]);
    }
    let axis = sink.ints(&name("axis"), &[1]);
    let (mut start, mut parts) = (0, vec![]);
    for size in sizes {
        let ends = [start, start + *size as i64].map(|end| sink.ints(&name("end"), &[end]));
        let part = sink.step("Slice", &[from, &ends[0], &ends[1], &axis], &name("part"), vec![]);
        parts.push(sink.step("Softmax", &[&part], &name("softmax"), vec![int("axis", 1)]));
        start += *size as i64;
    }
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    sink.put("Concat", &parts, to, vec![int("axis", 1)]);
}
