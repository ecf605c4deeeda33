//! Training in bf16: refused where the processor has no products of it, said by the run folder, kept by `--resume`. Models in
//! bf16: made everywhere, refused where they cannot predict.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/program.rs"]
mod program;

use std::fs;
use std::path::Path;

use program::taxel;

const CONFIG: &str = r#"
name = "halves"
seed = 5
baselines = ["majority"]
[data]
scene = "fingertip"
samples = 40
[protocol]
folds = 2
[train]
epochs = 2
batch_size = 8
[[networks]]
name = "resnet8-lite-1d"
[[networks]]
name = "lstm"
"#;

/// Runs the experiment, and returns the status and what went to standard error.
fn run(folder: &Path, output: &str, arguments: &[&str], simd: Option<&str>) -> (i32, String) {
    fs::write(folder.join("halves.toml"), CONFIG).unwrap();
    let mut command = taxel(folder, &["run", "halves.toml", "--output", output]);
    command.args(arguments);
    if let Some(simd) = simd {
        command.env("TAXEL_SIMD", simd);
    }
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn bf16_is_refused_where_the_processor_lacks_it() {
    let folder = tempfile::tempdir().unwrap();
    let half = ["--set", "train.precision=bf16"];
    for (simd, what) in [("portable", "precision = \"bf16\""), ("avx2", "not possible here")] {
        let (code, text) = run(folder.path(), "out", &half, Some(simd));
        assert_eq!(code, 2, "{text}");
        assert!(text.contains(what) && text.contains("take f32"), "{text}");
        assert!(!folder.path().join("out").exists(), "a folder is left behind");
    }
    let (code, text) = run(folder.path(), "out", &["--set", "train.precision=f16"], None);
    assert!(code == 2 && text.contains("bf16"), "{text}");
}

#[test]
#[ignore = "needs avx512_bf16"]
fn bf16_has_the_same_bytes_on_any_number_of_threads_and_is_kept_needs_bf16() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let half = ["--set", "train.precision=bf16"];
    for (out, threads) in [("one", "1"), ("three", "3")] {
        let (code, text) = run(at, out, &[&half[..], &["--threads", threads]].concat(), None);
        assert_eq!(code, 0, "{text}");
    }
    assert_eq!(run(at, "floats", &[], None).0, 0);
    let read = |out: &str, file: &str| fs::read(at.join(out).join(file)).unwrap();
    for file in ["metrics.jsonl", "predictions.npz"] {
        assert!(read("one", file) == read("three", file), "{file} depends on threads");
        assert!(read("one", file) != read("floats", file), "{file} is that of floats");
    }
    let config = String::from_utf8(read("one", "config.toml")).unwrap();
    assert!(config.contains("precision = \"bf16\""), "{config}");
    let (code, text) = run(at, "one", &["--resume"], None);
    assert!(code == 2 && text.contains("precision"), "{text}");
    let (code, text) = run(at, "floats", &[&half[..], &["--resume"]].concat(), None);
    assert!(code == 2 && text.contains("precision"), "{text}");
    assert_eq!(run(at, "one", &[&half[..], &["--resume"]].concat(), None).0, 0);
}

/// Calls the program, and returns the status and what went to standard output and error.
fn call(folder: &Path, arguments: &[&str], simd: Option<&str>) -> (i32, String) {
    let mut command = taxel(folder, arguments);
    if let Some(simd) = simd {
        command.env("TAXEL_SIMD", simd);
    }
    let output = command.output().unwrap();
    let text = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (output.status.code().unwrap(), text.concat())
}

/// Returns a folder with recordings, a model of floats and the same in bf16.
fn models() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("halves.toml"), CONFIG).unwrap();
    let fit = ["fit", "halves.toml", "--network", "resnet8-lite-1d", "--output", "large.safetensors"];
    for arguments in [
        &["simulate", "fingertip", "--samples", "40", "--output", "presses.npz"][..],
        &fit,
        &["quantize", "large.safetensors", "--to", "bf16", "--output", "small.safetensors"],
    ] {
        // Made everywhere: on a processor without products of bf16, too.
        let (code, text) = call(at, arguments, Some("portable"));
        assert_eq!(code, 0, "{arguments:?}: {text}");
    }
    folder
}

#[test]
fn a_model_in_bf16_is_refused_where_it_cannot_predict() {
    let folder = models();
    let at = folder.path();
    let (code, text) = call(at, &["inspect", "small.safetensors"], Some("avx2"));
    assert!(code == 0 && text.contains("in bits      16 per weight and factor (bf16)"), "{text}");
    for simd in ["portable", "avx2"] {
        let (code, text) = call(at, &["predict", "small.safetensors", "presses.npz"], Some(simd));
        assert_eq!(code, 2, "{text}");
        assert!(
            text.contains("products of bf16") && text.contains("in floats that it was made of"),
            "{text}"
        );
    }
    for format in ["onnx", "c"] {
        let (code, text) =
            call(at, &["export", "small.safetensors", "--format", format, "--output", "out.onnx"], None);
        assert!(code == 2 && text.contains("is in bf16") && text.contains("export the model"), "{text}");
    }
    let refused = [
        (&["small.safetensors", "--output", "again.safetensors"][..], "is in bf16 already"),
        (
            &["large.safetensors", "--calibrate", "presses.npz", "--output", "b.safetensors"],
            "needs no recordings",
        ),
        (&["large.safetensors"], "--output MODEL"),
        (&["."], "takes a model, not a run"),
    ];
    for (arguments, what) in refused {
        let (code, text) = call(at, &[&["quantize", "--to", "bf16"], arguments].concat(), None);
        assert!(code == 2 && text.contains(what), "{arguments:?}: {text}");
    }
}

#[test]
#[ignore = "needs avx512_bf16"]
fn a_model_in_bf16_predicts_the_same_on_any_number_of_threads_needs_bf16() {
    let folder = models();
    let predict = |model: &str, threads: &str| {
        let arguments =
            ["predict", model, "presses.npz", "--format", "npz", "--output", "out.npz", "--threads", threads];
        let (code, text) = call(folder.path(), &arguments, None);
        assert_eq!(code, 0, "{text}");
        fs::read(folder.path().join("out.npz")).unwrap()
    };
    let one = predict("small.safetensors", "1");
    assert!(one != predict("large.safetensors", "1"), "the model predicts in floats");
    for threads in ["2", "3"] {
        assert!(predict("small.safetensors", threads) == one, "{threads} threads");
    }
}
