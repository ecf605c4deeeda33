//! Run folders that were damaged by hand are refused, or do no harm: never a panic, never a silent number.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use ndarray::ArrayD;
use serde_json::{Value, json};
use taxel_baselines::Method;
use taxel_data::{Dataset, Layout};
use taxel_faults::Fault;
use taxel_judge::{
    Case, Choice, Criteria, JudgeOptions, Judgement, StressOptions, choose, judge, report, stress,
};
use taxel_learn::{Candidate, CrossValidation, Encoding, Protocol, Recipe, RunFolder, RunOptions, Silent};

/// 24 presses of two classes, ten readings each.
fn presses() -> Dataset {
    let x = ArrayD::from_shape_fn(vec![24, 1, 10], |at| {
        (at[0] % 2) as f32 * 0.3 + 0.1 * ((at[0] * 7 + at[2] * 13) % 11) as f32
    });
    let labels: Vec<&str> = (0..24).map(|i| ["soft", "hard"][i % 2]).collect();
    Dataset::new("presses", Layout::Series, x, &labels).unwrap().with_full_scale(2.0).unwrap()
}

fn mlp(encoder: &mut taxel_learn::Encoder, name: &str, optimizer: Value) -> Candidate {
    let entry = taxel_zoo::find("mlp").unwrap();
    encoder.prepare(&["signal"]).unwrap();
    let mut settings = entry.fit(2, |input| encoder.shape(input)).unwrap();
    settings.insert("hidden".into(), json!(4));
    let recipe: Recipe =
        serde_json::from_value(json!({ "epochs": 2, "batch_size": 4, "optimizer": optimizer })).unwrap();
    let graph = entry.graph(&settings).unwrap();
    Candidate { name: name.into(), ..Candidate::network(graph, recipe) }
}

/// An MLP and k-NN on two folds, and with `wild` an MLP that diverges.
fn run(out: &Path, wild: bool) {
    run_or_resume(out, wild, false).unwrap();
}

fn run_or_resume(out: &Path, wild: bool, resume: bool) -> Result<RunFolder, taxel_learn::Error> {
    let dataset = presses();
    let mut cv = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).encoding(Encoding::default());
    let candidate = mlp(cv.encoder(), "mlp", json!({ "name": "adam", "lr": 1e-2 }));
    cv = cv.candidate(candidate).candidate(Candidate::baseline(Method::NearestNeighbours { k: 1 }));
    if wild {
        let candidate = mlp(cv.encoder(), "wild", json!({ "name": "sgdm", "lr": 300.0 }));
        cv = cv.candidate(candidate);
    }
    let options = RunOptions { threads: Some(1), resume, ..RunOptions::default() };
    cv.run_in(out, &options, &Silent, &AtomicBool::new(false))
}

fn open(out: &Path) -> Result<Case, taxel_judge::Error> {
    Case::new(RunFolder::open(out)?, presses())
}

fn one_fault() -> StressOptions {
    StressOptions { faults: vec![Fault::Gain], severity: Some(3), threads: 1, ..StressOptions::default() }
}

fn judged(case: &Case) -> Result<Judgement, taxel_judge::Error> {
    judge(case, &JudgeOptions { stress: Some(one_fault()), budget: 1e-4, ..JudgeOptions::default() })
}

/// Runs `choose` and `report`; drawing is left out where `draw` is false.
fn all(out: &Path, draw: bool) -> Result<Choice, taxel_judge::Error> {
    let case = open(out)?;
    let judgement = match Judgement::read(&case)? {
        Some(judgement) => judgement,
        None => judged(&case)?,
    };
    let choice = choose(&case, &judgement, &Criteria::default())?;
    if draw {
        report(&judgement, Some(&choice))?;
    }
    Ok(choice)
}

#[test]
fn a_model_of_another_fold_or_run_is_not_scored() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    run(&out, false);
    let model = out.join("models/mlp.r0.f0.safetensors");
    fs::copy(out.join("models/mlp.r0.f1.safetensors"), &model).unwrap();
    let case = open(&out).unwrap();
    for error in [
        stress(&case, &one_fault(), &|_| {}, &|| {}).expect_err("stress refuses it").to_string(),
        judged(&case).expect_err("judge refuses it").to_string(),
    ] {
        assert!(error.starts_with(&model.display().to_string()), "{error}");
        assert!(error.contains("is mlp of repetition 0, fold 1"), "{error}");
    }
}

#[test]
fn a_diverged_network_is_never_chosen() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    run(&out, true);
    let case = open(&out).unwrap();
    let judgement = judged(&case).unwrap();
    // Were it not diverged, this one would be chosen: the most accurate and the smallest.
    let choice = choose(&case, &judgement, &Criteria::default()).unwrap();
    let wild = choice.evidence.iter().find(|evidence| evidence.network == "wild").unwrap();
    assert_eq!(wild.refused.as_deref(), Some("diverged in training (2 of 2 folds)"));
    assert!(choice.chosen.as_deref() != Some("wild") && choice.best != "wild", "{choice:?}");
    let made = report(&judgement, Some(&choice)).unwrap();
    assert_eq!(made.summary.json[2]["role"], json!("diverged"));
    let page = made.files().iter().find(|(name, _)| name == "report.html").unwrap();
    let text = String::from_utf8_lossy(&page.1).into_owned();
    assert!(text.contains("Diverged: wild in 2 of 2 folds"), "the page says it at its top");
}

