//! The files of the repository, without what `.gitignore` leaves out.

use std::fs;
use std::path::{Path, PathBuf};

/// The top folder of the repository.
pub fn root() -> PathBuf {
    fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).unwrap()
}

/// Paths and names that `.gitignore` leaves out, and further ones that builds and tools leave behind.
fn ignored() -> Vec<String> {
    let listed = fs::read_to_string(root().join(".gitignore")).unwrap();
    let listed = listed.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(String::from);
    listed.chain(["target", "node_modules", "/fuzz/corpus", "/fuzz/artifacts"].map(String::from)).collect()
}

/// Tells whether git leaves out a path below the top folder.
pub fn is_ignored(path: &str) -> bool {
    ignored().iter().any(|pattern| match pattern.strip_prefix('/') {
        Some(place) => path == place || path.starts_with(&format!("{place}/")),
        None => path.split('/').any(|part| part == pattern),
    })
}

/// The paths below the top folder of all files with one of these endings, in the order of their names.
pub fn with_ending(endings: &[&str]) -> Vec<String> {
    let (root, mut found, mut open) = (root(), Vec::new(), vec![root()]);
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
            let hidden = name.split('/').next_back().is_some_and(|last| last.starts_with('.'));
            if hidden || is_ignored(&name) {
                continue;
            } else if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|ending| endings.contains(&ending.to_str().unwrap())) {
                found.push(name);
            }
        }
    }
    found.sort();
    found
}

/// Reads a file by its path below the top folder.
pub fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}
