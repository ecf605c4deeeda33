//! `taxel record` as a user runs it: files, pipes, a port, a terminal, signals, a pulled cable.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/page.rs"]
mod page;
#[path = "support/person.rs"]
mod person;
#[path = "support/program.rs"]
mod program;
#[path = "support/sensor.rs"]
mod sensor;

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use page::{Served, events, get};
use person::Person;
use program::taxel;
use sensor::{Sensor, press};
use serde_json::Value;
use taxel::data::Tare;

/// Runs a command; returns its exit code, what it printed, and its messages.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    parts(&taxel(folder, arguments).output().unwrap())
}

fn parts(output: &Output) -> (i32, String, String) {
    let text = |bytes: &Vec<u8>| String::from_utf8(bytes.clone()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// Runs a command whose standard input is these lines.
fn piped(folder: &Path, arguments: &[&str], lines: &str) -> (i32, String, String) {
    let mut child = taxel(folder, arguments).stdin(Stdio::piped()).spawn().unwrap();
    let mut to = child.stdin.take().unwrap();
    let lines = lines.to_string();
    let writer = std::thread::spawn(move || to.write_all(lines.as_bytes()));
    let output = child.wait_with_output().unwrap();
    let _ = writer.join().unwrap();
    parts(&output)
}

/// Lines of CSV of two channels at 100 Hz with time stamps: presses of one second each.
fn lines(readings: std::ops::Range<usize>) -> String {
    let line = |t: usize| format!("{},{},{}\n", 10 * t, press(t, 0), press(t, 1));
    format!("time_ms,thumb,index\n{}", readings.map(line).collect::<String>())
}

/// The files of recordings below a folder, with how many rows each has.
fn files(folder: &Path) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(at) = folders.pop() {
        for entry in fs::read_dir(&at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().unwrap() != "labels.json" {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap().to_string();
                found.insert(name, fs::read_to_string(&path).unwrap().lines().count() - 1);
            }
        }
    }
    found
}

const CUP_AND_POT: [&str; 8] = ["--label", "cup", "--label", "pot", "--seconds", "0.5", "--output", "skin"];

fn record<'a>(source: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [&["record"], source, &CUP_AND_POT, more].concat()
}

#[test]
fn a_file_becomes_a_data_set_that_is_read_without_a_flag() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("stream.csv"), lines(0..2000)).unwrap();
    let arguments =
        record(&["--input", "stream.csv"], &["--count", "3", "--unit", "N", "--full-scale", "900"]);
    let (code, said, messages) = run(at, &arguments);
    assert_eq!(code, 0, "{said}{messages}");
    let written = files(&at.join("skin"));
    let names: Vec<&str> = written.keys().map(String::as_str).collect();
    let cup = ["cup/session-1/001.csv", "cup/session-1/002.csv", "cup/session-1/003.csv"];
    assert_eq!(names[..3], cup);
    assert_eq!(names[3..], cup.map(|name| name.replace("cup", "pot")));
    // A quarter of a second at rest, and half a second.
    assert!(written.values().all(|rows| *rows == 75), "{written:?}");
    let text = fs::read_to_string(at.join("skin/cup/session-1/001.csv")).unwrap();
    assert!(text.starts_with("time,thumb,index\n0,"), "{text:.60}");
    let dataset = taxel::load(&at.join("skin"), &taxel::ReadOptions::default()).unwrap();
    assert_eq!(dataset.x.shape(), [6, 2, 75]);
    assert_eq!(dataset.spec.channel_names, ["thumb", "index"]);
    assert_eq!((dataset.spec.rate, dataset.spec.unit.as_deref()), (Some(100.0), Some("N")));
    assert_eq!(
        (dataset.spec.full_scale, dataset.spec.tare.clone()),
        (Some(900.0), Some(Tare::Recording { steps: 25 }))
    );
    assert_eq!(dataset.output_names(), ["cup", "pot"]);
    let (code, card, messages) = run(at, &["data", "check", "skin"]);
    assert!(code <= 1 && card.contains("6×2×75") && card.contains("recording:25"), "{card}{messages}");
    // All are there: nothing more is recorded, and a file of facts that somebody wrote into stays so.
    let facts = at.join("skin/labels.json");
    let mut json: Value = serde_json::from_str(&fs::read_to_string(&facts).unwrap()).unwrap();
    assert_eq!(json["recorded"]["recordings"].as_array().unwrap().len(), 6);
    json["note"] = "new gel".into();
    fs::write(&facts, json.to_string()).unwrap();
    let (code, _, messages) = run(at, &arguments);
    assert_eq!((code, files(&at.join("skin"))), (0, written));
    assert!(messages.contains("6 of 6 recordings, 0 of them new"), "{messages}");
    // Two more of each are another session.
    let more = record(&["--input", "stream.csv"], &["--count", "5"]);
    assert_eq!(run(at, &more).0, 0);
    let dataset = taxel::load(&at.join("skin"), &taxel::ReadOptions::default()).unwrap();
    assert_eq!(
        (dataset.len(), dataset.groups.as_ref().map(|groups| groups[0] == groups[4])),
        (10, Some(false))
    );
    let json: Value = serde_json::from_str(&fs::read_to_string(&facts).unwrap()).unwrap();
    assert_eq!((&json["note"], &json["unit"]), (&"new gel".into(), &"N".into()));
}

