//! Text files as editors, spreadsheets and loggers write them; labels that look alike; splits that are folders.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::files;
use std::fs;
use std::path::Path;
use taxel_data::{Dataset, ReadOptions, Targets, check, load};
use tempfile::{TempDir, tempdir};

fn with(list: &[(&str, &str)]) -> TempDir {
    let folder = tempdir().unwrap();
    files(folder.path(), list);
    folder
}

fn read(path: &Path) -> Dataset {
    load(path, &ReadOptions::default()).expect("the text is read")
}

fn refused(path: &Path) -> String {
    load(path, &ReadOptions::default()).unwrap_err().to_string()
}

/// Text in UTF-16 with its mark.
fn utf16(text: &str, big: bool) -> Vec<u8> {
    let bytes = |unit: u16| if big { unit.to_be_bytes() } else { unit.to_le_bytes() };
    format!("\u{feff}{text}").encode_utf16().flat_map(bytes).collect()
}

const TABLE: &str = "force,travel,label\n1.5,0.2,a\n2.5,0.3,b\n1.6,0.2,a\n2.4,0.4,b\n";

/// Sets of every kind of text file: the path to read, and the files.
fn kinds() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    let (arff, ts) = (
        "@relation P\n@attribute t0 numeric\n@attribute t1 numeric\n@attribute target {a,b}\n@data\n",
        "@problemName P\n@data\n",
    );
    let arff_train = Box::leak(format!("{arff}1,2,a\n3,4,b\n").into_boxed_str());
    let arff_test = Box::leak(format!("{arff}1,3,a\n").into_boxed_str());
    let ts_train = Box::leak(format!("{ts}1,2:a\n3,4:b\n").into_boxed_str());
    let ts_test = Box::leak(format!("{ts}1,3:a\n").into_boxed_str());
    let recordings = [("a/1.csv", "x,y\n1,2\n3,4\n"), ("b/1.csv", "x,y\n5,6\n7,8\n")];
    vec![
        ("t.csv", vec![("t.csv", TABLE)]),
        ("P", vec![("P_TRAIN.tsv", "a\t1\t2\nb\t3\t4\n"), ("P_TEST.tsv", "a\t1\t3\n")]),
        ("P", vec![("P_TRAIN.ts", ts_train), ("P_TEST.ts", ts_test)]),
        ("P", vec![("P_TRAIN.arff", arff_train), ("P_TEST.arff", arff_test)]),
        ("", recordings.to_vec()),
        ("", [&recordings[..], &[("labels.json", "{\"classes\": [\"b\", \"a\"]}")]].concat()),
        (
            "",
            vec![
                ("1.csv", "1,2\n3,4\n"),
                ("2.csv", "5,6\n7,8\n"),
                ("labels.csv", "file,label\n1.csv,a\n2.csv,b\n"),
            ],
        ),
        ("", vec![("a/1.jsonl", "{\"x\": 1}\n{\"x\": 2}\n"), ("b/1.jsonl", "{\"x\": 3}\n{\"x\": 4}\n")]),
    ]
}

#[test]
fn a_mark_and_utf_16_are_no_part_of_any_text() {
    for (path, list) in kinds() {
        let plain = with(&list);
        let plain = read(&plain.path().join(path));
        assert_eq!(plain.output_names().len(), 2, "{list:?}");
        let encodings: [fn(&str) -> Vec<u8>; 3] = [
            |text| format!("\u{feff}{text}").into_bytes(),
            |text| utf16(&text.replace('\n', "\r\n"), false),
            |text| utf16(text, true),
        ];
        for encode in encodings {
            let folder = with(&list);
            list.iter().for_each(|(name, text)| fs::write(folder.path().join(name), encode(text)).unwrap());
            let marked = read(&folder.path().join(path));
            assert_eq!(
                (&marked.digest, marked.output_names()),
                (&plain.digest, plain.output_names()),
                "{list:?}"
            );
        }
    }
}

