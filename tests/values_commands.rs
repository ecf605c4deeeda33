//! Every command on a network and baselines of values: a run with fault-augmented rows, a learning curve, sweep, shrink, the choice,
//! faults and eight bits. Each prints errors in the unit of the targets, and nothing that belongs to classes.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// Words and signs of classes, which nothing that a command says of values holds.
const OF_CLASSES: [&str; 8] =
    ["accuracy", "Accuracy", " points", "chance", "Chance", "classes", "per class", "each class"];

const CONFIG: &str = r#"
name = "shore"
baselines = ["mean", "extra-trees"]
[data]
scene = "fingertip"
samples = 60
y = "shore"
[protocol]
folds = 2
[train]
epochs = 12
batch_size = 16
optimizer = { name = "adam", lr = 0.01 }
[harden]
faults = { kinds = ["noise", "dead"] }
[[networks]]
name = "mlp"
set = { hidden = 8 }
"#;

/// A folder with the config, whose commands run in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(config: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("shore.toml"), config).unwrap();
        Folder(folder)
    }

    /// Runs a command, parted by spaces, and returns what it said.
    fn says(&self, command: &str) -> String {
        let output = Command::cargo_bin("taxel")
            .unwrap()
            .current_dir(self.0.path())
            .args(command.split(' '))
            .output()
            .unwrap();
        let status = output.status;
        let [said, error] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert_eq!(status.code(), Some(0), "{command}: {error}");
        format!("{said}{error}")
    }

    fn json(&self, path: &str) -> Value {
        serde_json::from_str(&self.text(path)).unwrap()
    }

    fn text(&self, path: &str) -> String {
        fs::read_to_string(self.0.path().join(path)).unwrap()
    }
}

/// Returns the visible text of a page.
fn visible(page: &str) -> String {
    let without = |text: &str, tag: &str| {
        let (begin, end) = (format!("<{tag}"), format!("</{tag}>"));
        let mut parts = text.split(begin.as_str());
        let first = parts.next().unwrap_or_default().to_string();
        parts.fold(first, |all, part| all + part.split_once(end.as_str()).map_or("", |(_, rest)| rest))
    };
    let plain = without(&without(page, "style"), "script");
    plain
        .split('<')
        .map(|part| part.split_once('>').map_or(part, |(_, text)| text))
        .collect::<Vec<_>>()
        .join(" ")
}

fn refuse_words_of_classes(from: &str, said: &str) {
    for word in OF_CLASSES {
        let at = said.find(word);
        let around = at.map(|at| {
            said.chars().skip(said[..at].chars().count().saturating_sub(80)).take(200).collect::<String>()
        });
        assert!(at.is_none(), "{from} says {word:?}: {}", around.unwrap_or_default());
    }
}

#[test]
fn every_command_takes_a_run_of_values_and_counts_in_their_unit() {
    let folder = Folder::new(CONFIG);
    for (command, wanted) in [
        ("run shore.toml --output run", "MAE Shore A"),
        ("run shore.toml --output run --resume", "mlp.hardened"),
        ("quantize run", "mlp.hardened.int8"),
        ("stress run --fault noise --fault dead", "MAE added in Shore A"),
        ("report run", "Shore A"),
        ("choose run", "MAE Shore A"),
        ("shrink run --network mlp --quick --axes sensors,bits --output small", "MAE Shore A"),
        ("fit run --network mlp --output mlp.safetensors", "intervals fitted on 60 held-out predictions"),
        ("simulate fingertip --samples 30 --seed 1 --output new.npz", "new.npz"),
        (
            "quantize mlp.safetensors --calibrate new.npz --output bytes.safetensors",
            "shore: a value, in Shore A",
        ),
        ("predict bytes.safetensors new.npz", "shore (Shore A)"),
        ("predict small/shrunk.safetensors new.npz", "shore (Shore A)"),
    ] {
        let said = folder.says(command);
        assert!(said.contains(wanted), "{command} says no {wanted:?}: {said}");
        let is_of_scene = command.starts_with("simulate");
        if !is_of_scene {
            refuse_words_of_classes(command, &said);
        }
    }
    for page in ["run/report.html", "small/index.html"] {
        refuse_words_of_classes(page, &visible(&folder.text(page)));
    }
    assert!(visible(&folder.text("run/report.html")).contains("Samples that are answered as unknown"));
    // Files that are read again keep one key for all metrics, and say which it is.
    for file in ["run/judgement.json", "small/shrink.json"] {
        assert!(folder.text(file).contains("\"mae\""), "{file}");
    }
}

