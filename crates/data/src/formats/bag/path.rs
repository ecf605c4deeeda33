//! Where a bag lies: one MCAP file, or the folder that rosbag2 makes of one recording.

use crate::layout::order::in_order;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Whether a path is a bag: an MCAP file, or the folder that rosbag2 makes of one recording.
pub(crate) fn is_bag(path: &Path) -> bool {
    is_part(path) || path.join("metadata.yaml").is_file() && parts(path).is_ok_and(|own| !own.is_empty())
}

fn is_part(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap")) && !path.is_dir()
}

/// The files of a bag, in the order in which they were recorded.
pub(crate) fn parts(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.into()]);
    }
    let io = |e: std::io::Error| Error::Io { file: path.display().to_string(), kind: e.kind() };
    let mut own = vec![];
    for entry in path.read_dir().map_err(io)? {
        own.push(entry.map_err(io)?.path());
    }
    own.retain(|path| is_part(path));
    Ok(in_order(own))
}
