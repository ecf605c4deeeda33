//! A file is whole or not there.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::io::Write;

use taxel_base::files::{PartFile, is_part, remove_parts, write_piecewise, write_unflushed, write_whole};

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
fn a_half_written_file_of_a_killed_process_is_in_nobodys_way() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.json");
    for left in ["results.json.part", "results.json.a8Kq2x.part"] {
        fs::write(folder.path().join(left), "half of somethi").unwrap();
    }
    let others = ["results.json.bak", "results.jsonl.a8Kq2x.part"];
    for other in others {
        fs::write(folder.path().join(other), "stays").unwrap();
    }
    write_whole(&path, b"whole").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"whole");
    remove_parts(&path).unwrap();
    assert_eq!(names(folder.path()), ["results.json", others[0], others[1]]);
    assert!(remove_parts(&folder.path().join("missing/results.json")).is_ok());

    let mut living = PartFile::create(&path).unwrap();
    living.write_all(b"newer").unwrap();
    remove_parts(&path).unwrap();
    living.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"newer");
}

#[test]
fn writers_of_one_file_do_not_disturb_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.json");
    std::thread::scope(|scope| {
        for writer in 0..4u8 {
            let path = &path;
            scope.spawn(move || {
                (0..50).for_each(|_| {
                    remove_parts(path).unwrap();
                    write_unflushed(path, &[writer; 5000]).unwrap();
                });
            });
        }
    });
    let bytes = fs::read(&path).unwrap();
    assert_eq!((bytes.len(), bytes.iter().all(|byte| *byte == bytes[0])), (5000, true));
    assert_eq!(names(folder.path()), ["results.json"]);
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ours, other) = (folder.path().join("ours"), folder.path().join("other"));
    write_whole(&ours, b"bytes").unwrap();
    fs::write(&other, b"bytes").unwrap();
    let mode = |path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&other));
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
    let missing = write_whole(&folder.path().join("missing/results.json"), b"bytes").unwrap_err();
    assert_eq!(
        missing.raw_os_error().map(std::io::Error::from_raw_os_error).unwrap().to_string(),
        missing.to_string()
    );
}

#[test]
fn a_part_that_is_dropped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.csv");
    let mut part = PartFile::create(&path).unwrap();
    part.write_all(b"half").unwrap();
    let [name] = &names(folder.path())[..] else { panic!("one file") };
    assert!(name.starts_with("trials.csv.") && is_part(name.as_ref()), "{name}");
    drop(part);
    assert!(names(folder.path()).is_empty());
    let mut part = PartFile::create(&path).unwrap();
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
        let pieces = |file: &mut PartFile| file.write_all(b"bytes");
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
