//! Sets of LeRobot of all versions: features of two axes, names of tasks and channels, episodes that were copied.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod writers;

use std::path::Path;
use taxel_data::{ReadOptions, TableOptions, TaskKind, check, load};
use tempfile::tempdir;
use writers::{Column, episode, info, parquet, refused};

const ROWS: usize = 6;

fn state(index: i64) -> (&'static str, Column) {
    ("observation.state", Column::List((0..ROWS).map(|row| vec![row as f32, index as f32]).collect()))
}

/// A value that says row, column and time of a taxel.
fn taxel(time: usize, row: usize, column: usize) -> f32 {
    (100 * row + 10 * column + time) as f32
}

fn grid() -> Column {
    let frame = |time| (0..2).map(|row| (0..3).map(|column| taxel(time, row, column)).collect()).collect();
    Column::Grid((0..ROWS).map(frame).collect())
}

fn tasks(root: &Path) {
    let lines = "{\"task_index\": 0, \"task\": \"soft\"}\n{\"task_index\": 1, \"task\": \"hard\"}\n";
    std::fs::write(root.join("meta/tasks.jsonl"), lines).unwrap();
}

/// Four episodes of a state and a grid of taxels, in one file each.
fn set_of_grids(root: &Path, features: &str) {
    info(root, "v2.1", features);
    tasks(root);
    for index in 0..4 {
        let columns = [vec![state(index), ("observation.tactile", grid())], episode(index, index % 2, ROWS)];
        let columns: Vec<_> = columns.into_iter().flatten().collect();
        parquet(&root.join(format!("data/chunk-000/episode_{index:06}.parquet")), &columns);
    }
}

const FEATURES: &str = r#""observation.state": {"dtype": "float32", "shape": [2], "names": ["x", "y"]},
    "observation.tactile": {"dtype": "float32", "shape": [2, 3], "names": null}"#;

#[test]
fn a_feature_of_two_axes_is_as_many_channels() {
    let root = tempdir().unwrap();
    set_of_grids(root.path(), FEATURES);
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.x.shape(), [4, 8, ROWS]);
    assert_eq!(
        data.spec.channel_names,
        [
            "observation.state.x",
            "observation.state.y",
            "observation.tactile[0,0]",
            "observation.tactile[0,1]",
            "observation.tactile[0,2]",
            "observation.tactile[1,0]",
            "observation.tactile[1,1]",
            "observation.tactile[1,2]"
        ]
    );
    for (channel, (row, column)) in (0..2).flat_map(|row| (0..3).map(move |column| (row, column))).enumerate()
    {
        for time in 0..ROWS {
            assert_eq!(data.x[[1, 2 + channel, time]], taxel(time, row, column));
        }
    }
    assert_eq!(data.output_names(), ["soft", "hard"]);
    let shape = TableOptions {
        columns: (0..6).map(|i| format!("observation.tactile.{}.{}", i / 3, i % 3)).collect(),
        shape: vec![2, 3],
        ..TableOptions::default()
    };
    let images = load(root.path(), &ReadOptions { table: shape, ..ReadOptions::default() }).unwrap();
    assert_eq!(images.x.shape(), [4, ROWS, 2, 3], "the columns may be named");
}

#[test]
fn features_may_be_the_targets_of_time_steps() {
    let root = tempdir().unwrap();
    set_of_grids(root.path(), FEATURES);
    let y = ReadOptions { y: Some("observation.state".into()), ..ReadOptions::default() };
    let values = ReadOptions { task: Some(TaskKind::Values), ..y };
    let message = refused(root.path(), &values);
    assert!(message.contains("are both recording \"0\", but observation.state.0 is"), "{message}");
    assert!(message.contains("the target changes within a recording"), "{message}");
    let options = ReadOptions { length: Some("window:2,2".parse().unwrap()), ..values };
    let data = load(root.path(), &options).unwrap();
    assert_eq!(data.x.shape(), [12, 6, 2]);
    assert_eq!(data.output_names(), ["observation.state.0", "observation.state.1"]);
    assert_eq!(data.targets.values().unwrap().of(&[0, 1, 3]), [1.0, 0.0, 3.0, 0.0, 1.0, 1.0]);
}

