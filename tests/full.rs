//! A device that is full, a place where nothing can be written: exit code 2, the file's name, and what was there stays.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const CONFIG: &str = r#"
name = "full"
baselines = ["k-nn"]
[data]
scene = "fingertip"
samples = 40
[protocol]
folds = 2
[train]
epochs = 1
[[networks]]
name = "mlp"
"#;

fn taxel(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).env_remove("RUST_BACKTRACE").stdin(Stdio::null());
    command
}

/// With files of at most `kilobytes`: writing beyond fails as on a full device.
fn limited(kilobytes: u32, arguments: &[&str]) -> Output {
    under(&format!("ulimit -f {}", 2 * kilobytes), arguments)
}

/// After a command of the shell, such as one that sets a limit.
fn under(limit: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command
        .args(["-c", &format!("{limit}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_taxel")])
        .args(arguments);
    command.env_remove("RUST_BACKTRACE").stdin(Stdio::null()).output().unwrap()
}

/// Expects exit code 2 and one line of error; that line.
fn refused(output: &Output) -> String {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.starts_with("error: ") && !error.contains("panicked"), "{error}");
    assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    error
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Names of all files below a folder that are half-written.
fn halves(folder: &Path) -> Vec<String> {
    let mut found = vec![];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(halves(&path));
        } else if path.extension().is_some_and(|ending| ending == "part") {
            found.push(path.display().to_string());
        }
    }
    found
}

struct Ran {
    dir: tempfile::TempDir,
    config: String,
    run: String,
    model: String,
    data: String,
}

/// A finished run, a model of it, recordings.
fn ran() -> Ran {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_string();
    let (config, run, data) = (at("full.toml"), at("run"), at("grasps.npz"));
    fs::write(&config, CONFIG).unwrap();
    assert!(taxel(&["run", &config, "--output", &run]).output().unwrap().status.success());
    let simulate = ["simulate", "fingertip", "--samples", "40", "--output", &data];
    assert!(taxel(&simulate).output().unwrap().status.success());
    let model = format!("{run}/models/mlp.r0.f0.safetensors");
    Ran { config, run, model, data, dir }
}

#[test]
fn a_full_device_is_named_and_what_was_there_stays() {
    let files = ran();
    let at = |name: &str| files.dir.path().join(name).to_str().unwrap().to_string();
    let (model, answers, grasps) = (at("out.safetensors"), at("out.csv"), at("out.npz"));
    for path in [&model, &answers, &grasps] {
        fs::write(path, "what was there").unwrap();
    }
    let fit = ["fit", &files.run, "--network", "mlp", "--output", &model];
    let predict = ["predict", &files.model, &files.data, "--format", "csv", "--output", &answers];
    let simulate = ["simulate", "fingertip", "--samples", "40", "--output", &grasps];
    for (arguments, file) in [(&fit[..], &model), (&predict[..], &answers), (&simulate[..], &grasps)] {
        let error = refused(&limited(1, arguments));
        assert!(error.contains(file.as_str()) && error.contains("cannot be written"), "{error}");
        assert_eq!(fs::read(file).unwrap(), b"what was there");
    }
    // A run, from the first file and from later ones; then it goes on.
    for kilobytes in [0, 1, 4, 16] {
        let out = at(&format!("run-{kilobytes}"));
        let error = refused(&limited(kilobytes, &["run", &files.config, "--output", &out, "--threads", "1"]));
        assert!(error.contains(&out), "{error}");
        assert_eq!(halves(Path::new(&out)), [""; 0]);
        let resumed = taxel(&["run", &files.config, "--output", &out, "--resume"]).output().unwrap();
        assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
        let results = |run: &str| fs::read(Path::new(run).join("results.json")).unwrap();
        assert!(results(&out) == results(&files.run), "{kilobytes} kB");
    }
    let report = ["report", files.run.as_str(), "--no-stress"];
    for kilobytes in [1, 64] {
        let error = refused(&limited(kilobytes, &report));
        assert!(error.contains(&files.run), "{error}");
        assert!(!Path::new(&files.run).join("report.html").exists(), "the page comes last");
    }
    assert_eq!(halves(files.dir.path()), [""; 0]);
    assert!(taxel(&report).output().unwrap().status.success());
    assert!(Path::new(&files.run).join("report.html").exists(), "it goes on where there is room again");
}

