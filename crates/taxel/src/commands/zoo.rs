//! `taxel zoo`: every registered network.

use std::process::ExitCode;

use clap::Args;
use taxel::base::thousands;
use taxel_zoo::{Settings, built_in};

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::terminal::tables;
use crate::{out, outln};

/// Lists all networks with family, paper, input shapes and cost.
#[derive(Args)]
#[command(after_help = "Example:  taxel zoo --format json")]
pub struct Zoo {
    #[command(flatten)]
    format: OutputFormat,
}

impl Zoo {
    pub fn run(self) -> CommandResult {
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&taxel::listing(built_in())?)?);
            return Ok(ExitCode::SUCCESS);
        }
        let mut rows = vec![];
        for entry in built_in().entries() {
            let graph = entry.graph(&Settings::new())?;
            let cost = graph.cost();
            let inputs: Vec<String> = graph.inputs().map(|n| tables::shape(&n.shape)).collect();
            rows.push(vec![
                entry.name.clone(),
                entry.family.clone(),
                entry.paper.clone(),
                inputs.join(" + "),
                thousands(cost.parameters),
                thousands(cost.macs),
            ]);
        }
        let header = ["network", "family", "paper", "input", "parameters", "MACs"];
        out!("{}", tables::table(&header, &rows, &[4, 5]));
        Ok(ExitCode::SUCCESS)
    }
}