/// Every place of a JSON text at which something can be changed.
fn places(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_string());
    let step = |key: &str| format!("{at}/{}", key.replace('~', "~0").replace('/', "~1"));
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| places(value, &step(key), found)),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| places(item, &step(&i.to_string()), found));
        }
        _ => {}
    }
}

/// Values that damage may put in the place of another.
fn mutations(value: &Value) -> Vec<Value> {
    match value {
        Value::Number(number) => {
            let mut others = vec![json!(0), json!(7), json!(u64::MAX), json!(-1), json!(1e300)];
            others.extend(number.as_f64().map(|v| json!(v + 0.5)));
            others
        }
        Value::String(_) => vec![json!(""), json!("no-such-thing")],
        Value::Bool(flag) => vec![json!(!flag)],
        Value::Array(items) => {
            let mut others = vec![json!([])];
            if let Some((last, rest)) = items.split_last() {
                others.push(json!(rest));
                others.push(json!([items.as_slice(), std::slice::from_ref(last)].concat()));
            }
            others
        }
        Value::Object(map) => map
            .keys()
            .map(|key| {
                let mut less = map.clone();
                less.shift_remove(key);
                Value::Object(less)
            })
            .collect(),
        Value::Null => vec![json!(1), json!([])],
    }
}

/// The JSON files of a run folder.
fn files(out: &Path) -> Vec<PathBuf> {
    let of = |folder: PathBuf| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<PathBuf> = of(out.into()).chain(of(out.join("folds"))).collect();
    all.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    all.sort();
    // Folds are alike: one of each network is enough.
    all.retain(|path| !path.to_string_lossy().contains(".r0.f1"));
    all
}

#[test]
fn whatever_number_list_or_key_is_damaged_nothing_panics() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    run(&out, false);
    judged(&open(&out).unwrap()).unwrap().write(&RunFolder::open(&out).unwrap()).unwrap();
    assert!(all(&out, true).is_ok());
    let kept = fs::read(out.join("judgement.json")).unwrap();
    let results = fs::read(out.join("results.json")).unwrap();
    std::panic::set_hook(Box::new(|_| {}));
    let (mut refused, mut stood, mut drawn, mut wrong) = (0, 0, 0, vec![]);
    for path in files(&out) {
        let name = path.file_name().unwrap().to_str().unwrap().to_string();
        let is_judgement = name == "judgement.json";
        // Records and times are read where nothing is measured yet.
        if !is_judgement {
            let _ = fs::remove_file(out.join("judgement.json"));
        } else {
            fs::write(&path, &kept).unwrap();
        }
        let text = fs::read(&path).unwrap();
        let whole: Value = serde_json::from_slice(&text).unwrap();
        let mut at = vec![];
        places(&whole, "", &mut at);
        // Every list and object; of the values in them some, and of a judgement, which is under a digest, few.
        let every = if is_judgement { 97 } else { 9 };
        for (number, place) in at.iter().enumerate() {
            let value = whole.pointer(place).unwrap();
            if number % every > 0 && (is_judgement || !(value.is_array() || value.is_object())) {
                continue;
            }
            for other in mutations(value) {
                let mut damaged = whole.clone();
                *damaged.pointer_mut(place).unwrap() = other.clone();
                if damaged == whole {
                    continue;
                }
                fs::write(&path, damaged.to_string()).unwrap();
                // What opens without complaint is drawn from time to time: it takes long.
                match catch_unwind(AssertUnwindSafe(|| all(&out, false))) {
                    Ok(Ok(_)) => {
                        stood += 1;
                        if stood % 32 == 1 {
                            drawn += 1;
                            if catch_unwind(AssertUnwindSafe(|| all(&out, true).map(|_| ()))).is_err() {
                                wrong.push(format!("{name}{place} = {other} panics where it is drawn"));
                            }
                        }
                    }
                    Ok(Err(error)) => {
                        refused += 1;
                        let error = error.to_string();
                        if !error.contains(".json") {
                            wrong.push(format!("{name}{place} = {other}: no file in: {error}"));
                        }
                    }
                    Err(_) => wrong.push(format!("{name}{place} = {other} panics")),
                }
                if !is_judgement {
                    match catch_unwind(AssertUnwindSafe(|| run_or_resume(&out, false, true).map(|_| ()))) {
                        Ok(Err(error)) => {
                            let error = error.to_string();
                            if !error.contains(".json") && !error.contains("was run with other settings") {
                                wrong.push(format!("{name}{place} = {other}, resumed: no file in: {error}"));
                            }
                        }
                        Ok(Ok(())) => {}
                        Err(_) => wrong.push(format!("{name}{place} = {other} panics where it is resumed")),
                    }
                    fs::write(out.join("results.json"), &results).unwrap();
                }
            }
        }
        fs::write(&path, &text).unwrap();
    }
    let _ = std::panic::take_hook();
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(refused > 200 && drawn > 2, "{refused} refused, {stood} stood, {drawn} drawn");
}