#[test]
fn labels_interleave_and_json_says_each_recording() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = record(&["--input", "-"], &["--count", "4", "--format", "json", "--seed", "3"]);
    let (code, said, messages) = piped(at, &arguments, &lines(0..1000));
    assert_eq!(code, 0, "{messages}");
    let lines: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 9, "{said}");
    let labels: Vec<&str> = lines[..8].iter().map(|line| line["label"].as_str().unwrap()).collect();
    for block in labels.chunks_exact(2) {
        assert_ne!(block[0], block[1], "{labels:?}");
    }
    for (line, next) in lines[..7].iter().zip(&labels[1..]) {
        assert_eq!((&line["kept"], &line["next"]), (&true.into(), &(*next).into()));
        assert_eq!((&line["dead"], &line["readings"]), (&serde_json::json!([]), &75.into()));
    }
    assert_eq!(lines[8]["summary"]["recordings"], serde_json::json!({"cup": 4, "pot": 4}));
    assert_eq!(lines[8]["summary"]["ended"], "complete");
}

#[test]
fn an_input_that_ends_keeps_what_is_complete_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = record(&["--input", "-"], &["--count", "2"]);
    // Two recordings, and most of a third.
    let (code, _, messages) = piped(at, &arguments, &lines(0..220));
    assert_eq!(code, 1, "{messages}");
    assert!(messages.contains("not kept, the input ended (after 70 of 75 readings)"), "{messages}");
    assert!(messages.contains("the same command goes on"), "{messages}");
    assert_eq!(files(&at.join("skin")).values().collect::<Vec<_>>(), [&75; 2]);
    let (code, _, messages) = piped(at, &arguments, &lines(0..220));
    assert_eq!((code, files(&at.join("skin")).len()), (0, 4), "{messages}");
}

#[test]
fn what_does_not_agree_with_the_set_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = record(&["--input", "-"], &["--count", "1", "--unit", "N"]);
    assert_eq!(piped(at, &arguments, &lines(0..200)).0, 0);
    let before = files(&at.join("skin"));
    let faster = lines(0..400).replace("time_ms", "time_us");
    let renamed = lines(0..400).replace("thumb", "ring");
    let fewer: String = (0..400).map(|t| format!("{},{}\n", 10 * t, press(t, 0))).collect();
    let cases: [(&str, &[&str], &str); 6] = [
        (&faster, &[], "rate is 100 Hz, and 100000 Hz here"),
        (&renamed, &[], "missing are thumb, more are ring"),
        (&format!("time_ms,thumb\n{fewer}"), &[], "missing are index"),
        (&lines(0..400), &["--no-tare"], "tare is 25 readings at rest, and no rest here"),
        (&lines(0..400), &["--unit", "mN"], "unit is N, and mN here"),
        (&lines(0..400), &["--seconds", "1"], "the length of a recording is 0.500 s, and 1.000 s here"),
    ];
    for (lines, more, why) in cases {
        let arguments = ["--input", "-", "--count", "2", "--output", "skin"];
        let (code, _, messages) = piped(at, &[&["record"], &arguments[..], more].concat(), lines);
        assert!(code == 2 && messages.contains(why), "{why}: {messages}");
    }
    // Channels in another order are the same channels.
    let swapped: String = (0..400).map(|t| format!("{},{},{}\n", 10 * t, press(t, 1), press(t, 0))).collect();
    let arguments = ["record", "--input", "-", "--count", "2", "--output", "skin"];
    assert_eq!(piped(at, &arguments, &format!("time_ms,index,thumb\n{swapped}")).0, 0);
    let first = fs::read_to_string(at.join("skin/cup/session-2/001.csv")).unwrap();
    assert!(first.starts_with("time,thumb,index\n"), "{first:.40}");
    let most = |column: usize| {
        let values =
            first.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse::<f32>().unwrap());
        values.fold(0.0, f32::max)
    };
    // A press of the second channel is twice as strong.
    assert!(most(1) < 200.0 && most(2) > 220.0, "{} {}", most(1), most(2));
    assert_eq!(before.len() + 2, files(&at.join("skin")).len());
    // A folder of somebody else stays as it is.
    fs::create_dir_all(at.join("other/cup")).unwrap();
    fs::write(at.join("other/cup/a.csv"), "1,2\n3,4\n").unwrap();
    let arguments = ["record", "--input", "-", "--label", "cup", "--output", "other"];
    let (code, _, messages) = piped(at, &arguments, &lines(0..400));
    assert!(code == 2 && messages.contains("did not make"), "{messages}");
}

