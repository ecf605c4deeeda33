//! The first hour of a person with a sensor: a cable, a data set, a network, a model on the sensor.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/browser.rs"]
mod browser;
#[path = "support/page.rs"]
mod page;
#[path = "support/person.rs"]
mod person;
#[path = "support/program.rs"]
mod program;
#[path = "support/sensor.rs"]
mod sensor;

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use page::{Served, events, get};
use person::Person;
use program::taxel;
use sensor::Sensor;

/// Recordings of each label.
const COUNT: usize = 6;

/// Runs a command that has to do well; returns what it said.
fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = taxel(folder, arguments).output().unwrap();
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
    said
}

/// A sensor at 200 Hz whose presses are slow for what is held while `held` is 0, and quick while it is 1.
fn sensor(held: &Arc<AtomicUsize>) -> Sensor {
    let held = Arc::clone(held);
    Sensor::of(200.0, move |t| {
        let speed = [0.05, 0.31][held.load(Ordering::Relaxed)];
        let noise = ((t * 7919) % 13) as f64 * 0.05;
        let force = 40.0 * (1.0 + (speed * t as f64).sin());
        [100.0 + force + noise, 300.0 - 0.5 * force + noise]
    })
}

/// Records as a person does: holds what is asked for, presses Enter; returns how it ended, and the recordings that were begun.
fn record(folder: &Path, held: &Arc<AtomicUsize>, sensor: Sensor, pulled_at: Option<usize>) -> (i32, String) {
    let arguments = [
        "record",
        "--serial",
        &sensor.port,
        "--label",
        "slow",
        "--label",
        "quick",
        "--seconds",
        "0.3",
        "--pause",
        "0",
        "--count",
        &COUNT.to_string(),
        "--output",
        "skin",
    ];
    let mut person = Person::at(&mut taxel(folder, &arguments));
    let mut sensor = Some(sensor);
    let mut begun = 0;
    while let Some(line) = person.next() {
        if line.contains(". Enter starts") {
            let label = line.split(": ").nth(1).unwrap();
            held.store(usize::from(label.starts_with("quick")), Ordering::Relaxed);
            person.writes("\n");
            begun += 1;
        }
        if line.contains("now touch it") && pulled_at == Some(begun) {
            sensor = None;
        }
    }
    let ended = person.leaves();
    drop(sensor);
    ended
}

/// Trains on the recordings, and makes a model; returns the table of scores.
fn trained(at: &Path) -> String {
    let table = good(at, &["run", "skin", "--budget", "2s", "--set", "train.least_steps=1"]);
    good(at, &["fit", "runs/skin", "--network", "mini-rocket", "--output", "skin.safetensors"]);
    table
}

/// Starts a stream of quick presses with its live page.
fn served(at: &Path, held: &Arc<AtomicUsize>) -> (Sensor, Served) {
    let last = sensor(held);
    held.store(1, Ordering::Relaxed);
    let arguments =
        ["stream", "skin.safetensors", "--serial", &last.port, "--serve", "127.0.0.1:0", "--unknown", "0"];
    let served = Served::of(&mut taxel(at, &arguments));
    (last, served)
}

#[test]
fn from_a_cable_to_decisions_on_the_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let held = Arc::new(AtomicUsize::new(0));
    // The cable is pulled in the middle of the seventh recording.
    let (code, said) = record(at, &held, sensor(&held), Some(7));
    assert!(code == 2 && said.contains("not kept") && said.contains("6 of 12 recordings"), "{code}: {said}");
    let (code, said) = record(at, &held, sensor(&held), None);
    assert!(code == 0 && said.contains("12 of 12 recordings, 6 of them new"), "{code}: {said}");

    let card = good(at, &["data", "check", "skin"]);
    // A quarter of a second at rest, at the rate that the time stamps give.
    let number = |after: &str| -> f64 {
        let digits = card.split(after).nth(1).unwrap_or_default();
        digits.chars().take_while(char::is_ascii_digit).collect::<String>().parse().unwrap_or(f64::NAN)
    };
    let (rate, rest) = (number("time stamps give "), number("tared by recording:"));
    assert!(card.contains("quick") && (0.25 * rate - rest).abs() <= 1.0, "{card}");
    let table = trained(at);
    assert!(table.contains("grouped 2-fold"), "sessions are groups: {table}");
    good(at, &["report", "runs/skin", "--no-stress"]);

    // On the sensor's own controller: C with the same bits.
    let said =
        good(at, &["export", "skin.safetensors", "--output", "sensor", "--format", "c", "--name", "skin"]);
    assert!(said.contains("flash") && said.contains("RAM"), "{said}");
    let check = at.join("check");
    let arguments = ["-std=c99", "-O2", "sensor/test/check.c", "-o"];
    let compiled = Command::new("cc").current_dir(at).args(arguments).arg(&check).output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let said = Command::new(&check).output().unwrap();
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("equal: 200 samples") && said.contains(" 0 differences"), "{said}");

    // Another recording, and what the model takes it for.
    let last = sensor(&held);
    let more = [
        "record",
        "--serial",
        &last.port,
        "--output",
        "skin",
        "--count",
        "7",
        "--start",
        "now",
        "--model",
        "skin.safetensors",
    ];
    let said = good(at, &more);
    assert!(said.contains("model: "), "{said}");
    drop(last);

    let (last, served) = served(at, &held);
    assert!(get(&served.host, "/").contains("<!doctype html>"));
    let decisions =
        |all: &[(String, serde_json::Value)]| all.iter().filter(|(name, _)| name == "decision").count();
    let seen = events(&served.host, |all| decisions(all) == 4);
    let classes: Vec<&str> = seen
        .iter()
        .filter(|(name, _)| name == "decision")
        .map(|(_, decision)| decision["class"].as_str().unwrap())
        .collect();
    assert!(classes.iter().all(|class| ["slow", "quick"].contains(class)), "{classes:?}");
    assert_eq!(seen[0].1["channels"], serde_json::json!(["thumb", "index"]));
    served.stop();
    drop(last);
}

#[test]
#[ignore = "needs chromium"]
fn needs_chromium_that_shows_decisions_as_they_come() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let held = Arc::new(AtomicUsize::new(0));
    let (code, said) = record(at, &held, sensor(&held), None);
    assert_eq!(code, 0, "{said}");
    trained(at);
    let (last, served) = served(at, &held);
    let page = browser::page_with_decision(&served.host);
    let class = page.split("id=\"class\"").nth(1).and_then(|rest| rest.split(['>', '<']).nth(1));
    assert!(class.is_some_and(|class| ["slow", "quick"].contains(&class)), "{class:?}: {page}");
    assert!(page.contains("thumb") && page.contains("index"), "names of the channels: {page}");
    served.stop();
    drop(last);
}
