//! Time stamps that repeat, wrap, fall or are no numbers of seconds.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{files, refused};
use std::fmt::Write;
use taxel_data::{Dataset, ReadOptions, check, load};
use tempfile::tempdir;

/// Two recordings of each class in a long table; `stamp` gives the time of a row of a recording.
fn table(column: &str, rows: usize, stamp: impl Fn(usize, usize) -> String) -> String {
    let mut text = format!("recording,{column},force,label\n");
    for recording in 0..4 {
        for row in 0..rows {
            let (time, force) = (stamp(recording, row), 10 * recording + row);
            writeln!(text, "r{recording},{time},{force},{}", ["soft", "hard"][recording % 2]).unwrap();
        }
    }
    text
}

fn read(text: &str) -> (Result<Dataset, String>, Vec<String>) {
    let folder = tempdir().unwrap();
    let path = folder.path().join("presses.csv");
    std::fs::write(&path, text).unwrap();
    let read_as = check(&path).map_or(vec![], |card| card.read_as);
    (load(&path, &ReadOptions::default()).map_err(|e| e.to_string()), read_as)
}

fn message(text: &str) -> String {
    read(text).0.unwrap_err()
}

#[test]
fn counters_that_wrap_are_unwrapped_and_said() {
    let wrapped = |start: u64, step: u64, modulus: u64| {
        move |recording: usize, row: usize| {
            let raw = if recording == 2 { start + step * row as u64 } else { step * row as u64 };
            (raw % modulus).to_string()
        }
    };
    let (u32s, u16s) = (1u64 << 32, 1u64 << 16);
    for (column, start, step, modulus) in [
        ("t_us", u32s - 7296, 1000, u32s),
        ("t_ms", u32s - 35, 10, u32s),
        ("t_ms", u16s - 35, 10, u16s),
        ("t_us", u32s - 500, 1000, u32s),
    ] {
        let (data, read_as) = read(&table(column, 12, wrapped(start, step, modulus)));
        let data = data.unwrap();
        let per_second = if column == "t_us" { 1e6 } else { 1e3 };
        assert_eq!(data.spec.rate, Some(per_second / step as f64), "{column} {modulus}");
        let forces: Vec<f32> = (0..12).map(|row| (20 + row) as f32).collect();
        assert_eq!(data.x.as_slice().unwrap()[24..36], forces[..], "nothing is scrambled");
        assert!(read_as.iter().any(|line| line.contains("wrap")), "{read_as:?}");
    }
    // micros() that were written as seconds.
    let seconds = |recording: usize, row: usize| {
        let raw = if recording == 2 { (1u64 << 32) - 7296 } else { 0 } + 1000 * row as u64;
        format!("{:.6}", (raw % (1 << 32)) as f64 / 1e6)
    };
    assert_eq!(read(&table("t", 12, seconds)).0.unwrap().spec.rate, Some(1000.0));
}

#[test]
fn a_counter_that_wraps_in_a_gap_is_called_that() {
    let stamp = |_, row: usize| {
        if row < 6 { (1u64 << 32) - 7000 + 1000 * row as u64 } else { 90_000_000 + 1000 * row as u64 }
    };
    let text = table("t_us", 12, |recording, row| stamp(recording, row).to_string());
    let message = message(&text);
    assert!(message.contains("counter of 32 bits") && !message.contains("sort"), "{message}");
}

#[test]
fn time_that_goes_back_is_not_to_be_sorted() {
    let begins_again = message(&table("t", 12, |_, row| format!("{}", (row % 6) as f64 / 100.0)));
    assert!(begins_again.contains("line 8") && begins_again.contains("begins again"), "{begins_again}");
    let set_back = message(&table("t", 12, |_, row| {
        format!("{}", 5.0 + row as f64 / 100.0 - if row > 7 { 0.05 } else { 0.0 })
    }));
    assert!(set_back.contains("goes back"), "{set_back}");
    for message in [begins_again, set_back] {
        assert!(!message.contains("sort"), "{message}");
    }
}

