//! A file is whole or not there.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::Write;

use taxel_base::files::{Part, part_of, write_piecewise, write_unflushed, write_whole};

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
    for (i, bytes) in
        [&b"the first and longer one"[..], b"the second", b"", b"the last"].into_iter().enumerate()
    {
        let write = if i % 2 == 0 { write_whole } else { write_unflushed };
        write(&path, bytes).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
        assert_eq!(names(folder.path()), ["results.json"], "nothing else is left");
    }
}

#[test]
fn a_file_whose_pieces_end_early_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("manifest.jsonl");
    write_whole(&path, b"old").unwrap();
    let ended = write_piecewise(&path, |file| {
        file.write_all(b"half")?;
        Err(std::io::Error::other("no more"))
    });
    assert_eq!(ended.unwrap_err().to_string(), "no more");
    assert_eq!(
        (fs::read(&path).unwrap().as_slice(), names(folder.path())),
        (&b"old"[..], vec!["manifest.jsonl".into()])
    );
    write_piecewise(&path, |file| (0..3).try_for_each(|i| writeln!(file, "{i}"))).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"0\n1\n2\n");
}

#[test]
fn a_half_written_file_of_a_killed_process_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.json");
    assert_eq!(part_of(&path), folder.path().join("results.json.part"));
    fs::write(part_of(&path), "half of somethi").unwrap();
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

#[test]
fn a_part_that_is_dropped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.csv");
    let mut part = Part::create(&path).unwrap();
    part.write_all(b"half").unwrap();
    assert_eq!(names(folder.path()), ["trials.csv.part"]);
    drop(part);
    assert!(names(folder.path()).is_empty());
    let mut part = Part::create(&path).unwrap();
    part.write_all(b"whole").unwrap();
    part.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"whole");
    assert_eq!(names(folder.path()), ["trials.csv"]);
}

/// Where the system has no such device there is nothing to test.
#[cfg(target_os = "linux")]
#[test]
fn a_device_is_written_and_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    // Behind a link, so that a mistake costs the link and not the device.
    for (device, is_full) in [("/dev/full", true), ("/dev/null", false)] {
        let link = folder.path().join(device.rsplit('/').next().unwrap());
        std::os::unix::fs::symlink(device, &link).unwrap();
        let pieces = |file: &mut Part| file.write_all(b"bytes");
        assert_eq!(write_whole(&link, b"bytes").is_err(), is_full, "{device}");
        assert_eq!(write_piecewise(&link, pieces).is_err(), is_full, "{device}");
        assert!(fs::metadata(&link).unwrap().file_type().is_char_device(), "{device}");
    }
    assert_eq!(names(folder.path()), ["full", "null"]);
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    fs::write(&file, "before").unwrap();
    std::os::unix::fs::symlink("file", &link).unwrap();
    write_whole(&link, b"after").unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"after");
    write_piecewise(&link, |file| file.write_all(b"in pieces")).unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"in pieces");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
}
