//! Wrong inputs, one by one: every error names the file, the place and the value, says what is expected and how to fix
//! it, and ends with exit code 2.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use taxel_data::Npz;
use tempfile::TempDir;

const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/quickstart.toml");

/// A config with one small network; the line of a test is put in.
const CONFIG: &str = "name = \"tiny\"\nseed = 1\n\n[data]\nscene = \"fingertip\"\nsamples = 24\n\n[train]\nepochs = 1\n\n\
                      [protocol]\nfolds = 2\n\n[[networks]]\nname = \"mlp\"\n";

/// A folder with good and damaged files, and the commands that are tried on them.
struct Bench {
    folder: TempDir,
}

/// A command with a mistake, the file or value that the error has to name, and words that tell how to fix it.
struct Mistake<'a> {
    what: &'a str,
    arguments: Vec<&'a str>,
    named: &'a str,
    fix: &'a [&'a str],
}

impl Bench {
    fn new() -> Bench {
        let bench = Bench { folder: tempfile::tempdir().unwrap() };
        let [data, model, run] = ["grasps.npz", "model.safetensors", "run"].map(|name| bench.at(name));
        bench.good(&["simulate", "fingertip", "--samples", "24", "--output", &data]);
        let small = ["--set", "networks=[{name=\"mlp\"}]", "--set", "train.epochs=1"];
        let quick = ["--quick", "--data", &data, "--set", "baselines=[\"majority\"]"];
        bench.good(&[&["run", QUICKSTART, "--output", &run][..], &small, &quick].concat());
        bench.good(
            &[&["fit", QUICKSTART, "--network", "mlp", "--output", &model][..], &small, &quick].concat(),
        );
        bench.damaged_files();
        bench
    }

