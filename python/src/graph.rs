//! Networks as values: of the zoo, from files, or written down step by step.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use taxel::graph::{Extent, Scheme, Weights, describe};
use taxel::{Conv, Pool, Registry, Settings, costs, listing, onnx};
use taxel_checkpoint::{network_from_bytes, network_to_bytes, write_network};

use crate::raise::{raised, refused};
use crate::work::short;

/// A network, with its weights where it has some.
#[pyclass(frozen, module = "taxel._taxel")]
pub struct Graph {
    inner: taxel::Graph,
    weights: Option<Weights>,
    /// Notes of the reader: parts that were left out or renamed.
    #[pyo3(get)]
    notes: Vec<String>,
}

impl Graph {
    fn of(inner: taxel::Graph, weights: Option<Weights>) -> Self {
        Graph { inner, weights, notes: vec![] }
    }

    /// Returns its weights, or fresh ones.
    fn weighted(&self) -> Weights {
        let fresh = || Weights::init(&self.inner, Scheme::Pytorch, 0, "graph");
        self.weights.clone().unwrap_or_else(fresh)
    }
}

#[pymethods]
impl Graph {
    /// Makes a network of the zoo.
    #[staticmethod]
    fn zoo(py: Python<'_>, name: &str, settings: &str) -> PyResult<Self> {
        short(py, || {
            let settings: Settings = serde_json::from_str(settings).map_err(refused)?;
            let registry = Registry::built_in();
            let entry = registry.find(name).map_err(raised)?;
            Ok(Graph::of(entry.graph(&settings).map_err(raised)?, None))
        })
    }

    /// Reads a network from an `.onnx`, or from a `.safetensors` with a network or model in it.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        short(py, || {
            let (graph, weights) = taxel::experiment::read_network(&path).map_err(raised)?;
            Ok(Graph::of(graph, Some(weights)))
        })
    }

    /// Reads a network from the bytes of an ONNX model.
    #[staticmethod]
    fn from_onnx(py: Python<'_>, bytes: Vec<u8>, name: &str) -> PyResult<Self> {
        short(py, || {
            let read = onnx::from_bytes(bytes, name, None).map_err(|e| refused(format!("{name}: {e}")))?;
            Ok(Graph { inner: read.graph, weights: Some(read.weights), notes: read.notes })
        })
    }

    /// Reads the bytes that [`Graph::to_bytes`] returns.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8], weights: bool) -> PyResult<Self> {
        short(py, || {
            let read = network_from_bytes(bytes).map_err(refused)?;
            let (graph, stored) = read.ok_or_else(|| refused("these bytes hold no network"))?;
            Ok(Graph::of(graph, weights.then_some(stored)))
        })
    }

    /// Returns network and weights as the bytes of a `.safetensors`.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = short(py, || network_to_bytes(&self.inner, &self.weighted()).map_err(refused))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes network and weights as a `.safetensors`.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        short(py, || {
            let written = write_network(&path, &self.inner, &self.weighted());
            written.map_err(|e| raised(taxel::learn::Error::from(e)))
        })
    }

    /// Checks whether it has weights of its own.
    #[getter]
    fn has_weights(&self) -> bool {
        self.weights.is_some()
    }

    /// Returns its name.
    #[getter]
    fn name(&self) -> &str {
        self.inner.name()
    }

    /// Returns names and shapes of the inputs, batch axis left out.
    #[getter]
    fn inputs(&self) -> Vec<(String, Vec<usize>)> {
        self.inner.inputs().map(|node| (node.name.clone(), node.shape.clone())).collect()
    }

    /// Returns names and shapes of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<(String, Vec<usize>)> {
        let shape = |id: usize| self.inner.nodes()[id].shape.clone();
        self.inner.outputs().iter().map(|(name, id)| (name.clone(), shape(*id))).collect()
    }

    /// Returns its costs, as JSON.
    fn costs(&self) -> String {
        costs(&self.inner).to_string()
    }

    fn __repr__(&self) -> String {
        let inputs = self.inner.inputs().map(|node| format!("{}: {}", node.name, describe(&node.shape)));
        let inputs: Vec<String> = inputs.collect();
        format!(
            "<taxel.Graph {}: {}, {} parameters>",
            self.name(),
            inputs.join("; "),
            self.inner.parameter_count()
        )
    }
}

/// Lists every network of the zoo, as JSON.
#[pyfunction]
pub fn zoo(py: Python<'_>) -> PyResult<String> {
    short(py, || Ok(listing(&Registry::built_in()).map_err(raised)?.to_string()))
}

/// One size for every axis, or one each.
#[derive(FromPyObject)]
enum AxisSizes {
    One(usize),
    Each(Vec<usize>),
}

impl From<AxisSizes> for Extent {
    fn from(sizes: AxisSizes) -> Self {
        match sizes {
            AxisSizes::One(size) => Extent::All(size),
            AxisSizes::Each(sizes) => Extent::Each(sizes),
        }
    }
}

