//! Decides what a column is: one rule for tables, recordings in CSV and lines of JSON.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{files, labels, npz, refused, samples};
use std::fmt::Write;
use std::path::Path;
use taxel_data::{Card, Dataset, ReadOptions, check, check_with, convert, load, recordings};
use tempfile::{TempDir, tempdir};

fn table(text: &str) -> ReadOptions {
    ReadOptions { table: text.parse().unwrap(), ..ReadOptions::default() }
}

/// A set of a class `soft` and a class `hard`, two files each; `text` writes the number of each file.
fn set(ending: &str, text: impl Fn(usize) -> String) -> TempDir {
    let folder = tempdir().unwrap();
    for file in 0..4 {
        let class = if file < 2 { "soft" } else { "hard" };
        files(folder.path(), &[(&format!("{class}/{file}.{ending}"), &text(file))]);
    }
    folder
}

/// Rows of `cells` under a header, `count` of them; a cell is made of the file, the row and its number.
fn rows(header: &str, count: usize, cells: impl Fn(usize) -> String) -> String {
    (0..count).fold(format!("{header}\n"), |mut text, row| {
        writeln!(text, "{}", cells(row)).unwrap();
        text
    })
}

fn force(file: usize, row: usize) -> f32 {
    (file * 7 + row * row % 5) as f32 + 0.25
}

fn names(data: &Dataset) -> Vec<&str> {
    data.spec.channel_names.iter().map(String::as_str).collect()
}

fn said(card: &Card) -> String {
    [card.ignored.join("; "), card.other_arrays.join("; "), card.read_as.join("; ")].join(" | ")
}

#[test]
fn time_and_indices_are_no_channels_in_any_reader() {
    type Stamp = fn(usize) -> String;
    let stamps: [(&str, Stamp); 5] = [
        ("t_us", |row| (row * 10_000).to_string()),
        ("timestamp", |row| format!("{:.2}", 1_709_281_200.0 + row as f64 / 100.0)),
        ("timestamp_ns", |row| (1_709_281_200_000_000_000 + row * 10_000_000).to_string()),
        ("time", |row| (1_709_281_200_000 + row * 10).to_string()),
        ("when", |row| format!("2024-05-01T12:00:00.{:03}Z", row * 10)),
    ];
    for (time, stamp) in stamps {
        for index in ["", "Unnamed: 0", "__index_level_0__", "index", "row", "frame_index", "nr"] {
            let cells = |file: usize, row: usize| format!("{row},{},{}", stamp(row), force(file, row));
            let each = set("csv", |file| rows(&format!("{index},{time},force"), 6, |row| cells(file, row)));
            let long: Vec<String> = (0..4)
                .flat_map(|file| (0..6).map(move |row| (file, row)))
                .map(|(file, row)| format!("r{file},{},{}\n", cells(file, row), file / 2))
                .collect();
            let long = format!("recording,{index},{time},force,label\n{}", long.concat());
            let lone = tempdir().unwrap();
            files(lone.path(), &[("long.csv", &long)]);
            let json = set("jsonl", |file| {
                let quoted = if time == "when" { "\"" } else { "" };
                let line = |row: usize| {
                    let (stamp, force) = (stamp(row), force(file, row));
                    format!(
                        "{{\"{index}\": {row}, \"{time}\": {quoted}{stamp}{quoted}, \"force\": {force}}}\n"
                    )
                };
                (0..6).map(line).collect()
            });
            for path in [each.path(), &lone.path().join("long.csv"), json.path()] {
                let data = load(path, &ReadOptions::default()).unwrap();
                assert_eq!(
                    (names(&data), data.x.shape()),
                    (vec!["force"], &[4, 1, 6][..]),
                    "{index:?} {time}"
                );
                assert_eq!(data.spec.rate, Some(100.0), "{time}");
                let card = check(path).unwrap();
                assert!(said(&card).contains(&format!("{index:?}")), "{}", said(&card));
                assert!(said(&card).contains(&format!("time by {time:?}")), "{}", said(&card));
            }
        }
    }
}

#[test]
fn an_index_of_a_wide_table_is_no_feature() {
    for name in ["", "nr", "id", "index", "Unnamed: 0"] {
        let text = rows(&format!("{name},f,label"), 6, |row| format!("{row},{},{}", force(0, row), row / 3));
        let folder = tempdir().unwrap();
        files(folder.path(), &[("grasps.csv", &text)]);
        let data = load(&folder.path().join("grasps.csv"), &ReadOptions::default()).unwrap();
        assert_eq!(names(&data), ["f"], "{name:?}");
        let card = check(&folder.path().join("grasps.csv")).unwrap();
        assert!(card.ignored[0].starts_with(&format!("column {name:?} (")), "{:?}", card.ignored);
        // Who names it means it.
        if !name.is_empty() {
            let both =
                load(&folder.path().join("grasps.csv"), &table(&format!("column=f,column={name}"))).unwrap();
            assert_eq!(names(&both), ["f", name]);
        }
    }
}

