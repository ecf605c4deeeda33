//! `taxel export`: a model as ONNX.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use taxel::learn::read_weights;
use taxel::onnx::{IR_VERSION, OPSET};
use taxel::{Exported, ExportedInput, Model};

use super::network::{is_file, named};
use crate::Outcome;

/// Writes a trained model as ONNX, which onnxruntime, TensorRT, tract and others run.
///
/// The file takes any number of samples and answers `logits` and `probabilities`. Where ONNX can say the encoding (z-scores,
/// full scale, the order of axes) it takes raw readings, as the sensor gives them; Gramian fields, quantile codes and
/// NumaTac series have to be made before, and what is printed says so. Classes, unit and loss are in the file's metadata.
///
/// MODEL may also be a network without encoding: a file that `taxel import` wrote, or a name of the zoo with --weights.
/// Baselines are refused. docs/onnx.md has the operations and five lines of Python that run the file.
#[derive(Args)]
#[command(after_help = "Examples:  taxel export model.safetensors model.onnx
           taxel export resnet18 resnet18.onnx --weights resnet18.safetensors --set classes=1000")]
pub struct Export {
    /// A model made by `taxel fit`, or one of a run folder's models/.
    model: String,
    /// Where the ONNX file goes.
    output: PathBuf,
    /// Weights of a network of the zoo.
    #[arg(long)]
    weights: Option<PathBuf>,
    /// A configuration value of a network of the zoo: key=value.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Export {
    pub fn run(self) -> Outcome {
        let exported = match self.weights.is_none() && is_file(&self.model) {
            true => self.file()?,
            false => self.bare()?,
        };
        println!("{}: opset {OPSET}, IR version {IR_VERSION}", self.output.display());
        for ExportedInput { name, shape, encoded } in exported.inputs {
            let takes = encoded.map_or("raw readings".to_string(), |encoding| {
                format!("NOT raw readings, but {encoding}: encode them before")
            });
            println!("input `{name}` [batch, {}]: {takes}", sizes(&shape));
        }
        println!("outputs: {}", exported.outputs.join(", "));
        Ok(ExitCode::SUCCESS)
    }

    fn file(&self) -> Result<Exported, Box<dyn std::error::Error>> {
        let path = Path::new(&self.model);
        let is_network = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("onnx"))
            || taxel_checkpoint::read_network(path)?.is_some();
        match is_network {
            true => self.bare(),
            false => {
                let model = Model::open(path)?;
                let exported = taxel::export(&model, &self.output)?;
                if model.card().guard.is_some() {
                    eprintln!(
                        "note: the model's guard is not in the file: broken channels reach the network as they are"
                    );
                }
                Ok(exported)
            }
        }
    }

    /// A network alone.
    fn bare(&self) -> Result<Exported, Box<dyn std::error::Error>> {
        let (graph, own) = named(&self.model, &self.set)?;
        let weights = match (&self.weights, own) {
            (Some(path), _) => {
                let weights = read_weights(path)?;
                weights.check(&graph).map_err(|e| format!("{}: {e}", path.display()))?;
                weights
            }
            (None, Some(weights)) => weights,
            (None, None) => {
                let model = &self.model;
                let reason =
                    "is a network of the zoo: give its --weights, or export a model that `taxel fit` made";
                return Err(format!("{model}: {reason}").into());
            }
        };
        taxel::onnx::write(&self.output, &taxel::onnx::Export::new(&graph, &weights))?;
        let input = |node: &taxel_graph::Node| ExportedInput {
            name: node.name.clone(),
            shape: node.shape.clone(),
            encoded: Some("what the network reads (no encoding is known)"),
        };
        let outputs = graph.outputs().iter().map(|(name, _)| name.clone()).collect();
        Ok(Exported { inputs: graph.inputs().map(input).collect(), outputs })
    }
}

fn sizes(shape: &[usize]) -> String {
    shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}
