//! `taxel completions`: what a shell needs to complete the command line.

use std::process::ExitCode;

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use crate::{Arguments, Outcome};

/// Prints completions for a shell.
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
    pub fn run(self) -> Outcome {
        let mut script = vec![];
        generate(self.shell, &mut Arguments::command(), "taxel", &mut script);
        print!("{}", String::from_utf8_lossy(&script));
        Ok(ExitCode::SUCCESS)
    }
}