#[test]
fn a_finger_that_is_called_index_is_a_channel() {
    let text = |file: usize| {
        rows("thumb,index", 5, |row| format!("{},{}", force(file, row), (row * row + file) % 7))
    };
    let folder = set("csv", text);
    assert_eq!(names(&load(folder.path(), &ReadOptions::default()).unwrap()), ["thumb", "index"]);
    let json = set("jsonl", |file| {
        (0..5)
            .map(|row| {
                format!("{{\"thumb\": {}, \"index\": {}}}\n", force(file, row), (row * row + file) % 7)
            })
            .collect()
    });
    assert_eq!(names(&load(json.path(), &ReadOptions::default()).unwrap()), ["thumb", "index"]);
}

#[test]
fn a_line_that_numbers_the_columns_is_a_header() {
    for (header, is_index) in [("0,1,2", false), (",0,1,2", true)] {
        let index = |row: usize| if is_index { format!("{row},") } else { String::new() };
        let text = |file: usize| {
            rows(header, 4, |row| format!("{}{},{},0.5", index(row), force(file, row), force(row, file)))
        };
        let folder = set("csv", text);
        let data = load(folder.path(), &ReadOptions::default()).unwrap();
        assert_eq!((names(&data), data.x.shape()), (vec!["0", "1", "2"], &[4, 3, 4][..]));
        assert!(said(&check(folder.path()).unwrap()).contains("numbers the columns"));
    }
    let readings = set("csv", |file| format!("1,2\n3,{file}\n"));
    assert_eq!(load(readings.path(), &ReadOptions::default()).unwrap().x.shape(), [4, 2, 2], "readings");
    // A reading of some files may look like such a line.
    for numbered in 0..4 {
        let readings = set("csv", |file| format!("{},1\n5,{file}\n", u32::from(file != numbered)));
        let data = load(readings.path(), &ReadOptions::default()).unwrap();
        assert_eq!(data.x.shape(), [4, 2, 2], "file {numbered}");
        assert_eq!(data.x.iter().filter(|value| **value == 0.0).count(), 1 + 1, "file {numbered}");
    }
}

#[test]
fn decimal_commas_are_read_where_commas_part_no_columns() {
    let point = |value: f32| value.to_string();
    let comma = |value: f32| value.to_string().replace('.', ",");
    let recording = |separator: &'static str, write: fn(f32) -> String| {
        let text = move |file: usize| {
            rows(&["a", "b"].join(separator), 4, |row| {
                [write(force(file, row)), write(force(row, file))].join(separator)
            })
        };
        let folder = set("csv", text);
        (load(folder.path(), &ReadOptions::default()).unwrap().digest, check(folder.path()).unwrap())
    };
    let (want, _) = recording(",", point);
    for separator in [";", "\t"] {
        let (digest, card) = recording(separator, comma);
        assert_eq!(digest, want);
        assert!(said(&card).contains("decimals have commas"), "{}", said(&card));
        assert_eq!(recording(separator, point).0, want);
    }
    // A table, in which a row number would be the only column left.
    let folder = tempdir().unwrap();
    let wide = |separator: &str, write: fn(f32) -> String| {
        let row = |row: usize| [row.to_string(), write(force(row, 1)), (row / 3).to_string()].join(separator);
        files(folder.path(), &[("t.csv", &rows(&["nr", "kraft", "label"].join(separator), 6, row))]);
        load(&folder.path().join("t.csv"), &ReadOptions::default())
    };
    assert_eq!(wide(";", comma).unwrap().digest, wide(",", point).unwrap().digest);
    assert_eq!(names(&wide(";", comma).unwrap()), ["kraft"]);
}

