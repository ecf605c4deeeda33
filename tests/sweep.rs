//! A sweep that is killed, stopped, divided and handed to schedulers ends like one that was left alone.
//! `scripts/slurm_sweep.py` does the same with Slurm, and `scripts/kill_sweep.py` with more kills.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/clock.rs"]
mod clock;
#[path = "support/run_folder.rs"]
mod run_folder;

use clock::set_back;
use run_folder::contents;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

const CONFIG: &str = r#"
name = "tiny"
baselines = ["majority"]
[data]
scene = "fingertip"
samples = 40
[protocol]
folds = 2
[train]
epochs = 40
batch_size = 8
optimizer = { name = "adam", lr = 1e-3 }
[[networks]]
name = "mlp"
"#;

/// A folder with the config and a study of it.
struct Bench {
    dir: tempfile::TempDir,
}

impl Bench {
    fn new(study: &str) -> Self {
        let bench = Bench { dir: tempfile::tempdir().unwrap() };
        std::fs::write(bench.path("tiny.toml"), CONFIG).unwrap();
        std::fs::write(bench.path("study.toml"), format!("config = \"tiny.toml\"\n{study}")).unwrap();
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// A planned sweep.
    fn plan(&self, name: &str) -> PathBuf {
        let out = self.path(name);
        let planned = taxel(&["plan"], &self.path("study.toml"), &["--output", out.to_str().unwrap()]);
        assert!(planned.status.success(), "{}", said(&planned));
        out
    }
}

fn command(verb: &[&str], sweep: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.arg("sweep").args(verb).arg(sweep).args(more);
    command
}

fn taxel(verb: &[&str], sweep: &Path, more: &[&str]) -> Output {
    command(verb, sweep, more).output().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn run(sweep: &Path) {
    let output = taxel(&["run"], sweep, &["--jobs", "2", "--quiet"]);
    assert!(output.status.success(), "{}", said(&output));
}

/// Run folders and results of a sweep, but for the file that a killed process had begun to write.
fn results(sweep: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let all = ["runs", "results"].into_iter();
    all.flat_map(|part| {
        contents(&sweep.join(part)).into_iter().map(move |(path, b)| (Path::new(part).join(path), b))
    })
    .filter(|(path, _)| path.extension().is_none_or(|ending| ending != "part"))
    .collect()
}

fn assert_equal(a: &BTreeMap<PathBuf, Vec<u8>>, b: &BTreeMap<PathBuf, Vec<u8>>) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    a.iter().for_each(|(name, bytes)| assert!(*bytes == b[name], "{} differs", name.display()));
}

fn entries(folder: &Path) -> usize {
    std::fs::read_dir(folder).map_or(0, |entries| entries.count())
}

fn finished(sweep: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(sweep.join("results")) else { return 0 };
    let is_result = |path: &str| !path.ends_with(".timing.json") && !path.ends_with(".part");
    entries.filter(|e| is_result(e.as_ref().unwrap().path().to_str().unwrap())).count()
}

/// Whether `process` has claimed a trial and works on it.
fn works(process: &Child, sweep: &Path) -> bool {
    let holder = format!("\"pid\":{},", process.id());
    let claims = std::fs::read_dir(sweep.join("claims")).into_iter().flatten();
    claims.map(|claim| claim.unwrap().path()).any(|claim| {
        let its = std::fs::read_to_string(&claim).is_ok_and(|text| text.contains(&holder));
        its && sweep.join("work").join(claim.file_name().unwrap()).exists()
    })
}

/// Sends `signal`, such as `-TERM`.
#[cfg(unix)]
fn send(process: &Child, signal: &str) {
    let id = process.id().to_string();
    assert!(Command::new("kill").args([signal, id.as_str()]).status().unwrap().success());
}

/// Kills it at work: held still first, for a trial that was seen may have ended since. False where it has.
fn kill_at_work(process: &mut Child, sweep: &Path) -> bool {
    #[cfg(unix)]
    send(process, "-STOP");
    if works(process, sweep) {
        process.kill().unwrap();
        process.wait().unwrap();
        return true;
    }
    #[cfg(unix)]
    send(process, "-CONT");
    false
}

#[test]
fn a_killed_sweep_ends_like_one_left_alone() {
    let bench = Bench::new("[grid]\nseed = [0, 1, 2, 3, 4, 5]\ntrain.optimizer.lr = [1e-2, 1e-3]\n");
    let (alone, killed) = (bench.plan("alone"), bench.plan("killed"));
    run(&alone);
    assert_eq!(finished(&alone), 12);
    let mut kills = 0;
    for round in 0..5 {
        let more = ["--jobs", "2", "--save-every", "0"];
        let mut command = command(&["run"], &killed, &more);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let before = finished(&killed);
        // In the middle of trials, some further on each time.
        while child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(3 + 2 * round));
            if finished(&killed) > before && works(&child, &killed) && kill_at_work(&mut child, &killed) {
                kills += 1;
            }
        }
        if round == 2 {
            set_back(&killed);
        }
    }
    assert!(kills > 0, "no kill met a trial under way");
    run(&killed);
    assert_equal(&results(&alone), &results(&killed));
    let collected = taxel(&["collect"], &killed, &[]);
    assert!(
        said(&collected).contains("12 of 12 trials finished, 0 failed, 0 begun, 0 missing"),
        "{}",
        said(&collected)
    );
    assert!(collected.status.success() && killed.join("collected/index.html").is_file());
    assert_eq!((entries(&killed.join("claims")), entries(&killed.join("work"))), (0, 0));
}

