//! `taxel forward`: the logits or features of a batch.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueHint};
use ndarray::{ArrayD, IxDyn};
#[cfg(feature = "candle")]
use taxel_devices::{Device, Model};
use taxel_engine::{EngineOptions, Evaluator};
use taxel_graph::{Graph, Weights};

use crate::CommandResult;
use crate::arrays::write_npy;
use crate::commands::arguments::network::weighted;
use crate::commands::arguments::threads::Threads;

/// Computes the logits of a batch of network inputs, or with --at the features of a node.
///
/// The network runs in evaluation mode.
///
/// Inputs come in the order of the network's inputs (`taxel zoo`), batch axis first. Weights are
/// `.safetensors` or, in a build with the cargo feature `candle`, a PyTorch `state_dict` (`.pth`); missing, extra
/// and misshaped tensors are refused.
#[derive(Args)]
#[command(after_help = "Example:  taxel forward --model hybrid-resvgg --weights w.safetensors \\
              --input signal.npy --input image.npy --output logits.npy\n          \
              taxel forward --model vgg16 --set classes=1000 --weights vgg16.safetensors --at classifier.3/relu \\
                --input images.npy --output features.npy")]
pub struct Forward {
    /// A network of `taxel zoo`; or a file: `.onnx`, or a `.safetensors` with a network or model in it.
    #[arg(long, value_name = "NETWORK")]
    model: String,
    /// Weights of a network of the zoo, by its tensor names; a file has its own.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    weights: Option<PathBuf>,
    /// The `.npy` of an input, [N, ...]; once per input of the network.
    #[arg(long, required = true, value_name = "FILE", value_hint = ValueHint::FilePath)]
    input: Vec<PathBuf>,
    /// The `.npy` to write, [N, classes] (features [N, ...]); of several outputs each goes to NAME.<output>.npy.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// The engine that computes: `native`, taxel's for CPUs, or `candle` in a build with that cargo feature.
    #[arg(long, default_value = "native", value_parser = backend)]
    backend: Backend,
    /// The node, or the block, whose output is wanted in place of the logits; `taxel cost` lists them.
    #[arg(long, value_name = "NODE")]
    at: Option<String>,
    /// A setting of the network in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    threads: Threads,
}

#[derive(Clone, Copy)]
enum Backend {
    Native,
    #[cfg(feature = "candle")]
    Candle,
}

fn backend(name: &str) -> Result<Backend, &'static str> {
    match name {
        "native" => Ok(Backend::Native),
        #[cfg(feature = "candle")]
        "candle" => Ok(Backend::Candle),
        #[cfg(not(feature = "candle"))]
        "candle" => Err("this build has no candle; build taxel with `--features candle`"),
        _ => Err("expected native or candle"),
    }
}

/// Samples per pass: bounds the memory whatever the size of the batch.
const CHUNK: usize = 64;

impl Forward {
    pub fn run(self) -> CommandResult {
        let (graph, weights) = self.network()?;
        let inputs = self.inputs(&graph)?;
        let samples = inputs[0].shape()[0];
        let threads = self.threads.count()?;
        let mut outputs: Vec<(String, Vec<f32>)> = vec![];
        let mut keep = |name: &str, values: &[f32]| match outputs.iter_mut().find(|(n, _)| n == name) {
            Some((_, all)) => all.extend_from_slice(values),
            None => outputs.push((name.into(), values.to_vec())),
        };
        let slices = |from: usize, n: usize| -> Vec<&[f32]> {
            let part = |a: &'_ ArrayD<f32>| (a.len() / samples * from, a.len() / samples * (from + n));
            inputs.iter().map(|a| &a.as_slice().unwrap_or_default()[part(a).0..part(a).1]).collect()
        };
        match self.backend {
            Backend::Native => {
                let batch = CHUNK.min(samples);
                let options = EngineOptions { batch, threads, ..EngineOptions::default() };
                let evaluator = Evaluator::new(&graph, &weights, options)?;
                let mut workspace = evaluator.workspace();
                for from in (0..samples).step_by(CHUNK) {
                    let n = CHUNK.min(samples - from);
                    evaluator.predict(&mut workspace, &slices(from, n), n)?;
                    workspace.outputs().for_each(|(name, values)| keep(name, values));
                }
            }
            #[cfg(feature = "candle")]
            Backend::Candle => {
                let model = Model::new(&graph, &weights, &device()?)?;
                for from in (0..samples).step_by(CHUNK) {
                    let n = CHUNK.min(samples - from);
                    for (name, values) in model.forward(&slices(from, n), n, false)? {
                        keep(&name, &values);
                    }
                }
            }
        }
        let several = outputs.len() > 1;
        for ((name, values), (_, id)) in outputs.into_iter().zip(graph.outputs()) {
            let path =
                if several { self.output.with_extension(format!("{name}.npy")) } else { self.output.clone() };
            let shape = [&[samples], graph.nodes()[*id].shape.as_slice()].concat();
            write_npy(&path, &ArrayD::from_shape_vec(IxDyn(&shape), values)?)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Reads the network, or the part of it up to --at, and its weights.
    fn network(&self) -> Result<(Graph, Weights), Box<dyn std::error::Error>> {
        let (graph, weights) = weighted(&self.model, &self.set, self.weights.as_deref())?;
        let Some(node) = &self.at else { return Ok((graph, weights)) };
        let part = graph.cut(node)?;
        let weights = weights.only(&part);
        Ok((part, weights))
    }

    /// Reads the inputs of `graph` in its order, with equally many samples.
    fn inputs(&self, graph: &Graph) -> Result<Vec<ArrayD<f32>>, Box<dyn std::error::Error>> {
        let nodes: Vec<_> = graph.inputs().collect();
        if self.input.len() != nodes.len() {
            let names: Vec<&str> = nodes.iter().map(|n| n.name.as_str()).collect();
            let given = self.input.len();
            return Err(format!("{} reads {} ({given} given)", self.model, names.join(" + ")).into());
        }
        let mut inputs = vec![];
        for (path, node) in self.input.iter().zip(&nodes) {
            inputs.push(read_input(path, &node.shape, &node.name)?);
        }
        let samples = inputs[0].shape()[0];
        for (path, array) in self.input.iter().zip(&inputs) {
            if array.shape()[0] != samples {
                let first = self.input[0].display();
                let (here, n) = (path.display(), array.shape()[0]);
                return Err(format!("{here}: {n} samples, but {first} has {samples}").into());
            }
        }
        Ok(inputs)
    }
}

fn read_input(path: &Path, shape: &[usize], name: &str) -> Result<ArrayD<f32>, Box<dyn std::error::Error>> {
    let array = taxel_data::read_npy(path)?;
    if array.ndim() == 0 || array.shape()[1..] != *shape || array.shape()[0] == 0 {
        let got = array.shape();
        let expected = taxel_graph::describe(shape);
        return Err(format!(
            "{}: shape {got:?} does not fit input `{name}`; expected at least one sample of {expected}, batch first",
            path.display()
        )
        .into());
    }
    Ok(array)
}

/// Opens the accelerator this build knows, else the CPU.
#[cfg(feature = "candle")]
fn device() -> Result<Device, Box<dyn std::error::Error>> {
    if cfg!(feature = "cuda") {
        Ok(Device::new_cuda(0)?)
    } else if cfg!(feature = "metal") {
        Ok(Device::new_metal(0)?)
    } else {
        Ok(Device::Cpu)
    }
}