#[test]
fn numbers_in_disguise_are_refused_with_how_to_write_them() {
    let hints = [
        ("\"1,5\"", "decimals with points"),
        ("1.5 N", "the unit into the name"),
        ("12mV", "the unit into the name"),
        ("50%", "the unit into the name"),
        ("\"1,234.5\"", "separators of thousands"),
        ("1'234", "separators of thousands"),
        ("\"[1, 2]\"", "a column for each"),
        ("0x1F", "in decimals"),
    ];
    for (cell, hint) in hints {
        let bare = cell.trim_matches('"');
        let folder = tempdir().unwrap();
        let wide = rows("f,kraft,label", 4, |row| format!("{},{cell},{}", force(row, 0), row / 2));
        files(folder.path(), &[("t.csv", &wide)]);
        let path = folder.path().join("t.csv");
        let message = refused(&path, &ReadOptions::default());
        let want = format!("t.csv: line 2, column kraft: {bare:?} ");
        assert!(
            message.starts_with(&want) && message.contains(hint) && message.contains("table.ignore"),
            "{message}"
        );
        assert_eq!(names(&load(&path, &table("ignore=kraft")).unwrap()), ["f"]);

        let each = set("csv", |file| rows("f,kraft", 4, |row| format!("{},{cell}", force(row, file))));
        let message = load(each.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains(&format!(".csv: line 2, column kraft: {bare:?} ")), "{message}");
        assert_eq!(names(&load(each.path(), &table("ignore=kraft")).unwrap()), ["f"]);

        let json = set("jsonl", |file| {
            (0..4).map(|row| format!("{{\"f\": {}, \"kraft\": {bare:?}}}\n", force(row, file))).collect()
        });
        let message = load(json.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains(&format!(".jsonl: line 1, key \"kraft\": {bare:?} ")), "{message}");
    }
    // Points and commas in one file: which of the two parts thousands cannot be known.
    let folder = tempdir().unwrap();
    files(folder.path(), &[("t.csv", "a;b;label\n0.5;1,5;x\n0.25;2,5;y\n")]);
    assert!(refused(&folder.path().join("t.csv"), &ReadOptions::default()).contains("column b: \"1,5\""));
}

#[test]
fn columns_of_texts_are_listed() {
    let each = set("csv", |file| rows("f,state", 4, |row| format!("{},contact", force(row, file))));
    assert_eq!(names(&load(each.path(), &ReadOptions::default()).unwrap()), ["f"]);
    assert_eq!(check(each.path()).unwrap().ignored, ["column \"state\" (text)"]);
    let message = load(each.path(), &table("column=f,column=state")).unwrap_err().to_string();
    assert!(message.contains(".csv: column \"state\" is to be a channel and holds no numbers"), "{message}");
}

#[test]
fn numbers_that_f32_does_not_hold_are_refused() {
    for (cell, is_held) in
        [("16777217", false), ("16777216", true), ("-33554433", false), ("1000000.001", false)]
    {
        let cell = |row: usize| if row == 1 { cell.to_string() } else { cell.replace(".001", ".002") };
        let each = set("csv", |file| rows("f,g", 4, |row| format!("{},{}", force(row, file), cell(row))));
        let json = set("jsonl", |file| {
            (0..4).map(|row| format!("{{\"f\": {}, \"g\": {}}}\n", force(row, file), cell(row))).collect()
        });
        let folder = tempdir().unwrap();
        let wide = rows("f,g,label", 4, |row| format!("{},{},{}", force(row, 0), cell(row), row / 2));
        files(folder.path(), &[("t.csv", &wide)]);
        for path in [each.path(), json.path(), &folder.path().join("t.csv")] {
            match load(path, &ReadOptions::default()) {
                Ok(_) => assert!(is_held, "{}", cell(1)),
                Err(e) => {
                    assert!(!is_held && e.to_string().contains("f32") && e.to_string().contains('g'), "{e}")
                }
            }
        }
    }
}

#[test]
fn files_are_matched_by_the_names_of_their_columns() {
    let text = |file: usize, turned: bool| {
        let header = if turned { "index,thumb" } else { "thumb,index" };
        rows(header, 5, |row| {
            let (thumb, index) = (force(file, row), force(row, file));
            if turned { format!("{index},{thumb}") } else { format!("{thumb},{index}") }
        })
    };
    let plain = set("csv", |file| text(file, false));
    let turned = set("csv", |file| text(file, file % 2 == 1));
    let digest = |folder: &TempDir| load(folder.path(), &ReadOptions::default()).unwrap().digest;
    assert_eq!(digest(&plain), digest(&turned));
    for (header, why) in [
        ("thumb,ring", "3.csv: has no channel \"index\"; it has thumb, ring, and "),
        ("thumb,index,ring", "3.csv: has a channel \"ring\", and "),
        ("thumb,thumb", "3.csv: two columns are named \"thumb\""),
        ("time,thumb,index", "3.csv: has a column of time stamps, and "),
    ] {
        let width = header.split(',').count();
        let other = |row: usize| {
            (0..width).map(|at| (row * row * (at + 1)).to_string()).collect::<Vec<_>>().join(",")
        };
        files(plain.path(), &[("hard/3.csv", &rows(header, 5, other))]);
        let message = load(plain.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains(why), "{message}");
    }
}

