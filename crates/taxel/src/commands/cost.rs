//! `taxel cost`: the costs of a network, layer by layer.

use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use taxel::base::thousands;
use taxel::{Core, Footprint, Model, Part};
use taxel_graph::Op;

use crate::CommandResult;
use crate::commands::arguments::network::{existing, is_file, named};
use crate::commands::arguments::output_format::OutputFormat;
use crate::terminal::tables;
use crate::{out, outln};

/// Counts the costs of a network: parameters, bytes, MACs, FLOPs and activation memory of each layer.
///
/// A MAC is one multiply-accumulate of a convolution, linear or recurrent layer; FLOPs are 2 MACs plus one
/// addition per bias and output value. Everything is for one sample in 32-bit floats. Layers have the numbers that ranges
/// of layers to freeze use, dropout left out: MATLAB's numbers in mobilenet-v2.
///
/// With --target a network in eight bits or in floats, MiniRocket or ridge says how much flash and RAM it takes as C on a microcontroller, and
/// about how many instructions one prediction takes. It says whether a large part with that core has the memory. A network in floats is refused on a
/// core without FPU. Instructions are not cycles (docs/firmware.md).
#[derive(Args)]
#[command(after_help = "Examples:  taxel cost hybrid-resvgg --set classes=28
           taxel cost small.safetensors --target m4f")]
pub struct Cost {
    /// A network of `taxel zoo`; or a file: `.onnx`, or a `.safetensors` with a network or model in it.
    model: String,
    /// A setting of the network in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// A microcontroller's core: flash, RAM and instructions of the model as C.
    #[arg(long, value_name = "CORE", value_parser = PossibleValuesParser::new(Core::ALL.map(Core::name)))]
    target: Option<String>,
    #[command(flatten)]
    format: OutputFormat,
}

impl Cost {
    pub fn run(self) -> CommandResult {
        if let Some(core) = self.target.as_deref().and_then(core) {
            return self.on(core);
        }
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

    /// Prints what the model takes on a core.
    fn on(&self, core: Core) -> CommandResult {
        if !self.set.is_empty() || !is_file(&self.model) {
            return Err(
                "--target counts a model file, which has its own settings: name one that `taxel fit` made"
                    .into(),
            );
        }
        let model = Model::open(existing(&self.model)?)?;
        let footprint = taxel::footprint(&model, core)?;
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&footprint)?);
            return Ok(ExitCode::SUCCESS);
        }
        let Footprint { flash_bytes, table_bytes, ram_bytes, ring_bytes, products, instructions, .. } =
            footprint;
        let fits = fits(&footprint);
        let [flash, tables, ram, ring] = [flash_bytes, table_bytes, ram_bytes, ring_bytes].map(thousands);
        outln!("{} on {core}, as C", model.card().name);
        let soft = if core.has_floats() { "" } else { "; the compiler's float routines come on top" };
        outln!("flash         about {flash} bytes, of which {tables} are tables{soft}");
        match ring_bytes {
            0 => outln!("RAM           {ram} bytes"),
            _ => outln!("RAM           {ram} bytes, and {ring} for the time steps of push"),
        }
        outln!("fits          {fits}");
        outln!("products      {}", thousands(products));
        match instructions {
            Some(count) => outln!(
                "instructions  about {} of one prediction, {:.2} per product; instructions, not cycles",
                thousands(count),
                count as f64 / products.max(1) as f64
            ),
            None => outln!("instructions  not counted for this kind of model"),
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Says whether a large part with the core has the memory, and what is missing.
fn fits(footprint: &Footprint) -> String {
    let Part { name, flash_bytes, ram_bytes } = footprint.part;
    let taken = [footprint.flash_bytes, footprint.ram_bytes + footprint.ring_bytes];
    let over = |what: &str, taken: u64, there: u64| {
        (taken > there).then(|| format!("{} bytes of {what} are missing", thousands(taken - there)))
    };
    let missing = [over("flash", taken[0], flash_bytes), over("RAM", taken[1], ram_bytes)];
    let missing: Vec<String> = missing.into_iter().flatten().collect();
    let [flash, ram] = [flash_bytes, ram_bytes].map(|bytes| thousands(bytes / 1024));
    let verdict = if missing.is_empty() { "yes".into() } else { format!("NO, {}", missing.join(" and ")) };
    format!("{verdict}: a large part with this core, {name}, has {flash} KB of flash and {ram} KB of RAM")
}

fn core(name: &str) -> Option<Core> {
    Core::ALL.into_iter().find(|core| core.name() == name)
}
