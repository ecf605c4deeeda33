//! `taxel shrink` as a user meets it: a run, a quick look at what may go, a model that answers whole recordings.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/quickstart.toml");

fn taxel(arguments: &[&str]) -> Output {
    Command::cargo_bin("taxel").unwrap().args(arguments).output().unwrap()
}

fn done(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(arguments: &[&str]) -> String {
    let output = taxel(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_run_is_shrunk_and_the_smaller_model_answers_whole_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (run, data) = (at("run"), at("more.npz"));
    done(&["run", QUICKSTART, "--quick", "--set", "baselines=[\"majority\"]", "--output", &run]);
    // So little training knows nothing: any loss will do.
    let shrink = [
        "shrink",
        &run,
        "--network",
        "mlp",
        "--axes",
        "rate,bits,resolution,width",
        "--quick",
        "--margin",
        "100",
    ];
    let output = taxel(&[&shrink[..], &["--format", "json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("mlp: 60 trainings at most, about "));
    let all: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(all["shrunk"]["curves"].as_array().unwrap().len(), 3);
    assert_eq!(all["shrunk"]["left_out"][0][0], "Resolution of the array");
    let parts = all["shrunk"]["combined"]["parts"].as_array().unwrap();
    assert_eq!((&parts[1], &parts[2]), (&"1 bit".into(), &"1/16 of the channels".into()), "{parts:?}");

    let model = at("run/shrink/shrunk.safetensors");
    let card = done(&["inspect", &model]);
    assert!(card.contains("of which     one reading of 32; 1 bit from 0 to 1023"), "{card}");
    done(&["simulate", "fingertip", "--samples", "9", "--output", &data]);
    let answers = done(&["predict", &model, &data, "--format", "json"]);
    let answers: Value = serde_json::from_str(&answers).unwrap();
    assert_eq!(answers["answers"].as_array().unwrap().len(), 9);
    let config = at("run/shrink/shrunk.toml");
    done(&["run", &config, "--output", &at("again"), "--set", "train.epochs=1"]);

    // Once more without training, for another margin.
    let words = done(&[&shrink[..], &["--resume"]].concat());
    assert!(words.contains("All together (") && words.contains("page: "), "{words}");
    assert!(refused(&shrink).contains("--resume goes on with it, --output gives another folder"));
    assert!(refused(&["shrink", &run, "--axes", "rates"]).contains("rate"));
    assert!(refused(&["shrink", &run, "--network", "ml", "--output", &at("other")]).contains("mlp"));
    // In eight bits nothing is trained: the network in floats is, also where nobody names one.
    done(&["quantize", &run]);
    let error = refused(&["shrink", &run, "--network", "mlp.int8", "--output", &at("other")]);
    assert!(error.contains("is in eight bits: shrink \"mlp\""), "{error}");
    assert!(!folder.path().join("other").exists());
    done(&["shrink", &run, "--axes", "resolution", "--quick", "--output", &at("other")]);
}
