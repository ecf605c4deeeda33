//! The same samples in other words: a model gives the same answers, bit for bit, or refuses.
//!
//! Each set is written in every form that holds it, and in each with columns, files, rows, keys and classes in another order
//! or under other names; then it is converted. One model of it, fitted once, predicts them all.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "sets/mod.rs"]
mod sets;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rand::RngExt;
use serde_json::Value;
use taxel::Layout;
use taxel_base::seed;
use tempfile::TempDir;

use sets::files::{By, Form, Style};
use sets::{Cell, Extra, Set};

/// Samples of a set.
const SAMPLES: usize = 18;
/// Threads that take cases.
const THREADS: usize = 2;

/// The exit code of a refusal.
const REFUSED: i32 = 2;

/// Runs the program. Returns what it printed, or its message with the exit code of a refusal.
fn taxel(arguments: &[String]) -> Result<String, String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).env("TAXEL_THREADS", "1").env_remove("RUST_BACKTRACE").stdin(Stdio::null());
    let output = command.output().unwrap();
    let [out, error] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    match output.status.code() {
        Some(0) => Ok(out),
        Some(REFUSED) => Err(error),
        other => panic!("{arguments:?}: exit code {other:?}: {error}"),
    }
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().into()
}

/// Makes samples of which each class has a pattern of its own in each channel.
fn learnable(layout: Layout, shape: &[usize]) -> Set {
    let mut rng = seed::rng(7, layout.name());
    let y: Vec<usize> = (0..SAMPLES).map(|row| row % 3).collect();
    let size = shape.iter().product::<usize>();
    let x = y.iter().map(|class| {
        (0..size)
            .map(|at| (90 + (at * (7 + 4 * class) + 31 * class) % 97 + rng.random_range(0..40)) as f32)
            .collect()
    });
    let mut x: Vec<Vec<f32>> = x.collect();
    if matches!(layout, Layout::Series | Layout::Features) {
        // Digits after the point, for decimal commas; pixels have none.
        x.iter_mut().flatten().for_each(|value| *value += 0.5);
    }
    let mut set = Set::new(layout, shape, x, y);
    set.groups = Some((0..SAMPLES).map(|row| row / 3 % 2).collect());
    set.marks = Some((0..SAMPLES).map(|row| (row / 3 % 2) as i64).collect());
    set
}

/// A model of a set that was fitted to one form of it.
struct Fitted {
    folder: TempDir,
    set: Set,
    method: &'static str,
    /// Probabilities of each sample.
    answers: Vec<Value>,
}

impl Fitted {
    fn new(set: &Set, form: Form, method: &'static str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (path, keys) = form.write(set, &Style::of(form), &folder.path().join("set"));
        let config = folder.path().join("c.toml");
        let text_of = format!(
            "name = \"m\"\nnetworks = []\nbaselines = [\"{method}\"]\n[data]\npath = {:?}\n{keys}",
            text(&path)
        );
        fs::write(&config, text_of).unwrap();
        let model = text(&folder.path().join("m.safetensors"));
        let arguments = ["fit", &text(&config), "--network", method, "--output", &model].map(String::from);
        taxel(&arguments).unwrap_or_else(|error| panic!("{form:?}: {error}"));
        let mut fitted = Self { folder, set: set.clone(), method, answers: vec![] };
        let answers =
            fitted.predict(&path, &form.arguments(set)).unwrap_or_else(|error| panic!("{form:?}: {error}"));
        fitted.answers = vec![Value::Null; set.len()];
        for (row, answer) in form.order(set).into_iter().zip(answers) {
            fitted.answers[row] = answer;
        }
        let distinct = |at: usize| fitted.answers[..at].iter().all(|other| *other != fitted.answers[at]);
        assert!((1..set.len()).any(distinct), "one answer for all would be equal to itself");
        fitted
    }

