//! A folder that is whole or not there.

use std::fs;
use std::io;
use std::path::Path;

use crate::error::{Error, Result};
use crate::library::CFile;

/// Writes `files` into the new folder `path`: below another name first, which it gets when all are there. A folder that taxel
/// has exported before is replaced.
///
/// # Errors
/// [`Error::Folder`] where something else is at `path`, or for an error of the system.
pub fn write_folder(path: &Path, files: &[CFile]) -> Result<()> {
    let refuse = |reason: String| Error::Folder { path: path.display().to_string(), reason };
    let system = |error: io::Error| refuse(error.to_string());
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().ok_or_else(|| refuse("it names no folder".into()))?;
    let is_old = fs::symlink_metadata(path).is_ok();
    if is_old && !is_ours(path, files).map_err(system)? {
        return Err(refuse("it holds other files; name a new folder".into()));
    }
    let mut prefix = name.to_owned();
    prefix.push(".");
    let part = tempfile::Builder::new().prefix(&prefix).suffix(".part").tempdir_in(parent).map_err(system)?;
    let fresh = part.path().join("new");
    for file in files {
        let at = fresh.join(&file.path);
        fs::create_dir_all(at.parent().unwrap_or(&fresh)).map_err(system)?;
        taxel_base::files::write_whole(&at, file.text.as_bytes()).map_err(system)?;
    }
    if is_old {
        // The old folder goes with the temporary one.
        fs::rename(path, part.path().join("old")).map_err(system)?;
    }
    fs::rename(&fresh, path).map_err(system)?;
    taxel_base::files::sync_folder(path).map_err(system)
}

/// Checks whether a folder is empty or holds files of the same names alone.
fn is_ours(path: &Path, files: &[CFile]) -> io::Result<bool> {
    let mut waiting = vec![path.to_path_buf()];
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let at = entry.path();
            let below = at.strip_prefix(path).unwrap_or(&at).to_string_lossy().replace('\\', "/");
            if entry.file_type()?.is_dir() {
                if !files.iter().any(|file| file.path.starts_with(&format!("{below}/"))) {
                    return Ok(false);
                }
                waiting.push(at);
            } else if !files.iter().any(|file| file.path == below) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn folders_are_replaced_whole_and_others_are_left_alone() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("out");
        let file = |text: &str| CFile { path: "src/a.c".into(), text: text.into() };
        write_folder(&path, &[file("1")]).unwrap();
        write_folder(&path, &[file("2")]).unwrap();
        assert_eq!(fs::read_to_string(path.join("src/a.c")).unwrap(), "2");
        fs::write(path.join("mine.txt"), "x").unwrap();
        let error = write_folder(&path, &[file("3")]).unwrap_err().to_string();
        assert!(error.contains("holds other files"), "{error}");
        assert_eq!(fs::read_to_string(path.join("src/a.c")).unwrap(), "2");
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1, "nothing half-written is left");
    }
}
