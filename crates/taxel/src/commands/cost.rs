//! `taxel cost`: the costs of a network, layer by layer.

use std::process::ExitCode;

use clap::Args;
use taxel::base::thousands;
use taxel_graph::Op;

use crate::CommandResult;
use crate::commands::arguments::network::named;
use crate::commands::arguments::output_format::OutputFormat;
use crate::terminal::tables;
use crate::{out, outln};

/// Counts the costs of a network: parameters, bytes, MACs, FLOPs and activation memory of each layer.
///
/// A MAC is one multiply-accumulate of a convolution, linear or recurrent layer; FLOPs are 2 MACs plus one
/// addition per bias and output value. Everything is for one sample in 32-bit floats. Layers have the numbers that ranges
/// of layers to freeze use, dropout left out: MATLAB's numbers in mobilenet-v2.
#[derive(Args)]
#[command(after_help = "Example:  taxel cost hybrid-resvgg --set classes=28")]
pub struct Cost {
    /// A network of `taxel zoo`; or a file: `.onnx`, or a `.safetensors` with a network or model in it.
    model: String,
    /// A setting of the network in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    format: OutputFormat,
}

impl Cost {
    pub fn run(self) -> CommandResult {
        let (graph, _) = named(&self.model, &self.set)?;
        let total = graph.cost();
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&taxel::costs(&graph))?);
            return Ok(ExitCode::SUCCESS);
        }
        let row = |number: Option<usize>, name: &str, kind: &str, shape: String, cost: taxel_graph::Cost| {
            vec![
                number.map_or(String::new(), |number| number.to_string()),
                name.into(),
                kind.into(),
                shape,
                thousands(cost.parameters),
                thousands(cost.bytes()),
                thousands(cost.macs),
                thousands(cost.flops),
                thousands(cost.activation_bytes()),
            ]
        };
        let mut rows: Vec<Vec<String>> = vec![];
        for (number, node) in taxel_zoo::matlab::layers(&graph) {
            rows.push(row(number, &node.name, node.op.kind(), tables::shape(&node.shape), node.cost()));
        }
        rows.push(row(None, "total", "", String::new(), total));
        let header =
            ["", "layer", "operation", "output", "parameters", "bytes", "MACs", "FLOPs", "activation bytes"];
        out!("{}", tables::table(&header, &rows, &[0, 4, 5, 6, 7, 8]));
        let inputs = graph.nodes().iter().filter(|n| n.op == Op::Input).map(|n| n.name.as_str());
        outln!(
            "\nBytes count parameters and batch-norm statistics. Inputs: {}.",
            inputs.collect::<Vec<_>>().join(", ")
        );
        Ok(ExitCode::SUCCESS)
    }
}
