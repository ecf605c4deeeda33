//! `taxel import`: an ONNX file as a network of taxel.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::base::thousands;

use crate::CommandResult;
use crate::commands::arguments::paths::check_model_output;
use crate::outln;
use crate::terminal::tables;

/// Imports a network that PyTorch or another framework exported as ONNX.
///
/// The .safetensors that is written can be used where networks are named: `[[networks]] file = "mine.safetensors"` in a
/// config trains, judges and ships it like one of the zoo (its last layer gets as many outputs as there are classes),
/// `taxel cost mine.safetensors` counts it, `taxel forward --model mine.safetensors` computes its logits. All of them take
/// the .onnx itself too (`[[networks]] onnx = "mine.onnx"`); an import prints how the file was understood.
///
/// An operation that taxel does not have is refused with its node; docs/onnx.md lists all that it has. Export in evaluation
/// mode (model.eval()), with the batch axis first and fixed sizes after it.
#[derive(Args)]
#[command(
    after_help = "Example:  python -c 'torch.onnx.export(model.eval(), (torch.zeros(1, 5, 50),), \"mine.onnx\")'
          taxel import mine.onnx --output mine.safetensors
          taxel cost mine.safetensors"
)]
pub struct Import {
    /// The ONNX file; a .data file beside it is read where it names one.
    #[arg(value_hint = ValueHint::FilePath)]
    model: PathBuf,
    /// The network file to write, `.safetensors`.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
}

impl Import {
    pub fn run(self) -> CommandResult {
        check_model_output(&self.output)?;
        let read = taxel::onnx::read(&self.model)?;
        taxel_checkpoint::write_network(&self.output, &read.graph, &read.weights)?;
        let cost = read.graph.cost();
        let (parameters, macs) = (thousands(cost.parameters), thousands(cost.macs));
        outln!("{}: {}, {parameters} parameters, {macs} MACs", self.output.display(), read.graph.name());
        for node in read.graph.inputs() {
            outln!("input `{}`: {}", node.name, taxel_graph::describe(&node.shape));
        }
        for (name, id) in read.graph.outputs() {
            outln!("output `{name}`: {}", tables::shape(&read.graph.nodes()[*id].shape));
        }
        read.notes.iter().for_each(|note| outln!("{note}"));
        Ok(ExitCode::SUCCESS)
    }
}