    fn predict(&self, path: &Path, more: &[String]) -> Result<Vec<Value>, String> {
        let model = text(&self.folder.path().join("m.safetensors"));
        let arguments = ["predict".into(), model, text(path), "--format".into(), "json".into()];
        let printed = taxel(&[&arguments[..], more].concat())?;
        let all: Value = serde_json::from_str(&printed).unwrap();
        Ok(all["answers"].as_array().unwrap().iter().map(|answer| answer["probabilities"].clone()).collect())
    }
}

/// The answers that a set in other words must get.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Must {
    BeEqual,
    BeRefused,
    /// The rows of the same number have equal answers, or all are refused.
    BeEqualOrRefused,
    /// A control: what has no names is read by place, and another order is another sample.
    Differ,
}

/// A set in other words.
struct Change {
    what: &'static str,
    set: Set,
    /// The sample of the fitted set that each of its samples is.
    rows: Vec<usize>,
    style: Style,
    must: Must,
}

/// Puts the channels into another order, with their names.
fn with_channels(set: &Set, order: &[usize]) -> Set {
    let names = set.channels(channels(set));
    let mut shape = set.shape.clone();
    if set.layout != Layout::Features {
        shape[0] = order.len();
    } else {
        shape = vec![order.len()];
    }
    let steps = set.shape.iter().product::<usize>() / channels(set);
    let of = |sample: &Vec<f32>| {
        order.iter().flat_map(|at| sample[at * steps..(at + 1) * steps].to_vec()).collect()
    };
    Set {
        x: set.x.iter().map(of).collect(),
        shape,
        names: order.iter().map(|at| names[*at].clone()).collect(),
        ..set.clone()
    }
}

/// Counts what has a name of its own: channels of a series, features.
fn channels(set: &Set) -> usize {
    set.shape[0]
}

fn is_text(form: Form) -> bool {
    matches!(form, Form::Files("csv", _) | Form::Wide("csv") | Form::Long("csv"))
}

/// Checks whether the channels of a form have names.
fn has_names(form: Form) -> bool {
    match form {
        Form::Arrays(_) | Form::Halves | Form::Wide(_) | Form::Long(_) | Form::LeRobot => true,
        Form::Files(ending, _) => ["csv", "jsonl", "ndjson", "mcap"].contains(&ending),
        Form::Pair(_) | Form::Pictures(_) => false,
    }
}

/// Lists the changes of a set that a form can hold.
fn changes(set: &Set, form: Form) -> Vec<Change> {
    let rows: Vec<usize> = (0..set.len()).collect();
    let style = Style::of(form);
    let change =
        |what: &'static str, set: Set, must: Must| Change { what, set, rows: rows.clone(), style, must };
    let styled =
        |what: &'static str, style: Style, must: Must| Change { style, ..change(what, set.clone(), must) };
    let mut all = vec![change("as it is", set.clone(), Must::BeEqual)];
    let turned: Vec<usize> = (0..set.len()).map(|at| (7 * at + 5) % set.len()).collect();
    all.push(Change {
        rows: turned.clone(),
        ..change("samples in another order", set.select(&turned), Must::BeEqual)
    });
    let renamed = Set { classes: ["zinc", "ash", "moss"].map(String::from).to_vec(), ..set.clone() };
    all.push(change("classes under other names", renamed, Must::BeEqualOrRefused));
    let mut other = set.clone();
    other.classes.reverse();
    other.y.iter_mut().for_each(|class| *class = 2 - *class);
    all.push(change("classes in another order", other, Must::BeEqual));
    if !matches!(set.layout, Layout::Series | Layout::Features) {
        return all;
    }
    let count = channels(set);
    let order: Vec<usize> = (0..count).map(|at| (at + 2) % count).collect();
    let fewer: Vec<usize> = (0..count - 1).collect();
    all.push(change("a channel less", with_channels(set, &fewer), Must::BeRefused));
    if !has_names(form) {
        let place = Must::Differ;
        all.push(change("channels in another order, without names", with_channels(set, &order), place));
        return all;
    }
    all.push(change("channels in another order", with_channels(set, &order), Must::BeEqual));
    let mut renamed = set.clone();
    renamed.names = set.channels(count);
    renamed.names[0] = "elbow".into();
    all.push(change("a channel under another name", renamed, Must::BeRefused));
    let more: Vec<usize> = (0..count).chain([0]).collect();
    let mut more = with_channels(set, &more);
    more.names[count] = "elbow".into();
    all.push(change("a channel more", more, Must::BeEqualOrRefused));
    if !matches!(form, Form::Arrays(_) | Form::LeRobot) {
        let cells = |row: usize| {
            (0..set.steps()).map(|step| Cell::Count((row * set.steps() + step) as i64)).collect()
        };
        let index = Extra { name: "index".into(), cells: (0..set.len()).map(cells).collect() };
        let text = Extra {
            name: "remark".into(),
            cells: (0..set.len()).map(|_| vec![Cell::Text("dry".into()); set.steps()]).collect(),
        };
        // Bags have no rule for counters.
        let must =
            if matches!(form, Form::Files("mcap", _)) { Must::BeEqualOrRefused } else { Must::BeEqual };
        all.push(change("an index beside", Set { extras: vec![index], ..set.clone() }, must));
        all.push(change("a text beside", Set { extras: vec![text], ..set.clone() }, must));
    }
    if matches!(form, Form::Files("csv" | "jsonl" | "ndjson" | "mcap", _)) {
        let style = Style { is_turned: true, ..style };
        all.push(styled("columns or keys in another order each time", style, Must::BeEqual));
    }
    if is_text(form) {
        all.push(styled("semicolons", Style { separator: ';', ..style }, Must::BeEqual));
        all.push(styled("tabs", Style { separator: '\t', ..style }, Must::BeEqual));
        let comma = Style { separator: ';', point: ',', ..style };
        all.push(styled("decimal commas", comma, Must::BeEqual));
    }
    all
}

