//! Two models or rows side by side, the scores of many runs in one table, the model card of the Hub, and the learning curve.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

const CONFIG: &str = r#"
name = "grasps"
baselines = ["majority", "k-nn", "svm-linear"]
[data]
scene = "fingertip"
samples = 120
[protocol]
folds = 3
[train]
epochs = 3
[[networks]]
name = "mlp"
set = { hidden = 8 }
"#;

const VALUES: &str = r#"
name = "shore"
networks = []
baselines = ["mean", "ridge"]
[data]
scene = "fingertip"
samples = 60
y = "shore"
[data.set]
between = [0.0, 60.0]
[protocol]
folds = 3
"#;

/// A folder whose commands run in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("grasps.toml"), CONFIG).unwrap();
        fs::write(folder.path().join("shore.toml"), VALUES).unwrap();
        Folder(folder)
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn output(&self, command: &str) -> (Option<i32>, String, String) {
        let mut taxel = Command::cargo_bin("taxel").unwrap();
        let output = taxel.current_dir(self.0.path()).args(command.split(' ')).output().unwrap();
        let [said, error] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (output.status.code(), said, error)
    }

    fn says(&self, command: &str) -> String {
        let (code, said, error) = self.output(command);
        assert_eq!(code, Some(0), "{command}: {error}");
        said
    }

    fn json(&self, command: &str) -> Value {
        serde_json::from_str(&self.says(command)).unwrap()
    }

    fn refuses(&self, command: &str, with: &str) {
        let (code, said, error) = self.output(command);
        assert_eq!(code, Some(2), "{command}: {said}{error}");
        assert!(error.contains(with), "{command}: {error}");
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Two-sided p of a fair coin.
fn coin(heads: u64, tails: u64) -> f64 {
    let n = heads + tails;
    let mut chance = 0.5f64.powi(n as i32);
    let mut below = 0.0;
    for k in 0..=heads.min(tails) {
        below += chance;
        chance *= (n - k) as f64 / (k + 1) as f64;
    }
    (2.0 * below).min(1.0)
}

/// Checks that the counts of a comparison of classes add up.
fn adds_up(found: &Value) {
    let samples = found["samples"].as_u64().unwrap();
    let right = &found["right"];
    let count = |value: &Value| value.as_u64().unwrap();
    let only = [count(&right["only"][0]), count(&right["only"][1])];
    assert_eq!(count(&right["both"]) + only[0] + only[1] + count(&right["neither"]), samples, "{found}");
    let places = found["places"].as_array().unwrap();
    assert_eq!(places.iter().map(|place| count(&place["samples"])).sum::<u64>(), samples);
    for side in [0, 1] {
        assert_eq!(places.iter().map(|place| count(&place["only"][side])).sum::<u64>(), only[side]);
        let share = 100.0 * (count(&right["both"]) + only[side]) as f64 / samples as f64;
        assert!((number(&found["scores"][side]) - share).abs() < 1e-6, "{found}");
    }
    let difference = number(&found["scores"][0]) - number(&found["scores"][1]);
    assert!((number(&found["difference"]) - difference).abs() < 1e-6, "{found}");
}

#[test]
fn rows_and_models_are_compared_on_the_same_samples() {
    let folder = Folder::new();
    folder.says("run grasps.toml --output run");
    let rows = folder.json("compare run run --network svm-linear --network majority --format json");
    adds_up(&rows);
    assert_eq!((rows["samples"].as_u64(), rows["parts"].as_u64()), (Some(120), Some(3)));
    assert!(rows["test"] == "nadeau-bengio" || rows["test"] == "NadeauBengio", "{rows}");

    for name in ["k-nn", "majority"] {
        folder.says(&format!("fit run --network {name} --output {name}.safetensors"));
    }
    folder.says("simulate fingertip --samples 45 --seed 9 --output new.npz");
    let models = folder.json("compare k-nn.safetensors majority.safetensors new.npz --format json");
    adds_up(&models);
    let only = |side: usize| models["right"]["only"][side].as_u64().unwrap();
    if models["groups"].is_null() {
        assert!((number(&models["p"]) - coin(only(0), only(1))).abs() < 1e-9, "{models}");
    }
    assert!(only(0) > only(1) && number(&models["difference"]) > 0.0, "{models}");
    // The other way round all signs turn.
    let turned = folder.json("compare majority.safetensors k-nn.safetensors new.npz --format json");
    assert!((number(&turned["difference"]) + number(&models["difference"])).abs() < 1e-9);
    assert_eq!(turned["p"], models["p"]);
    let text = folder.says("compare k-nn.safetensors majority.safetensors new.npz");
    assert!(text.contains("A is better by") && text.contains("only A right"), "{text}");
    // A model is no better than itself.
    let same = folder.says("compare k-nn.safetensors k-nn.safetensors new.npz");
    assert!(same.contains("Both score alike"), "{same}");

    folder.refuses("compare run run --network svm", "did you mean");
    folder.refuses("compare run k-nn.safetensors", "compare two models, or two runs");
    folder.refuses("compare k-nn.safetensors majority.safetensors", "on labelled recordings");
    folder.refuses("compare run run new.npz", "leave the data out");

    let table = folder.says("results .");
    let lines: Vec<&str> = table.lines().collect();
    let width = lines[0].split(',').count();
    assert!(lines[0].starts_with("run,name,source") && lines.len() > 4 * 4, "{table}");
    // No field of this run needs quotes but protocols with commas.
    assert!(
        lines.iter().filter(|line| !line.contains('"')).all(|line| line.split(',').count() == width),
        "{table}"
    );
    for row in ["mlp", "majority", "k-nn", "svm-linear"] {
        assert!(table.contains(&format!(",{row},")), "{row}: {table}");
    }
    folder.refuses("results grasps.toml", "grasps.toml");
    fs::create_dir(folder.path("empty")).unwrap();
    folder.refuses("results empty", "holds no run folder");
}

#[test]
fn values_are_compared_by_their_errors() {
    let folder = Folder::new();
    folder.says("run shore.toml --output run");
    for name in ["mean", "ridge"] {
        folder.says(&format!("fit run --network {name} --output {name}.safetensors"));
    }
    folder.says("simulate fingertip --samples 45 --seed 9 --set between=[0,60] --output new.npz");
    let found = folder.json("compare ridge.safetensors mean.safetensors new.npz --y shore --format json");
    let places = found["places"].as_array().unwrap();
    assert_eq!(places.len(), 3, "{found}");
    let weighted = |side: usize| {
        let sum: f64 =
            places.iter().map(|place| number(&place["samples"]) * number(&place["scores"][side])).sum();
        sum / number(&found["samples"])
    };
    for side in [0, 1] {
        assert!((weighted(side) - number(&found["scores"][side])).abs() < 1e-3, "{found}");
    }
    assert!(number(&found["difference"]) < 0.0, "ridge is nearer than the mean: {found}");
    let text = folder.says("compare ridge.safetensors mean.safetensors new.npz --y shore");
    assert!(
        text.contains("A is better by") && text.contains("A closer") && !text.contains("points"),
        "{text}"
    );
    folder.says("run grasps.toml --output other");
    folder.says("fit other --network k-nn --output classes.safetensors");
    folder.refuses(
        "compare ridge.safetensors classes.safetensors new.npz --y shore",
        "compare models of one task",
    );
}

#[test]
fn a_model_has_a_page_for_the_hub() {
    let folder = Folder::new();
    folder.says("run grasps.toml --output run");
    fs::create_dir(folder.path("hub")).unwrap();
    folder.says("fit run --network k-nn --output hub/grasps.safetensors --model-card");
    let page = fs::read_to_string(folder.path("hub/README.md")).unwrap();
    let (head, body) = page.strip_prefix("---\n").unwrap().split_once("\n---\n").unwrap();
    assert!(head.starts_with("library_name: taxel\n") && head.contains("type: accuracy"), "{head}");
    assert!(
        head.lines().all(|line| !line.contains('\t') && (line.contains(':') || line.starts_with("- "))),
        "{head}"
    );
    assert!(
        body.contains("taxel predict grasps.safetensors") && body.contains("simulated recordings only"),
        "{body}"
    );
    assert_eq!(folder.says("inspect hub/grasps.safetensors --model-card"), page);
    // It writes over its own page, and over nobody else's.
    folder.says("fit run --network k-nn --output hub/grasps.safetensors --model-card");
    fs::write(folder.path("hub/README.md"), "# mine\n").unwrap();
    folder.refuses(
        "fit run --network k-nn --output hub/grasps.safetensors --model-card",
        "is no model card of taxel",
    );
    assert_eq!(fs::read_to_string(folder.path("hub/README.md")).unwrap(), "# mine\n");
}

fn is_file(path: &Path) -> bool {
    path.is_file()
}

/// Checks that a training of a learning curve is not tested on a test sample of the fold that it belongs to.
fn no_test_sample_is_used(folder: &Folder) {
    let rows = |record: &Value| -> Vec<u64> {
        record["index"].as_array().unwrap().iter().map(|row| row.as_u64().unwrap()).collect()
    };
    let mut seen = 0;
    for entry in fs::read_dir(folder.path("run/learning-curve")).unwrap() {
        let record: Value = serde_json::from_slice(&fs::read(entry.unwrap().path()).unwrap()).unwrap();
        let record = &record["value"];
        let fold = record["fold"].as_u64().unwrap() % 1000;
        let mut own = fs::read_dir(folder.path("run/folds")).unwrap().map(|entry| entry.unwrap().path());
        let end = format!(".r0.f{fold}.json");
        let outer = own.find(|path| path.to_string_lossy().ends_with(&end)).unwrap();
        let outer = rows(&serde_json::from_slice(&fs::read(outer).unwrap()).unwrap());
        assert!(!outer.is_empty() && rows(record).iter().all(|row| !outer.contains(row)), "{record}");
        seen += 1;
    }
    assert_eq!(seen, 24);
}

#[test]
fn a_report_says_what_more_recordings_bring() {
    let folder = Folder::new();
    let plan = folder.json("run grasps.toml --plan --format json");
    // Four rows of three folds; of the curve two inner folds of each, at four sizes.
    assert_eq!(
        (&plan["trainings"], &plan["learning_curve"]["trainings"]),
        (&12.into(), &24.into()),
        "{plan}"
    );
    assert!(plan["rows"].as_array().unwrap().iter().all(|row| number(&row["seconds"]) > 0.0), "{plan}");
    assert!(!folder.path("runs").exists(), "a plan writes nothing");
    let few = folder.json(r#"run grasps.toml --plan --format json --set protocol={kind="few-samples"}"#);
    assert!(few["learning_curve"]["refused"].as_str().unwrap().contains("a learning curve itself"), "{few}");
    folder.refuses("run grasps.toml --plan --resume", "cannot be used with");
    folder.says("run grasps.toml --output run");
    let report = folder.json("report run --no-stress --learning-curve --format json");
    let curve = &report["learning_curve"];
    let points = curve["points"].as_array().unwrap();
    assert_eq!(points.len(), 4, "{report}");
    let counts: Vec<f64> = points.iter().map(|point| number(&point["count"])).collect();
    assert!(
        counts.windows(2).all(|pair| pair[0] < pair[1])
            && points.iter().all(|point| point["scores"].as_array().unwrap().len() == 6)
    );
    assert_eq!(curve["whole"]["scores"].as_array().unwrap().len(), 3, "the run's own folds: {curve}");
    no_test_sample_is_used(&folder);
    let page = fs::read_to_string(folder.path("run/report.html")).unwrap();
    assert!(page.contains("More recordings") && is_file(&folder.path("run/charts/learning-curve.svg")));
    // What was trained is kept, with the same bytes.
    let again = folder.json("report run --no-stress --learning-curve --again --format json");
    assert_eq!(again["learning_curve"], *curve);
    // Without the flag the curve that is there stays on the page.
    let plain = folder.json("report run --no-stress --format json");
    assert_eq!(plain["learning_curve"], *curve);
}

/// Forty recordings of three channels, of which `b` tells the class in its second half and nothing else does.
fn table() -> String {
    let mut text = String::from("recording,label,a,b,c\n");
    let mut state = 1u32;
    let mut noise = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 16) / 65536.0
    };
    for recording in 0..40 {
        let class = recording % 2;
        for step in 0..20 {
            let told = if class == 1 && step >= 10 { 6.0 } else { 0.0 };
            let b = told + noise();
            text +=
                &format!("r{recording},{},{:.3},{b:.3},{:.3}\n", ["soft", "hard"][class], noise(), noise());
        }
    }
    text
}

