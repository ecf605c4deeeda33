//! Models say how sure they may be: fitted on the test parts of a run, or on own recordings.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

fn taxel(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).env("TAXEL_THREADS", "2").env_remove("RUST_BACKTRACE").stdin(Stdio::null());
    command.output().unwrap()
}

fn good(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

fn refused(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// Runs with these lines on standard error too.
fn said(arguments: &[&str]) -> (String, String) {
    let output = taxel(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    (String::from_utf8(output.stdout).unwrap(), error)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A run of MiniRocket and an MLP on simulated presses, of other fingertips in each part.
struct Ran {
    folder: TempDir,
}

impl Ran {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("c.toml");
        std::fs::write(
            &config,
            "name = \"presses\"\nbaselines = [\"mini-rocket\", \"k-nn\"]\n[data]\nscene = \"fingertip\"\nsamples = 120\n[protocol]\n\
             kind = \"k-fold\"\nfolds = 3\nsplit = \"group\"\n[train]\nepochs = 60\n[[networks]]\nname = \"mlp\"\n",
        )
        .unwrap();
        let run = folder.path().join("run");
        good(&["run", text(&config), "--output", text(&run)]);
        Ran { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn fit(&self, network: &str, name: &str, more: &[&str]) -> PathBuf {
        let (run, model) = (self.path("run"), self.path(name));
        let arguments = ["fit", text(&run), "--network", network, "--output", text(&model)];
        good(&[&arguments[..], more].concat());
        model
    }

    fn answers(&self, model: &Path, data: &Path) -> Vec<Value> {
        let printed = good(&["predict", text(model), text(data), "--format", "json"]);
        let all: Value = serde_json::from_str(&printed).unwrap();
        all["answers"].as_array().unwrap().clone()
    }

    fn presses(&self, name: &str, seed: &str) -> PathBuf {
        let path = self.path(name);
        good(&["simulate", "fingertip", "--samples", "60", "--seed", seed, "--output", text(&path)]);
        path
    }
}

fn certainty(model: &Path) -> Value {
    let card: Value = serde_json::from_str(&good(&["inspect", text(model), "--format", "json"])).unwrap();
    card["certainty"].clone()
}

fn highest(answer: &Value) -> f64 {
    let probabilities = answer["probabilities"].as_object().unwrap();
    probabilities.values().map(|p| p.as_f64().unwrap()).fold(0.0, f64::max)
}

#[test]
fn a_model_is_as_sure_as_its_run_was_right() {
    let ran = Ran::new();
    let new = ran.presses("new.npz", "9");
    for network in ["mini-rocket", "mlp"] {
        let (fitted, plain) = (
            ran.fit(network, "fitted.safetensors", &[]),
            ran.fit(network, "plain.safetensors", &["--no-calibration"]),
        );
        assert_eq!(certainty(&plain), Value::Null);
        assert!(good(&["inspect", text(&plain)]).contains("not calibrated"));
        let card = certainty(&fitted);
        assert_eq!(
            (&card["fitted_on"]["samples"], &card["fitted_on"]["parts"]),
            (&120.into(), &"groups".into())
        );
        assert_eq!(card["tenths"].as_array().unwrap().len(), 10);
        let error = |key: &str| card["calibration_error"][key].as_f64().unwrap();
        assert!(error("after") < error("before") + 0.01, "{}", card["calibration_error"]);
        let [sure, shy] = [&fitted, &plain].map(|model| ran.answers(model, &new));
        let class = |answer: &Value| answer.get("likeliest").unwrap_or(&answer["predicted"])["class"].clone();
        let classes = |all: &[Value]| all.iter().map(class).collect::<Vec<_>>();
        assert_eq!(classes(&sure), classes(&shy), "the answers stay");
        assert!(sure.iter().zip(&shy).any(|(a, b)| highest(a) != highest(b)));
        let right = sure.iter().filter(|answer| class(answer) == answer["true"][0]).count();
        let said: f64 = sure.iter().map(highest).sum::<f64>() / sure.len() as f64;
        let share = right as f64 / sure.len() as f64;
        assert!((said - share).abs() < 0.15, "{network} says {said} and is right in {share}");
    }
}

#[test]
fn own_recordings_calibrate_a_model_that_has_not_seen_them() {
    let ran = Ran::new();
    let model = ran.fit("mini-rocket", "plain.safetensors", &["--no-calibration"]);
    let (new, output) = (ran.presses("own.npz", "7"), ran.path("calibrated.safetensors"));
    let printed = good(&["calibrate", text(&model), text(&new), "--output", text(&output)]);
    assert!(printed.contains("fitted on 60 held-out predictions"), "{printed}");
    assert_eq!(certainty(&output)["fitted_on"]["parts"], "recordings");
    let few = ran.path("few.npz");
    good(&["simulate", "fingertip", "--samples", "12", "--seed", "3", "--output", text(&few)]);
    let error =
        refused(&["calibrate", text(&model), text(&few), "--output", text(&ran.path("x.safetensors"))]);
    assert!(error.contains("12 samples; give 30 or more") && !ran.path("x.safetensors").exists(), "{error}");
}

#[test]
fn onnx_has_the_temperature_and_is_read_back_without_it() {
    let ran = Ran::new();
    let model = ran.fit("mlp", "mlp.safetensors", &[]);
    let (onnx, back) = (ran.path("mlp.onnx"), ran.path("back.safetensors"));
    good(&["export", text(&model), "--output", text(&onnx)]);
    let bytes = std::fs::read(&onnx).unwrap();
    assert!(bytes.windows(17).any(|part| part == b"taxel.temperature"));
    let output = taxel(&["import", text(&onnx), "--output", text(&back)]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
}

#[test]
fn c_has_the_bits_of_a_calibrated_model_in_eight_bits() {
    let ran = Ran::new();
    let (model, new) = (ran.fit("mlp", "mlp.safetensors", &[]), ran.presses("own.npz", "7"));
    let (small, folder) = (ran.path("small.safetensors"), ran.path("firmware"));
    let refusal = refused(&["cost", text(&model), "--target", "m3"]);
    assert!(refusal.contains("is in 32-bit floats") && refusal.contains("taxel quantize"), "{refusal}");
    good(&["quantize", text(&model), "--calibrate", text(&new), "--output", text(&small)]);
    let call = ["export", text(&small), "--output", text(&folder), "--format", "c", "--name", "Two Words"];
    let said = good(&call);
    assert!(said.contains("functions taxel_two_words_") && said.contains("RAM: "), "{said}");
    let source = std::fs::read(folder.join("src/taxel_two_words.c")).unwrap();
    good(&call);
    assert!(
        source == std::fs::read(folder.join("src/taxel_two_words.c")).unwrap(),
        "equal models give equal files"
    );
    let program = ran.path("check");
    let compiled = Command::new("cc")
        .args(["-std=c99", "-O2"])
        .arg(folder.join("test/check.c"))
        .arg("-o")
        .arg(&program)
        .status();
    assert!(compiled.unwrap().success());
    let checked = Command::new(&program).output().unwrap();
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(checked.status.success() && said.starts_with("equal: 200 samples"), "{said}");
    let error = refused(&["export", text(&small), "--output", text(&ran.path("x.onnx")), "--name", "x"]);
    assert!(error.contains("--name belongs to --format c"), "{error}");
}

/// Writes samples that no finger has felt, of the shape of the presses.
fn foreign(ran: &Ran, name: &str, value: impl Fn(usize) -> f32) -> PathBuf {
    let shape = [60, 5, 50];
    let values: Vec<f32> = (0..shape.iter().product()).map(value).collect();
    let mut npz = taxel::data::Npz::default();
    npz.add("x", &shape.map(|n| n), &values).unwrap();
    let path = ran.path(name);
    std::fs::write(&path, npz.finish().unwrap()).unwrap();
    path
}

#[test]
fn samples_that_no_finger_has_felt_are_unknown_and_sets_hold_the_truth() {
    let ran = Ran::new();
    let new = ran.presses("new.npz", "5");
    for network in ["mini-rocket", "mlp", "k-nn"] {
        let model = ran.fit(network, "gated.safetensors", &[]);
        let card = certainty(&model);
        let count = |list: &Value| list.as_array().map_or(0, Vec::len);
        // k-NN has no logits: its readings alone tell.
        let of_logits = if network == "k-nn" { [0, 0, 0] } else { [100, 10, 100] };
        let [seen, readings] = ["seen", "readings"].map(|gate| &card[gate]);
        let lists = [&seen["distances"], &seen["tenths"], &readings["together"]].map(count);
        assert_eq!((lists, count(&readings["distances"])), (of_logits, 100), "{network}");
        let unknown = |data: &Path, more: &[&str]| {
            let arguments =
                [&["predict", text(&model), text(data), "--format", "json", "--as-is"], more].concat();
            let all: Value = serde_json::from_str(&good(&arguments)).unwrap();
            let answers = all["answers"].as_array().unwrap().clone();
            let share = answers.iter().filter(|answer| answer["predicted"]["class"] == "unknown").count();
            (share as f64 / answers.len() as f64, answers)
        };
        // A hash as white noise between 0 and full scale.
        let hash = |i: usize| (i as u32).wrapping_mul(2_654_435_761) >> 8;
        let foreign = [
            ("noise", foreign(&ran, "noise.npz", |i| hash(i) as f32 / (1 << 24) as f32 * 5.0)),
            ("zeros", foreign(&ran, "zeros.npz", |_| 0.0)),
            ("full scale", foreign(&ran, "full.npz", |_| 5.0)),
            ("faint noise", foreign(&ran, "faint.npz", |i| 1.0 + hash(i) as f32 / (1 << 24) as f32 * 0.1)),
            ("stuck channels", foreign(&ran, "stuck.npz", |i| (i / 50 % 5) as f32)),
            ("another sensor", foreign(&ran, "other.npz", |i| 4000.0 + (i % 50) as f32)),
        ];
        for (name, path) in foreign {
            let (share, answers) = unknown(&path, &[]);
            assert!(share >= 0.95, "{network}: {share} of {name} are unknown");
            assert!(
                answers[0]["likeliest"]["class"].is_string()
                    && answers[0]["familiarity"].as_f64().unwrap() <= 0.05
            );
            assert_eq!(unknown(&path, &["--unknown", "0"]).0, 0.0, "the likeliest class if that is wanted");
        }
        let learned = ran.path("learned.npz");
        good(&["simulate", "fingertip", "--samples", "120", "--output", text(&learned)]);
        let (share, _) = unknown(&learned, &[]);
        assert!(share < 0.15, "{network}: {share} of the presses that it has learned are unknown");
        let (share, answers) = unknown(&new, &["--set", "0.9"]);
        // Other fingertips than in training.
        assert!(share < 0.4, "{network}: {share} of other presses are unknown");
        let holds = |answer: &&Value| answer["set"]["class"].as_array().unwrap().contains(&answer["true"][0]);
        let covered = answers.iter().filter(holds).count() as f64 / answers.len() as f64;
        assert!(covered >= 0.8, "{network}: {covered} of the sets hold the true class");
        let table = good(&["predict", text(&model), text(&new), "--set", "0.99"]);
        assert!(table.contains("99 % set") && table.contains(" | "), "{table}");
        let csv = good(&["predict", text(&model), text(&new), "--format", "csv"]);
        assert!(csv.lines().next().unwrap().ends_with("likeliest class,familiarity"), "{csv}");
    }
}

#[test]
fn what_a_model_does_not_know_it_is_not_asked() {
    let ran = Ran::new();
    let new = ran.presses("new.npz", "5");
    let model = ran.fit("k-nn", "knn.safetensors", &[]);
    let error = refused(&["predict", text(&model), text(&new), "--set", "0.7"]);
    assert!(error.contains("0.8, 0.9, 0.95 and 0.99"), "{error}");
    let plain = ran.fit("mlp", "plain.safetensors", &["--no-calibration"]);
    let error = refused(&["predict", text(&plain), text(&new), "--unknown", "0.05"]);
    assert!(error.contains("does not know which samples are familiar"), "{error}");
    let error = refused(&["predict", text(&plain), text(&new), "--set", "0.9"]);
    assert!(error.contains("is not calibrated"), "{error}");
    let error = refused(&["predict", text(&plain), text(&new), "--unknown", "1"]);
    assert!(error.contains("below 1"), "{error}");
}

#[test]
fn a_stream_says_what_is_unknown_and_decides_early_only_if_that_is_worth_it() {
    let ran = Ran::new();
    let (new, model) = (ran.presses("new.npz", "5"), ran.fit("mini-rocket", "m.safetensors", &[]));
    let noise = foreign(&ran, "noise.npz", |i| ((i * 7919) % 101) as f32 / 20.0);
    let lines = |data: &Path, more: &[&str]| {
        let (out, error) =
            said(&[&["stream", text(&model), "--input", text(data), "--as-is"], more].concat());
        (out.lines().map(|line| serde_json::from_str(line).unwrap()).collect::<Vec<Value>>(), error)
    };
    let (decisions, summary) = lines(&noise, &[]);
    assert!(
        decisions.iter().all(|line| line["class"] == "unknown" && line["likeliest"].is_string()),
        "{decisions:?}"
    );
    assert!(summary.contains("\"unknown\":60"), "{summary}");
    let (decisions, _) = lines(&new, &["--set", "0.9", "--early", "0.9"]);
    assert!(decisions.iter().all(|line| line["set"].is_array() && line["familiarity"].is_number()));
    // Of decisions before the window is full nine in ten are right, or none is made.
    let card = certainty(&model);
    let record =
        card["early"].as_array().unwrap().iter().find(|record| record["confidence"] == 0.9).unwrap().clone();
    let early: Vec<&Value> = decisions.iter().filter(|line| line["seen"].as_f64().unwrap() < 1.0).collect();
    assert!(early.is_empty() || record["right"].as_f64().unwrap() > 0.8, "{record}");
    // They are looked at in tenths, and as sure as it takes for that.
    let least = record["least"].as_f64().unwrap();
    assert!((0.9..=1.0).contains(&least), "{record}");
    for line in &early {
        let tenths = 10.0 * line["seen"].as_f64().unwrap();
        assert!((tenths - tenths.round()).abs() < 1e-6 && highest(line) >= least - 1e-6, "{line}");
    }
}

#[test]
fn mini_rocket_without_a_run_is_calibrated_by_leaving_one_out() {
    let ran = Ran::new();
    let model = ran.path("alone.safetensors");
    let config = ran.path("c.toml");
    good(&["fit", text(&config), "--network", "mini-rocket", "--output", text(&model)]);
    let card = certainty(&model);
    assert_eq!((&card["fitted_on"]["samples"], &card["fitted_on"]["parts"]), (&120.into(), &"groups".into()));
    let of_run = certainty(&ran.fit("mini-rocket", "run.safetensors", &[]));
    let [own, wanted] = [&card, &of_run].map(|card| card["temperature"].as_f64().unwrap());
    assert!((own / wanted - 1.0).abs() < 0.5, "{own} and {wanted} of the folds of the run");
    let plain = ran.path("plain.safetensors");
    good(&["fit", text(&config), "--network", "mini-rocket", "--no-calibration", "--output", text(&plain)]);
    assert_eq!(certainty(&plain), Value::Null);
}

#[test]
fn eight_bits_are_as_sure_as_floats() {
    let ran = Ran::new();
    let (model, own, new) =
        (ran.fit("mlp", "mlp.safetensors", &[]), ran.presses("own.npz", "7"), ran.presses("new.npz", "8"));
    let small = ran.path("small.safetensors");
    good(&["quantize", text(&model), "--calibrate", text(&own), "--output", text(&small)]);
    let [floats, bits] = [&model, &small].map(|model| ran.answers(model, &new));
    let said = |all: &[Value]| all.iter().map(highest).sum::<f64>() / all.len() as f64;
    assert!((said(&floats) - said(&bits)).abs() < 0.03, "{} and {}", said(&floats), said(&bits));
    assert!(certainty(&small)["seen"].is_object());
}

#[test]
fn a_run_without_some_classes_says_whether_its_gates_tell_them() {
    let ran = Ran::new();
    let (config, run) = (ran.path("c.toml"), ran.path("run"));
    let arguments = ["run", text(&config), "--set", "unknown.draws=2", "--resume", "--output", text(&run)];
    let reported = || {
        good(&["report", text(&run)]);
        std::fs::read_to_string(run.join("tables/certainty.csv")).unwrap().contains("unknown_auroc")
    };
    assert!(!reported());
    good(&arguments);
    assert!(reported(), "a report of before knows what was tried since");
    let scores: Value =
        serde_json::from_str(&std::fs::read_to_string(run.join("unknown.json")).unwrap()).unwrap();
    let rows: Vec<&str> =
        scores.as_array().unwrap().iter().map(|row| row["network"].as_str().unwrap()).collect();
    assert_eq!(rows, ["mlp", "mini-rocket"], "k-NN has no logits");
    for row in scores.as_array().unwrap() {
        let draws = row["draws"].as_array().unwrap();
        assert_eq!(draws.len(), 2);
        for draw in draws {
            assert_eq!(draw["known"].as_u64().unwrap() + draw["unknown"].as_u64().unwrap(), 120);
            assert!((0.0..=1.0).contains(&draw["auroc"].as_f64().unwrap()));
        }
    }
    let trainings = || {
        std::fs::read_dir(run.join("unknown"))
            .unwrap()
            .map(|entry| entry.unwrap().metadata().unwrap().modified().unwrap())
            .max()
    };
    let last = trainings();
    good(&arguments);
    assert_eq!(trainings(), last, "finished trainings are kept");
}
