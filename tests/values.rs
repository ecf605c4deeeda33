//! Targets that are values from a file to a prediction, as a user goes: run, fit, inspect, predict.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use ndarray::ArrayD;
use serde_json::Value;
use taxel::data::{Quantity, Targets, Values};
use taxel::{Dataset, Layout};

/// Runs and expects this exit code; what was printed, on the stream of that code.
fn ends(code: i32, arguments: &[&str]) -> String {
    let output = Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    if code == 2 { error } else { String::from_utf8(output.stdout).unwrap() }
}

/// Presses from 0 to 10 N on two channels, whose readings are linear in the force, with a little noise.
fn presses(path: &Path, samples: usize, offset: usize) {
    let force = |i: usize| ((i * 37 + offset) % 101) as f32 / 10.1;
    let noise = |i: usize| ((i * 7919 % 997) as f32 / 997.0 - 0.5) * 0.02;
    let x = ArrayD::from_shape_fn(vec![samples, 2, 12], |at| {
        let rise = (at[2] + 1) as f32 / 12.0;
        force(at[0]) * rise * (1.0 + at[1] as f32) + noise(at[0] * 24 + at[1] * 12 + at[2])
    });
    save(path, Layout::Series, x, (0..samples).map(force).collect());
}

/// Saves samples of which the force is known.
fn save(path: &Path, layout: Layout, x: ArrayD<f32>, forces: Vec<f32>) {
    let mut dataset = Dataset::new("skin", layout, x, &vec![0; forces.len()]).unwrap();
    let quantity = Quantity { name: "force".into(), unit: Some("N".into()) };
    dataset.targets = Targets::Values(Values::new(vec![quantity], forces));
    dataset.save(path).unwrap();
}

const CONFIG: &str = r#"
name = "skin"
networks = []
[data]
path = "skin.npz"
[encoding]
signal = { scale = "raw" }
"#;

#[test]
fn a_force_is_learned_and_predicted_with_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("skin.npz"), 80, 0);
    presses(&folder.path().join("new.npz"), 20, 5);
    fs::write(folder.path().join("skin.toml"), CONFIG).unwrap();
    let (config, run, model, new) = (at("skin.toml"), at("run"), at("m.safetensors"), at("new.npz"));

    let table = ends(0, &["run", &config, "--output", &run]);
    assert!(table.contains("MAE N") && table.contains("R²"), "{table}");
    assert!(table.contains("left out: svm-rbf: learns classes, and the targets are values"), "{table}");
    let results: Value = serde_json::from_str(&fs::read_to_string(at("run/results.json")).unwrap()).unwrap();
    assert_eq!(results["quantities"][0]["unit"], "N");
    let networks = results["networks"].as_array().unwrap();
    let row = |name: &str| networks.iter().find(|row| row["network"] == name).unwrap();
    for name in ["mean", "k-nn", "mini-rocket", "extra-trees"] {
        assert!(row(name)["mean"]["mae"].is_f64(), "{name}");
    }
    let ridge = row("ridge");
    let mae = ridge["mean"]["mae"].as_f64().unwrap();
    assert!(mae < 0.05 && ridge["mean"]["r2"].as_f64().unwrap() > 0.999, "{ridge}");
    let interval = &ridge["interval"];
    assert!(interval[0].as_f64().unwrap() <= mae && mae <= interval[1].as_f64().unwrap(), "{interval}");
    // Nothing is trained again, and the scores follow from the records.
    ends(0, &["run", &config, "--output", &run, "--resume"]);

    ends(0, &["fit", &run, "--network", "ridge", "--output", &model]);
    let card = ends(0, &["inspect", &model]);
    assert!(card.contains("force: a value, in N") && card.contains("MAE 0.0"), "{card}");
    // A run that names no baselines has that of values all the same.
    ends(0, &["shrink", &run, "--network", "ridge", "--axes", "sensors", "--output", &at("smaller")]);
    let said = ends(0, &["predict", &model, &new, "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    for (i, answer) in said["answers"].as_array().unwrap().iter().enumerate() {
        let force = f64::from(((i * 37 + 5) % 101) as u32) / 10.1;
        let predicted = answer["predicted"]["force"].as_f64().unwrap();
        assert!((predicted - force).abs() < 0.2, "sample {i}: {predicted} for {force}");
    }
    let table = ends(0, &["predict", &model, &new]);
    assert!(table.contains("force (N)") && table.contains("  true"), "{table}");
    // The file holds the true forces: the same error as by hand.
    let errors = said["answers"].as_array().unwrap().iter().enumerate().map(|(i, answer)| {
        let force = f64::from(((i * 37 + 5) % 101) as u32) / 10.1;
        assert!((answer["true"][0].as_f64().unwrap() - force).abs() < 1e-5, "{answer}");
        (answer["predicted"]["force"].as_f64().unwrap() - force).abs()
    });
    let errors: Vec<f64> = errors.collect();
    let mae = errors.iter().sum::<f64>() / errors.len() as f64;
    let noted = Command::cargo_bin("taxel").unwrap().args(["predict", &model, &new]).output().unwrap().stderr;
    let noted = String::from_utf8(noted).unwrap();
    assert!(
        noted.contains(&format!("MAE {mae:.3} N")) && noted.contains("over 20 samples"),
        "{mae}: {noted}"
    );
}

