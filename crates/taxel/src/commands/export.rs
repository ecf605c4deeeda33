//! `taxel export`: a model as ONNX.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::onnx::{IR_VERSION, OPSET};
use taxel::{Exported, ExportedInput, Model};

use crate::CommandResult;
use crate::commands::arguments::network::{existing, is_file, weighted};
use crate::outln;
use crate::terminal::messages::note;

/// Writes a trained model as an ONNX file, for onnxruntime, TensorRT, tract and others.
///
/// The file takes any number of samples and has the outputs `logits` and `probabilities`. Where ONNX can say the encoding
/// (z-scores, full scale, the order of axes) it takes raw samples, as the sensor gives them. Gramian fields, quantile codes
/// and NumaTac series have to be computed before; the command says so. Classes, unit and loss are in the file's metadata.
///
/// MODEL may also be a network without encoding: a file that `taxel import` wrote, or a name of the zoo with --weights.
/// Baselines are refused. docs/onnx.md has the operations and five lines of Python that run the file.
#[derive(Args)]
#[command(after_help = "Examples:  taxel export model.safetensors --output model.onnx
           taxel export resnet18 -o resnet18.onnx --weights resnet18.safetensors --set classes=1000")]
pub struct Export {
    /// A model made by `taxel fit`, or one of a run folder's models/.
    model: String,
    /// The ONNX file to write.
    #[arg(long, short, value_name = "FILE", required_unless_present = "old_output")]
    output: Option<PathBuf>,
    /// The place of the ONNX file until version 0.1.
    #[arg(hide = true, conflicts_with = "output")]
    old_output: Option<PathBuf>,
    /// Weights of a network of the zoo, by its tensor names; a file has its own.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    weights: Option<PathBuf>,
    /// A setting of the network in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Export {
    pub fn run(self) -> CommandResult {
        let Some(output) = self.output.as_ref().or(self.old_output.as_ref()) else {
            return Err("--output is missing; name the ONNX file to write".into());
        };
        let is_model = self.weights.is_none() && is_file(&self.model);
        let exported = if is_model { self.file(output)? } else { self.without_encoding(output)? };
        outln!("{}: opset {OPSET}, IR version {IR_VERSION}", output.display());
        for ExportedInput { name, shape, encoded } in exported.inputs {
            let takes = encoded.map_or("raw readings".to_string(), |encoding| {
                format!("NOT raw readings, but {encoding}: encode them before")
            });
            outln!("input `{name}` [batch, {}]: {takes}", sizes(&shape));
        }
        outln!("outputs: {}", exported.outputs.join(", "));
        Ok(ExitCode::SUCCESS)
    }

    fn file(&self, output: &Path) -> Result<Exported, Box<dyn std::error::Error>> {
        let path = existing(&self.model)?;
        let is_network = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("onnx"))
            || taxel_checkpoint::read_network(path)?.is_some();
        if is_network {
            return self.without_encoding(output);
        }
        let model = Model::open(path)?;
        let exported = taxel::export(&model, output)?;
        if model.card().guard.is_some() {
            note("note: the model's guard is not in the file: broken channels reach the network as they are");
        }
        Ok(exported)
    }

    /// Writes a network whose encoding is not known.
    fn without_encoding(&self, output: &Path) -> Result<Exported, Box<dyn std::error::Error>> {
        let (graph, weights) = weighted(&self.model, &self.set, self.weights.as_deref())?;
        taxel::onnx::write(output, &taxel::onnx::Export::new(&graph, &weights))?;
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