    /// Writes the files with a mistake inside.
    fn damaged_files(&self) {
        let write = |name: &str, bytes: &[u8]| {
            let path = self.path(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        };
        let half =
            |name: &str| fs::read(self.path(name)).map(|bytes| bytes[..bytes.len() / 2].to_vec()).unwrap();
        write("empty.npz", b"");
        write("half.npz", &half("grasps.npz"));
        write("half.safetensors", &half("model.safetensors"));
        write("notes.docx", b"words");
        let npz = |labels: &[i64], samples: usize| {
            let mut npz = Npz::default();
            npz.add("x", &[samples, 2, 10], &vec![1.5f32; samples * 20]).unwrap();
            npz.add("y", &[labels.len()], labels).unwrap();
            npz.finish().unwrap()
        };
        write("short.npz", &npz(&[0, 1, 0, 1, 0], 6));
        write("one-class.npz", &npz(&[0; 6], 6));
        write("two-channels.npz", &npz(&[0, 1, 0, 1, 0, 1], 6));
        for (set, soft, hard) in
            [("mixed", "1,2\n3,4\n", "1,2,3\n4,5,6\n"), ("cut", "1,2\n3,4\n", "1,2\n3\n")]
        {
            write(&format!("{set}/soft/a.csv"), soft.as_bytes());
            write(&format!("{set}/hard/b.csv"), hard.as_bytes());
        }
        for (set, soft, hard) in
            [("lengths", "1,2\n3,4\n", "1,2\n3,4\n5,6\n"), ("word", "1,2\n3,4\n", "1,2\n3,x\n")]
        {
            write(&format!("{set}/soft/a.csv"), soft.as_bytes());
            write(&format!("{set}/hard/b.csv"), hard.as_bytes());
        }
        let config = |name: &str, from: &str, to: &str| {
            assert!(CONFIG.contains(from), "{from}");
            write(name, CONFIG.replace(from, to).as_bytes());
        };
        config("good.toml", "seed = 1", "seed = 1");
        config("key.toml", "epochs = 1", "epoch = 1");
        config("type.toml", "epochs = 1", "epochs = \"one\"");
        config("range.toml", "epochs = 1", "epochs = 0");
        config("syntax.toml", "epochs = 1", "epochs = ");
        config("network.toml", "\"mlp\"", "\"mpl\"");
        config("scene.toml", "\"fingertip\"", "\"fingertop\"");
        config("baseline.toml", "seed = 1", "baselines = [\"majorty\"]");
        config(
            "metric.toml",
            "[protocol]",
            "[choose]\ngrid = { \"optimizer.lr\" = [0.1] }\nby = \"acuracy\"\n\n[protocol]",
        );
        config("variable.toml", "scene = \"fingertip\"\nsamples = 24", "path = \"${TAXEL_NOWHERE}/x.npz\"");
        config("gone.toml", "scene = \"fingertip\"\nsamples = 24", "path = \"gone.npz\"");
        config("old-key.toml", "seed = 1", "rivals = [\"k-nn\"]");
        write("study.toml", b"config = \"good.toml\"\n[grid]\ntrain.epoch = [1]\n");
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn at(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_string()
    }

    fn taxel(&self, arguments: &[&str]) -> std::process::Output {
        let mut command = Command::cargo_bin("taxel").unwrap();
        command.current_dir(self.folder.path()).env_remove("TAXEL_THREADS").args(arguments).output().unwrap()
    }

    fn good(&self, arguments: &[&str]) {
        let output = self.taxel(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Runs a command with a mistake; returns its error, and everything that the error fails to say.
    fn run(&self, mistake: &Mistake) -> (String, Vec<String>) {
        let Mistake { what, arguments, named, fix } = mistake;
        let output = self.taxel(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        let missing = fix.iter().chain([named, &"error: "]).filter(|words| !error.contains(**words));
        let mut failed: Vec<String> =
            missing.map(|words| format!("{what}: {words:?} is not in {error}")).collect();
        if output.status.code() != Some(2) {
            failed.push(format!("{what}: exit code {:?}: {error}", output.status.code()));
        }
        (error, failed)
    }
}

/// The mistakes: wrong files first, then configs, then options.
fn mistakes() -> Vec<Mistake<'static>> {
    let mistake = |what, arguments: &[&'static str], named, fix| Mistake {
        what,
        arguments: arguments.to_vec(),
        named,
        fix,
    };
    vec![
        // Files.
        mistake(
            "a missing file",
            &["data", "check", "gone.npz"],
            "gone.npz",
            &["no such file or folder", "check the path"],
        ),
        mistake(
            "a folder in place of a file",
            &["inspect", "run"],
            "run",
            &["is a folder", "give the path of a file"],
        ),
        mistake(
            "a file in place of a folder",
            &["report", "grasps.npz"],
            "grasps.npz",
            &["is a file", "give the path of a folder"],
        ),
        mistake(
            "a folder that holds no run",
            &["report", "mixed"],
            "mixed",
            &["no run folder", "make one with taxel run"],
        ),
        mistake(
            "an empty file",
            &["data", "check", "empty.npz"],
            "empty.npz",
            &["is empty", "copy or record it again"],
        ),
        mistake("another ending", &["data", "check", "notes.docx"], "notes.docx", &["give a .ts"]),
        mistake(
            "half an archive",
            &["data", "check", "half.npz"],
            "half.npz",
            &["cut short or damaged", "copy it again"],
        ),
        mistake("half a model", &["inspect", "half.safetensors"], "half.safetensors", &["copy it again"]),
        mistake(
            "no model",
            &["predict", "grasps.npz", "grasps.npz"],
            "grasps.npz",
            &["expected .safetensors"],
        ),
        mistake("a row cut short", &["data", "check", "cut"], "b.csv", &["line 2"]),
        mistake("a word among numbers", &["data", "check", "word"], "b.csv", &["line 2", "\"x\""]),
        mistake(
            "labels short by one",
            &["run", "good.toml", "--data", "short.npz"],
            "short.npz",
            &["6", "5"],
        ),
        mistake("one class", &["run", "good.toml", "--data", "one-class.npz"], "one-class", &["class"]),
        mistake("files of mixed channels", &["data", "check", "mixed"], "b.csv", &["3", "2"]),
        mistake(
            "recordings of other lengths",
            &["run", "good.toml", "--data", "lengths"],
            "lengths",
            &["--length resample:"],
        ),
        mistake(
            "samples for another model",
            &["predict", "model.safetensors", "two-channels.npz"],
            "two-channels.npz",
            &["[5, 50]"],
        ),
        // Configs.
        mistake("an unknown key", &["run", "key.toml"], "key.toml:9:1", &["did you mean `epochs`?"]),
        mistake("a value of another type", &["run", "type.toml"], "type.toml:9:10", &["expected"]),
        mistake("a value out of range", &["run", "range.toml"], "range.toml:9", &["must be in 1..=100000"]),
        mistake("no value at all", &["run", "syntax.toml"], "syntax.toml:9", &["epochs ="]),
        mistake("an unknown network", &["run", "network.toml"], "network.toml:15", &["did you mean `mlp`?"]),
        mistake("an unknown scene", &["run", "scene.toml"], "scene.toml:5", &["did you mean `fingertip`?"]),
        mistake(
            "an unknown baseline",
            &["run", "baseline.toml"],
            "baseline.toml:2",
            &["did you mean `majority`?"],
        ),
        mistake("an unknown metric", &["run", "metric.toml"], "metric.toml", &["acuracy", "accuracy"]),
        mistake(
            "a variable that is not set",
            &["run", "variable.toml"],
            "variable.toml:5",
            &["TAXEL_NOWHERE", "export"],
        ),
        mistake(
            "a config whose data are gone",
            &["run", "gone.toml"],
            "gone.npz",
            &["no such file or folder"],
        ),
        mistake(
            "an old key",
            &["run", "old-key.toml"],
            "old-key.toml:2:1",
            &["it is called `baselines` now"],
        ),
        mistake(
            "a study with an unknown key",
            &["sweep", "plan", "study.toml"],
            "study.toml",
            &["did you mean `epochs`?"],
        ),
        // Options.
        mistake(
            "--set without a value",
            &["run", "good.toml", "--set", "train.epochs"],
            "--set train.epochs",
            &["must be key=value"],
        ),
        mistake(
            "--set beyond a list",
            &["run", "good.toml", "--set", "networks.9.label=a"],
            "networks.9.label",
            &["not a position in an array of 1"],
        ),
        mistake(
            "--set of an unknown key",
            &["run", "good.toml", "--set", "train.epoch=1"],
            "train.epoch=1",
            &["did you mean `epochs`?"],
        ),
        mistake("no such network", &["cost", "mpl"], "mpl", &["did you mean `mlp`?"]),
        mistake("no such fault", &["stress", "run", "--fault", "gian"], "gian", &["gain"]),
        mistake("no such severity", &["stress", "run", "--severity", "9"], "9", &["1"]),
        mistake("no such scene", &["simulate", "hnd", "--output", "x.npz"], "hnd", &["did you mean `hand`?"]),
        mistake(
            "no such setting",
            &["simulate", "fingertip", "--set", "shroe=1", "--output", "x.npz"],
            "shroe",
            &["did you mean `shore`?"],
        ),
        mistake(
            "no such effect",
            &["simulate", "fingertip", "--without", "plcement", "--output", "x.npz"],
            "plcement",
            &["did you mean `placement`?"],
        ),
        mistake("no such option", &["run", "good.toml", "--outptu", "x"], "--outptu", &["--output"]),
        mistake(
            "no such row",
            &["fit", "run", "--network", "mpl", "--output", "x.safetensors"],
            "mpl",
            &["did you mean `mlp`?"],
        ),
        mistake(
            "a model of another ending",
            &["fit", "run", "--output", "model.pt"],
            "model.pt",
            &["--output model.safetensors"],
        ),
        mistake(
            "a folder that cannot be written",
            &["simulate", "fingertip", "--output", "/proc/x.npz"],
            "/proc/x.npz",
            &["cannot be written"],
        ),
        mistake(
            "a file as the output folder",
            &["run", "good.toml", "--output", "grasps.npz/run"],
            "grasps.npz",
            &["cannot be created"],
        ),
        mistake(
            "a run that is there",
            &["run", "good.toml", "--output", "run"],
            "run",
            &["--resume", "--output"],
        ),
        mistake(
            "weights that are not given",
            &["forward", "--model", "mlp", "--input", "grasps.npz", "--output", "y.npy"],
            "mlp",
            &["--weights FILE"],
        ),
    ]
}

#[test]
fn every_error_names_the_place_and_the_fix() {
    let bench = Bench::new();
    let all = mistakes();
    assert!(all.len() >= 30);
    let mut failed = vec![];
    for mistake in &all {
        let (error, missing) = bench.run(mistake);
        println!("{}\n  taxel {}\n  {}", mistake.what, mistake.arguments.join(" "), error.trim_end());
        failed.extend(missing);
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// Every command that reads a path says the same of one where nothing is.
#[test]
fn a_missing_path_reads_the_same_in_all_commands() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("there"), "a file").unwrap();
    let commands: &[&[&str]] = &[
        &["data", "check", "gone"],
        &["data", "convert", "gone", "--output", "x.npz"],
        &["encode", "gadf", "--input", "gone", "--output", "x.npy"],
        &["run", "gone"],
        &["run", "there", "--data", "gone"],
        &["fit", "gone", "--output", "x.safetensors"],
        &["import", "gone", "--output", "x.safetensors"],
        &["stitch", "--visual", "gone", "--tactile", "there", "--output", "x.safetensors"],
        &["report", "gone"],
        &["choose", "gone"],
        &["stress", "gone"],
        &["predict", "gone", "there"],
        &["predict", "there", "gone"],
        &["stream", "gone"],
        &["stream", "there", "--input", "gone"],
        &["inspect", "gone"],
        &["quantize", "gone"],
        &["quantize", "there", "--calibrate", "gone", "--output", "x.safetensors"],
        &["export", "gone.safetensors", "--output", "x.onnx"],
        &["export", "mlp", "--weights", "gone", "--output", "x.onnx"],
        &["shrink", "gone"],
        &["sweep", "plan", "gone"],
        &["sweep", "run", "gone"],
        &["sweep", "run-one", "gone", "--index", "0"],
        &["sweep", "collect", "gone"],
        &["sweep", "emit", "make", "gone"],
        &["sweep", "emit", "slurm", "gone"],
        &["cost", "gone.onnx"],
        &["forward", "--model", "mlp", "--input", "gone", "--output", "x.npy"],
    ];
    for arguments in commands {
        let mut command = Command::cargo_bin("taxel").unwrap();
        let output = command.current_dir(folder.path()).args(*arguments).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        let gone = arguments.iter().find(|word| word.starts_with("gone")).unwrap();
        assert_eq!(
            error,
            format!("error: {gone}: no such file or folder; check the path\n"),
            "{arguments:?}"
        );
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was written");
}

#[test]
fn the_variable_of_threads_is_checked_like_the_option() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("x.npz");
    let simulate = |threads: &str, output: &Path| {
        let mut command = Command::cargo_bin("taxel").unwrap();
        command.env("TAXEL_THREADS", threads).args(["simulate", "fingertip", "--samples", "8", "--output"]);
        command.arg(output).output().unwrap()
    };
    assert!(simulate("1", &data).status.success());
    let report = |threads: &str| {
        let mut command = Command::cargo_bin("taxel").unwrap();
        command
            .env("TAXEL_THREADS", threads)
            .args(["report", folder.path().to_str().unwrap()])
            .output()
            .unwrap()
    };
    let error = String::from_utf8(report("two").stderr).unwrap();
    assert!(
        error.contains("TAXEL_THREADS=two: must be a number of threads from 1, such as TAXEL_THREADS=2"),
        "{error}"
    );
}
