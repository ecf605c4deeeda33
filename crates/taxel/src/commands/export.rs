//! `taxel export`: a model as ONNX, or as C for microcontrollers.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum, ValueHint};
use taxel::judge::Room;
use taxel::onnx::{IR_VERSION, OPSET};
use taxel::{Exported, ExportedC, ExportedInput, Model};

use taxel::base::thousands;

use crate::CommandResult;
use crate::commands::arguments::bytes::bytes;
use crate::commands::arguments::network::{existing, is_file, weighted};
use crate::outln;
use crate::terminal::messages::note;

/// The form of an exported model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// An ONNX file.
    Onnx,
    /// A folder of C99 for microcontrollers.
    C,
}

/// Writes a trained model as an ONNX file, for onnxruntime, TensorRT, tract and others, or as C for microcontrollers.
///
/// The ONNX file takes any number of samples and has the outputs `logits` and `probabilities`, or `values`. Where ONNX can say the
/// encoding (z-scores, full scale, the order of axes, quantile codes, histories) it takes raw samples, as the sensor gives them.
/// Gramian fields and NumaTac series have to be computed before; the command says so. Classes, unit and loss are in the file's
/// metadata.
///
/// MODEL may also be a network without encoding: a file that `taxel import` wrote, or a name of the zoo with --weights.
/// Of the baselines MiniRocket and ridge can be exported. docs/onnx.md has the operations and five lines of Python that run the file.
///
/// With --format c a network in eight bits or in floats, MiniRocket or ridge becomes a folder that compiles as it is: C99 without malloc and libm, a test, and
/// what Arduino, PlatformIO, Zephyr and CMake expect. Networks on images have to be in eight bits. Its predictions have the bits of `taxel predict`
/// (docs/firmware.md). With --max-flash or --max-ram a model that needs more is refused with the numbers, and nothing is written.
#[derive(Args)]
#[command(after_help = "Examples:  taxel export model.safetensors --output model.onnx
           taxel export resnet18 -o resnet18.onnx --weights resnet18.safetensors --set classes=1000
           taxel export small.safetensors firmware/ --format c --name squeeze
           taxel export small.safetensors -o firmware/ --format c --max-flash 64k --max-ram 16k")]
pub struct Export {
    /// A model made by `taxel fit`, or one of a run folder's models/.
    model: String,
    /// The ONNX file to write, or the folder of C.
    #[arg(long, short, value_name = "PLACE", required_unless_present = "old_output")]
    output: Option<PathBuf>,
    /// The same without `--output`.
    #[arg(hide = true, conflicts_with = "output")]
    old_output: Option<PathBuf>,
    /// How the result is written: as ONNX, or as C for microcontrollers.
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "onnx")]
    format: Format,
    /// Name of the C library; without it that of the model.
    #[arg(long)]
    name: Option<String>,
    /// Flash of a microcontroller that the C has to fit, code and tables: 64k, 1M, or bytes.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    max_flash: Option<u64>,
    /// RAM of a microcontroller that the C has to fit, workspace and time steps: 16k, or bytes. Stack is left out.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    max_ram: Option<u64>,
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
            return Err("--output is missing; name the ONNX file or the folder to write".into());
        };
        match (self.format, &self.name) {
            (Format::C, _) => return self.c(output),
            (Format::Onnx, Some(_)) => return Err("--name belongs to --format c; leave it out".into()),
            (Format::Onnx, None) if self.max_flash.or(self.max_ram).is_some() => {
                return Err("--max-flash and --max-ram belong to --format c; leave them out".into());
            }
            (Format::Onnx, None) => {}
        }
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
        exported.remarks.iter().for_each(|remark| note(format!("note: {remark}")));
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

    /// Writes a folder of C.
    fn c(&self, folder: &Path) -> CommandResult {
        if self.weights.is_some() || !self.set.is_empty() {
            return Err("--weights and --set belong to networks without encoding, which do not become C; name a model".into());
        }
        let model = Model::open(existing(&self.model)?)?;
        let room = Room { max_flash: self.max_flash, max_ram: self.max_ram, ..Room::default() };
        let ExportedC { name, size, remarks } =
            taxel::export_c_within(&model, folder, self.name.as_deref(), room)?;
        let [flash, tables, ram, ring, macs] =
            [size.flash, size.tables, size.ram, size.ring, size.macs].map(|number| thousands(number as u64));
        outln!("{}: C99, functions taxel_{name}_..", folder.display());
        outln!("flash: about {flash} bytes on a Cortex-M, of which {tables} are tables");
        match size.ring {
            0 => outln!("RAM: {ram} bytes"),
            _ => outln!("RAM: {ram} bytes, and {ring} for the time steps of taxel_{name}_push"),
        }
        outln!("products of one prediction: {macs}");
        remarks.iter().for_each(|remark| note(format!("note: {remark}")));
        Ok(ExitCode::SUCCESS)
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
        Ok(Exported { inputs: graph.inputs().map(input).collect(), outputs, remarks: vec![] })
    }
}

fn sizes(shape: &[usize]) -> String {
    shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}
