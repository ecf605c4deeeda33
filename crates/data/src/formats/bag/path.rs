//! The files of a bag: one MCAP file, or the folder that rosbag2 makes of one recording.

use crate::ending::has_ending;
use crate::layout::order::in_order;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Checks whether a path is a bag: an MCAP file, or the folder that rosbag2 makes of one recording.
pub(crate) fn is_bag(path: &Path) -> bool {
    is_part(path) || path.join("metadata.yaml").is_file() && parts(path).is_ok_and(|files| !files.is_empty())
}

fn is_part(path: &Path) -> bool {
    has_ending(path, &["mcap"]) && !path.is_dir()
}

/// Lists the files of a bag, in the order in which they were recorded.
pub(crate) fn parts(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.into()]);
    }
    let mut files = entries(path)?;
    files.retain(|path| is_part(path));
    Ok(in_order(files))
}

/// Lists the files and folders in a folder, in no order.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let read = folder.read_dir().and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    read.map_err(Error::io(folder))
}
