//! Names of files that are asked for in every build, with their reader or without.

use crate::reader::has_ending;
use std::path::Path;

/// What the names of image files end in.
pub(crate) const IMAGE: &[&str] = &["png", "jpg", "jpeg"];

/// Whether a path is named like an image.
pub(crate) fn is_image(path: &Path) -> bool {
    has_ending(path, IMAGE)
}

/// Whether a folder is a data set of LeRobot.
pub(crate) fn is_lerobot(path: &Path) -> bool {
    path.join("meta/info.json").is_file() && path.join("data").is_dir()
}