/// Checks the answers to one change; none where they are as they must be.
fn fault(fitted: &Fitted, form: Form, change: &Change) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = form.write(&change.set, &change.style, &folder.path().join("set"));
    let arguments = form.arguments(&change.set);
    let wanted: Vec<&Value> =
        form.order(&change.set).into_iter().map(|row| &fitted.answers[change.rows[row]]).collect();
    let judged = |answers: Result<Vec<Value>, String>| match (change.must, answers) {
        (Must::BeRefused | Must::BeEqualOrRefused, Err(_)) => None,
        (_, Err(error)) => Some(format!("refused: {error}")),
        (Must::BeRefused, Ok(_)) => Some("was answered".into()),
        (must, Ok(answers)) => {
            let is_equal = answers.iter().collect::<Vec<_>>() == wanted;
            (is_equal == (must == Must::Differ)).then(|| format!("answers are equal: {is_equal}"))
        }
    };
    let direct = judged(fitted.predict(&path, &arguments)).map(|why| format!("{}: {why}", change.what));
    direct.or_else(|| {
        let output = folder.path().join("converted.npz");
        let mut convert =
            vec!["data".into(), "convert".into(), text(&path), "--output".into(), text(&output)];
        if matches!(form, Form::Wide(_) | Form::Long(_)) && change.set.marks.is_some() {
            convert.extend(["--test", "marks"].map(String::from));
        }
        let converted = taxel(&[convert, arguments].concat());
        let why = match converted {
            Err(error) => Some(format!("cannot be converted: {error}")),
            Ok(_) => judged(fitted.predict(&output, &[])),
        };
        why.map(|why| format!("{}, converted: {why}", change.what))
    })
}

/// A model to fit, and the forms that it predicts.
struct Plan {
    set: Set,
    /// The form that it is fitted to.
    fitted: Form,
    method: &'static str,
    forms: Vec<Form>,
}