#[test]
fn other_recordings_give_a_model_of_values_its_intervals() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("skin.npz"), 80, 0);
    presses(&folder.path().join("other.npz"), 60, 5);
    presses(&folder.path().join("few.npz"), 20, 5);
    fs::write(folder.path().join("skin.toml"), CONFIG).unwrap();
    let (plain, fitted) = (at("plain.safetensors"), at("fitted.safetensors"));
    ends(0, &["fit", &at("skin.toml"), "--network", "k-nn", "--no-calibration", "--output", &plain]);
    assert!(ends(0, &["inspect", &plain]).contains("no intervals"));

    let card = ends(0, &["calibrate", &plain, &at("other.npz"), "--output", &fitted, "--format", "json"]);
    let card: Value = serde_json::from_str(&card).unwrap();
    let intervals = &card["intervals"];
    assert_eq!(
        (&intervals["fitted_on"]["samples"], &intervals["fitted_on"]["parts"]),
        (&60.into(), &"recordings".into())
    );
    // Split conformal prediction by hand: the 55th of 60 errors at 90 %, the rank (60 + 1) 0.9 rounded up.
    let said = ends(0, &["predict", &plain, &at("other.npz"), "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let off = |answer: &Value| {
        (answer["predicted"]["force"].as_f64().unwrap() - answer["true"][0].as_f64().unwrap()).abs()
    };
    let mut errors: Vec<f64> = said["answers"].as_array().unwrap().iter().map(off).collect();
    errors.sort_by(f64::total_cmp);
    let half = intervals["at"].as_array().unwrap().iter().find(|at| at["share"] == 0.9).unwrap()["half"][0]
        .as_f64()
        .unwrap();
    assert!((half - errors[54]).abs() < 1e-5, "{half}, {errors:?}");

    let refused = |data: &str| ends(2, &["calibrate", &plain, &at(data), "--output", &at("x.safetensors")]);
    assert!(refused("few.npz").contains("20 samples; give 30 or more"));
    assert!(refused("skin.npz").contains("was trained on these recordings"));
    let x = ArrayD::from_shape_fn(vec![60, 2, 12], |at| at[0] as f32);
    let mut depths = Dataset::new("skin", Layout::Series, x, &[0; 60]).unwrap();
    let quantity = Quantity { name: "depth".into(), unit: Some("mm".into()) };
    depths.targets = Targets::Values(Values::new(vec![quantity], (0..60).map(|i| i as f32).collect()));
    depths.save(&folder.path().join("depths.npz")).unwrap();
    assert!(refused("depths.npz").contains("answers force (N), and the recordings have depth (mm)"));
}

