//! The one error of files.

use std::fmt::{self, Display};
use std::io;
use std::path::Path;

use crate::printable::printable;

/// A file or folder that cannot be used as asked: `file: place: reason`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileError {
    /// The path as the user gave it.
    pub file: String,
    /// Line, key, sample or member inside the file; empty where the whole file is meant.
    pub place: String,
    /// The problem, and how to fix it.
    pub reason: String,
    /// Kind of the system's refusal; none where the content is wrong.
    pub kind: Option<io::ErrorKind>,
}

impl FileError {
    /// Refuses the content of `file`.
    pub fn new(file: &Path, reason: impl Into<String>) -> Self {
        let file = file.display().to_string();
        FileError { file, place: String::new(), reason: reason.into(), kind: None }
    }

    /// Refuses a path to read where nothing is, in the same words everywhere.
    pub fn missing(file: &Path) -> Self {
        FileError {
            kind: Some(io::ErrorKind::NotFound),
            ..FileError::new(file, "no such file or folder; check the path")
        }
    }

    /// Reports what the system said when `file` was to be `action` (`read`, `written`, `created`, `removed`).
    pub fn io(file: &Path, action: &str, source: &io::Error) -> Self {
        if source.kind() == io::ErrorKind::NotFound && action == "read" {
            return FileError::missing(file);
        }
        FileError {
            kind: Some(source.kind()),
            ..FileError::new(file, format!("cannot be {action}: {source}"))
        }
    }

    /// Adds the place inside the file.
    pub fn at(self, place: impl Display) -> Self {
        FileError { place: place.to_string(), ..self }
    }
}

impl Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FileError { file, place, reason, .. } = self;
        // Names out of files go to terminals.
        let [file, place, reason] = [file, place, reason].map(|text| printable(text));
        if place.is_empty() { write!(f, "{file}: {reason}") } else { write!(f, "{file}: {place}: {reason}") }
    }
}

impl std::error::Error for FileError {}

/// Says in words why the system refused, without the number of its error.
pub fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    let words = text.split(" (os error").next().unwrap_or_default();
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_names_file_place_and_reason() {
        let file = Path::new("runs/a.csv");
        let error = FileError::new(file, "holds no rows; record again");
        assert_eq!(error.to_string(), "runs/a.csv: holds no rows; record again");
        assert_eq!(error.at("line 3").to_string(), "runs/a.csv: line 3: holds no rows; record again");
        let error = FileError::io(file, "read", &io::Error::from(io::ErrorKind::NotFound));
        assert_eq!(error.to_string(), "runs/a.csv: no such file or folder; check the path");
        assert_eq!(error.kind, Some(io::ErrorKind::NotFound));
        let too_many = io::Error::from_raw_os_error(24);
        assert_eq!(reason(&too_many), "too many open files");
        assert_eq!(reason(&io::Error::from(io::ErrorKind::PermissionDenied)), "permission denied");
        let error = FileError::io(file, "read", &io::Error::from(io::ErrorKind::PermissionDenied));
        assert_eq!(error.to_string(), "runs/a.csv: cannot be read: permission denied");
        let error = FileError::new(Path::new("a\u{1b}[2J.csv"), "has columns x\u{7}, y").at("line\r1");
        assert_eq!(error.to_string(), "a\\u001b[2J.csv: line\\u000d1: has columns x\\u0007, y");
    }
}