/// Lists the models.
fn plans() -> Vec<Plan> {
    let named = |mut set: Set| {
        set.names = set.channels(set.shape[0]);
        set
    };
    let files = |endings: &[&'static str], by: &[By]| -> Vec<Form> {
        endings.iter().flat_map(|ending| by.iter().map(|by| Form::Files(ending, *by))).collect()
    };
    let arrays = ["npz", "mat", "h5", "hdf5"].map(Form::Arrays).to_vec();
    let tables = ["csv", "tsv", "parquet", "pq"];
    let (wide, long) = (tables.map(Form::Wide).to_vec(), tables.map(Form::Long).to_vec());
    let sorted = [By::Class, By::Session, By::Table];
    let mut of_series = files(&["csv", "npy", "jsonl", "mcap"], &sorted);
    of_series.extend(files(&["ndjson", "mat", "h5", "hdf5"], &[By::Class]));
    of_series.extend([Form::Files("mcap", By::Name), Form::Halves, Form::Pair("ts"), Form::Pair("arff")]);
    of_series.extend(arrays.iter().chain(&long));
    let of_images = [arrays.clone(), files(&["npy", "mat", "h5", "png"], &sorted)].concat();
    let of_sequences = [arrays.clone(), files(&["npy"], &sorted), vec![Form::Pictures(By::Name)]].concat();
    let npz = Form::Arrays("npz");
    let series = named(learnable(Layout::Series, &[3, 16]));
    let features = named(learnable(Layout::Features, &[6]));
    let image = learnable(Layout::Image, &[4, 5]);
    let colour = learnable(Layout::Colour, &[3, 4, 5]);
    let sequence = learnable(Layout::Sequence, &[10, 2, 3]);
    let fingers = learnable(Layout::Fingers, &[3, 2, 12]);
    let class_csv = Form::Files("csv", By::Class);
    let of_fingers = [arrays.clone(), files(&["npy"], &sorted)].concat();
    let of_features = [wide.clone(), arrays].concat();
    let plan = |set: &Set, fitted: Form, method: &'static str, forms: &[Form]| Plan {
        set: set.clone(),
        fitted,
        method,
        forms: forms.to_vec(),
    };
    vec![
        plan(&series, npz, "mini-rocket", &of_series),
        plan(&series, class_csv, "k-nn", &of_series),
        plan(&series, Form::LeRobot, "mini-rocket", &[Form::LeRobot]),
        plan(&features, Form::Wide("csv"), "k-nn", &of_features),
        plan(&image, npz, "k-nn", &of_images),
        plan(&image, Form::Wide("parquet"), "k-nn", &wide),
        plan(&colour, npz, "k-nn", &of_images),
        plan(&sequence, npz, "k-nn", &of_sequences),
        plan(&sequence, Form::Long("csv"), "k-nn", &long),
        plan(&fingers, npz, "k-nn", &of_fingers),
    ]
}

#[test]
fn the_same_samples_in_other_words_have_the_same_answers() {
    let plans = plans();
    let fitted: Vec<Fitted> =
        plans.iter().map(|plan| Fitted::new(&plan.set, plan.fitted, plan.method)).collect();
    let forms = fitted
        .iter()
        .zip(&plans)
        .flat_map(|(fitted, plan)| plan.forms.iter().map(move |form| (fitted, *form)));
    let cases: Vec<(&Fitted, Form, Change)> = forms
        .flat_map(|(fitted, form)| {
            changes(&fitted.set, form).into_iter().map(move |change| (fitted, form, change))
        })
        .collect();
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(vec![]));
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                while let Some((fitted, form, change)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Some(why) = fault(fitted, *form, change) {
                        let (method, layout) = (fitted.method, fitted.set.layout.name());
                        failed
                            .lock()
                            .unwrap()
                            .push(format!("{method} of {layout} | {} | {why}", form.name()));
                    }
                }
            });
        }
    });
    println!("{} cases", cases.len());
    let mut failed = failed.into_inner().unwrap();
    failed.sort();
    assert!(failed.is_empty(), "{} of {} cases:\n{}", failed.len(), cases.len(), failed.join("\n"));
}

/// Every line of the table of formats is in a form that is predicted.
#[test]
fn every_reader_is_asked_in_other_words() {
    let forms: Vec<Form> = plans().into_iter().flat_map(|plan| plan.forms).collect();
    for format in taxel::data::formats() {
        assert!(forms.iter().any(|form| form.formats().contains(&format.name)), "no form of {}", format.name);
    }
}
