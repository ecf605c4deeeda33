//! `taxel schema`: every key of a config.

use std::process::ExitCode;

use clap::Args;
use taxel::{Registry, experiment};

use crate::{CommandResult, out, outln};

/// Prints the JSON schema of a config: every key with its type, its default and its meaning.
///
/// An editor of TOML completes and checks the keys of a config whose first line is `#:schema ./taxel.schema.json`: a path
/// from the config's folder, or an address. `taxel init` writes both.
#[derive(Args)]
#[command(after_help = "Examples:  taxel schema > taxel.schema.json
           taxel schema --page > docs/config.md")]
pub struct Schema {
    /// Prints the same as a page to read, in Markdown.
    #[arg(long)]
    page: bool,
}

impl Schema {
    pub fn run(self) -> CommandResult {
        let registry = Registry::built_in();
        if self.page {
            out!("{}", experiment::page(&registry));
        } else {
            outln!("{}", serde_json::to_string_pretty(&experiment::schema(&registry))?);
        }
        Ok(ExitCode::SUCCESS)
    }
}
