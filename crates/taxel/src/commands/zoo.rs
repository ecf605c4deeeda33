//! `taxel zoo`: every registered network.

use std::process::ExitCode;

use clap::Args;
use taxel::base::thousands;
use taxel_zoo::{Settings, built_in};

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::terminal::tables;
use crate::{out, outln};

/// Lists all networks with family, input shapes, cost and paper.
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
                inputs.join(" + "),
                thousands(cost.parameters),
                format!("{:.3}", cost.bytes() as f64 / f64::from(1 << 20)),
                thousands(cost.macs),
                thousands(cost.flops),
                entry.paper.clone(),
            ]);
        }
        let header = ["network", "family", "input", "parameters", "MiB", "MACs", "FLOPs", "paper"];
        out!("{}", tables::table(&header, &rows, &[3, 4, 5, 6]));
        Ok(ExitCode::SUCCESS)
    }
}
