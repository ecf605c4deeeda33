//! Pauses in time stamps, and recordings of other rates in one set, are said with their place.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::files;
use std::path::{Path, PathBuf};
use taxel_data::{ReadOptions, check_with, load};
use tempfile::tempdir;

/// Time steps of a file: at a rate, with a pause of so many seconds after the step 20.
fn stamps(rate: f64, pause: f64) -> Vec<f64> {
    (0..60).map(|i| f64::from(i) / rate + if i > 20 { pause } else { 0.0 }).collect()
}

fn value(file: usize, at: usize) -> f32 {
    (file * 7 + at * at % 11) as f32 + 0.25
}

/// Writes recordings of two classes, `of` says the stamps of each, in class folders of a format or in one table.
fn write(root: &Path, form: &str, of: impl Fn(usize) -> Vec<f64>) -> PathBuf {
    let class = |file: usize| ["soft", "hard"][file % 2];
    match form {
        "table" => {
            let row = |file: usize, (at, time): (usize, f64)| {
                format!("r{file},{:.6},{},{}\n", 1e3 * time, value(file, at), class(file))
            };
            let rows =
                (0..6).flat_map(|file| of(file).into_iter().enumerate().map(move |one| row(file, one)));
            let text = format!("recording,time_ms,force,label\n{}", rows.collect::<String>());
            files(root, &[("t.csv", &text)]);
            root.join("t.csv")
        }
        ending => {
            for file in 0..6 {
                let line = |(at, time): (usize, f64)| match ending {
                    "csv" => format!("{time:.6},{}\n", value(file, at)),
                    _ => format!("{{\"t\": {time:.6}, \"force\": {}}}\n", value(file, at)),
                };
                let head = if ending == "csv" { "time,force\n" } else { "" };
                let text =
                    format!("{head}{}", of(file).into_iter().enumerate().map(line).collect::<String>());
                files(root, &[(&format!("set/{}/r{file}.{ending}", class(file)), &text)]);
            }
            root.join("set")
        }
    }
}

fn said(form: &str, of: impl Fn(usize) -> Vec<f64>) -> String {
    let folder = tempdir().unwrap();
    let path = write(folder.path(), form, of);
    let options = ReadOptions { length: Some("crop:50".parse().unwrap()), ..ReadOptions::default() };
    let card = check_with(&path, &options).unwrap();
    assert_eq!(card.problems, [""; 0]);
    let read = load(&path, &options).unwrap().warnings;
    assert!(read.iter().all(|words| card.warnings.contains(words)), "the card says what a run says");
    read.join("\n")
}

#[test]
fn a_pause_is_said_with_its_recording_place_and_length() {
    for form in ["table", "csv", "jsonl"] {
        assert_eq!(said(form, |_| stamps(100.0, 0.0)), "", "{form}");
        let words = said(form, |file| stamps(100.0, if file == 3 { 0.7 } else { 0.0 }));
        assert!(words.contains("1 recording pauses") && words.contains("r3"), "{form}: {words}");
        assert!(words.contains("for 0.710 s at 0.200 s (its usual step is 10.000 ms)"), "{form}: {words}");
        assert!(words.contains("cut recordings at their pauses"), "{form}: {words}");
    }
}

#[test]
fn recordings_of_another_rate_are_said() {
    for form in ["table", "csv", "jsonl"] {
        let words = said(form, |file| stamps(if file == 4 { 50.0 } else { 100.0 }, 0.0));
        assert!(words.contains("5 of 6 about 100.0 Hz") && words.contains("with 50.0 Hz"), "{form}: {words}");
        assert!(words.contains("r4"), "{form}: {words}");
        assert_eq!(
            said(form, |file| stamps(if file == 4 { 99.0 } else { 100.0 }, 0.0)),
            "",
            "{form}: a clock"
        );
    }
}
