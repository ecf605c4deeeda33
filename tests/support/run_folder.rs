//! The files that two equal runs share.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Every file below a run folder whose bytes are results.
pub fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_string();
            let is_time = ["timings.jsonl", "environment.json", ".lock"].contains(&name.as_str());
            if path.is_dir() {
                open.push(path);
            } else if !is_time && !name.ends_with(".timing.json") {
                files.insert(path.strip_prefix(folder).unwrap().into(), std::fs::read(&path).unwrap());
            }
        }
    }
    files
}