#[test]
fn what_is_wrong_is_said_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let plain: String = (0..400).map(|t| format!("{},{}\n", press(t, 0), press(t, 1))).collect();
    let banner = format!("hello\n{plain}");
    let cases: [(&[&str], &str, &str); 8] = [
        (&["--label", "cup"], "", "nothing came"),
        (&["--label", "cup"], &plain, "say --rate HZ"),
        (&["--label", "cup"], &banner, "say --rate HZ"),
        (&[], &lines(0..400), "no label to record"),
        (&["--label", "a/b"], &lines(0..400), "is the name of a folder"),
        (&["--label", "cup", "--label", "Cup"], &lines(0..400), "is a label already"),
        (&["--label", "cup", "--seconds", "0"], &lines(0..400), "above 0"),
        (&["--label", "cup", "--start", "key"], &lines(0..400), "say --start now"),
    ];
    for (more, lines, why) in cases {
        let arguments = [&["record", "--input", "-", "--output", "skin"], more].concat();
        let (code, _, messages) = piped(at, &arguments, lines);
        assert!(code == 2 && messages.contains(why), "{more:?}: {messages}");
        assert!(!at.join("skin").exists(), "{more:?}");
    }
    let (code, _, messages) = run(at, &["record", "--label", "cup", "--output", "skin"]);
    assert!(code == 2 && messages.contains("say --serial PORT"), "{messages}");
}

#[test]
fn faults_of_channels_are_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = |t: usize| format!("{},{},7,{}\n", 10 * t, press(t, 0), press(t, 1).min(150.0));
    let text = format!("time_ms,good,dead,cut\n{}", (0..400).map(line).collect::<String>());
    let arguments = [
        "record",
        "--input",
        "-",
        "--label",
        "a",
        "--label",
        "b",
        "--seconds",
        "0.75",
        "--count",
        "1",
        "--output",
        "skin",
    ];
    let (code, _, messages) = piped(at, &arguments, &text);
    assert_eq!(code, 0, "{messages}");
    assert!(messages.contains("dead, or never touched so far: dead"), "{messages}");
    assert!(messages.contains("sensor can say: cut"), "{messages}");
    // Lines that are no reading leave a hole that time which is counted would hide.
    let broken: String =
        (0..400).map(|t| if t == 90 { "oops\n".into() } else { format!("{}\n", press(t, 0)) }).collect();
    let arguments = [
        "record",
        "--input",
        "-",
        "--rate",
        "100",
        "--label",
        "a",
        "--seconds",
        "0.75",
        "--count",
        "2",
        "--output",
        "holes",
    ];
    let (code, _, messages) = piped(at, &arguments, &broken);
    assert!(code == 0 && messages.contains("a: not kept, 1 lines were no readings"), "{messages}");
    assert_eq!(files(&at.join("holes")).len(), 2);
}

#[test]
fn the_rate_of_a_set_is_that_of_its_time_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // A sensor at 96 Hz, whose lines come all at once; somebody takes it for 97 Hz.
    let line = |t: usize| format!("{:.9},{},{}\n", t as f64 / 96.0, press(t, 0), press(t, 1));
    let text = format!("time,thumb,index\n{}", (0..2000).map(line).collect::<String>());
    for (more, output) in [(&[][..], "skin"), (&["--rate", "97"], "other")] {
        let set =
            ["record", "--input", "-", "--label", "a", "--seconds", "1", "--count", "2", "--output", output];
        let (code, _, messages) = piped(at, &[&set[..], more].concat(), &text);
        assert_eq!(code, 0, "{messages}");
        let facts: Value =
            serde_json::from_slice(&fs::read(at.join(output).join("labels.json")).unwrap()).unwrap();
        assert_eq!(facts["rate"], 96.0, "{messages}");
        let recording = fs::read_to_string(at.join(output).join("a/session-1/001.csv")).unwrap();
        assert!(recording.lines().nth(2).unwrap().starts_with("0.01041"), "{recording:.80}");
    }
    let set = ["record", "--input", "-", "--label", "a", "--rate", "50", "--output", "third"];
    let (code, _, messages) = piped(at, &set, &text);
    assert!(
        code == 2 && messages.contains("--rate 50: the time stamps of standard input say 96 Hz"),
        "{messages}"
    );
}

/// Starts a recording from a port.
fn from_port(folder: &Path, port: &str, more: &[&str]) -> Child {
    taxel(folder, &record(&["--serial", port], more)).spawn().unwrap()
}