#[test]
fn recordings_for_a_model_are_matched_by_name() {
    let options =
        ReadOptions { channel_names: vec!["thumb".into(), "index".into()], ..ReadOptions::default() };
    let read = |name: &str, text: &str| {
        let folder = tempdir().unwrap();
        files(folder.path(), &[(name, text)]);
        recordings(&folder.path().join(name), &options, 2)
            .map(|read| read.x.iter().copied().collect::<Vec<f32>>())
    };
    let want = vec![1.0, 2.0, 3.0, 4.0];
    for (name, text) in [
        ("a.csv", "thumb,index\n1,3\n2,4\n"),
        ("a.csv", "index,thumb\n3,1\n4,2\n"),
        ("a.csv", "ring,index,time,thumb\n9,3,0,1\n9,4,1,2\n"),
        ("a.csv", "1,3\n2,4\n"),
        ("a.jsonl", "{\"index\": 3, \"ring\": 1, \"thumb\": 1}\n{\"thumb\": 2, \"ring\": 1, \"index\": 4}\n"),
    ] {
        assert_eq!(read(name, text).unwrap(), want, "{text}");
    }
    for (name, text) in [("a.csv", "thumb,ring\n1,3\n2,4\n"), ("a.jsonl", "{\"thumb\": 1}\n{\"thumb\": 2}\n")]
    {
        let message = read(name, text).unwrap_err().to_string();
        assert!(message.contains("has no channel \"index\""), "{message}");
    }
}

#[test]
fn keys_of_json_may_come_in_any_order() {
    let line = |file: usize, row: usize, turned: bool| {
        let (a, b) = (force(file, row), force(row, file));
        if turned {
            format!("{{\"b\": [{b}, 1], \"a\": {a}}}\n")
        } else {
            format!("{{\"a\": {a}, \"b\": [{b}, 1]}}\n")
        }
    };
    let plain = set("jsonl", |file| (0..4).map(|row| line(file, row, false)).collect());
    let turned = set("jsonl", |file| (0..4).map(|row| line(file, row, (file + row) % 2 == 1)).collect());
    let [plain, turned] = [plain, turned].map(|folder| load(folder.path(), &ReadOptions::default()).unwrap());
    assert_eq!((plain.digest, names(&turned)), (turned.digest.clone(), vec!["a", "b[0]", "b[1]"]));
}

#[test]
fn names_of_channels_survive_a_round_trip() {
    let each =
        set("csv", |file| rows("thumb,index", 5, |row| format!("{},{}", force(file, row), force(row, file))));
    let folder = tempdir().unwrap();
    let out = folder.path().join("set.npz");
    convert(each.path(), &ReadOptions::default(), &out).unwrap();
    let data = load(&out, &ReadOptions::default()).unwrap();
    assert_eq!(names(&data), ["thumb", "index"]);
    let picked = load(&out, &ReadOptions { channels: Some(vec![1]), ..ReadOptions::default() }).unwrap();
    assert_eq!(names(&picked), ["index"]);
    // A model that wants them in another order gets them.
    let options =
        ReadOptions { channel_names: vec!["index".into(), "thumb".into()], ..ReadOptions::default() };
    let turned = recordings(&out, &options, 2).unwrap().x;
    assert_eq!(turned[[0, 0, 3]], data.x[[0, 1, 3]]);
}

#[test]
fn channels_in_a_file_of_names_fit_the_arrays() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    let beside = |channels: &str| {
        let text = format!("{{\"classes\": [\"a\", \"b\"], \"channels\": {channels}}}");
        std::fs::write(folder.path().join("labels.json"), text).unwrap();
        load(&path, &ReadOptions::default())
    };
    assert_eq!(names(&beside("[\"thumb\", \"index\"]").unwrap()), ["thumb", "index"]);
    for (channels, why) in [
        ("[\"thumb\"]", "channels is 1 name, and samples have 2 channels"),
        ("[\"thumb\", \"thumb\"]", "channels is \"thumb\" twice"),
        ("\"thumb\"", "not a list of texts"),
        ("[\"a\", \"b\", \"c\", \"d\"]", "channels is 4 names"),
    ] {
        let message = beside(channels).unwrap_err().to_string();
        assert!(message.contains("labels.json: ") && message.contains(why), "{message}");
    }
}

