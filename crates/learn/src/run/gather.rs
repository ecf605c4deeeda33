//! Folds of one run that were trained apart, put together in one folder.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result};
use crate::run::folder::{ENVIRONMENT, IDENTITIES, RunFolder};
use crate::run::records::FoldKey;

/// Puts the finished `folds` of several folders of one run into a new folder `out`. A run that is resumed there
/// finds them finished and writes what follows from them.
///
/// # Errors
/// A fold that is not finished, a file that cannot be read or written, an `out` that is not empty.
pub fn gather(out: &Path, folds: &[(RunFolder, FoldKey)]) -> Result<RunFolder> {
    let Some((first, _)) = folds.first() else {
        return Err(Error::folder(out, "there are no folds to put into it"));
    };
    for part in ["folds", "models"] {
        make(&out.join(part))?;
    }
    for name in IDENTITIES.iter().chain(&[ENVIRONMENT]).filter(|name| first.file(name).is_file()) {
        link(&first.file(name), &out.join(name))?;
    }
    let folder = RunFolder::open(out)?;
    for (from, key) in folds {
        link(&from.model_path(key), &folder.model_path(key))?;
        link(&from.timing_path(key), &folder.timing_path(key))?;
        link(&from.record_path(key), &folder.record_path(key))?;
        let events = from.events_path(key);
        if events.is_dir() {
            make(&folder.events_path(key))?;
            for entry in fs::read_dir(&events).map_err(|e| Error::io(&events, "read", e))? {
                let path = entry.map_err(|e| Error::io(&events, "read", e))?.path();
                link(&path, &folder.events_path(key).join(path.file_name().unwrap_or_default()))?;
            }
        }
    }
    Ok(folder)
}

fn make(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(|e| Error::io(folder, "created", e))
}

/// Gives one file two names where the file system can, and copies it elsewhere.
fn link(from: &Path, to: &Path) -> Result<()> {
    match fs::hard_link(from, to) {
        // Copying a file onto another name of itself would empty it.
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => Err(Error::io(to, "linked", e)),
        Err(_) => fs::copy(from, to).map(|_| ()).map_err(|e| Error::io(from, "copied", e)),
        Ok(()) => Ok(()),
    }
}