#[test]
fn rows_of_a_grid_that_differ_in_length_are_refused_by_file_and_row() {
    let root = tempdir().unwrap();
    info(root.path(), "v2.1", FEATURES);
    let ragged =
        Column::Grid(vec![vec![vec![1.0, 2.0], vec![3.0, 4.0]], vec![vec![1.0, 2.0, 3.0], vec![4.0]]]);
    let columns = [vec![("observation.tactile", ragged)], episode(0, 0, 2)].into_iter().flatten();
    parquet(&root.path().join("data/chunk-000/episode_000000.parquet"), &columns.collect::<Vec<_>>());
    let message = refused(root.path(), &ReadOptions::default());
    assert!(
        message.starts_with("data/chunk-000/episode_000000.parquet: row 2: column \"observation.tactile\""),
        "{message}"
    );
}

#[test]
fn a_feature_of_numbers_that_is_not_read_is_an_error_and_others_are_listed() {
    let root = tempdir().unwrap();
    let more = r#", "observation.force": {"dtype": "float32", "shape": [3], "names": null},
        "observation.images.front": {"dtype": "video", "shape": [4, 4, 3], "names": null}"#;
    set_of_grids(root.path(), &format!("{FEATURES}{more}"));
    let message = refused(root.path(), &ReadOptions::default());
    assert!(message.contains("meta/info.json") && message.contains("observation.force"), "{message}");
    set_of_grids(root.path(), &format!("{FEATURES}{}", more.replace("float32", "string")));
    let card = check(root.path()).unwrap();
    let listed = card.ignored.join("; ");
    assert!(listed.contains("observation.images.front (video)"), "{listed}");
    assert!(listed.contains("observation.force (string)"), "{listed}");
}

/// A set of version 3: episodes one after the other in two files, tasks in Parquet under a column `index`.
fn third(root: &Path, index: &str, tasks: &[(i64, &str)], of_episode: impl Fn(i64) -> i64) {
    info(
        root,
        "v3.0",
        r#""observation.state": {"dtype": "float32", "shape": [2], "names": {"motors": ["elbow", "wrist"]}}"#,
    );
    let named = Column::Text(tasks.iter().map(|(_, name)| (*name).to_string()).collect());
    let numbers = Column::Int(tasks.iter().map(|(index, _)| *index).collect());
    parquet(&root.join("meta/tasks.parquet"), &[("task_index", numbers), (index, named)]);
    for file in 0..2 {
        let (mut states, mut stamps, mut frames, mut numbers, mut labels) =
            (vec![], vec![], vec![], vec![], vec![]);
        for episode in 4 * file..4 * file + 4 {
            for row in 0..ROWS {
                states.push(vec![row as f32, episode as f32]);
                stamps.push(row as f32 / 10.0);
                frames.push(row as i64);
                numbers.push(episode);
                labels.push(of_episode(episode));
            }
        }
        let columns = [
            ("observation.state", Column::List(states)),
            ("timestamp", Column::Float(stamps)),
            ("frame_index", Column::Int(frames)),
            ("episode_index", Column::Int(numbers)),
            ("task_index", Column::Int(labels)),
        ];
        parquet(&root.join(format!("data/chunk-000/file-{file:03}.parquet")), &columns);
    }
}

#[test]
fn classes_of_version_3_have_the_names_of_its_tasks() {
    for index in ["__index_level_0__", "task"] {
        let root = tempdir().unwrap();
        third(root.path(), index, &[(1, "hard block"), (0, "soft pad"), (2, "never done")], |episode| {
            episode % 2
        });
        let data = load(root.path(), &ReadOptions::default()).unwrap();
        assert_eq!(data.output_names(), ["soft pad", "hard block"], "{index}");
        assert_eq!(data.strata()[..], [0, 1, 0, 1, 0, 1, 0, 1]);
        assert_eq!(data.spec.channel_names, ["observation.state.elbow", "observation.state.wrist"]);
    }
}