#[test]
fn an_average_is_a_row_and_ships() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("skin.npz"), 80, 0);
    presses(&folder.path().join("new.npz"), 20, 5);
    let config = format!(
        "{}\n[[averages]]\nlabel = \"both\"\nof = [\"ridge\", \"extra-trees\"]\n",
        CONFIG.replace("networks = []", "networks = []\nbaselines = [\"ridge\", \"extra-trees\"]")
    );
    let (path, run, model, new) = (at("skin.toml"), at("run"), at("m.safetensors"), at("new.npz"));
    fs::write(&path, &config).unwrap();
    ends(0, &["run", &path, "--output", &run]);
    ends(0, &["report", &run]);
    ends(0, &["fit", &run, "--network", "both", "--output", &model]);
    let card = ends(0, &["inspect", &model]);
    assert!(card.contains("the mean of ridge and extra-trees") && card.contains("90 %"), "{card}");
    let mean = |name: &str| -> Vec<f64> {
        let model = at(&format!("{name}.safetensors"));
        ends(0, &["fit", &run, "--network", name, "--output", &model]);
        let said: Value =
            serde_json::from_str(&ends(0, &["predict", &model, &new, "--format", "json"])).unwrap();
        let answers = said["answers"].as_array().unwrap();
        answers.iter().map(|answer| answer["predicted"]["force"].as_f64().unwrap()).collect()
    };
    let (both, ridge, trees) = (mean("both"), mean("ridge"), mean("extra-trees"));
    for ((both, ridge), trees) in both.iter().zip(ridge).zip(trees) {
        assert!((both - (ridge + trees) / 2.0).abs() < 1e-4, "{both} of {ridge} and {trees}");
    }
    let lines: String = (0..12).map(|step| format!("{step},{step}\n")).collect();
    let stream =
        Command::cargo_bin("taxel").unwrap().args(["stream", &model]).write_stdin(lines).output().unwrap();
    let said = String::from_utf8_lossy(&stream.stdout).into_owned();
    assert!(
        stream.status.success() && said.contains("force"),
        "{said} {}",
        String::from_utf8_lossy(&stream.stderr)
    );
    let text = ends(2, &["export", &model, "--output", &at("m.onnx")]);
    assert!(text.contains("is an average, and a file of ONNX holds one network"), "{text}");
    let text = ends(2, &["export", &model, "--output", &at("c"), "--format", "c"]);
    assert!(text.contains("is an average, and C is printed of one network"), "{text}");
    let text = ends(2, &["fit", &new, "--from", &model, "--output", &at("other.safetensors")]);
    assert!(text.contains("it is an average"), "{text}");
    let text =
        ends(2, &["shrink", &run, "--network", "both", "--axes", "sensors", "--output", &at("smaller")]);
    assert!(text.contains("is an average, which has no smaller size"), "{text}");
    for (of, reason) in [
        (r#"["ridge"]"#, "an average needs two rows or more"),
        (r#"["ridge", "ridge"]"#, "name each row once"),
        (r#"["ridge", "extra-tree"]"#, "did you mean `extra-trees`"),
    ] {
        fs::write(&path, config.replace(r#"of = ["ridge", "extra-trees"]"#, &format!("of = {of}"))).unwrap();
        let text = ends(2, &["run", &path, "--output", &at("never")]);
        assert!(text.contains(reason), "{of}: {text}");
    }
}

#[test]
fn trees_ask_features_of_a_row_by_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let config = CONFIG.replace("networks = []", "networks = []\nbaselines = [\"extra-trees\"]");
    let scores = [Layout::Features, Layout::Series].map(|layout| {
        let value = |i: usize, at: usize| (((i * 37 + at * 53) % 101) * (at + 1)) as f32 / 10.1;
        let shape = if layout == Layout::Features { vec![80, 12] } else { vec![80, 12, 1] };
        let x = ArrayD::from_shape_fn(shape, |at| value(at[0], at[1]));
        save(&folder.path().join("skin.npz"), layout, x, (0..80).map(|i| value(i, 3)).collect());
        fs::write(folder.path().join("skin.toml"), &config).unwrap();
        let (run, model) = (path(layout.name()), path("m.safetensors"));
        ends(0, &["run", &path("skin.toml"), "--output", &run]);
        ends(0, &["fit", &run, "--network", "extra-trees", "--output", &model]);
        let said = ends(0, &["predict", &model, &path("skin.npz"), "--format", "json"]);
        let said: Value = serde_json::from_str(&said).unwrap();
        let results: Value =
            serde_json::from_str(&fs::read_to_string(format!("{run}/results.json")).unwrap()).unwrap();
        let of_answer = |answer: &Value| answer["predicted"].clone();
        let answers: Vec<Value> = said["answers"].as_array().unwrap().iter().map(of_answer).collect();
        (results["networks"][0]["mean"]["mae"].clone(), answers)
    });
    assert!(scores[0].0.is_f64());
    assert_eq!(scores[0], scores[1], "a row of features, and as many channels of one step");
}

#[test]
fn a_trial_without_some_classes_is_refused_for_values() {
    let folder = tempfile::tempdir().unwrap();
    presses(&folder.path().join("skin.npz"), 20, 0);
    let config = folder.path().join("skin.toml");
    fs::write(&config, format!("{CONFIG}[unknown]\n")).unwrap();
    let run = folder.path().join("run");
    let error = ends(2, &["run", config.to_str().unwrap(), "--output", run.to_str().unwrap()]);
    assert!(
        error.contains("unknown") && error.contains("leaves classes out, and the targets are quantities"),
        "{error}"
    );
    assert!(!run.exists(), "nothing is left behind");
}

/// A config of networks that learn the force by each loss, in few epochs.
fn networks(losses: &[&str]) -> String {
    let one = |loss: &&str| {
        let train = r#"train = { epochs = 60, batch_size = 16, optimizer = { name = "adam", lr = 0.01 }"#;
        format!("{{ name = \"mlp\", label = \"{loss}\", {train}, loss = \"{loss}\" }} }}")
    };
    let all: Vec<String> = losses.iter().map(one).collect();
    // On raw readings a likelihood explains its first errors by a large spread, and learns no mean.
    let config = CONFIG.replace("\"raw\"", "\"z-score\"");
    config.replace("networks = []", &format!("baselines = []\nnetworks = [{}]", all.join(", ")))
}

#[test]
fn networks_learn_values_by_every_loss_and_say_how_far_off_they_may_be() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("skin.npz"), 80, 0);
    presses(&folder.path().join("new.npz"), 60, 5);
    let losses = ["huber", "mean-squared-error", "gaussian-likelihood", "quantiles"];
    fs::write(folder.path().join("skin.toml"), networks(&losses)).unwrap();
    ends(0, &["run", &at("skin.toml"), "--output", &at("run")]);
    let results: Value = serde_json::from_str(&fs::read_to_string(at("run/results.json")).unwrap()).unwrap();
    for (row, loss) in results["networks"].as_array().unwrap().iter().zip(losses) {
        let mae = row["mean"]["mae"].as_f64().unwrap();
        assert!(row["network"] == loss && mae < 0.5, "{loss}: {mae}");
        let model = at(&format!("{loss}.safetensors"));
        ends(0, &["fit", &at("run"), "--network", loss, "--output", &model]);
        let card = ends(0, &["inspect", &model]);
        assert!(
            card.contains("intervals fitted on 80 held-out predictions; those of 90 % covered"),
            "{card}"
        );
        let said = ends(0, &["predict", &model, &at("new.npz"), "--format", "json"]);
        let said: Value = serde_json::from_str(&said).unwrap();
        let answers = said["answers"].as_array().unwrap();
        // Of samples like those of the training about 5 % are taken for unknown, and have no interval.
        let unknown = answers.iter().filter(|answer| answer["unknown"] == true).count();
        assert!(unknown <= 9, "{loss}: {unknown} of 60");
        let is_within = |(i, answer): (usize, &Value)| {
            let force = f64::from(((i * 37 + 5) % 101) as u32) / 10.1;
            let end = |at: usize| answer["interval"]["force"][at].as_f64().unwrap();
            let value = answer["predicted"]["force"].as_f64().unwrap();
            assert!(end(0) <= value && value <= end(1), "{loss}: {answer}");
            end(0) <= force && force <= end(1)
        };
        let known = answers.iter().enumerate().filter(|(_, answer)| answer["unknown"] == false);
        let within = known.filter(|(i, answer)| is_within((*i, answer))).count();
        assert!(said["interval_share"] == 0.9 && within >= 48 - unknown, "{loss}: {within} of 60");
    }
    let model = at("gaussian-likelihood.safetensors");
    let table = ends(0, &["predict", &model, &at("new.npz"), "--set", "0.8"]);
    assert!(table.contains("80 % interval"), "{table}");
    let error = ends(2, &["predict", &model, &at("new.npz"), "--set", "0.7"]);
    assert!(error.contains("has intervals for 0.8, 0.9, 0.95"), "{error}");
    ends(0, &["export", &model, &at("model.onnx")]);
    let bytes = at("bytes.safetensors");
    ends(0, &["quantize", &model, "--calibrate", &at("skin.npz"), "--output", &bytes]);
    assert!(ends(0, &["inspect", &bytes]).contains("those of 90 % covered"));
}

#[test]
fn values_of_broken_and_foreign_sensors_are_unknown() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    presses(&folder.path().join("skin.npz"), 80, 0);
    fs::write(
        folder.path().join("skin.toml"),
        CONFIG.replace("networks = []", "baselines = [\"ridge\"]\nnetworks = []"),
    )
    .unwrap();
    ends(0, &["run", &at("skin.toml"), "--output", &at("run")]);
    let model = at("ridge.safetensors");
    ends(0, &["fit", &at("run"), "--network", "ridge", "--output", &model]);
    assert!(ends(0, &["inspect", &model]).contains("; says unknown"));
    // Dead, at full scale, noise, and a press whose gain is another.
    let noise = |at: usize| 20.0 * (at * 7919 % 997) as f32 / 997.0;
    let foreign = ArrayD::from_shape_fn(vec![4, 2, 12], |at| match at[0] {
        0 => 0.0,
        1 => 20.0,
        2 => noise(at[1] * 12 + at[2]),
        _ => 100.0 * (at[2] + 1) as f32 / 12.0 * (1.0 + at[1] as f32),
    });
    save(&folder.path().join("foreign.npz"), Layout::Series, foreign.clone(), vec![1.0; 4]);
    let said = ends(0, &["predict", &model, &at("foreign.npz"), "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    for answer in said["answers"].as_array().unwrap() {
        assert!(answer["unknown"] == true && answer["interval"].is_null(), "{answer}");
        assert!(
            answer["predicted"]["force"].is_number() && answer["familiarity"].as_f64() <= Some(0.05),
            "{answer}"
        );
    }
    let table = ends(0, &["predict", &model, &at("foreign.npz")]);
    assert_eq!(table.matches("unknown (").count(), 4, "{table}");
    let csv = ends(0, &["predict", &model, &at("foreign.npz"), "--format", "csv"]);
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("sample,force,force_low,force_high,familiarity,unknown"));
    assert!(lines.all(|line| line.contains(",,,") && line.ends_with(",true")), "{csv}");
    ends(0, &["predict", &model, &at("foreign.npz"), "--format", "npz", "--output", &at("said.npz")]);
    let mut said = npyz::npz::NpzArchive::open(at("said.npz")).unwrap();
    let ends_of_intervals: Vec<f32> = said.by_name("interval").unwrap().unwrap().into_vec().unwrap();
    let unknown: Vec<bool> = said.by_name("unknown").unwrap().unwrap().into_vec().unwrap();
    assert!(ends_of_intervals.iter().all(|end| end.is_nan()) && unknown == [true; 4]);
    // A stream of the same, and one of a known press.
    let lines = |x: &ArrayD<f32>, sample: usize| -> String {
        let step = |step: usize| format!("{},{}\n", x[[sample, 0, step]], x[[sample, 1, step]]);
        (0..12).map(step).collect()
    };
    let known = taxel::load(&folder.path().join("skin.npz"), &taxel::ReadOptions::default()).unwrap();
    let known = known.x.slice_axis(ndarray::Axis(0), ndarray::Slice::from(50..51)).to_owned();
    for (text, is_unknown) in [(lines(&foreign, 2), true), (lines(&known, 0), false)] {
        let mut stream = Command::cargo_bin("taxel").unwrap();
        let said = stream.args(["stream", &model]).write_stdin(text).output().unwrap();
        let said = String::from_utf8(said.stdout).unwrap();
        let decision: Value = serde_json::from_str(said.lines().next().unwrap()).unwrap();
        assert_eq!(
            (&decision["unknown"], decision["interval"].is_null()),
            (&is_unknown.into(), is_unknown),
            "{said}"
        );
    }
    let error = ends(2, &["predict", &model, &at("foreign.npz"), "--unknown", "2"]);
    assert!(error.contains("is a share from 0 and below 1"), "{error}");
    let whole = ends(0, &["predict", &model, &at("foreign.npz"), "--unknown", "0"]);
    assert!(!whole.contains("unknown ("), "{whole}");
}

