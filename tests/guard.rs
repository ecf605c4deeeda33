//! A guard before a network, as a user meets it: fitted, stated, at work, switched off, measured.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/quickstart.toml");

fn taxel(arguments: &[&str]) -> Output {
    let output = Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn out(arguments: &[&str]) -> String {
    String::from_utf8(taxel(arguments).stdout).unwrap()
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&out(arguments)).unwrap()
}

#[test]
fn a_model_behind_its_guard_answers_broken_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (clean, broken, model, plain) =
        (at("clean.npz"), at("broken.npz"), at("m.safetensors"), at("plain.safetensors"));
    taxel(&["simulate", "fingertip", "--samples", "90", "--output", &clean]);
    taxel(&[
        "simulate",
        "fingertip",
        "--samples",
        "90",
        "--fault",
        "stuck",
        "--severity",
        "5",
        "--output",
        &broken,
    ]);
    let fit =
        ["fit", QUICKSTART, "--quick", "--network", "mlp", "--data", &clean, "--set", "train.epochs=25"];
    let card = out(&[&fit[..], &["--guard", "--output", &model]].concat());
    assert!(card.contains("guard        on: 5 channels; readings 0 to 1023, fitted on 90 samples"), "{card}");
    assert!(!out(&[&fit[..], &["--output", &plain]].concat()).contains("guard"));
    assert!(out(&["inspect", &model]).contains("guard        on: 5 channels"));
    assert_eq!(json(&["inspect", &model, "--format", "json"])["guard"]["layout"], "series");

    // A quarter of five channels is one or two in each recording.
    let predict = ["predict", &model, &broken];
    let answers = json(&[&predict[..], &["--format", "json"]].concat());
    let replaced = |i: usize| answers["answers"][i]["replaced"].as_array().unwrap();
    assert!((0..90).all(|i| !replaced(i).is_empty()), "{answers}");
    let first = &replaced(0)[0];
    let channel = first["element"].as_u64().unwrap();
    assert_eq!(first["name"], format!("channel {channel}"));
    assert_eq!(first["how"], "full");
    let said = taxel(&predict);
    let (table, summary) = (String::from_utf8(said.stdout).unwrap(), String::from_utf8(said.stderr).unwrap());
    assert!(table.contains(&format!("channel {channel} (at full scale)")), "{table}");
    assert!(summary.contains("the guard replaced values in 90 of 90 samples: channel "), "{summary}");
    assert!(summary.contains("--no-guard leaves them"), "{summary}");
    let csv = out(&[&predict[..], &["--format", "csv"]].concat());
    assert!(csv.lines().next().unwrap().ends_with(",replaced"), "{csv}");
    let counts = |answers: &Value| answers["accuracy_percent"].as_f64().unwrap();

    // Switched off it answers as the model without one.
    let off = json(&[&predict[..], &["--no-guard", "--format", "json"]].concat());
    assert_eq!(off, json(&["predict", &plain, &broken, "--format", "json"]));
    assert!(
        off["answers"][0].get("replaced").is_none() && counts(&answers) > counts(&off),
        "{}",
        counts(&off)
    );
    let npz = at("answers.npz");
    taxel(&[&predict[..], &["--format", "npz", "--output", &npz]].concat());
    let mut npz = npyz::npz::NpzArchive::open(&npz).unwrap();
    let replaced: Vec<i64> = npz.by_name("replaced").unwrap().unwrap().into_vec().unwrap();
    assert!(replaced.len() == 90 && replaced.iter().all(|count| *count >= 1));
}

#[test]
fn a_run_without_a_guard_and_one_with_it_are_asked_both_ways() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (plain, guarded) = (at("plain"), at("guarded"));
    let set = [
        "--quick",
        "--set",
        "train.epochs=25",
        "--set",
        "baselines=[\"k-nn\"]",
        "--set",
        "networks=[{ name = \"mlp\" }]",
    ];
    taxel(&[&["run", QUICKSTART, "--output", &plain], &set[..]].concat());
    taxel(&[&["run", QUICKSTART, "--output", &guarded, "--set", "encoding.guard=true"], &set[..]].concat());
    let stress = |run: &str| {
        json(&["stress", run, "--compare-guard", "--fault", "stuck", "--severity", "5", "--format", "json"])
    };
    let [off, on] = [&plain, &guarded].map(|run| stress(run));
    assert_eq!(off["alarms"], on["alarms"], "the same guards, of the same training samples");
    assert_eq!((&off["alarms"]["samples"], &off["alarms"]["elements"]), (&120.into(), &5.into()));
    let mut gained = vec![];
    for (i, name) in ["mlp", "k-nn"].into_iter().enumerate() {
        let [a, b] = [&off, &on].map(|stress| &stress["networks"][i]);
        assert_eq!(
            (&a["network"], &a["other"]["is_guarded"], &b["other"]["is_guarded"]),
            (&name.into(), &true.into(), &false.into())
        );
        // A gate is fitted behind the guard that its models have.
        let points = |curve: &Value| {
            let mut points = curve["curves"][0]["points"].clone();
            points[0][1].as_object_mut().unwrap().remove("unknown");
            points
        };
        assert_eq!(points(a), points(&b["other"]), "{name} without");
        assert_eq!(points(&a["other"]), points(b), "{name} with");
        let accuracy = |points: &Value| points[0][1]["accuracy"].as_f64().unwrap();
        gained.push(accuracy(&points(b)) - accuracy(&points(a)));
    }
    assert!(gained.iter().all(|points| *points >= 0.0) && gained.iter().sum::<f64>() > 5.0, "{gained:?}");
    let text = out(&["stress", &plain, "--compare-guard", "--fault", "stuck", "--severity", "5"]);
    assert!(text.contains("without a guard > with one") && text.contains("false alarms: in "), "{text}");
    assert!(!out(&["stress", &plain, "--fault", "stuck", "--severity", "5"]).contains("guard"));
    assert!(
        std::fs::read_to_string(folder.path().join("guarded/config.toml")).unwrap().contains("guard = true")
    );
    out(&["report", &plain, "--compare-guard", "--max-samples", "20"]);
    let page = std::fs::read_to_string(folder.path().join("plain/report.html")).unwrap();
    assert!(page.contains("Behind a guard"));
}
