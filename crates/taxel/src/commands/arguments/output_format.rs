//! `--format`: how the result of a command is printed.

use clap::{Args, ValueEnum};

/// The `--format` of commands that print a text or JSON.
#[derive(Args)]
pub struct OutputFormat {
    /// How the result is printed: text to read, or json for programs.
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "text")]
    format: TextOrJson,
    /// The name of `--format json` until version 0.1.
    #[arg(long, hide = true, conflicts_with = "format")]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TextOrJson {
    Text,
    Json,
}

impl OutputFormat {
    /// Checks whether JSON is wanted.
    pub fn is_json(&self) -> bool {
        self.json || self.format == TextOrJson::Json
    }
}
