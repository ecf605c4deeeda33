//! Targets that are values: read, saved, split.

#![allow(clippy::unwrap_used)]

mod common;

use common::{f32s, files, i64s, npz, refused, samples};
use ndarray::ArrayD;
use std::path::Path;
use taxel_data::{
    Dataset, Drop, Layout, Npz, Quantity, ReadOptions, TargetNames, TargetOf, Targets, Task, TaskKind,
    Values, check, check_with, load,
};
use tempfile::tempdir;

/// Presses of so many newtons.
fn presses(forces: &[f32]) -> Dataset {
    let x = ArrayD::from_shape_fn(vec![forces.len(), 1, 3], |at| forces[at[0]] * (at[2] + 1) as f32);
    let dataset = Dataset::new("skin", Layout::Series, x, &vec![0; forces.len()]).unwrap();
    let force = Quantity { name: "force".into(), unit: Some("N".into()) };
    dataset.with_values(vec![force], forces.to_vec()).unwrap()
}

#[test]
fn values_are_saved_and_read_back_with_name_and_unit() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let saved = presses(&[0.5, 1.25, 2.0, 7.5]);
    saved.save(&path).unwrap();
    let read = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!((&read.targets, &read.x, &read.digest), (&saved.targets, &saved.x, &saved.digest));
    assert_eq!(read.output_names(), ["force"]);
    let card = check(&path).unwrap();
    assert!(card.problems.is_empty(), "{:?}", card.problems);
    assert_eq!(card.labels.as_deref(), Some("values: force 0.5 to 7.5 N"));
}

#[test]
fn named_quantities_are_values_whatever_they_hold() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let mut saved = presses(&[1.0, 2.0, 3.0]);
    let fingers = ["left", "right"].map(|name| Quantity { name: name.into(), unit: Some("N".into()) });
    saved.targets = Targets::Values(Values::new(fingers.to_vec(), vec![0.0, 1.0, 1.0, 0.0, 0.0, 1.0]));
    saved.save(&path).unwrap();
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().targets, saved.targets);
}

