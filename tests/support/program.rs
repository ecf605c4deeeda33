//! The program in a folder of its own.

use std::path::Path;
use std::process::{Command, Stdio};

/// Returns a call of the program whose output is read and whose input is empty.
pub fn taxel(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}