/// `"same"`, or zeros on both sides.
#[derive(FromPyObject)]
enum Edges {
    Named(String),
    Zeros(AxisSizes),
}

/// Number of the next network under construction.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// A network under construction.
#[pyclass(frozen, module = "taxel._taxel")]
pub struct Builder {
    inner: taxel::Network,
    /// Which one it is: flows of another one are refused.
    id: u64,
}

#[pymethods]
impl Builder {
    #[new]
    fn new(name: &str) -> Self {
        Builder { inner: taxel::Network::new(name), id: NEXT.fetch_add(1, Ordering::Relaxed) }
    }

    /// Adds an input of `shape`, batch axis left out.
    fn input(&self, name: &str, shape: Vec<usize>) -> PyResult<Flow> {
        self.step(self.inner.input(name, &shape))
    }

    /// Flows joined along channels.
    fn concat(&self, name: &str, flows: Vec<PyRef<'_, Flow>>) -> PyResult<Flow> {
        flows.iter().try_for_each(|flow| self.refuse_other(flow))?;
        let flows: Vec<&taxel::Flow> = flows.iter().map(|flow| &flow.inner).collect();
        self.step(self.inner.concat(name, &flows))
    }

    /// Returns the network with these outputs.
    fn finish(&self, outputs: Vec<(String, PyRef<'_, Flow>)>) -> PyResult<Graph> {
        outputs.iter().try_for_each(|(_, flow)| self.refuse_other(flow))?;
        let outputs: Vec<(&str, taxel::Flow)> =
            outputs.iter().map(|(name, flow)| (name.as_str(), flow.inner.clone())).collect();
        let graph = self.inner.clone().finish(&outputs).map_err(raised)?;
        Ok(Graph::of(graph, None))
    }
}

impl Builder {
    /// Returns the step, or why it does not fit.
    fn step(&self, flow: taxel::Flow) -> PyResult<Flow> {
        self.inner.check().map_err(raised)?;
        Ok(Flow { net: self.inner.clone(), id: self.id, inner: flow })
    }

    fn refuse_other(&self, flow: &Flow) -> PyResult<()> {
        if flow.id == self.id {
            Ok(())
        } else {
            Err(refused("a flow of another network; a network is made of its own inputs"))
        }
    }
}

/// The tensor that flows through a network under construction.
#[pyclass(frozen, module = "taxel._taxel")]
pub struct Flow {
    net: taxel::Network,
    id: u64,
    inner: taxel::Flow,
}

impl Flow {
    fn step(&self, flow: taxel::Flow) -> PyResult<Flow> {
        self.builder().step(flow)
    }

    fn builder(&self) -> Builder {
        Builder { inner: self.net.clone(), id: self.id }
    }
}

/// Returns a convolution without groups, with bias.
fn convolution(
    filters: usize,
    kernel: AxisSizes,
    stride: Option<AxisSizes>,
    padding: Option<Edges>,
    dilation: Option<AxisSizes>,
) -> PyResult<Conv> {
    let mut conv = Conv::new(filters, kernel);
    if let Some(stride) = stride {
        conv = conv.stride(stride);
    }
    if let Some(dilation) = dilation {
        conv = conv.dilation(dilation);
    }
    match padding {
        Some(Edges::Named(name)) if name == "same" => Ok(conv.same()),
        Some(Edges::Named(name)) if name != "valid" => {
            Err(refused(format!("padding = {name:?}: must be \"same\", \"valid\" or a number")))
        }
        Some(Edges::Zeros(zeros)) => Ok(conv.pad(zeros)),
        Some(Edges::Named(_)) | None => Ok(conv),
    }
}

fn window(
    kernel: AxisSizes,
    stride: Option<AxisSizes>,
    padding: Option<Edges>,
    round_up: bool,
) -> PyResult<Pool> {
    let mut pool = Pool::new(kernel);
    if let Some(stride) = stride {
        pool = pool.stride(stride);
    }
    match padding {
        Some(Edges::Zeros(zeros)) => pool = pool.pad(zeros),
        Some(Edges::Named(name)) => {
            return Err(refused(format!("padding = {name:?}: a pool takes zeros on both sides, a number")));
        }
        None => {}
    }
    Ok(if round_up { pool.round_up() } else { pool })
}

#[pymethods]
impl Flow {
    /// Returns the shape without the batch axis.
    #[getter]
    fn shape(&self) -> Vec<usize> {
        self.inner.shape()
    }

    /// Puts `prefix.` before the names of all nodes that follow.
    fn within(&self, prefix: &str) -> Flow {
        Flow { net: self.net.clone(), id: self.id, inner: self.inner.clone().within(prefix) }
    }

