//! A file is whole or not there.

#![allow(clippy::unwrap_used)]

use std::fs;

use taxel_files::{PART, write_whole};

fn names(folder: &std::path::Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.json");
    for bytes in [&b"the first and longer one"[..], b"the second", b""] {
        write_whole(&path, bytes).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
        assert_eq!(names(folder.path()), ["results.json"], "nothing else is left");
    }
}

#[test]
fn a_half_written_file_of_a_killed_process_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(format!("results.json{PART}")), "half of somethi").unwrap();
    write_whole(&folder.path().join("results.json"), b"whole").unwrap();
    assert_eq!(names(folder.path()), ["results.json"]);
    assert_eq!(fs::read(folder.path().join("results.json")).unwrap(), b"whole");
}

#[test]
fn a_file_that_cannot_be_renamed_leaves_no_part() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("inside"), "stays").unwrap();
    assert!(write_whole(&taken, b"bytes").is_err(), "a folder stands there");
    assert_eq!(names(folder.path()), ["taken"]);
    assert_eq!(fs::read(taken.join("inside")).unwrap(), b"stays");
    assert!(write_whole(&folder.path().join("missing/results.json"), b"bytes").is_err());
}