#[test]
fn times_beyond_reason_are_written_short() {
    for stamps in [["1e300", "0"], ["0", "1e300"], ["-1e300", "1e300"]] {
        let text = table("t", 4, |_, row| if row < 2 { stamps[row].into() } else { format!("{}", row) });
        let message = message(&text);
        assert!(message.len() < 400 && !message.contains("000000000000"), "{message}");
    }
    let late =
        table("t", 9, |_, row| if row == 8 { "1e300".into() } else { format!("{}", row as f64 / 100.0) });
    assert!(message(&late).len() < 600, "{}", message(&late));
    let folder = tempdir().unwrap();
    let lines = "{\"t\": 1e300, \"a\": 1}\n{\"t\": 0, \"a\": 2}\n";
    files(folder.path(), &[("soft/1.jsonl", lines), ("hard/1.jsonl", lines)]);
    let message = refused(folder.path(), &ReadOptions::default());
    assert!(message.len() < 300, "{message}");
}

#[test]
fn of_time_steps_with_one_stamp_the_first_is_kept_and_the_others_are_counted() {
    let stamp = |recording: usize, row: usize| if recording == 1 && row > 20 { row - 1 } else { row };
    let text = table("t_ms", 40, |recording, row| (10 * stamp(recording, row)).to_string());
    let folder = tempdir().unwrap();
    let path = folder.path().join("presses.csv");
    std::fs::write(&path, &text).unwrap();
    let options = ReadOptions { length: Some("crop:39".parse().unwrap()), ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    let second = &data.x.as_slice().unwrap()[39..78];
    assert_eq!((second[20], second[21]), (30.0, 32.0), "the first of two is kept");
    assert_eq!(data.spec.rate, Some(100.0));
    let read_as = check(&path).unwrap().read_as.join("; ");
    assert!(read_as.contains("1 of 160 time steps repeats the stamp before it and is dropped"), "{read_as}");

    let lines = |from: usize| {
        let mut text = String::new();
        (0..40).for_each(|row| {
            writeln!(text, "{{\"t\": {}, \"a\": {row}}}", 0.01 * stamp(from, row) as f64).unwrap();
        });
        text
    };
    files(folder.path(), &[("set/soft/1.jsonl", &lines(1)), ("set/hard/1.jsonl", &lines(1))]);
    let data = load(&folder.path().join("set"), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape()[2], data.spec.rate), (39, Some(100.0)));
    let read_as = check(&folder.path().join("set")).unwrap().read_as.join("; ");
    assert!(read_as.contains("2 of 80 time steps repeat"), "{read_as}");
}

#[test]
fn a_clock_that_stands_still_is_refused() {
    let message = message(&table("t_ms", 40, |_, row| (row / 2).to_string()));
    assert!(message.contains("20 of the 40 time steps of recording \"r0\" repeat"), "{message}");
    assert!(message.contains("ignore"), "{message}");
}

#[test]
fn a_time_column_that_is_ignored_is_neither_time_nor_channel() {
    let text = table("t_us", 12, |_, row| (row % 6).to_string());
    let folder = tempdir().unwrap();
    let path = folder.path().join("presses.csv");
    std::fs::write(&path, text).unwrap();
    for name in ["t_us", "T_us"] {
        let table = format!("long,ignore={name}").parse().unwrap();
        let data = load(&path, &ReadOptions { table, ..ReadOptions::default() }).unwrap();
        assert_eq!((data.x.shape(), data.spec.rate), (&[4, 1, 12][..], None), "{name}");
    }
}

#[test]
fn a_counter_of_16_bits_may_wrap_to_0_and_never_reaches_its_range() {
    let counted = |last: i64, next: i64| {
        table("t_ms", 12, move |_, row| {
            let row = row as i64;
            (if row < 6 { last - 10 * (5 - row) } else { next + 10 * (row - 6) }).to_string()
        })
    };
    assert_eq!(read(&counted(65_526, 0)).0.unwrap().spec.rate, Some(100.0));
    // 65,536 is a stamp of more bits, whose time goes back.
    let message = message(&counted(65_536, 10));
    assert!(message.contains("65536 to 10"), "{message}");
}
