//! `fit`, `report` and `stress` that are stopped (SIGTERM) or killed (SIGKILL) leave whole files or none, and go on.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/clock.rs"]
mod clock;

use clock::set_back;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

const CONFIG: &str = r#"
name = "stopped"
baselines = ["k-nn"]
[data]
scene = "fingertip"
samples = 60
[protocol]
folds = 2
[train]
epochs = 40
batch_size = 8
[[networks]]
name = "resnet8-lite-1d"
"#;

fn taxel(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).args(["--threads", "1"]).stdin(Stdio::null());
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn good(arguments: &[&str]) {
    let output = taxel(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn run(dir: &Path) -> String {
    let (config, run) = (dir.join("stopped.toml"), dir.join("run"));
    fs::write(&config, CONFIG).unwrap();
    good(&["run", config.to_str().unwrap(), "--output", run.to_str().unwrap()]);
    run.to_str().unwrap().into()
}

fn terminate(child: &Child) {
    assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
}

/// Every file below `folder`.
fn below(folder: &Path) -> Vec<PathBuf> {
    let mut files = vec![];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files.extend(below(&path)) } else { files.push(path) }
    }
    files
}

/// Whether a file is what its ending says, to its end.
fn is_whole(path: &Path) -> bool {
    let bytes = fs::read(path).unwrap();
    match path.extension().and_then(|ending| ending.to_str()).unwrap_or_default() {
        "json" => serde_json::from_slice::<serde_json::Value>(&bytes).is_ok(),
        "html" => bytes.trim_ascii_end().ends_with(b"</html>"),
        "svg" => bytes.trim_ascii_end().ends_with(b"</svg>"),
        "png" => bytes.ends_with(b"IEND\xaeB`\x82"),
        "safetensors" => taxel_checkpoint::read(path).is_ok(),
        "md" | "csv" => bytes.ends_with(b"\n"),
        _ => true,
    }
}

#[test]
fn a_killed_fit_leaves_a_whole_model_or_none_and_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let run = run(dir.path());
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_string();
    let (whole, parts) = (at("whole.safetensors"), at("parts.safetensors"));
    let fit = |output: &str| {
        taxel(&["fit", &run, "--network", "resnet8-lite-1d", "--save-every", "0", "-o", output])
    };
    let begin = Instant::now();
    assert!(fit(&whole).status().unwrap().success());
    let length = begin.elapsed();
    let (mut with_session, mut ended) = (0, 0);
    for kill in 1..10 {
        let mut child = fit(&parts).spawn().unwrap();
        std::thread::sleep(length * kill / 10);
        let kind = if kill % 2 == 0 { "term" } else { "kill" };
        match kind {
            "term" => terminate(&child),
            _ => child.kill().unwrap(),
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        if output.status.success() {
            ended += 1;
        } else if kind == "term" && output.status.code().is_some() {
            assert_eq!(output.status.code(), Some(130), "{said}");
            assert!(said.contains("the same command"), "{said}");
        }
        let model = Path::new(&parts);
        assert!(!model.exists() || fs::read(model).unwrap() == fs::read(&whole).unwrap(), "half a model");
        let session = below(dir.path()).into_iter().any(|path| path.to_string_lossy().contains(".session."));
        with_session += usize::from(session);
        let _ = fs::remove_file(model);
    }
    assert!(with_session > 0 || ended > 8, "no kill met a training");
    // A kill between the model's first byte and its name is rare here, so one is staged.
    fs::write(dir.path().join("parts.safetensors.a8Kq2x.part"), "half a mod").unwrap();
    assert!(fit(&parts).status().unwrap().success());
    assert!(fs::read(&parts).unwrap() == fs::read(&whole).unwrap());
    let left: Vec<PathBuf> = below(dir.path()).into_iter().filter(|p| !p.starts_with(&run)).collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn a_killed_report_leaves_whole_files_or_none() {
    let dir = tempfile::tempdir().unwrap();
    let run = run(dir.path());
    let folder = Path::new(&run);
    let report = || taxel(&["report", &run, "--no-stress"]);
    let before = below(folder).len();
    let begin = Instant::now();
    assert!(report().status().unwrap().success());
    let length = begin.elapsed();
    let finished = below(folder).len();
    assert!(finished > before + 20);
    for kill in 1..7 {
        for made in ["judgement.json", "report.html"] {
            let _ = fs::remove_file(folder.join(made));
        }
        for made in ["tables", "charts"] {
            let _ = fs::remove_dir_all(folder.join(made));
        }
        let mut child = report().spawn().unwrap();
        std::thread::sleep(length * kill / 7);
        if kill % 2 == 0 {
            terminate(&child)
        } else {
            child.kill().unwrap()
        }
        let output = child.wait_with_output().unwrap();
        if output.status.code() == Some(130) {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(said.contains("the same command"), "{said}");
        } else if kill % 2 == 0 {
            assert!(output.status.success() || kill == 2, "{:?}", output.status);
        }
        for file in below(folder) {
            assert!(is_whole(&file), "{} is half-written", file.display());
        }
        if kill == 3 {
            set_back(folder);
        }
        if folder.join("report.html").exists() {
            assert!(folder.join("judgement.json").exists() && below(folder).len() >= finished);
        }
    }
    assert!(report().status().unwrap().success());
    assert_eq!(below(folder).len(), finished, "nothing half-written is left");
}

#[test]
fn a_stopped_stress_says_that_nothing_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let run = run(dir.path());
    let before = below(Path::new(&run));
    let begin = Instant::now();
    assert!(taxel(&["stress", &run]).status().unwrap().success());
    let (length, mut stopped) = (begin.elapsed(), 0);
    for part in 1..8 {
        let mut child = taxel(&["stress", &run]).spawn().unwrap();
        std::thread::sleep(length * part / 8);
        if part % 3 == 0 {
            child.kill().unwrap()
        } else {
            terminate(&child)
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        // Sooner than the program has begun, or later than it has ended, there is nobody who could say something.
        if output.status.code() == Some(130) {
            stopped += 1;
            assert!(said.contains("nothing was written") && said.contains("the same command"), "{said}");
        }
        assert_eq!(below(Path::new(&run)), before);
    }
    assert!(stopped > 0, "no signal met the test of faults");
}

#[test]
fn a_report_waits_for_no_other_process_but_says_who_writes() {
    let dir = tempfile::tempdir().unwrap();
    let run = run(dir.path());
    let lock = fs::OpenOptions::new().write(true).open(Path::new(&run).join(".lock")).unwrap();
    lock.lock().unwrap();
    for arguments in [vec!["report", &run, "--no-stress"], vec!["choose", &run]] {
        let output = taxel(&arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("is writing to this run folder"), "{said}");
    }
    lock.unlock().unwrap();
    good(&["choose", &run]);
}