#[test]
fn a_learning_curve_and_a_sweep_count_values_in_their_unit() {
    let curve = CONFIG
        .replace("folds = 2", "kind = \"few-samples\"\nper_class = [2, 4]\nrepetitions = 2\ntest = 0.4");
    let folder = Folder::new(&curve.replace("[harden]\nfaults = { kinds = [\"noise\", \"dead\"] }\n", ""));
    let said = folder.says("run shore.toml --output run");
    assert!(said.contains("few samples per part of the range") && said.contains("mlp.n4"), "{said}");
    folder.says("report run");
    let page = visible(&folder.text("run/report.html"));
    refuse_words_of_classes("the report", &page);
    assert!(page.contains("training samples of each part of the range"), "{page}");

    let study = "name = \"rates\"\nconfig = \"shore.toml\"\n[grid]\nseed = [0, 1]\ntrain.epochs = [2, 4]\n";
    fs::write(folder.0.path().join("study.toml"), study).unwrap();
    fs::write(folder.0.path().join("shore.toml"), CONFIG).unwrap();
    folder.says("sweep plan study.toml");
    let said = folder.says("sweep run sweeps/rates");
    assert!(said.contains("4 finished"), "{said}");
    let said = folder.says("sweep collect sweeps/rates");
    assert!(said.contains("MAE Shore A"), "{said}");
    refuse_words_of_classes("sweep collect", &said);
    refuse_words_of_classes(
        "the page of a sweep",
        &visible(&folder.text("sweeps/rates/collected/index.html")),
    );
}

#[test]
fn folds_choose_a_recipe_by_a_metric_of_values() {
    let grid = "[choose]\ngrid = { \"optimizer.lr\" = [0.01, 1e-6] }\nby = \"mae\"\n";
    let without = CONFIG.replace("[harden]\nfaults = { kinds = [\"noise\", \"dead\"] }\n", grid);
    let folder = Folder::new(&without);
    folder.says("run shore.toml --output run");
    let record = folder.json("run/folds/mlp.r0.f0.json").to_string();
    assert!(record.contains("\"optimizer.lr\":0.01"), "{record}");
    let refused = Folder::new(&without.replace("\"mae\"", "\"accuracy\""));
    let run = Command::cargo_bin("taxel")
        .unwrap()
        .current_dir(refused.0.path())
        .args(["run", "shore.toml"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&run.stderr);
    assert!(
        run.status.code() == Some(2) && error.contains("choose.by = \"accuracy\": known: loss, mae"),
        "{error}"
    );
    assert!(!Path::new(&refused.0.path().join("runs")).exists());
}

#[test]
fn a_simulated_file_says_the_units_of_its_true_values() {
    let folder = Folder::new(CONFIG);
    folder.says("simulate gripper --samples 30 --output grasps.npz");
    let card = folder.says("data check grasps.npz --y stiffness_n_per_mm");
    assert!(card.contains("values: stiffness 0.") && card.contains("N/mm"), "{card}");
    folder.says("simulate fingertip --samples 60 --set between=[0,40] --set unseen=0.5 --output between.npz");
    let run = "run shore.toml --data between.npz --y shore --set protocol={kind=\"official\"} --output run";
    assert!(folder.says(run).contains("MAE Shore A"));
    assert_eq!(folder.json("run/results.json")["quantities"][0]["unit"], "Shore A");
}