#[test]
fn what_mattered_is_found_where_it_is() {
    let folder = Folder::new();
    fs::write(folder.path("presses.csv"), table()).unwrap();
    let config = "name = \"presses\"\nnetworks = []\nbaselines = [\"mini-rocket\", \"svm-linear\", \"majority\"]\n\
                  [data]\npath = \"presses.csv\"\ny = \"label\"\n[protocol]\nfolds = 2\n";
    fs::write(folder.path("presses.toml"), config).unwrap();
    folder.says("run presses.toml --output run");
    folder.says("report run --no-stress");
    let text = fs::read_to_string(folder.path("run/judgement.json")).unwrap();
    let judgement: Value = serde_json::from_str(&text).unwrap();
    let found = &judgement["importance"];
    assert_eq!(found["rows"], serde_json::json!(["a", "b", "c"]), "{found}");
    let by_row: Vec<f64> = found["by_row"].as_array().unwrap().iter().map(number).collect();
    assert!(by_row[1] > 10.0 && by_row[1] > 4.0 * by_row[0].max(by_row[2]), "{by_row:?}");
    let by_column: Vec<f64> = found["by_column"].as_array().unwrap().iter().map(number).collect();
    let halves = [&by_column[..5], &by_column[5..]].map(|half| half.iter().sum::<f64>());
    assert!(halves[1] > 2.0 * halves[0].max(0.0), "{by_column:?}");
    assert_eq!(found["classes"].as_array().unwrap().len(), 2);
    let page = fs::read_to_string(folder.path("run/report.html")).unwrap();
    assert!(page.contains("What mattered") && is_file(&folder.path("run/charts/importance.svg")));

    folder.says("fit run --network svm-linear --output model.safetensors");
    fs::write(
        folder.path("one.csv"),
        table()
            .lines()
            .filter(|line| line.starts_with("r1,") || line.starts_with("rec"))
            .collect::<Vec<_>>()
            .join("\n"),
    )
    .unwrap();
    let explained = folder.json("predict model.safetensors one.csv --explain --format json");
    let parts = explained["answers"][0]["rests_on"].as_array().unwrap();
    assert_eq!(parts[0]["without"], "b", "{explained}");
    assert!(number(&parts[0]["change"][0]) < 0.0, "{explained}");
    let text = folder.says("predict model.safetensors one.csv --explain");
    assert!(text.contains("without b: -"), "{text}");
    folder.refuses("predict model.safetensors one.csv --explain --format csv", "--explain");
}
