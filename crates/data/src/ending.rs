//! The ending of a file's name.

use std::path::Path;

/// Checks whether a path ends in one of `endings`, in small or capital letters.
pub(crate) fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|found| endings.iter().any(|ending| found.eq_ignore_ascii_case(ending)))
}