#[test]
fn a_task_without_a_name_is_refused_and_a_missing_file_is_said() {
    let root = tempdir().unwrap();
    third(
        root.path(),
        "task",
        &[(0, "soft"), (1, "hard")],
        |episode| if episode == 5 { 7 } else { episode % 2 },
    );
    let message = refused(root.path(), &ReadOptions::default());
    assert!(message.contains("meta/tasks.parquet") && message.contains("task 7"), "{message}");
    third(root.path(), "task", &[(0, "soft"), (1, "soft")], |episode| episode % 2);
    let message = refused(root.path(), &ReadOptions::default());
    assert!(message.contains("two tasks are named \"soft\""), "{message}");
    std::fs::remove_file(root.path().join("meta/tasks.parquet")).unwrap();
    let card = check(root.path()).unwrap();
    assert!(card.read_as.iter().any(|line| line.contains("no meta/tasks")), "{:?}", card.read_as);
}

#[test]
fn two_episodes_of_one_index_are_said_to_be_that() {
    let root = tempdir().unwrap();
    info(root.path(), "v2.1", FEATURES);
    tasks(root.path());
    // The second continues where the first ends: by time alone they would be one.
    for (chunk, start) in [("chunk-000", 0.0), ("chunk-001", 10.0)] {
        for index in 0..2 {
            let mut columns = vec![state(index)];
            columns.extend(episode(index, index, ROWS));
            columns[1].1 = Column::Float((0..ROWS).map(|row| start + row as f32 / 10.0).collect());
            parquet(&root.path().join(format!("data/{chunk}/episode_{index:06}.parquet")), &columns);
        }
    }
    let message = refused(root.path(), &ReadOptions::default());
    assert!(message.starts_with("data/chunk-001/episode_000000.parquet: row 1: "), "{message}");
    for part in ["episode_index 0", "data/chunk-000/episode_000000.parquet", "two episodes", "renumber"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert!(!message.contains("sort"), "{message}");
}

#[test]
fn an_episode_that_begins_again_in_its_file_is_two_episodes() {
    let root = tempdir().unwrap();
    third(root.path(), "task", &[(0, "soft"), (1, "hard")], |episode| episode % 2);
    let mut columns = episode(3, 0, 2 * ROWS);
    columns[0].1 = Column::Float((0..2 * ROWS).map(|row| (row % ROWS) as f32 / 10.0).collect());
    columns.insert(0, ("observation.state", Column::List(vec![vec![1.0, 2.0]; 2 * ROWS])));
    columns.retain(|(name, _)| *name != "index");
    parquet(&root.path().join("data/chunk-000/file-000.parquet"), &columns);
    let message = refused(root.path(), &ReadOptions::default());
    assert!(
        message.starts_with(&format!("data/chunk-000/file-000.parquet: row {}: ", ROWS + 1)),
        "{message}"
    );
    assert!(
        message.contains("\"3\"") && message.contains("begins again") && !message.contains("sort"),
        "{message}"
    );
}

#[test]
fn an_episode_that_comes_again_after_others_is_two_episodes() {
    let root = tempdir().unwrap();
    third(root.path(), "task", &[(0, "soft"), (1, "hard")], |episode| episode % 2);
    let mut columns = episode(3, 0, 2 * ROWS);
    let numbers = (0..2 * ROWS).map(|row| if (ROWS / 2..ROWS).contains(&row) { 2 } else { 3 }).collect();
    columns[2].1 = Column::Int(numbers);
    columns.insert(0, ("observation.state", Column::List(vec![vec![1.0, 2.0]; 2 * ROWS])));
    columns.retain(|(name, _)| *name != "index");
    parquet(&root.path().join("data/chunk-000/file-000.parquet"), &columns);
    let message = refused(root.path(), &ReadOptions::default());
    assert!(
        message.starts_with(&format!("data/chunk-000/file-000.parquet: row {}: ", ROWS + 1)),
        "{message}"
    );
    assert!(message.contains("two episodes have one number"), "{message}");
}

#[test]
fn signals_of_64_bits_on_a_large_offset_are_refused_by_column() {
    let root = tempdir().unwrap();
    let values =
        |offset: f64| Column::Double((0..40).map(|row| offset + f64::from(row % 10) * 0.01).collect());
    let table = |offset| {
        let path = root.path().join("presses.parquet");
        let recording = Column::Int((0..40).map(|row| row / 10).collect());
        let label = Column::Text((0..40).map(|row| ["soft", "hard"][row / 10 % 2].to_string()).collect());
        parquet(&path, &[("recording", recording), ("depth", values(offset)), ("label", label)]);
        load(&path, &ReadOptions::default()).map_err(|e| e.to_string())
    };
    table(1000.0).unwrap();
    let message = table(1e7).unwrap_err();
    assert!(message.contains("column \"depth\" goes from") && message.contains("offset"), "{message}");
}

#[test]
fn time_stamps_of_parquet_have_the_unit_of_their_type() {
    let root = tempdir().unwrap();
    let path = root.path().join("presses.parquet");
    for (unit, per_second) in [("MILLIS", 1000), ("MICROS", 1_000_000), ("NANOS", 1_000_000_000)] {
        let stamps = || (0..40).map(|row| (1_795_363_200 * 100 + row % 10) * (per_second / 100)).collect();
        let columns = [
            ("recording", Column::Int((0..40).map(|row| row / 10).collect())),
            ("time", Column::Stamp(stamps(), unit)),
            ("force", Column::Float((0..40).map(|row| row as f32).collect())),
            ("received", Column::Stamp(stamps(), unit)),
            ("label", Column::Text((0..40).map(|row| ["soft", "hard"][row / 10 % 2].to_string()).collect())),
        ];
        parquet(&path, &columns);
        let data = load(&path, &ReadOptions::default()).unwrap();
        assert_eq!((data.x.shape(), data.spec.rate), (&[4, 1, 10][..], Some(100.0)), "{unit}");
        assert_eq!(
            check(&path).unwrap().ignored,
            ["column \"received\" (time)"],
            "a date is no channel, and that is said"
        );
    }
}

#[test]
fn a_column_of_time_that_is_to_be_ignored_is_and_actions_stay_out() {
    let root = tempdir().unwrap();
    info(root.path(), "v2.1", FEATURES);
    tasks(root.path());
    for index in 0..4 {
        let mut columns = vec![state(index), ("action", Column::List(vec![vec![9.0]; ROWS]))];
        columns.extend(episode(index, index % 2, ROWS));
        parquet(&root.path().join(format!("data/chunk-000/episode_{index:06}.parquet")), &columns);
    }
    let table = TableOptions { ignore: vec!["timestamp".into()], ..TableOptions::default() };
    let data = load(root.path(), &ReadOptions { table, ..ReadOptions::default() }).unwrap();
    assert_eq!((data.x.shape(), data.spec.rate), (&[4, 2, ROWS][..], None));
}

#[test]
fn classes_come_from_labels_features_or_the_task_in_this_order() {
    let root = tempdir().unwrap();
    let write = |with_task: bool, labels: Option<&str>| {
        info(
            root.path(),
            "v2.1",
            r#""observation.state": {"dtype": "float32", "shape": [2], "names": null}"#,
        );
        tasks(root.path());
        for index in 0..4 {
            let mut columns = vec![state(index)];
            columns.extend(episode(index, index % 2, ROWS));
            columns.retain(|(name, _)| with_task || *name != "task_index");
            parquet(&root.path().join(format!("data/chunk-000/episode_{index:06}.parquet")), &columns);
        }
        let path = root.path().join("labels.csv");
        match labels {
            Some(text) => std::fs::write(path, text).unwrap(),
            None => std::fs::remove_file(path).unwrap_or_default(),
        }
    };
    let names = || load(root.path(), &ReadOptions::default()).map(|data| data.output_names());
    let labels = "episode,label\n0,cup\n1,cup\n2,pen\n3,pen\n";
    for with_task in [true, false] {
        write(with_task, Some(labels));
        assert_eq!(names().unwrap(), ["cup", "pen"], "task: {with_task}");
    }
    write(true, None);
    assert_eq!(names().unwrap(), ["soft", "hard"]);
    write(false, None);
    let message = names().unwrap_err().to_string();
    assert!(message.contains("label") && !message.contains("task_index"), "{message}");
}