#[test]
fn bytes_of_another_encoding_are_refused_with_their_line() {
    for (path, list) in kinds() {
        let folder = with(&list);
        let name = list.last().unwrap().0;
        let mut bytes = list.last().unwrap().1.as_bytes().to_vec();
        bytes.extend(b"caf\xe9\n");
        fs::write(folder.path().join(name), bytes).unwrap();
        let message = refused(&folder.path().join(path));
        assert!(message.contains("0xE9, which is not UTF-8; save it as UTF-8"), "{name}: {message}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn class_folders_that_are_no_utf_8_do_not_merge() {
    use std::os::unix::ffi::OsStrExt;
    let root = tempdir().unwrap();
    for name in [&b"caf\xe8"[..], b"caf\xe9", b"tea"] {
        let class = root.path().join(std::ffi::OsStr::from_bytes(name));
        fs::create_dir(&class).unwrap();
        fs::write(class.join("1.csv"), "1,2\n").unwrap();
    }
    assert!(
        refused(root.path()).contains(r#"the name "caf\xE8" is not UTF-8; rename it"#),
        "{}",
        refused(root.path())
    );
}

#[test]
fn tables_of_spreadsheets_and_loggers_are_read() {
    for text in [
        TABLE.replace(',', ";").replacen("force", "sep=;\nforce", 1),
        format!("sep=,\r\n{}", TABLE.replace('\n', "\r\n")),
        TABLE.replace('\n', ",\n"),
        TABLE.replace('\n', ",\n").replacen("label,", "label", 1),
        TABLE.replace(',', "\t").replace('\n', "\t\n"),
    ] {
        let folder = with(&[("t.csv", &text), ("plain/t.csv", TABLE)]);
        let (data, plain) = (read(&folder.path().join("t.csv")), read(&folder.path().join("plain/t.csv")));
        assert_eq!((&data.digest, data.output_names()), (&plain.digest, plain.output_names()), "{text:?}");
    }
    // A line of the file stays a line of the message.
    let folder = with(&[("t.csv", "sep=;\nforce;label\n1.5;a\nx;b\n")]);
    assert!(refused(&folder.path().join("t.csv")).contains("line 4, column force: \"x\""));
    let folder = with(&[("a/1.csv", "x,y,\n1,2,\n3,4,\n"), ("b/1.csv", "sep=;\nx;y\n1;2\n3;5\n")]);
    assert_eq!(read(folder.path()).x.shape(), [2, 2, 2]);
    let folder = with(&[("a/1.csv", "t:12,x:0.5\nt:13,x:0.6\n"), ("b/1.csv", "t:12,x:0.5\nt:13,x:0.6\n")]);
    let message = refused(folder.path());
    assert!(
        message.contains("a/1.csv: line 1 holds cells of a label and a value, such as \"t:12\""),
        "{message}"
    );
    let folder = with(&[
        ("labels.csv", "sep=;\nfile;label\n1.csv;a\n2.csv;b\n"),
        ("1.csv", "1,2\n"),
        ("2.csv", "3,4\n"),
    ]);
    assert_eq!(read(folder.path()).output_names(), ["a", "b"]);
}

#[test]
fn labels_that_look_alike_are_refused_in_every_layout() {
    for (a, b) in
        [("so ft", "so\u{a0}ft"), ("caf\u{e9}", "cafe\u{301}"), ("1", "1.0"), ("soft", "\u{200b}soft")]
    {
        let table = format!("x,label\n1,{a}\n2,{b}\n3,{a}\n4,stiff\n");
        let ts = format!("@data\n1,2:{a}\n1,3:stiff\n");
        let listed = format!("file,label\n1.csv,{a}\n2.csv,{b}\n");
        let groups = format!("x,label,group\n1,a,{a}\n2,b,{b}\n3,a,{a}\n4,b,other\n");
        let sets = [
            ("t.csv", with(&[("t.csv", &table)])),
            ("g.csv", with(&[("g.csv", &groups)])),
            ("P", with(&[("P_TRAIN.ts", &ts), ("P_TEST.ts", &format!("@data\n1,2:{b}\n"))])),
            ("", with(&[("labels.csv", &listed), ("1.csv", "1,2\n"), ("2.csv", "3,4\n")])),
            ("", with(&[(&format!("{a}/1.csv"), "1,2\n"), (&format!("{b}/1.csv"), "3,4\n")])),
            ("", with(&[(&format!("p/{a}/1.csv"), "1,2\n"), (&format!("q/{b}/1.csv"), "3,4\n")])),
        ];
        for (path, folder) in &sets {
            let path = folder.path().join(path);
            let message = refused(&path);
            assert!(message.contains("differ only in blanks"), "{a:?} {b:?}: {message}");
            assert!(message.contains(&format!("{a:?}")) && message.contains(&format!("{b:?}")), "{message}");
        }
    }
    let folder = with(&[("soft/1.csv", "1,2\n"), ("soft /1.csv", "3,4\n")]);
    assert!(refused(folder.path()).contains(r#""soft" and "soft ""#));
    let error = Dataset::new(
        "glove",
        taxel_data::Layout::Features,
        ndarray::ArrayD::zeros(vec![2, 3]),
        &["soft", "soft "],
    );
    assert!(error.unwrap_err().to_string().contains(r#""soft" and "soft ""#));
}

#[test]
fn names_with_control_characters_are_refused_escaped() {
    let esc = "so\u{1b}[31mft";
    let folder = with(&[(&format!("{esc}/1.csv"), "1,2\n"), ("b/1.csv", "3,4\n")]);
    let table = with(&[("t.csv", &format!("x,label\n1,{esc}\n2,b\n"))]);
    let column = with(&[("t.csv", &format!("{esc},label\n1,a\n2,b\n"))]);
    let file = with(&[(&format!("a/{esc}.csv"), "1,2\n"), ("b/1.csv", "3,4\n")]);
    for path in [folder.path(), &table.path().join("t.csv"), &column.path().join("t.csv"), file.path()] {
        let message = refused(path);
        assert!(
            message.contains("holds a control character; rename it") && !message.contains('\u{1b}'),
            "{message}"
        );
    }
}

#[test]
fn only_0_and_1_are_marks() {
    let table = |marks: [&str; 4]| {
        let rows: String = marks
            .iter()
            .zip(["a", "b", "a", "b"])
            .map(|(mark, class)| format!("1.{mark},{class},{mark}\n"))
            .collect();
        with(&[("t.csv", &format!("x,label,held\n{rows}"))])
    };
    let options = ReadOptions { test: Some("held".into()), ..ReadOptions::default() };
    let marked = table(["0", "0", "1", "2"]);
    let message = load(&marked.path().join("t.csv"), &options).unwrap_err().to_string();
    assert!(
        message.contains("held[3] = 2 is no mark: 0 is trained on and 1 tested")
            && message.contains("test_above"),
        "{message}"
    );
    let above = ReadOptions { test_above: Some(1), ..options.clone() };
    let data = load(&marked.path().join("t.csv"), &above).unwrap();
    assert_eq!(data.official, Some(vec![false, false, false, true]));
    let rows = "x,label,held\n1,a,False\n2,b,0.0\n3,a,TRUE\n4,b,1.0\n";
    let folder = with(&[("t.csv", rows)]);
    let data = load(&folder.path().join("t.csv"), &options).unwrap();
    assert_eq!(data.official, Some(vec![false, false, true, true]));
}

#[test]
fn labels_with_fractions_are_values_and_whole_numbers_classes() {
    let rows: String = (0..40).map(|i| format!("{i},0.{i:02}5\n")).collect();
    let folder = with(&[("t.csv", &format!("x,label\n{rows}"))]);
    let path = folder.path().join("t.csv");
    let data = read(&path);
    let Targets::Values(values) = &data.targets else { panic!("classes") };
    assert_eq!((values.quantities()[0].name.as_str(), values.values()[1]), ("label", 0.015));
    let card = check(&path).unwrap();
    assert!(card.read_as.iter().any(|line| line.contains("\"label\" are values")), "{:?}", card.read_as);
    let folder = with(&[("t.csv", "x,label\n1,Soft\n2,soft\n")]);
    let warned = check(&folder.path().join("t.csv")).unwrap().warnings;
    assert!(
        warned.iter().any(|line| line.contains(r#""Soft" and "soft" differ only in capital letters"#)),
        "{warned:?}"
    );
    // Who lists them means classes.
    let folder = with(&[("t.csv", "x,label\n1,0.5\n2,1.5\n3,0.5\n"), ("labels.json", r#"["0.5", "1.5"]"#)]);
    assert_eq!(read(&folder.path().join("t.csv")).output_names(), ["0.5", "1.5"]);
    let folder = with(&[("t.csv", "x,label\n1,1.0\n2,2.0\n3,1.0\n")]);
    assert_eq!(read(&folder.path().join("t.csv")).output_names(), ["1.0", "2.0"]);
    let list =
        [("labels.csv", "file,label\n1.csv,0.53\n2.csv,1.25\n"), ("1.csv", "1,2\n"), ("2.csv", "3,4\n")];
    let folder = with(&list);
    let data = read(folder.path());
    assert_eq!(data.targets.values().unwrap().values(), [0.53, 1.25]);
}

/// Recordings of two classes in the folders of some parts.
fn split(parts: &[&str]) -> Vec<(String, String)> {
    let mut list = vec![];
    for (p, part) in parts.iter().enumerate() {
        for (c, class) in ["knurled", "smooth"].iter().enumerate() {
            for i in 0..2 {
                list.push((format!("{part}/{class}/{i}.csv"), format!("{p}.5,{c}\n{i},1\n")));
            }
        }
    }
    list
}

fn split_at(parts: &[&str]) -> TempDir {
    let list = split(parts);
    with(&list.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect::<Vec<_>>())
}

#[test]
fn folders_of_parts_are_the_official_split() {
    for (parts, tested) in [
        (&["train", "test"][..], 1),
        (&["Training", "TEST"], 1),
        (&["train", "val"], 1),
        (&["train", "dev"], 1),
        (&["train", "testing", "valid"], 1),
        (&["TRAIN", "Test", "validation"], 1),
    ] {
        let folder = split_at(parts);
        let data = read(folder.path());
        assert_eq!(data.output_names(), ["knurled", "smooth"], "{parts:?}");
        let official = data.official.unwrap();
        for (origin, is_tested) in data.origins.iter().zip(&official) {
            assert_eq!(*is_tested, origin.starts_with(parts[tested]), "{parts:?}: {origin}");
        }
        let said = check(folder.path()).unwrap().read_as.join("; ");
        assert!(
            said.contains("an official split by folders")
                && said.contains(&format!("{} to test on", parts[tested])),
            "{said}"
        );
    }
    // Below the classes as well.
    let folder = with(&[
        ("a/train/1.csv", "1,2\n"),
        ("a/test/1.csv", "1,3\n"),
        ("b/train/1.csv", "1,4\n"),
        ("b/test/1.csv", "1,5\n"),
    ]);
    let data = read(folder.path());
    assert_eq!((data.official, data.groups), (Some(vec![true, false, true, false]), None));
    // With sessions, in the order of labels.json.
    let folder = with(&[
        ("train/a/s1/1.csv", "1,2\n"),
        ("train/b/s1/1.csv", "1,3\n"),
        ("test/a/s2/1.csv", "1,4\n"),
        ("test/b/s2/1.csv", "1,5\n"),
        ("labels.json", r#"["b", "a"]"#),
    ]);
    let data = read(folder.path());
    let of = |origin: &str| data.origins.iter().position(|held| held == origin).unwrap();
    let (official, groups) = (data.official.clone().unwrap(), data.groups.clone().unwrap());
    assert_eq!(data.output_names(), ["b", "a"]);
    for (origin, want) in [("train/a/s1/1.csv", (1, false, 0)), ("test/b/s2/1.csv", (0, true, 1))] {
        assert_eq!((data.strata()[of(origin)], official[of(origin)], groups[of(origin)]), want, "{origin}");
    }
}

#[test]
fn folders_that_are_no_split_are_classes_or_refused_by_name() {
    let classes = |list: &[(&str, &str)]| read(with(list).path()).output_names();
    assert_eq!(classes(&[("test/1.csv", "1,2\n"), ("other/1.csv", "3,4\n")]), ["other", "test"]);
    assert_eq!(classes(&[("train/1.csv", "1,2\n"), ("car/1.csv", "3,4\n")]), ["car", "train"]);
    let message = |list: &[(&str, &str)]| refused(with(list).path());
    let flat = message(&[("train/1.csv", "1,2\n"), ("test/1.csv", "3,4\n")]);
    assert!(flat.contains("train has no class folders") && flat.contains("labels.csv"), "{flat}");
    let beside =
        message(&[("train/a/1.csv", "1,2\n"), ("test/a/1.csv", "3,4\n"), ("extra/a/1.csv", "3,4\n")]);
    assert!(beside.contains("holds train and test, the parts of a split, beside extra"), "{beside}");
    let odd = message(&[
        ("train/a/1.csv", "1,2\n"),
        ("train/b/1.csv", "1,2\n"),
        ("test/a/1.csv", "3,4\n"),
        ("test/c/1.csv", "3,4\n"),
    ]);
    assert!(odd.contains(r#""c" is in test and not in train, "b" is in train and not in test"#), "{odd}");
    let alone = message(&[("train/a/1.csv", "1,2\n"), ("train/b/1.csv", "1,2\n")]);
    assert!(alone.contains("holds only train, a part of a split; give that folder itself"), "{alone}");
    // A table of labels says what they are.
    let list = [
        ("labels.csv", "file,label\ntrain/1.csv,train\ntest/1.csv,test\n"),
        ("train/1.csv", "1,2\n"),
        ("test/1.csv", "3,4\n"),
    ];
    assert_eq!(classes(&list), ["test", "train"]);
}

#[test]
fn bytes_in_arrays_that_are_no_text_do_not_merge() {
    let folder = tempdir().unwrap();
    let arrays = [
        ("x", common::f32s(&[3, 2], &[1.0; 6])),
        ("y", common::npy("|S4", false, &[3], b"caf\xe8caf\xe9tea\0")),
    ];
    let message = refused(&common::npz(folder.path(), &arrays));
    assert!(message.contains("is not UTF-8; save it as str (dtype U)"), "{message}");
}