#[test]
fn folds_apart_come_back_as_the_run_that_was_never_divided() {
    let bench = Bench::new("folds = \"apart\"\n");
    let sweep = bench.plan("sweep");
    let manifest = std::fs::read_to_string(sweep.join("manifest.jsonl")).unwrap();
    assert_eq!(manifest.lines().count(), 4, "two folds of a network and of a baseline");
    // Backwards, and each in a process of its own.
    for index in ["3", "1", "0"] {
        let output = taxel(&["run-one"], &sweep, &["--index", index]);
        assert!(output.status.success(), "{}", said(&output));
    }
    let early = taxel(&["collect"], &sweep, &[]);
    assert_eq!(early.status.code(), Some(1));
    assert!(said(&early).contains("3 of 4 trials finished"), "{}", said(&early));
    assert_eq!(entries(&sweep.join("runs")), 0);
    run(&sweep);
    assert!(taxel(&["collect"], &sweep, &[]).status.success());
    let whole = bench.path("whole");
    let undivided = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(["run", bench.path("tiny.toml").to_str().unwrap(), "--output", whole.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(undivided.status.success(), "{}", said(&undivided));
    let together = std::fs::read_dir(sweep.join("runs")).unwrap().next().unwrap().unwrap().path();
    assert_equal(&contents(&whole), &contents(&together));
    // A second time nothing is counted twice.
    assert!(said(&taxel(&["collect"], &sweep, &[])).contains("4 of 4 trials finished"));
}

#[cfg(unix)]
#[test]
fn a_scheduler_s_signal_saves_and_ends_with_75() {
    let bench = Bench::new("set = { train.epochs = 8000 }\n");
    let (alone, stopped) = (bench.plan("alone"), bench.plan("stopped"));
    run(&alone);
    for signal in ["-USR1", "-TERM"] {
        // Nothing is saved but by the signal.
        let more = ["--index", "0", "--save-every", "1000"];
        let mut command = command(&["run-one"], &stopped, &more);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let begun = |_| {
            std::thread::sleep(Duration::from_millis(5));
            works(&child, &stopped)
        };
        assert!((0..4000).any(begun), "it never began");
        std::thread::sleep(Duration::from_millis(150));
        // Twice: a scheduler sends it to a script and to its child, and the script passes it on.
        for _ in 0..2 {
            send(&child, signal);
        }
        assert_eq!(child.wait().unwrap().code(), Some(75), "{signal}");
        let work = std::fs::read_dir(stopped.join("work")).unwrap().next().unwrap().unwrap().path();
        let saved = std::fs::read_dir(work.join("folds")).unwrap();
        let mut saved = saved.map(|e| e.unwrap().file_name().into_string().unwrap());
        assert!(saved.any(|name| name.ends_with(".session.safetensors")), "{signal}: nothing was saved");
    }
    assert_eq!(taxel(&["run-one"], &stopped, &["--index", "0"]).status.code(), Some(0));
    assert_equal(&results(&alone), &results(&stopped));
}

#[test]
fn a_trial_counts_once_and_a_failed_one_is_named() {
    let bench = Bench::new(
        "set = { train.epochs = 2 }\n[grid]\nseed = [1, 2, 1]\ntrain.optimizer.lr = [1e-3, 1e30]\n",
    );
    let sweep = bench.plan("sweep");
    let manifest = sweep.join("manifest.jsonl");
    let lines = std::fs::read_to_string(&manifest).unwrap();
    assert_eq!(lines.lines().count(), 4, "the second seed 1 is the first again");
    // Somebody puts two plans together.
    std::fs::write(&manifest, format!("{lines}{lines}")).unwrap();
    let first = taxel(&["run-one"], &sweep, &["--index", "0", "--count", "2"]);
    assert_eq!(first.status.code(), Some(1), "{}", said(&first));
    assert!(said(&first).contains("1 finished, 0 were finished before, 1 failed"), "{}", said(&first));
    let again = taxel(&["run-one"], &sweep, &["--index", "4", "--count", "1"]);
    assert!(said(&again).contains("0 finished, 1 were finished before, 0 failed"), "{}", said(&again));
    let collected = said(&taxel(&["collect"], &sweep, &[]));
    assert!(collected.contains("1 of 4 trials finished, 1 failed, 0 begun, 2 missing"), "{collected}");
    assert!(collected.contains("lower train.optimizer.lr"), "{collected}");
    assert!(collected.contains("4 lines of the manifest name a trial again"), "{collected}");
    let trials = std::fs::read_to_string(sweep.join("collected/trials.csv")).unwrap();
    assert_eq!(trials.lines().count(), 5);
}

/// The page names some hundred trials without a result: not those that wait before one that failed.
#[test]
fn a_failed_trial_behind_many_missing_ones_is_named() {
    let rates: Vec<String> = (1..250).map(|i| format!("{i}e-6")).collect();
    let bench = Bench::new(&format!(
        "set = {{ train.epochs = 2 }}\n[grid]\ntrain.optimizer.lr = [{}, 1e30]\n",
        rates.join(", ")
    ));
    let sweep = bench.plan("sweep");
    for index in ["0", "249"] {
        taxel(&["run-one"], &sweep, &["--index", index]);
    }
    // As a power cut may leave it.
    let mut kept = std::fs::read_dir(sweep.join("results")).unwrap().map(|e| e.unwrap().path());
    let timing = kept.find(|path| path.to_str().unwrap().ends_with(".timing.json")).unwrap();
    std::fs::write(timing, "").unwrap();
    let collected = said(&taxel(&["collect"], &sweep, &[]));
    assert!(collected.contains("1 of 250 trials finished, 1 failed, 0 begun, 248 missing"), "{collected}");
    assert!(collected.contains("trial 249 (tiny train.optimizer.lr=1e+30)"), "{collected}");
    let page = std::fs::read_to_string(sweep.join("collected/index.html")).unwrap();
    assert!(page.contains("The first 200 of 249, failed ones before others; all are in trials.csv."));
    assert!(page.contains("lower train.optimizer.lr"), "the failed one is not on the page");
}

#[test]
fn what_cannot_be_done_is_said() {
    let bench = Bench::new("[grid]\ntrain.epoch = [1, 2]\n");
    let planned =
        taxel(&["plan"], &bench.path("study.toml"), &["--output", bench.path("s").to_str().unwrap()]);
    assert_eq!(planned.status.code(), Some(2));
    let error = said(&planned);
    assert!(error.contains("study.toml train.epoch=1: unknown field `epoch`"), "{error}");
    assert!(!bench.path("s/manifest.jsonl").exists());

    let bench = Bench::new("");
    let sweep = bench.plan("sweep");
    let error = said(&taxel(&["run-one"], &sweep, &["--index", "7"]));
    assert!(error.contains("has 1 trials, none of number 7"), "{error}");
    let error = said(&taxel(&["emit", "slurm"], &sweep, &[]));
    assert!(error.contains("run one trial first"), "{error}");
    let manifest = sweep.join("manifest.jsonl");
    let planned = std::fs::read_to_string(&manifest).unwrap();
    let other = planned.replace("\"program\":\"", "\"program\":\"0.0.1 of old, ");
    std::fs::write(&manifest, other).unwrap();
    let refused = taxel(&["run-one"], &sweep, &["--index", "0"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(said(&refused).contains("was planned by taxel 0.0.1 of old"), "{}", said(&refused));
    let error = said(&taxel(&["run"], &bench.path("nowhere"), &[]));
    assert!(error.contains("nowhere: no such file or folder; check the path"), "{error}");
}

/// A stand-in for Slurm's `sbatch` that runs each task at once.
#[cfg(unix)]
const SBATCH: &str = r#"#!/bin/bash
number=$(($(cat "$STAND_IN/number" 2> /dev/null || echo 0) + 1))
echo "$number" > "$STAND_IN/number"
echo "$@" >> "$STAND_IN/calls"
array=
while [ "${1#--}" != "$1" ]; do
  case $1 in --array=*) array=${1#--array=} ;; esac
  shift
done
script=$1; shift
if [ -z "$array" ]; then bash "$script" "$@" > /dev/null
else
  for task in $(seq "${array%-*}" "${array#*-}"); do
    SLURM_ARRAY_TASK_ID=$task SLURM_CPUS_PER_TASK=1 bash "$script" "$@" > /dev/null
  done
fi
echo "$number;cluster"
"#;

#[cfg(unix)]
#[test]
fn schedulers_get_what_is_missing() {
    let bench = Bench::new("set = { train.epochs = 2 }\n[grid]\nseed = [0, 1, 2, 3, 4, 5, 6]\n");
    // A name that a shell would take apart.
    let sweep = bench.plan("my $weep's");
    for index in ["1", "2"] {
        assert!(taxel(&["run-one"], &sweep, &["--index", index]).status.success());
    }
    let more = ["--count", "2", "--max-array", "2", "--sbatch=--partition=a b"];
    let emitted = taxel(&["emit", "slurm"], &sweep, &more);
    assert!(
        said(&emitted).contains("5 of 7 trials have no result: 3 tasks of at most 2"),
        "{}",
        said(&emitted)
    );
    let tasks = std::fs::read_to_string(sweep.join("slurm/tasks")).unwrap();
    assert_eq!(tasks, "0 4\n4 2\n6 1\n", "finished ones between are passed over");
    let bin = bench.path("bin");
    std::fs::create_dir(&bin).unwrap();
    std::fs::write(bin.join("sbatch"), SBATCH).unwrap();
    assert!(Command::new("chmod").arg("+x").arg(bin.join("sbatch")).status().unwrap().success());
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let submitted = Command::new("sh")
        .arg(sweep.join("slurm/submit.sh"))
        .env("PATH", path)
        .env("STAND_IN", bench.dir.path())
        .output()
        .unwrap();
    assert!(submitted.status.success(), "{}", said(&submitted));
    let calls = std::fs::read_to_string(bench.path("calls")).unwrap();
    let calls: Vec<&str> = calls.lines().collect();
    assert_eq!(calls.len(), 3, "{calls:?}");
    assert!(calls[0].contains("--array=0-1") && calls[1].contains("--array=0-0"), "{calls:?}");
    assert!(
        calls[2].contains("--dependency=afterany:1:2") && calls[0].contains("--partition=a b"),
        "{calls:?}"
    );
    assert_eq!(finished(&sweep), 7);
    assert!(sweep.join("collected/index.html").is_file());
    let nothing = taxel(&["emit", "slurm"], &sweep, &[]);
    assert!(said(&nothing).contains("0 of 7 trials have no result: 0 tasks"), "{}", said(&nothing));
}

/// USR1 is what Slurm sends before the time limit; SIGTERM is an end that somebody wants.
#[cfg(unix)]
#[test]
fn a_task_goes_back_into_the_queue_before_its_time_limit() {
    let bench = Bench::new("set = { train.epochs = 100000 }\n");
    let sweep = bench.plan("sweep");
    assert!(taxel(&["emit", "slurm"], &sweep, &["--count", "1"]).status.success());
    let calls = bench.path("calls");
    let stand_in = format!("#!/bin/sh\necho \"$@\" >> {}\n", calls.display());
    std::fs::write(bench.path("scontrol"), stand_in).unwrap();
    assert!(Command::new("chmod").arg("+x").arg(bench.path("scontrol")).status().unwrap().success());
    for (signal, requeued) in [("-TERM", false), ("-USR1", true)] {
        let before = entries(&sweep.join("claims"));
        let mut task = Command::new("bash")
            .arg(sweep.join("slurm/task.sh"))
            .arg("0")
            .env("SLURM_ARRAY_JOB_ID", "7")
            .env("SLURM_ARRAY_TASK_ID", "0")
            .env("PATH", format!("{}:{}", bench.dir.path().display(), std::env::var("PATH").unwrap()))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begun = |_| {
            std::thread::sleep(Duration::from_millis(5));
            entries(&sweep.join("claims")) > before && entries(&sweep.join("work")) > 0
        };
        assert!((0..4000).any(begun), "it never began");
        assert!(Command::new("kill").args([signal, &task.id().to_string()]).status().unwrap().success());
        assert_eq!(task.wait().unwrap().code(), Some(75), "{signal}");
        let said = std::fs::read_to_string(&calls).unwrap_or_default();
        assert_eq!(said, if requeued { "requeue 7_0\n" } else { "" }, "{signal}");
    }
}

#[cfg(unix)]
#[test]
fn make_runs_what_is_missing() {
    if Command::new("make").arg("--version").output().is_err() {
        return;
    }
    let bench = Bench::new("set = { train.epochs = 2 }\n[grid]\nseed = [0, 1, 2]\n");
    let sweep = bench.plan("a $weep");
    assert!(taxel(&["emit", "make"], &sweep, &["--count", "2"]).status.success());
    let made = Command::new("make").args(["-j", "2", "-f"]).arg(sweep.join("Makefile")).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    assert!(said(&made).contains("3 of 3 trials finished"), "{}", said(&made));
}
