//! `taxel man`: the manual pages.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Command, CommandFactory, ValueHint};
use clap_mangen::Man;
use taxel::base::files::write_whole;

use crate::{Arguments, CommandResult, outln};

/// Writes a manual page for each command.
#[derive(Args)]
#[command(after_help = "Example:  taxel man --output ~/.local/share/man/man1 && man taxel-run")]
pub struct ManualPages {
    /// The folder to write the pages to; it is made where it is not there.
    #[arg(long, short, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    output: PathBuf,
}

impl ManualPages {
    pub fn run(self) -> CommandResult {
        let refuse = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
        std::fs::create_dir_all(&self.output).map_err(|error| refuse(&self.output, error))?;
        let mut tree = Arguments::command().disable_help_subcommand(true);
        tree.build();
        let pages = pages(&tree)?;
        for (name, text) in &pages {
            let path = self.output.join(name);
            write_whole(&path, text).map_err(|error| refuse(&path, error))?;
        }
        outln!("{} manual pages: {}", pages.len(), self.output.display());
        Ok(ExitCode::SUCCESS)
    }
}

/// Returns the pages of a command and of all below it: file name and text.
fn pages(command: &Command) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let page = Man::new(command.clone()).manual("taxel");
    let mut text = vec![];
    page.render(&mut text)?;
    let mut found = vec![(page.get_filename(), text)];
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        found.extend(pages(below)?);
    }
    Ok(found)
}
