//! `taxel inspect`: what a model says about itself.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel::Model;

use crate::Outcome;

/// Prints the card of a model file: what it reads and answers, what it was trained on, how it scored.
///
/// The file needs nothing beside it. Whether its tensors are those that the card was written for is checked.
#[derive(Args)]
#[command(after_help = "Example:  taxel inspect model.safetensors --json")]
pub struct Inspect {
    /// A model made by `taxel fit`, or one of a run folder's models/.
    model: PathBuf,
    /// The whole card as one JSON object, the network's graph included.
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub fn run(self) -> Outcome {
        let model = Model::open(&self.model)?;
        match self.json {
            true => println!("{}", serde_json::to_string_pretty(model.card())?),
            false => print!("{}", model.card()),
        }
        Ok(ExitCode::SUCCESS)
    }
}