/// Waits until so many recordings are there.
fn wait_for(folder: &Path, count: usize) {
    let begin = Instant::now();
    while !folder.exists() || files(folder).len() < count {
        assert!(begin.elapsed() < Duration::from_secs(60), "{count} recordings");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_port_that_is_pulled_and_signals_lose_nothing_that_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let skin = at.join("skin");
    let end = |child: Child, code: i32, why: &str| {
        let (found, _, messages) = parts(&child.wait_with_output().unwrap());
        assert!(found == code && messages.contains(why), "{found}: {messages}");
        let rows: Vec<usize> = files(&skin).into_values().collect();
        assert!(rows.iter().all(|count| *count == rows[0] && (70..80).contains(count)), "{rows:?}");
        assert!(taxel::load(&skin, &taxel::ReadOptions::default()).is_ok() || files(&skin).len() < 2);
    };
    // The cable is pulled.
    let sensor = Sensor::start(100.0);
    let child = from_port(at, &sensor.port, &["--count", "50"]);
    wait_for(&skin, 2);
    std::thread::sleep(Duration::from_millis(300));
    drop(sensor);
    end(child, 2, "not kept");
    let after_pull = files(&skin).len();
    // Ctrl-C and SIGTERM.
    for signal in ["-INT", "-TERM"] {
        let sensor = Sensor::start(100.0);
        let before = files(&skin).len();
        let child = from_port(at, &sensor.port, &["--count", "50"]);
        wait_for(&skin, before + 1);
        std::thread::sleep(Duration::from_millis(300));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        end(child, 130, "not kept, it was stopped");
    }
    assert!(files(&skin).len() >= after_pull + 2);
    let facts: Value = serde_json::from_str(&fs::read_to_string(skin.join("labels.json")).unwrap()).unwrap();
    let rate = facts["rate"].as_f64().unwrap();
    assert!((rate / 100.0 - 1.0).abs() < 0.05, "{rate}");
    assert_eq!(facts["channels"], serde_json::json!(["thumb", "index"]));
}

#[test]
fn a_person_starts_throws_away_and_chooses() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sensor = Sensor::start(200.0);
    let arguments = record(&["--serial", &sensor.port], &["--count", "2", "--pause", "0"]);
    let mut person = Person::at(&mut taxel(at, &arguments));
    let line = person.hears("1 of 4:");
    let first = if line.contains("cup") { "cup" } else { "pot" };
    person.writes("what\n");
    person.hears("no key and no label");
    person.writes("\n");
    person.hears("do not touch it yet");
    person.hears("now touch it");
    person.hears("2 of 4:");
    assert_eq!(files(&at.join("skin")).len(), 1);
    person.writes("u\n");
    person.hears("thrown away");
    let line = person.hears("1 of 4:");
    assert!(line.contains(first), "the same label comes again: {line}");
    assert_eq!(files(&at.join("skin")).len(), 0);
    assert!(
        !at.join("skin/cup").exists() && !at.join("skin/pot").exists(),
        "no folder without files is left"
    );
    person.writes("pot\n");
    person.hears("1 of 4: pot");
    person.writes("\n");
    person.hears("2 of 4: cup");
    person.writes("s\n");
    person.hears("(session-2)");
    person.writes("\n");
    person.hears("3 of 4:");
    person.writes("q\n");
    person.hears("2 of 4 recordings");
    let (code, _) = person.leaves();
    assert_eq!(code, 0);
    let names: Vec<String> = files(&at.join("skin")).into_keys().collect();
    assert_eq!(names, ["cup/session-2/001.csv", "pot/session-1/001.csv"]);
}

#[test]
fn the_live_page_shows_what_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sensor = Sensor::start(100.0);
    let more = ["--count", "1", "--start", "now", "--serve", "127.0.0.1:0"];
    let served = Served::of(&mut taxel(at, &record(&["--serial", &sensor.port], &more)));
    assert!(get(&served.host, "/").contains("<!doctype html>"));
    let seen = events(&served.host, |all| all.iter().any(|(name, _)| name == "end"));
    let of = |wanted: &str| -> Vec<&Value> {
        seen.iter().filter(|(name, _)| name == wanted).map(|(_, data)| data).collect()
    };
    assert_eq!(of("facts")[0]["channels"], serde_json::json!(["thumb", "index"]));
    let takes = of("take");
    assert!(takes.len() == 2 && takes.iter().all(|take| take["kept"] == true), "{takes:?}");
    let phases: Vec<&str> = of("phase").iter().map(|phase| phase["phase"].as_str().unwrap()).collect();
    assert_eq!(phases, ["rest", "touch", "kept", "rest", "touch", "kept"]);
    assert!(of("readings").len() > 5);
    assert_eq!(of("end")[0]["why"], "complete");
    served.ends(0);
}