    /// Adds convolution `name` with so many `filters`; sizes are one number, or one per axis. `padding` is "same", or zeros
    /// on both sides.
    #[pyo3(signature = (name, filters, kernel, *, stride=None, padding=None, dilation=None, groups=1, bias=true))]
    #[expect(clippy::too_many_arguments, reason = "as many as PyTorch's")]
    fn conv(
        &self,
        name: &str,
        filters: usize,
        kernel: AxisSizes,
        stride: Option<AxisSizes>,
        padding: Option<Edges>,
        dilation: Option<AxisSizes>,
        groups: usize,
        bias: bool,
    ) -> PyResult<Flow> {
        let conv = convolution(filters, kernel, stride, padding, dilation)?.groups(groups);
        let conv = if bias { conv } else { conv.no_bias() };
        self.step(self.inner.conv(name, conv))
    }

    /// Adds convolution `prefix.conv`, batch norm `prefix.bn`, ReLU.
    #[pyo3(signature = (prefix, filters, kernel, *, stride=None, padding=None, dilation=None))]
    fn conv_bn_relu(
        &self,
        prefix: &str,
        filters: usize,
        kernel: AxisSizes,
        stride: Option<AxisSizes>,
        padding: Option<Edges>,
        dilation: Option<AxisSizes>,
    ) -> PyResult<Flow> {
        let conv = convolution(filters, kernel, stride, padding, dilation)?;
        self.step(self.inner.conv_bn_relu(prefix, conv))
    }

    /// Adds fully connected layer `name`.
    #[pyo3(signature = (name, outputs, *, bias=true))]
    fn linear(&self, name: &str, outputs: usize, bias: bool) -> PyResult<Flow> {
        let flow =
            if bias { self.inner.linear(name, outputs) } else { self.inner.linear_no_bias(name, outputs) };
        self.step(flow)
    }

    /// Adds batch normalisation `name`.
    fn batch_norm(&self, name: &str) -> PyResult<Flow> {
        self.step(self.inner.batch_norm(name))
    }

    /// Adds a rectified linear unit.
    fn relu(&self) -> PyResult<Flow> {
        self.step(self.inner.relu())
    }

    /// Applies a function of each value, by name: `relu6`, `sigmoid`, `tanh`, `hard_swish`.
    fn activation(&self, name: &str) -> PyResult<Flow> {
        let quoted = serde_json::Value::String(name.into());
        let function = serde_json::from_value(quoted).map_err(|e| refused(format!("activation: {e}")))?;
        self.step(self.inner.activation(function))
    }

    /// Adds dropout of that share of the values, in training.
    fn dropout(&self, probability: f32) -> PyResult<Flow> {
        self.step(self.inner.dropout(probability))
    }

    /// Adds LSTM layer `name`: channels × length to `hidden` features after the last step.
    fn lstm(&self, name: &str, hidden: usize) -> PyResult<Flow> {
        self.step(self.inner.lstm(name, hidden))
    }

    /// Adds GRU layer `name`: channels × length to `hidden` features after the last step.
    fn gru(&self, name: &str, hidden: usize) -> PyResult<Flow> {
        self.step(self.inner.gru(name, hidden))
    }

    /// Takes the maximum over windows; the stride is the kernel's size where nobody says it.
    #[pyo3(signature = (kernel, *, stride=None, padding=None, round_up=false))]
    fn max_pool(
        &self,
        kernel: AxisSizes,
        stride: Option<AxisSizes>,
        padding: Option<Edges>,
        round_up: bool,
    ) -> PyResult<Flow> {
        self.step(self.inner.max_pool(window(kernel, stride, padding, round_up)?))
    }

    /// Takes the mean over windows, as `max_pool`.
    #[pyo3(signature = (kernel, *, stride=None, padding=None, round_up=false, count_padding=true))]
    fn average_pool(
        &self,
        kernel: AxisSizes,
        stride: Option<AxisSizes>,
        padding: Option<Edges>,
        round_up: bool,
        count_padding: bool,
    ) -> PyResult<Flow> {
        let pool = window(kernel, stride, padding, round_up)?;
        self.step(self.inner.average_pool(if count_padding { pool } else { pool.ignore_padding() }))
    }

    /// Takes the mean over all axes but channels.
    fn global_average_pool(&self) -> PyResult<Flow> {
        self.step(self.inner.global_average_pool())
    }

    /// Turns all axes to features, channels first.
    fn flatten(&self) -> PyResult<Flow> {
        self.step(self.inner.flatten())
    }

    /// Channels of so many groups dealt out in turn.
    fn channel_shuffle(&self, groups: usize) -> PyResult<Flow> {
        self.step(self.inner.channel_shuffle(groups))
    }

    /// Adds another flow of the same shape: a residual connection.
    fn add(&self, other: PyRef<'_, Flow>) -> PyResult<Flow> {
        self.builder().refuse_other(&other)?;
        self.step(self.inner.add(&other.inner))
    }

    /// Joins it with another flow along channels: a dense connection.
    fn concat(&self, other: PyRef<'_, Flow>) -> PyResult<Flow> {
        self.builder().refuse_other(&other)?;
        self.step(self.inner.concat(&other.inner))
    }
}