#[test]
fn arrays_beside_the_labels_are_values_where_the_file_of_names_says_so() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let mut npz = Npz::default();
    npz.add("x", &[4, 3], &[1.0f32, 2.0, 3.0, 4.0].repeat(3)).unwrap();
    npz.add("y", &[4], &[0i64, 1, 0, 1]).unwrap();
    npz.add("shore", &[4], &[0.0f32, 10.0, 0.0, 10.0]).unwrap();
    npz.add("depth", &[4], &[0.5f32, 1.0, 1.5, 2.0]).unwrap();
    std::fs::write(&path, npz.finish().unwrap()).unwrap();
    let values = r#""values": { "shore": { "name": "hardness", "unit": "Shore A" } }"#;
    let names = format!(r#"{{ "classes": ["soft", "hard"], {values} }}"#);
    files(folder.path(), &[("skin.classes.json", &names)]);
    let of = |y: &str| ReadOptions { y: Some(y.into()), ..ReadOptions::default() };
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().output_names(), ["soft", "hard"]);
    let hardness = Quantity { name: "hardness".into(), unit: Some("Shore A".into()) };
    assert_eq!(load(&path, &of("shore")).unwrap().task(), Task::Values(vec![hardness]));
    let error = refused(&path, &of("depth"));
    assert!(error.contains("say task = \"values\" (--task values) if it is measured"), "{error}");
    files(folder.path(), &[("skin.classes.json", r#"{ "values": ["shore"] }"#)]);
    let error = refused(&path, &of("shore"));
    assert!(error.contains("values") && error.contains("not an object such as"), "{error}");
}

#[test]
fn values_in_memory_are_one_of_each_quantity_per_sample() {
    let refuse = |names: &[&str], values: &[f32]| {
        let quantities = names.iter().map(|name| Quantity { name: (*name).into(), unit: None }).collect();
        presses(&[1.0, 2.0]).with_values(quantities, values.to_vec()).unwrap_err().to_string()
    };
    assert_eq!(refuse(&["a"], &[1.0]), "skin: values has 1 entries but x has 2 samples; one per sample");
    assert_eq!(refuse(&["a", "b"], &[1.0, 2.0, 3.0]), "skin: 3 values are no rows of 2 quantities");
    assert_eq!(refuse(&[], &[]), "skin: 0 values are no rows of 0 quantities");
    assert!(refuse(&["a", "a "], &[1.0; 4]).contains("the quantity names"));
    let error = refuse(&["a", "b"], &[1.0, 2.0, 3.0, f32::NAN]);
    assert!(error.starts_with("skin: y[1]: value at [1] is NaN"), "{error}");
}

#[test]
fn floats_are_values_and_never_classes() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let write = |y: &[f32], shape: &[usize]| {
        let mut npz = Npz::default();
        npz.add("x", &[4, 3], &[1.0f32; 12]).unwrap();
        npz.add("y", shape, y).unwrap();
        std::fs::write(&path, npz.finish().unwrap()).unwrap();
        load(&path, &ReadOptions::default())
    };
    let whole = write(&[0.0, 1.0, 2.0, 3.0], &[4]).unwrap();
    assert_eq!(whole.task(), Task::Values(vec![Quantity { name: "y".into(), unit: None }]));
    let two = write(&[0.0; 8], &[4, 2]).unwrap();
    assert_eq!(two.output_names(), ["y-0", "y-1"]);
    let equal = write(&[1.0; 4], &[4]).unwrap();
    assert_eq!(equal.output_names(), ["y"], "a column of ones is no one-hot class");
    let error = write(&[0.0, 1.0, f32::NAN, 3.0], &[4]).unwrap_err().to_string();
    assert!(error.contains("skin.npz: y[2]") && error.contains("NaN"), "{error}");
    let mut rows = [0.5; 8];
    rows[5] = f32::NAN;
    let error = write(&rows, &[4, 2]).unwrap_err().to_string();
    assert!(error.contains("skin.npz: y[2] is NaN in y-1"), "{error}");
    for (count, said) in [(3, '3'), (5, '5')] {
        let error = write(&vec![0.5; count], &[count]).unwrap_err().to_string();
        assert!(error.contains(said) && error.contains('4'), "{error}");
    }
}

/// Options that name the targets.
fn named(y: &str) -> ReadOptions {
    ReadOptions { y: Some(y.into()), ..ReadOptions::default() }
}

fn as_values(options: ReadOptions) -> ReadOptions {
    ReadOptions { task: Some(TaskKind::Values), ..options }
}

/// The quantities of a data set with their units, and its values.
fn read(path: &Path, options: &ReadOptions) -> (Vec<String>, Vec<f32>) {
    let data = load(path, options).unwrap();
    let unit =
        |quantity: &Quantity| quantity.unit.as_ref().map_or(String::new(), |unit| format!(" [{unit}]"));
    let quantities = data.task().quantities().to_vec();
    let names = quantities.iter().map(|quantity| format!("{}{}", quantity.name, unit(quantity))).collect();
    (names, data.targets.values().unwrap().values().to_vec())
}

#[test]
fn several_arrays_are_quantities_side_by_side() {
    let folder = tempdir().unwrap();
    let arrays = [
        ("x", samples(3)),
        ("force_N", f32s(&[3], &[0.5, 1.5, 2.5])),
        ("place_mm", f32s(&[3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
        ("count", i64s(&[3], &[7, 8, 9])),
        ("short", f32s(&[2], &[1.0, 2.0])),
        ("kind", i64s(&[3], &[0, 1, 0])),
    ];
    let path = npz(folder.path(), &arrays);
    let (names, values) = read(&path, &named("force_N, place_mm,count"));
    assert_eq!(names, ["force [N]", "place-0 [mm]", "place-1 [mm]", "count"]);
    assert_eq!(values, [0.5, 1.0, 2.0, 7.0, 1.5, 3.0, 4.0, 8.0, 2.5, 5.0, 6.0, 9.0]);
    // Saved and read again.
    let copy = folder.path().join("copy.npz");
    load(&path, &named("force_N,place_mm")).unwrap().save(&copy).unwrap();
    let (again, _) = read(&copy, &ReadOptions::default());
    assert_eq!(again, ["force [N]", "place-0 [mm]", "place-1 [mm]"]);
    for (options, why) in [
        (named("force_N,depth"), "no array depth: it holds"),
        (named("force_N,force_N"), "y: names one array or column twice"),
        (named("force_N,,kind"), "y: names nothing between two commas"),
        (named("force_N,short"), "force_N has 3 rows of targets and short has 2"),
        (
            named("kind,count"),
            "kind and count hold whole numbers or texts, which are classes; say task = \"values\"",
        ),
    ] {
        let message = refused(&path, &options);
        assert!(message.contains(why), "{message}");
    }
}

#[test]
fn names_of_targets_are_read_as_text_and_as_a_list() {
    let read = |text: &str| serde_json::from_str::<ReadOptions>(text).unwrap().y.unwrap();
    assert_eq!(read(r#"{"y": "force_N, depth_mm"}"#), read(r#"{"y": ["force_N", "depth_mm"]}"#));
    let written = |names: TargetNames| serde_json::to_string(&named("").y.map(|_| names)).unwrap();
    assert_eq!(written("force".into()), r#""force""#);
    assert_eq!(written("force_N,depth_mm".into()), r#"["force_N","depth_mm"]"#);
    assert_eq!(written(vec!["a,b".to_string()].into()), r#"["a,b"]"#);
}

#[test]
fn several_columns_of_tables_are_quantities() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    let table = "a,b,force [N],depth (mm),kind\n1,2,0.5,1,up\n3,4,1.5,2,down\n5,6,2.5,3,up\n";
    files(root, &[("t.csv", table), ("f/labels.csv", "file,force_N,depth_mm\na.csv,0.5,1\nb.csv,1.5,2\n")]);
    files(root, &[("f/a.csv", "1,2\n3,4\n"), ("f/b.csv", "1,2\n3,5\n")]);
    let (names, values) = read(&root.join("t.csv"), &named("force [N],depth (mm)"));
    assert_eq!(
        (names, values),
        (vec!["force [N]".into(), "depth [mm]".into()], vec![0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
    );
    let (names, values) = read(&root.join("f"), &named("force_N,depth_mm"));
    assert_eq!((names, values), (vec!["force [N]".into(), "depth [mm]".into()], vec![0.5, 1.0, 1.5, 2.0]));
    let message = refused(&root.join("t.csv"), &named("force [N],kind"));
    assert!(
        message.contains("line 2: \"kind\" is \"up\", which is no number, and \"force [N]\" are values"),
        "{message}"
    );
    // A comma as decimal point is none of a name.
    files(root, &[("german.csv", "a;b;force_N\n1,5;2;0,5\n3;4;1,25\n5;6;2\n")]);
    assert_eq!(read(&root.join("german.csv"), &named("force_N")).1, [0.5, 1.25, 2.0]);
}

#[test]
fn whole_numbers_are_classes_unless_the_task_says_values() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    let path = npz(root, &[("x", samples(3)), ("y", i64s(&[3], &[2, 0, 1]))]);
    assert!(matches!(load(&path, &ReadOptions::default()).unwrap().task(), Task::Classes(_)));
    let options = as_values(ReadOptions::default());
    assert_eq!(read(&path, &options), (vec!["y".into()], vec![2.0, 0.0, 1.0]));
    files(root, &[("t.csv", "a,level\n1,2\n2,0\n3,1\n"), ("w.csv", "a,level\n1,soft\n2,hard\n3,soft\n")]);
    assert_eq!(read(&root.join("t.csv"), &as_values(named("level"))).1, [2.0, 0.0, 1.0]);
    let message = refused(&root.join("w.csv"), &as_values(named("level")));
    assert!(
        message.contains("line 2: \"level\" is \"soft\", which is no number, and task = \"values\""),
        "{message}"
    );
    // Folders that are called by numbers.
    files(root, &[("f/1/a.csv", "1,2\n3,4\n"), ("f/2.5/b.csv", "1,2\n3,5\n")]);
    assert_eq!(read(&root.join("f"), &options).1, [1.0, 2.5]);
    files(root, &[("g/soft/a.csv", "1,2\n3,4\n"), ("g/2.5/b.csv", "1,2\n3,5\n")]);
    let message = refused(&root.join("g"), &options);
    assert!(message.contains("\"soft\", which is no number"), "{message}");
}

#[test]
fn fractions_are_no_classes() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    let path = npz(root, &[("x", samples(3)), ("y", f32s(&[3], &[0.0, 1.5, 0.0]))]);
    let options = ReadOptions { task: Some(TaskKind::Classes), ..ReadOptions::default() };
    let message = refused(&path, &options);
    assert!(message.contains("y: holds floats, which are values, and task = \"classes\""), "{message}");
    files(root, &[("t.csv", "a,label\n1,0.5\n2,1\n3,1\n")]);
    let message = refused(&root.join("t.csv"), &options);
    assert!(message.contains("\"label\" has numbers with fractions, such as 0.5"), "{message}");
    let both = as_values(ReadOptions { attribute: Some(0), ..ReadOptions::default() });
    let message = refused(&path, &both);
    assert!(message.contains("attribute: speaks of classes, and task = \"values\""), "{message}");
}

#[test]
fn whole_floats_are_classes_where_the_task_says_so() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    let options = ReadOptions { task: Some(TaskKind::Classes), ..ReadOptions::default() };
    let path = npz(root, &[("x", samples(4)), ("y", f32s(&[4], &[2.0, 0.0, 1.0, 0.0]))]);
    assert!(matches!(load(&path, &ReadOptions::default()).unwrap().task(), Task::Values(_)));
    let data = load(&path, &options).unwrap();
    assert_eq!(data.output_names(), ["0", "1", "2"]);
    assert_eq!(data.labels().unwrap().values(), [2, 0, 1, 0]);
    let negative = npz(root, &[("x", samples(4)), ("y", f32s(&[4], &[-1.0, 0.0, 1.0, 0.0]))]);
    assert!(refused(&negative, &options).contains("is negative"), "as whole numbers are");
    files(
        root,
        &[("t.csv", "a,label\n1,0.0\n2,1.0\n3,2.0\n"), ("t.classes.json", r#"["soft", "mid", "hard"]"#)],
    );
    assert_eq!(load(&root.join("t.csv"), &options).unwrap().output_names(), ["soft", "mid", "hard"]);
    // One of the labels of each time step.
    let steps =
        ReadOptions { target: Some(TargetOf::Step), length: Some("window:2,1".parse().unwrap()), ..options };
    let path = npz(root, &[("x", samples(2)), ("y", f32s(&[2, 3], &[0.0, 1.0, 1.0, 0.0, 0.0, 1.0]))]);
    assert_eq!(load(&path, &steps).unwrap().labels().unwrap().values(), [1, 1, 0, 1]);
}

#[test]
fn many_whole_numbers_may_be_values_the_card_says() {
    let folder = tempdir().unwrap();
    let warned = |labels: Vec<i64>| {
        let count = labels.len() as u64;
        let path = npz(folder.path(), &[("x", samples(count)), ("y", i64s(&[count], &labels))]);
        check(&path).unwrap().warnings.join("\n")
    };
    let text = warned((0..20).map(|i| i / 2).collect());
    assert!(
        text.contains("10 classes of 20 samples are whole numbers") && text.contains("--task values"),
        "{text}"
    );
    assert!(!warned((0..20).map(|i| i % 2).collect()).contains("--task"));
    assert!(warned((0..300).map(|i| i % 60).collect()).contains("60 classes of 300 samples"));
}

#[test]
fn samples_without_a_target_are_refused_or_left_out() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    let nan = f32::NAN;
    let arrays = [("x", samples(4)), ("y", f32s(&[4, 2], &[0.5, 1.0, nan, 2.0, 2.5, nan, 3.5, 4.0]))];
    let path = npz(root, &arrays);
    let message = refused(&path, &ReadOptions::default());
    assert!(message.contains("y[1] is NaN in y-0: 2 of 4 samples have no target: x[1], x[2];"), "{message}");
    assert!(message.contains("drop = [\"no-target\"]"), "{message}");
    let options = ReadOptions { drop: vec![Drop::NoTarget], ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    assert_eq!((data.len(), data.dropped.as_slice()), (2, &["x[1]".to_string(), "x[2]".into()][..]));
    let card = check_with(&path, &options).unwrap();
    assert!(
        card.without_target == 2 && card.to_string().contains("no target   2 samples left out"),
        "{card}"
    );
    files(root, &[("t.csv", "a,label\n1,0.5\n2,\n3,1\n")]);
    let message = refused(&root.join("t.csv"), &ReadOptions::default());
    assert!(message.contains("1 of 3 samples have no target: line 3;"), "{message}");
    assert_eq!(read(&root.join("t.csv"), &options).1, [0.5, 1.0]);
    let all = npz(root, &[("x", samples(2)), ("y", f32s(&[2], &[nan, nan]))]);
    assert!(refused(&all, &options).contains("holds no samples"));
}

#[test]
fn quantities_take_the_names_that_are_said() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(2)), ("y", f32s(&[2, 2], &[0.5, 1.0, 1.5, 2.0]))]);
    let named = |names: &str| ReadOptions { quantities: Some(names.into()), ..ReadOptions::default() };
    let (quantities, values) = read(&path, &named("x_mm,force_N"));
    assert_eq!((quantities, values), (vec!["x [mm]".into(), "force [N]".into()], vec![0.5, 1.0, 1.5, 2.0]));
    let message = refused(&path, &named("force_N"));
    assert!(message.contains("are 1 names for 2 columns of y"), "{message}");
    let path = npz(folder.path(), &[("x", samples(2)), ("y", i64s(&[2], &[0, 1]))]);
    let message = refused(&path, &named("force_N"));
    assert!(message.contains("name values, and the targets are classes"), "{message}");
}
