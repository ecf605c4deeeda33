//! `taxel zoo`: every registered network.

use std::process::ExitCode;

use clap::Args;
use taxel::base::thousands;
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
        if self.json {
            println!("{}", serde_json::to_string_pretty(&taxel::listing(built_in())?)?);
            return Ok(ExitCode::SUCCESS);
        }
        let mut rows = vec![];
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
        }
        let header = ["network", "family", "paper", "input", "parameters", "MACs"];
        print!("{}", text::table(&header, &rows, &[4, 5]));
        Ok(ExitCode::SUCCESS)
    }
}
