//! `taxel completions`: completions of the command line for a shell.

use std::process::ExitCode;

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use crate::{Arguments, CommandResult, out};

/// Prints the completions of commands and options for a shell.
#[derive(Args)]
#[command(after_help = "Examples:  taxel completions bash > ~/.local/share/bash-completion/completions/taxel
           taxel completions zsh > ~/.zfunc/_taxel
           taxel completions fish > ~/.config/fish/completions/taxel.fish")]
pub struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    pub fn run(self) -> CommandResult {
        let mut script = vec![];
        generate(self.shell, &mut Arguments::command(), "taxel", &mut script);
        out!("{}", String::from_utf8_lossy(&script));
        Ok(ExitCode::SUCCESS)
    }
}