#[test]
fn a_loss_of_classes_is_refused_for_values() {
    let folder = tempfile::tempdir().unwrap();
    presses(&folder.path().join("skin.npz"), 40, 0);
    let config = folder.path().join("skin.toml");
    let out = folder.path().join("run");
    for loss in ["softmax-cross-entropy", "hinge"] {
        fs::write(&config, networks(&[loss])).unwrap();
        let error = ends(2, &["run", config.to_str().unwrap(), "--output", out.to_str().unwrap()]);
        assert!(error.contains(loss) && error.contains("values need \"huber\""), "{error}");
        assert!(!out.exists());
    }
}

/// The mean absolute error of a model for the presses of a file, whose forces are `offset`'s.
fn error_of(model: &str, file: &str, offset: usize) -> f64 {
    let said = ends(0, &["predict", model, file, "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let answers = said["answers"].as_array().unwrap();
    let error = |(i, answer): (usize, &Value)| {
        let force = f64::from(((i * 37 + offset) % 101) as u32) / 10.1;
        (answer["predicted"]["force"].as_f64().unwrap() - force).abs()
    };
    answers.iter().enumerate().map(error).sum::<f64>() / answers.len() as f64
}

#[test]
fn a_network_goes_on_learning_from_ten_presses_of_another_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let gained = |name: &str, samples, offset, gain: f32| {
        let path = folder.path().join(name);
        presses(&path, samples, offset);
        let mut dataset = taxel::load(&path, &taxel::ReadOptions::default()).unwrap();
        dataset.x *= gain;
        dataset.save(&path).unwrap();
    };
    presses(&folder.path().join("skin.npz"), 80, 0);
    gained("few.npz", 10, 3, 1.4);
    gained("new.npz", 60, 5, 1.4);
    fs::write(folder.path().join("skin.toml"), networks(&["huber"])).unwrap();
    let (old, new) = (at("old.safetensors"), at("new.safetensors"));
    ends(0, &["fit", &at("skin.toml"), "--output", &old]);
    let card = ends(0, &["fit", &at("few.npz"), "--from", &old, "--output", &new]);
    assert!(
        card.contains("tuned from") && card.contains("10 samples") && card.contains("no intervals"),
        "{card}"
    );
    let (before, after) = (error_of(&old, &at("new.npz"), 5), error_of(&new, &at("new.npz"), 5));
    assert!(before > 1.0 && after < 0.5 * before, "{before} N before, {after} N after");
    // The same command gives the same bytes.
    let again = at("again.safetensors");
    ends(0, &["fit", &at("few.npz"), "--from", &old, "--output", &again, "--threads", "1"]);
    assert_eq!(fs::read(&new).unwrap(), fs::read(&again).unwrap());

    let error = ends(2, &["fit", &at("few.npz"), "--from", &old, "--quick", "--output", &again]);
    assert!(error.contains("--quick"), "{error}");
    fs::write(folder.path().join("ridge.toml"), CONFIG).unwrap();
    ends(0, &["fit", &at("ridge.toml"), "--network", "ridge", "--output", &at("ridge.safetensors")]);
    let error = ends(2, &["fit", &at("few.npz"), "--from", &at("ridge.safetensors"), "--output", &again]);
    assert!(error.contains("a baseline, which is fitted at once"), "{error}");
    let mut dataset = taxel::load(&folder.path().join("few.npz"), &taxel::ReadOptions::default()).unwrap();
    let depth = Quantity { name: "depth".into(), unit: Some("mm".into()) };
    dataset.targets = Targets::Values(Values::new(vec![depth], vec![1.0; 10]));
    dataset.save(&folder.path().join("depth.npz")).unwrap();
    let error = ends(2, &["fit", &at("depth.npz"), "--from", &old, "--output", &again]);
    assert!(error.contains("quantities force N; these are quantities depth mm"), "{error}");
}

#[test]
fn the_rest_of_a_run_is_taken_off_in_training_prediction_and_stream() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    // The level of each recording at rest differs by more than a press changes it; its first reading is at rest.
    let levelled = |name: &str, samples, offset| {
        let path = folder.path().join(name);
        presses(&path, samples, offset);
        let mut dataset = taxel::load(&path, &taxel::ReadOptions::default()).unwrap();
        for (i, mut sample) in dataset.x.outer_iter_mut().enumerate() {
            for mut channel in sample.outer_iter_mut() {
                channel[0] = 0.0;
                channel += (i * 13 % 50) as f32;
            }
        }
        dataset.save(&path).unwrap();
    };
    levelled("skin.npz", 80, 0);
    levelled("new.npz", 20, 5);
    let config = CONFIG.replace("path = \"skin.npz\"", "path = \"skin.npz\"\ntare = \"recording\"");
    fs::write(folder.path().join("skin.toml"), config).unwrap();
    let model = at("m.safetensors");
    ends(0, &["fit", &at("skin.toml"), "--network", "ridge", "--output", &model]);
    assert!(error_of(&model, &at("new.npz"), 5) < 0.1);
    let said = ends(0, &["predict", &model, &at("new.npz"), "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let streamed = ends(0, &["stream", &model, "--input", &at("new.npz")]);
    for (line, answer) in streamed.lines().zip(said["answers"].as_array().unwrap()) {
        let line: Value = serde_json::from_str(line).unwrap();
        let [streamed, predicted] =
            [&line["values"]["force"], &answer["predicted"]["force"]].map(|v| v.as_f64().unwrap() as f32);
        assert_eq!(streamed, predicted, "{line}");
    }
    assert_eq!(streamed.lines().count(), 20);
    // A line takes the rest anew: the same press on another level has the same force.
    let press =
        |level: f32| (0..12).map(move |t| format!("{},{}\n", level + t as f32, level + 2.0 * t as f32));
    let lines: String = press(0.0).chain(["tare\n".to_string()]).chain(press(30.0)).collect();
    let mut command = Command::cargo_bin("taxel").unwrap();
    let output = command.args(["stream", &model, "--hop", "12"]).write_stdin(lines).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let forces: Vec<Value> = said
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["values"]["force"].clone())
        .collect();
    assert!(forces.len() == 2 && forces[0] == forces[1], "{said}");
    let plain = at("plain.safetensors");
    fs::write(folder.path().join("plain.toml"), CONFIG).unwrap();
    ends(0, &["fit", &at("plain.toml"), "--network", "ridge", "--output", &plain]);
    let error = ends(2, &["stream", &plain, "--input", &at("new.npz"), "--tare-steps", "3"]);
    assert!(error.contains("the model reads what the sensor gives"), "{error}");
}

/// Recordings of 60 readings at 10 Hz, in which speed rises above 1 for a while and the channel shows it a reading later.
fn slips() -> String {
    let mut text = String::from("recording,time,a,speed\n");
    for recording in 0..9 {
        let is_slip = |t: usize| (t + 7 * recording) % 30 >= 20;
        for t in 0..60 {
            let noise = ((t * 7919 + recording * 131) % 97) as f32 / 970.0;
            let a = if t > 0 && is_slip(t - 1) { 1.0 } else { 0.0 };
            let speed = if is_slip(t) { 1.5 } else { 0.2 };
            text += &format!("r{recording},{},{},{}\n", t as f32 / 10.0, a + noise, speed + noise);
        }
    }
    text
}

#[test]
fn events_of_time_steps_have_delays_and_false_alarms() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    fs::write(folder.path().join("slips.csv"), slips()).unwrap();
    let config = "name = \"slips\"\nnetworks = []\n\
                  baselines = [\"majority\", { name = \"extra-trees\", trees = 20 }]\n\
                  [data]\npath = \"slips.csv\"\nevent = \"speed > 1\"\n\
                  length = { kind = \"window\", to = 3, hop = 1 }\n\
                  [protocol]\nkind = \"k-fold\"\nfolds = 3\nsplit = \"group\"\n";
    fs::write(folder.path().join("slips.toml"), config).unwrap();
    let table = ends(0, &["run", &at("slips.toml"), "--output", &at("run")]);
    for column in ["AUROC", "average precision", "missed events", "delay s", "false alarms per minute"] {
        assert!(table.contains(column), "{column}: {table}");
    }
    let results: Value = serde_json::from_str(&fs::read_to_string(at("run/results.json")).unwrap()).unwrap();
    assert_eq!(results["classes"], serde_json::json!(["rest", "speed > 1"]));
    let networks = results["networks"].as_array().unwrap();
    let of = |name: &str, metric: &str| {
        networks.iter().find(|row| row["network"] == name).unwrap()["mean"][metric].as_f64()
    };
    // The channel shows a slip a reading late.
    assert!((of("extra-trees", "delay").unwrap() - 0.1).abs() < 1e-6, "{:?}", of("extra-trees", "delay"));
    // Of a slip that begins with the last reading of a recording nothing is seen.
    assert!(of("extra-trees", "missed_events").is_some_and(|share| share > 0.0 && share < 10.0));
    assert!(of("extra-trees", "auroc").unwrap() > 90.0);
    // After each slip the channel shows one for a reading more.
    assert!(of("extra-trees", "false_alarms_per_minute").unwrap() > 5.0);
    assert_eq!((of("majority", "missed_events"), of("majority", "delay")), (Some(100.0), None));
    assert_eq!(of("majority", "false_alarms_per_minute"), Some(0.0));
    assert_eq!(of("majority", "false_alarms_per_1000_steps"), None);
    let page = ends(0, &["report", &at("run"), "--format", "json"]);
    assert!(page.contains("false_alarms_per_minute"), "{page}");

    let refused = ends(2, &["run", &at("slips.toml"), "--event", "speed > 9", "--output", &at("no")]);
    assert!(refused.contains("event = \"speed > 9\" is true of none of"), "{refused}");
    let refused = ends(2, &["run", &at("slips.toml"), "--event", "speed above 1", "--output", &at("no")]);
    assert!(refused.contains("is no event; write the name of an array or column"), "{refused}");
    let card = ends(0, &["data", "check", &at("slips.csv"), "--event", "speed<1", "--length", "window:3,1"]);
    assert!(card.contains("speed < 1"), "{card}");
}

