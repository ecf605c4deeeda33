//! `taxel import`: an ONNX file as a network of taxel.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel::base::thousands;

use crate::Outcome;
use crate::text;

/// Reads a network that PyTorch or another framework exported as ONNX, and writes it as one .safetensors.
///
/// The file can then be named where networks are: `[[networks]] file = "mine.safetensors"` in a config trains, judges and
/// ships it like any of the zoo's (its last layer gets as many outputs as there are classes), `taxel cost
/// mine.safetensors` counts it, `taxel forward --model mine.safetensors` answers. All of them take the .onnx itself too
/// (`[[networks]] onnx = "mine.onnx"`); an import shows once what was understood.
///
/// An operation that taxel does not have is refused with its node; docs/onnx.md lists those that it has. Export in
/// evaluation (model.eval()), with samples first and fixed sizes after them.
#[derive(Args)]
#[command(
    after_help = "Example:  python -c 'torch.onnx.export(model.eval(), (torch.zeros(1, 5, 50),), \"mine.onnx\")'
          taxel import mine.onnx --output mine.safetensors
          taxel cost mine.safetensors"
)]
pub struct Import {
    /// The ONNX file; a .data file beside it is read where it names one.
    model: PathBuf,
    /// Where network and weights go, `.safetensors`.
    #[arg(long, short)]
    output: PathBuf,
}

impl Import {
    pub fn run(self) -> Outcome {
        if self.output.extension().is_none_or(|ending| ending != "safetensors") {
            return Err(format!("--output {}: must end in .safetensors", self.output.display()).into());
        }
        let read = taxel::onnx::read(&self.model)?;
        taxel_checkpoint::write_network(&self.output, &read.graph, &read.weights)?;
        let cost = read.graph.cost();
        let (parameters, macs) = (thousands(cost.parameters), thousands(cost.macs));
        println!("{}: {}, {parameters} parameters, {macs} MACs", self.output.display(), read.graph.name());
        for node in read.graph.inputs() {
            println!("input `{}`: {}", node.name, taxel_graph::describe(&node.shape));
        }
        for (name, id) in read.graph.outputs() {
            println!("output `{name}`: {}", text::shape(&read.graph.nodes()[*id].shape));
        }
        read.notes.iter().for_each(|note| println!("{note}"));
        Ok(ExitCode::SUCCESS)
    }
}
