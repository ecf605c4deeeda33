//! A run that is killed (SIGKILL) and resumed writes the bytes of one that was not.
//! `scripts/kill_resume.py` does the same at more moments and for more networks.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/clock.rs"]
mod clock;
#[path = "support/run_folder.rs"]
mod run_folder;

use clock::set_back;
use run_folder::contents;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const CONFIG: &str = r#"
name = "killed"
seed = 5
baselines = ["k-nn"]
[data]
scene = "fingertip"
samples = 60
[protocol]
folds = 2
[train]
epochs = 60
batch_size = 8
optimizer = { name = "adam", lr = 1e-3 }
early_stopping = { patience = 58 }
[choose]
grid = { "optimizer.lr" = [5e-2, 2e-2] }
[[networks]]
name = "resnet8-lite-1d"
"#;

fn taxel(config: &Path, out: &Path, resume: bool) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.arg("run").arg(config).arg("--output").arg(out).args(["--threads", "1", "--save-every", "0"]);
    if resume {
        command.arg("--resume");
    }
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn sessions(out: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(out.join("folds")) else { return 0 };
    entries.filter(|e| e.as_ref().unwrap().path().to_str().unwrap().ends_with(".session.safetensors")).count()
}

#[test]
fn a_killed_run_resumes_to_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("killed.toml");
    std::fs::write(&config, CONFIG).unwrap();
    let (whole, parts) = (dir.path().join("whole"), dir.path().join("parts"));
    let begin = Instant::now();
    assert!(taxel(&config, &whole, false).status().unwrap().success());
    let length = begin.elapsed();
    let mut within_a_fold = 0;
    for kill in 0..9 {
        let mut child = taxel(&config, &parts, kill > 0).spawn().unwrap();
        // Once something is saved, a tenth of the run further each time.
        let ready = (0..2000).any(|_| {
            std::thread::sleep(Duration::from_millis(2));
            sessions(&parts) > 0 || child.try_wait().unwrap().is_some()
        });
        assert!(ready, "nothing was saved");
        std::thread::sleep(length / 10);
        child.kill().unwrap();
        child.wait().unwrap();
        within_a_fold += sessions(&parts);
        assert!(parts.join("config.toml").is_file());
        if kill == 4 {
            set_back(&parts);
        }
    }
    assert!(within_a_fold > 0, "no kill met a fold in training");
    let output = taxel(&config, &parts, true).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (a, b) = (contents(&whole), contents(&parts));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{} differs", name.display());
    }
}

#[test]
fn a_second_process_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("killed.toml");
    std::fs::write(&config, CONFIG.replace("epochs = 60", "epochs = 100000")).unwrap();
    let out = dir.path().join("run");
    let mut first = taxel(&config, &out, false).spawn().unwrap();
    let ready = (0..2000).any(|_| {
        std::thread::sleep(Duration::from_millis(2));
        sessions(&out) > 0
    });
    assert!(ready, "nothing was saved");
    let second = taxel(&config, &out, true).output().unwrap();
    assert_eq!(second.status.code(), Some(2));
    let error = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(error.contains(&format!("process {} is writing", first.id())), "{error}");
    first.kill().unwrap();
    first.wait().unwrap();
}
