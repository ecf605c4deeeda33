//! The files of a bag: one MCAP file, or the folder that rosbag2 makes of one recording.

use crate::ending::has_ending;
use crate::layout::order::in_order;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Checks whether a path is a bag: an MCAP file, or the folder that rosbag2 makes of one recording.
pub fn is_bag(path: &Path) -> bool {
    is_part(path) || path.join("metadata.yaml").is_file() && parts(path).is_ok_and(|files| !files.is_empty())
}

fn is_part(path: &Path) -> bool {
    has_ending(path, &["mcap"]) && !path.is_dir()
}

/// Says how to make a recording that is no MCAP file readable: a compressed one, one of ROS 1, one in SQLite.
pub(crate) fn how_to_convert(path: &Path) -> Option<&'static str> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    if name == "metadata.yaml" {
        // Of the folder of a recording in another format.
        let beside = entries(path.parent()?).ok()?;
        return in_order(beside)
            .iter()
            .filter(|other| *other != path)
            .find_map(|other| how_to_convert(other));
    }
    let ends = |ending: &str| name.ends_with(ending);
    if ends(".mcap.zstd") || ends(".mcap.zst") {
        Some("is a compressed file; unpack it with zstd -d, and give the .mcap")
    } else if ends(".mcap.gz") || ends(".mcap.lz4") {
        Some("is a compressed file; unpack it, and give the .mcap")
    } else if ends(".bag") {
        Some(
            "is a bag of ROS 1; convert it with rosbags-convert (pip install rosbags): rosbags-convert --src FILE.bag --dst \
             FOLDER --dst-storage mcap",
        )
    } else if ends(".db3") || ends(".db3.zstd") {
        Some(
            "is a bag of ROS 2 in SQLite; convert it with mcap convert FILE.db3 FILE.mcap, or with ros2 bag convert",
        )
    } else {
        None
    }
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
