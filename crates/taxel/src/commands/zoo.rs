//! `taxel zoo`: every registered network.

use std::process::ExitCode;

use clap::Args;
use serde_json::json;
use taxel::learn::thousands;
use taxel_zoo::{Settings, built_in};

use crate::Outcome;
use crate::text;

/// Lists every registered network with family, paper, input shape and cost.
#[derive(Args)]
#[command(after_help = "Example:  taxel zoo --json")]
pub struct Zoo {
    /// One JSON array instead of a table.
    #[arg(long)]
    json: bool,
}

impl Zoo {
    pub fn run(self) -> Outcome {
        let mut rows = vec![];
        let mut list = vec![];
        for entry in built_in().entries() {
            let graph = entry.graph(&Settings::new())?;
            let cost = graph.cost();
            let inputs: Vec<String> = graph.inputs().map(|n| text::shape(&n.shape)).collect();
            rows.push(vec![
                entry.name.clone(),
                entry.family.clone(),
                entry.paper.clone(),
                inputs.join(" + "),
                thousands(cost.parameters),
                thousands(cost.macs),
            ]);
            let shapes: Vec<_> = graph.inputs().map(|n| json!({"name": n.name, "shape": n.shape})).collect();
            list.push(json!({
                "name": entry.name, "family": entry.family, "paper": entry.paper, "inputs": shapes,
                "parameters": cost.parameters, "bytes": cost.bytes(), "macs": cost.macs, "flops": cost.flops,
            }));
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&list)?);
        } else {
            let header = ["network", "family", "paper", "input", "parameters", "MACs"];
            print!("{}", text::table(&header, &rows, &[4, 5]));
        }
        Ok(ExitCode::SUCCESS)
    }
}
