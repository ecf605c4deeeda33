//! Names of files that every build knows, with their reader or without.

use crate::ending::has_ending;
use std::path::Path;

/// Endings of image files.
pub(crate) const IMAGE: &[&str] = &["png", "jpg", "jpeg"];

/// Checks whether a path is named like an image.
pub(crate) fn is_image(path: &Path) -> bool {
    has_ending(path, IMAGE)
}

/// Checks whether a folder is a data set of LeRobot.
pub(crate) fn is_lerobot(path: &Path) -> bool {
    path.join("meta/info.json").is_file() && path.join("data").is_dir()
}