#[test]
fn a_channel_that_counts_is_warned_of_whatever_it_is_called() {
    let warned = |path: &Path| {
        let card = check_with(path, &ReadOptions::default()).unwrap();
        card.warnings
            .iter()
            .filter(|warning| warning.contains("only counts up"))
            .cloned()
            .collect::<Vec<_>>()
            .join("; ")
    };
    let each = set("csv", |file| rows("force,level", 6, |row| format!("{},{}", force(file, row), row * 2)));
    assert!(warned(each.path()).contains("\"level\""), "{}", warned(each.path()));
    let headless = set("csv", |file| {
        (0..6).map(|row| format!("{}.5,{}\n", row + 40 * file, force(file, row))).collect()
    });
    assert!(warned(headless.path()).contains("channel 0"), "{}", warned(headless.path()));
    let folder = tempdir().unwrap();
    files(
        folder.path(),
        &[("t.csv", &rows("f,g,label", 6, |row| format!("{},{row},{}", force(row, 0), row / 3)))],
    );
    assert!(warned(&folder.path().join("t.csv")).contains("\"g\""));
    let plain = set("csv", |file| rows("force", 6, |row| force(file, row).to_string()));
    assert_eq!(warned(plain.path()), "");
}

#[test]
fn order_of_columns_files_and_keys_changes_nothing() {
    // Each way to write the same samples: columns turned, rows of recordings mixed, separators changed.
    let value = |file: usize, row: usize, channel: usize| {
        force(file, row) + channel as f32 * 0.5 + (file * channel) as f32
    };
    let columns = ["thumb", "index", "ring"];
    let long = |order: [usize; 3], mixed: bool, separator: &str| {
        let header = [&["recording", "t"][..], &order.map(|at| columns[at])[..], &["label"][..]]
            .concat()
            .join(separator);
        let mut all: Vec<(usize, usize)> =
            (0..4).flat_map(|file| (0..5).map(move |row| (file, row))).collect();
        if mixed {
            all.sort_by_key(|(file, row)| (*row, *file));
        }
        let line = |(file, row): &(usize, usize)| {
            let cells = order.map(|channel| value(*file, *row, channel).to_string());
            let row = format!("{}", *row as f64 / 50.0);
            [&[format!("r{file}"), row][..], &cells[..], &[["soft", "hard"][file / 2].to_string()][..]]
                .concat()
                .join(separator)
        };
        format!("{header}\n{}\n", all.iter().map(line).collect::<Vec<_>>().join("\n"))
    };
    let read = |text: &str| {
        let folder = tempdir().unwrap();
        files(folder.path(), &[("t.csv", text)]);
        let options = ReadOptions {
            channel_names: columns.map(String::from).to_vec(),
            table: "column=thumb,column=index,column=ring".parse().unwrap(),
            ..ReadOptions::default()
        };
        load(&folder.path().join("t.csv"), &options).unwrap().digest
    };
    let want = read(&long([0, 1, 2], false, ","));
    for order in [[1, 0, 2], [2, 1, 0], [1, 2, 0]] {
        for mixed in [false, true] {
            for separator in [",", ";", "\t"] {
                assert_eq!(read(&long(order, mixed, separator)), want, "{order:?} {mixed} {separator:?}");
            }
        }
    }
}

/// Three lines of two forces and a text.
fn lines(file: usize) -> String {
    (0..3).fold(String::new(), |text, row| {
        let (a, b) = (force(file, row), force(row, file));
        text + &format!("{{\"a\": {a}, \"b\": {b}, \"surface\": \"wood\"}}\n")
    })
}

#[test]
fn keys_of_json_are_channels_in_the_order_that_is_asked() {
    let folder = set("jsonl", lines);
    let read = |columns: &str| load(folder.path(), &table(columns)).unwrap();
    let (turned, plain) = (read("column=b,column=a"), read("column=a,column=b"));
    assert_eq!((names(&turned), names(&plain)), (vec!["b", "a"], vec!["a", "b"]));
    assert_eq!((turned.x[[0, 0, 1]], turned.x[[0, 1, 1]]), (plain.x[[0, 1, 1]], plain.x[[0, 0, 1]]));
}

#[test]
fn keys_of_json_that_are_no_numbers_or_not_there_are_refused() {
    let folder = set("jsonl", lines);
    for (option, word) in
        [("column=surface", "holds no numbers"), ("time=t_ms", "\"t_ms\", which table.time")]
    {
        let message = refused(folder.path(), &table(option));
        assert!(message.contains(word), "{option}: {message}");
    }
}