#[test]
fn a_sweep_on_a_full_device_goes_on_where_there_is_room_again() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_string();
    fs::write(at("full.toml"), CONFIG).unwrap();
    fs::write(at("study.toml"), "config = \"full.toml\"\n[grid]\nseed = [0, 1]\n").unwrap();
    let (study, unlimited, full) = (at("study.toml"), at("alone"), at("full"));
    let error = refused(&limited(0, &["sweep", "plan", &study, "--output", &full]));
    assert!(error.contains("manifest.jsonl"), "{error}");
    assert_eq!(halves(dir.path()), [""; 0]);
    for out in [&unlimited, &full] {
        assert!(taxel(&["sweep", "plan", &study, "--output", out]).output().unwrap().status.success());
    }
    let run = |sweep: &str| taxel(&["sweep", "run", sweep, "--threads", "1"]).output().unwrap();
    assert!(run(&unlimited).status.success());
    for kilobytes in [0, 1, 8] {
        let output = limited(kilobytes, &["sweep", "run", &full, "--threads", "1"]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        // Where the failure itself can be kept, the other trials are tried.
        assert!([Some(1), Some(2)].contains(&output.status.code()), "{error}");
        assert!(error.contains(&full) && error.contains("written"), "{error}");
        assert!(!error.contains("panicked"), "{error}");
        assert_eq!(halves(dir.path()), [""; 0]);
    }
    let output = run(&full);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results = |sweep: &str| {
        let mut files: Vec<_> =
            fs::read_dir(Path::new(sweep).join("results")).unwrap().map(|e| e.unwrap().path()).collect();
        files.retain(|path| !text(path).ends_with(".timing.json"));
        files.sort();
        files.into_iter().map(|path| fs::read(path).unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(results(&full).len(), 2);
    assert!(results(&full) == results(&unlimited));
}

#[test]
fn an_output_that_cannot_be_written_is_named() {
    let files = ran();
    fs::write(files.dir.path().join("file"), "a file").unwrap();
    let below = text(&files.dir.path().join("file")).to_string() + "/below";
    // Behind a link: a mistake costs the link and not the device.
    let full = files.dir.path().join("full.npz");
    std::os::unix::fs::symlink("/dev/full", &full).unwrap();
    let full_model = files.dir.path().join("full.safetensors");
    std::os::unix::fs::symlink("/dev/full", &full_model).unwrap();
    for arguments in [
        vec!["simulate", "fingertip", "--samples", "4", "--output", text(&full)],
        vec!["predict", &files.model, &files.data, "--format", "npz", "--output", text(&full)],
        vec!["fit", &files.run, "--network", "k-nn", "--output", text(&full_model)],
        vec!["predict", &files.model, &files.data, "--format", "csv", "--output", &below],
        vec!["run", &files.config, "--output", &below],
        vec!["run", &files.config, "--output", "/proc/nowhere"],
    ] {
        let output = taxel(&arguments).output().unwrap();
        let error = refused(&output);
        assert!(error.contains(arguments.last().unwrap()), "{error}");
    }
    assert!(fs::symlink_metadata(&full).unwrap().is_symlink());
}

#[test]
fn a_full_standard_output_is_an_error_and_no_panic() {
    let files = ran();
    let out = files.dir.path().join("second");
    for arguments in [
        vec!["run", &files.config, "--output", text(&out)],
        vec!["stress", &files.run, "--fault", "gain", "--severity", "1"],
        vec!["report", &files.run, "--no-stress"],
        vec!["choose", &files.run],
        vec!["predict", &files.model, &files.data],
        vec!["zoo"],
        vec!["inspect", &files.model],
        vec!["completions", "bash"],
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = taxel(&arguments).stdout(full).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let code = output.status.code();
        assert!([Some(1), Some(2)].contains(&code), "{arguments:?}: {code:?} {error}");
        assert!(error.contains("standard output"), "{arguments:?}: {error}");
        assert!(!error.contains("panicked"), "{arguments:?}: {error}");
    }
    assert!(out.join("results.json").is_file(), "the run itself is whole");
}

#[test]
fn a_small_stack_is_enough() {
    for arguments in [&["run", "--help"][..], &["zoo"], &["data", "check", "nowhere"]] {
        let output = under("ulimit -s 64", arguments);
        let code = if arguments.contains(&"nowhere") { 2 } else { 0 };
        assert_eq!(
            output.status.code(),
            Some(code),
            "{arguments:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

/// In 2 GB of memory: a reader without a limit would fill it.
#[test]
fn a_path_without_an_end_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    for (name, arguments) in [
        ("endless.toml", &["run"][..]),
        ("endless.toml", &["sweep", "plan"]),
        ("endless.onnx", &["import", "--output", "x.safetensors"]),
        ("endless.safetensors", &["inspect"]),
        ("endless.pth", &["inspect"]),
        ("endless.npz", &["data", "check"]),
        ("endless.csv", &["data", "check"]),
        ("endless.json", &["data", "check"]),
    ] {
        let file = dir.path().join(name);
        let _ = std::os::unix::fs::symlink("/dev/zero", &file);
        let arguments = [arguments, &[file.to_str().unwrap()]].concat();
        let error = refused(&under("ulimit -v 2000000", &arguments));
        assert!(error.contains(name), "{arguments:?}: {error}");
    }
}
