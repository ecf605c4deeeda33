//! Training in bf16: refused where the processor has no products of it, said by the run folder, kept by `--resume`.

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