/// Runs and returns what was said on standard error.
fn says(arguments: &[&str]) -> String {
    let output = Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    error
}

#[test]
fn few_groups_promise_no_interval_for_a_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let skin = folder.path().join("skin.npz");
    let config = CONFIG.replace("networks = []", "networks = []\nbaselines = [\"ridge\"]");
    let config = format!("{config}[protocol]\nkind = \"k-fold\"\nfolds = 3\nsplit = \"group\"\n");
    fs::write(folder.path().join("skin.toml"), config).unwrap();
    for (groups, is_few) in [(3, true), (12, false)] {
        presses(&skin, 84, 0);
        let mut dataset = taxel::load(&skin, &taxel::ReadOptions::default()).unwrap();
        dataset.groups = Some((0..84).map(|i| i % groups).collect());
        dataset.group_name = Some("session".into());
        dataset.save(&skin).unwrap();
        let (run, model) = (at(&format!("run-{groups}")), at("m.safetensors"));
        ends(0, &["run", &at("skin.toml"), "--output", &run]);
        let said = says(&["fit", &run, "--network", "ridge", "--output", &model]);
        let words = "with 3 groups 90 % cannot be promised for a new one, which needs 9 groups";
        assert_eq!(said.contains(&format!("warning: intervals of ridge: {words}")), is_few, "{said}");
        let card = ends(0, &["inspect", &model]);
        assert_eq!(card.contains(words), is_few, "{card}");
        let asked = says(&["predict", &model, &at("skin.npz"), "--set", "0.8"]);
        assert_eq!(
            asked.contains("80 % cannot be promised for a new one, which needs 4 groups"),
            is_few,
            "{asked}"
        );
        ends(0, &["report", &run]);
        let page = fs::read_to_string(format!("{run}/report.html")).unwrap();
        let caption = "With 3 groups nothing can be promised at 90 % for a new one, which needs 9";
        assert_eq!(page.contains(caption), is_few, "{groups} groups");
    }
}
