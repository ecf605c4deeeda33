//! Paths on the command line: those that are read have to exist, those of models end in `.safetensors`.

use std::ffi::OsStr;
use std::path::Path;

use clap::{ArgMatches, Command, ValueHint};
use taxel::base::FileError;

/// Arguments with paths that a command writes, or that another machine has.
const NOT_READ: [&str; 4] = ["html", "old_output", "output", "program"];

/// Checks the paths that a command reads, so that a missing one is refused in the same words by all commands: every
/// path on the command line that is not in [`NOT_READ`]. One with the hint of a file or a folder has to be that.
///
/// # Errors
/// A path where nothing is, a folder in place of a file, a file in place of a folder.
pub fn check_inputs(command: &Command, matches: &ArgMatches) -> Result<(), FileError> {
    if let Some((name, matches)) = matches.subcommand() {
        return command.find_subcommand(name).map_or(Ok(()), |command| check_inputs(command, matches));
    }
    for argument in command.get_arguments().filter(|argument| !NOT_READ.contains(&argument.get_id().as_str()))
    {
        let hint = argument.get_value_hint();
        let is_path = matches!(hint, ValueHint::AnyPath | ValueHint::FilePath | ValueHint::DirPath);
        let values = if is_path { matches.get_raw(argument.get_id().as_str()) } else { None };
        values.into_iter().flatten().try_for_each(|path: &OsStr| check(Path::new(path), hint))?;
    }
    Ok(())
}

fn check(path: &Path, hint: ValueHint) -> Result<(), FileError> {
    match path.try_exists() {
        Ok(true) => {}
        Ok(false) if taxel::data::exists(path) => {}
        Ok(false) => return Err(FileError::missing(path)),
        Err(error) => return Err(FileError::io(path, "read", &error)),
    }
    match hint {
        ValueHint::FilePath if path.is_dir() => {
            Err(FileError::new(path, "is a folder, not a file; give the path of a file"))
        }
        ValueHint::DirPath if !path.is_dir() => {
            Err(FileError::new(path, "is a file, not a folder; give the path of a folder"))
        }
        _ => Ok(()),
    }
}

/// Checks the name of a model to write before anything is computed.
///
/// # Errors
/// A name that does not end in `.safetensors`, a folder that does not exist.
#[cfg(feature = "lab")]
pub fn check_model_output(output: &Path) -> Result<(), FileError> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir());
    if let Some(folder) = folder {
        return Err(FileError::new(
            folder,
            format!("is no folder, and {} is to be in it; make it", output.display()),
        ));
    }
    if output.extension().is_some_and(|ending| ending == "safetensors") {
        return Ok(());
    }
    let name = output.with_extension("safetensors");
    Err(FileError::new(output, format!("a model is a .safetensors file: --output {}", name.display())))
}
