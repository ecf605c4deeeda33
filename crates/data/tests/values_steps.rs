//! Targets of each time step, which windows take at their end.

#![allow(clippy::unwrap_used)]

mod common;

use common::{f32s, files, i64s, npy, npz, refused};
use std::path::Path;
use taxel_data::{
    Drop, Length, Npz, ReadOptions, Recordings, Shares, TableOptions, TargetOf, TaskKind, check_with,
    convert, load, random_split, recordings,
};
use tempfile::tempdir;

fn window(to: usize, hop: usize) -> ReadOptions {
    ReadOptions { length: Some(Length::Window { to, hop: Some(hop) }), ..ReadOptions::default() }
}

fn values(path: &Path, options: &ReadOptions) -> Vec<f32> {
    load(path, options).unwrap().targets.values().unwrap().values().to_vec()
}

/// Two recordings of four readings, whose force rises.
const PRESSES: &str = "recording,time,a,b,force_N,group\n\
                       p,0,1,10,0.1,m\np,1,2,20,0.2,m\np,2,3,30,0.3,m\np,3,4,40,0.4,m\n\
                       q,0,5,50,1.1,n\nq,1,6,60,1.2,n\nq,2,7,70,1.3,n\nq,3,8,80,1.4,n\n";

#[test]
fn a_target_that_changes_in_a_long_table_is_that_of_the_windows_end() {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("t.csv", PRESSES)]);
    let path = folder.path().join("t.csv");
    let y = |options: ReadOptions| ReadOptions { y: Some("force_N".into()), ..options };
    let message = refused(&path, &y(ReadOptions::default()));
    assert!(
        message.contains("lines 2 and 3 are both recording \"p\", but force_N is \"0.1\" and \"0.2\""),
        "{message}"
    );
    assert!(message.contains("the target changes within a recording: give length = {"), "{message}");
    let crop = ReadOptions { length: Some("crop:2".parse().unwrap()), ..ReadOptions::default() };
    assert!(refused(&path, &y(crop)).contains("the target changes within a recording"));
    let data = load(&path, &y(window(2, 1))).unwrap();
    assert_eq!(data.x.shape(), [6, 2, 2]);
    assert_eq!(data.targets.values().unwrap().values(), [0.2, 0.3, 0.4, 1.2, 1.3, 1.4]);
    assert_eq!(data.output_names(), ["force"]);
    assert_eq!((data.groups.unwrap(), data.group_name.unwrap()), (vec![0, 0, 0, 1, 1, 1], "group".into()));
    assert_eq!(data.origins[1], "p[1..]");
    // One for all rows is said once.
    let of_each = y(ReadOptions { target: Some(TargetOf::Recording), ..window(2, 1) });
    assert!(refused(&path, &of_each).contains("leave target = \"recording\" out"));
    let constant = PRESSES.replace("0.2", "0.1").replace("0.3", "0.1").replace("0.4", "0.1");
    let constant = constant.replace("1.2", "1.1").replace("1.3", "1.1").replace("1.4", "1.1");
    files(folder.path(), &[("t.csv", &constant)]);
    assert_eq!(values(&path, &y(ReadOptions::default())), [0.1, 1.1]);
}

#[test]
fn rows_that_lie_mixed_and_irregular_times_keep_their_targets() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("t.csv");
    let mixed = "recording,a,y\np,1,0.1\nq,5,1.1\np,2,0.2\nq,6,1.2\np,3,0.3\nq,7,1.3\n";
    files(folder.path(), &[("t.csv", mixed)]);
    assert_eq!(values(&path, &window(2, 1)), [0.2, 0.3, 1.2, 1.3]);
    // Steps of 1, 1, 3 and 1 s: brought to equal steps of 1 s, with the targets on the same line as the channel.
    let uneven = "recording,time,a,y\np,0,0,0.5\np,1,10,10.5\np,2,20,20.5\np,5,50,50.5\np,6,60,60.5\n";
    files(folder.path(), &[("t.csv", uneven)]);
    let data = load(&path, &window(1, 1)).unwrap();
    let y = data.targets.values().unwrap().values();
    assert_eq!(data.len(), 7);
    assert!(data.x.iter().zip(y).all(|(x, y)| (x + 0.5 - y).abs() < 1e-4), "{:?} {y:?}", data.x);
    files(folder.path(), &[("t.csv", &uneven.replace("0.5", "up").replace(",1up", ",up"))]);
    let classes = "recording,time,a,y\np,0,0,up\np,1,10,up\np,2,20,up\np,5,50,down\np,6,60,down\n";
    files(folder.path(), &[("t.csv", classes)]);
    assert!(refused(&path, &window(1, 1)).contains("time stamps are irregular"));
}

#[test]
fn labels_of_time_steps_are_those_of_the_windows_end() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("t.csv");
    files(
        folder.path(),
        &[("t.csv", "recording,a,slip\np,1,no\np,2,no\np,3,yes\np,4,no\nq,5,yes\nq,6,no\n")],
    );
    let options = ReadOptions { y: Some("slip".into()), ..window(2, 1) };
    let data = load(&path, &options).unwrap();
    assert_eq!(
        (data.output_names(), data.strata().to_vec()),
        (vec!["no".into(), "yes".into()], vec![0, 1, 0, 0])
    );
    // Windows of one recording stay on one side.
    let units = data.units.clone().unwrap();
    assert_eq!(units, [0, 0, 0, 3]);
    // To predict they are cut the same way; the truth is that of the end.
    let options = ReadOptions { table: "long".parse::<TableOptions>().unwrap(), ..options };
    let Recordings { x, truth, starts, .. } = recordings(&path, &options, 2).unwrap();
    assert_eq!((x.shape(), starts.unwrap()), (&[4, 1, 2][..], vec![0, 1, 2, 0]));
    assert_eq!(truth.unwrap().concat(), ["no", "yes", "no", "no"]);
    let whole = ReadOptions { length: Some("pad:4".parse().unwrap()), ..options };
    assert_eq!(recordings(&path, &whole, 2).unwrap().truth, None);
}

/// `x` `[2, 1, 4]`, whose values count from 0.
fn series() -> Vec<u8> {
    f32s(&[2, 1, 4], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])
}

#[test]
fn arrays_hold_targets_of_time_steps_where_it_is_said() {
    let folder = tempdir().unwrap();
    let halves: Vec<f32> = (0..8).map(|i| i as f32 + 0.5).collect();
    let path = npz(folder.path(), &[("x", series()), ("y", f32s(&[2, 4], &halves))]);
    let data = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!(data.output_names(), ["y-0", "y-1", "y-2", "y-3"]);
    let said = check_with(&path, &ReadOptions::default()).unwrap().read_as.join("\n");
    assert!(said.contains("4 quantities of the recording") && said.contains("--target step"), "{said}");
    let step = |options: ReadOptions| ReadOptions { target: Some(TargetOf::Step), ..options };
    let message = refused(&path, &step(ReadOptions::default()));
    assert!(message.contains("the target changes within a recording: give length"), "{message}");
    let data = load(&path, &step(window(2, 2))).unwrap();
    assert_eq!(data.targets.values().unwrap().values(), [1.5, 3.5, 5.5, 7.5]);
    assert_eq!(data.group_name.as_deref(), Some("recording"));
    // Two quantities of each step, and one array of another length.
    let both: Vec<f32> = halves.iter().flat_map(|y| [*y, -y]).collect();
    let path = npz(folder.path(), &[("x", series()), ("y", f32s(&[2, 4, 2], &both))]);
    assert_eq!(values(&path, &step(window(3, 3))), [2.5, -2.5, 6.5, -6.5]);
    let path = npz(folder.path(), &[("x", series()), ("y", f32s(&[2, 3], &halves[..6]))]);
    let message = refused(&path, &step(window(2, 2)));
    assert!(message.contains("y has 3 targets for x[0], which has 4 time steps"), "{message}");
    // Classes.
    let path = npz(folder.path(), &[("x", series()), ("y", i64s(&[2, 4], &[0, 0, 1, 1, 0, 1, 0, 0]))]);
    assert!(refused(&path, &ReadOptions::default()).contains("target = \"step\""));
    assert_eq!(load(&path, &step(window(2, 1))).unwrap().strata().to_vec(), [0, 1, 1, 1, 0, 0]);
    let as_values = ReadOptions { task: Some(TaskKind::Values), ..step(window(2, 1)) };
    assert_eq!(values(&path, &as_values), [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
}

#[test]
fn windows_without_a_target_are_left_out() {
    let folder = tempdir().unwrap();
    let y = [f32::NAN, 0.5, 1.5, f32::NAN, 2.5, 3.5, 4.5, 5.5];
    let path = npz(folder.path(), &[("x", series()), ("y", f32s(&[2, 4], &y))]);
    let step = ReadOptions { target: Some(TargetOf::Step), ..window(2, 1) };
    let message = refused(&path, &step);
    assert!(message.contains("1 of 6 samples have no target: x[0][2..];"), "{message}");
    let options = ReadOptions { drop: vec![Drop::NoTarget], ..step };
    let data = load(&path, &options).unwrap();
    assert_eq!(data.targets.values().unwrap().values(), [0.5, 1.5, 3.5, 4.5, 5.5]);
    assert_eq!(data.x.shape(), [5, 1, 2]);
    assert_eq!(data.origins[2], "x[1][0..]");
    assert_eq!(check_with(&path, &options).unwrap().without_target, 1);
}

/// Readings of three recordings, of which rows of one lie apart.
fn readings(folder: &Path, more: &[(&str, Vec<u8>)]) -> std::path::PathBuf {
    let x: Vec<f32> = (0..16).map(|i| i as f32).collect();
    let mut arrays = vec![("x", f32s(&[8, 2], &x)), ("run", i64s(&[8], &[7, 7, 7, 3, 3, 7, 9, 9]))];
    arrays.extend(more.iter().cloned());
    npz(folder, &arrays)
}

#[test]
fn rows_of_arrays_are_joined_to_recordings() {
    let folder = tempdir().unwrap();
    let y: Vec<f32> = (0..8).map(|i| i as f32 / 2.0).collect();
    let path =
        readings(folder.path(), &[("y", f32s(&[8], &y)), ("day", i64s(&[8], &[1, 1, 1, 2, 2, 1, 2, 2]))]);
    let run = |options: ReadOptions| ReadOptions { recording: Some("run".into()), ..options };
    let message = refused(&path, &run(ReadOptions::default()));
    assert!(message.contains("rows 0 and 1 are both run 7, but differ in y; say one"), "{message}");
    let options = ReadOptions { group: Some("day".into()), ..run(window(2, 1)) };
    let data = load(&path, &options).unwrap();
    assert_eq!(data.x.shape(), [5, 2, 2]);
    assert_eq!(data.x.iter().copied().collect::<Vec<f32>>()[8..12], [4.0, 10.0, 5.0, 11.0]);
    assert_eq!(data.targets.values().unwrap().values(), [0.5, 1.0, 2.5, 2.0, 3.5]);
    assert_eq!(
        (data.groups.as_deref(), data.origins[4].as_str()),
        (Some(&[1, 1, 1, 2, 2][..]), "run 9[0..]")
    );
    let units = data.units.as_deref();
    assert_eq!(units, Some(&[0, 0, 0, 3, 4][..]));
    let card = check_with(&path, &options).unwrap();
    assert!(
        card.read_as.join(" ").contains("3 recordings by \"run\" rows of 1 recording lie apart"),
        "{card}"
    );
    assert_eq!(data.spec.recording.as_deref(), Some("run"));
    // Converted windows are those windows.
    let out = folder.path().join("out.npz");
    convert(&path, &options, &out).unwrap();
    assert_eq!(load(&out, &ReadOptions::default()).unwrap().digest, data.digest);
    let torn =
        readings(folder.path(), &[("y", f32s(&[8], &y)), ("day", i64s(&[8], &[1, 1, 2, 2, 2, 1, 2, 2]))]);
    let message = refused(&torn, &options);
    assert!(
        message.contains("day is 1 in row 0 and 2 in row 2, which are both run 7; day holds whole"),
        "{message}"
    );
    let other = ReadOptions { recording: Some("runs".into()), ..options };
    assert!(refused(&torn, &other).contains("no array runs: it holds"));
}

#[test]
fn a_target_that_stays_in_joined_rows_is_that_of_the_recording() {
    let folder = tempdir().unwrap();
    let path = readings(folder.path(), &[("y", i64s(&[8], &[1, 1, 1, 0, 0, 1, 2, 2]))]);
    let run = ReadOptions { recording: Some("run".into()), ..ReadOptions::default() };
    let options = ReadOptions { length: Some("pad:4".parse().unwrap()), ..run.clone() };
    assert_eq!(load(&path, &options).unwrap().strata().to_vec(), [1, 0, 2]);
    let values = ReadOptions { task: Some(TaskKind::Values), ..options };
    assert_eq!(load(&path, &values).unwrap().targets.values().unwrap().values(), [1.0, 0.0, 2.0]);
    // Unlabelled readings are cut the same way, joined by that array or, without it, as one recording.
    let cut = ReadOptions { recording: Some("run".into()), ..window(2, 2) };
    let unlabelled = readings(folder.path(), &[]);
    let Recordings { x, origins, .. } = recordings(&unlabelled, &cut, 2).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((x.shape(), origins[2].as_str()), (&[4, 2, 2][..], "run 3"));
    let mut alone = Npz::default();
    alone.add("x", &[5, 2], &[0.0f32, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]).unwrap();
    let path = folder.path().join("alone.npz");
    std::fs::write(&path, alone.finish().unwrap()).unwrap();
    let Recordings { x, origins, .. } = recordings(&path, &cut, 2).unwrap();
    assert_eq!((x.shape(), origins), (&[2, 2, 2][..], vec!["alone".to_string(), "alone".into()]));
    assert_eq!(x.iter().copied().collect::<Vec<f32>>()[..4], [0.0, 2.0, 1.0, 3.0]);
    // Whole recordings are taken as they are, whatever arrays lie beside.
    let whole = npz(folder.path(), &[("x", series()), ("run", i64s(&[2], &[0, 1]))]);
    assert_eq!(recordings(&whole, &cut, 2).unwrap().x.shape(), [4, 1, 2]);
}

#[test]
fn a_random_split_keeps_the_windows_of_a_recording_together() {
    let folder = tempdir().unwrap();
    let x: Vec<f32> = (0..240).map(|i| (i * 37 % 101) as f32).collect();
    let run: Vec<i64> = (0..240).map(|i| i / 12).collect();
    let y: Vec<f32> = (0..240).map(|i| (i % 12) as f32 / 3.0).collect();
    let arrays = [("x", f32s(&[240, 1], &x)), ("run", i64s(&[240], &run)), ("y", f32s(&[240], &y))];
    let path = npz(folder.path(), &arrays);
    let data = load(&path, &ReadOptions { recording: Some("run".into()), ..window(4, 2) }).unwrap();
    assert_eq!(data.len(), 100);
    let shares = Shares { test: 0.3, validation: 0.0 };
    let fold = random_split(&data.strata(), shares, 0, 0, data.units.as_deref()).unwrap();
    let groups = data.groups.unwrap();
    let trained: Vec<u32> = fold.train.iter().map(|row| groups[*row]).collect();
    assert!(fold.test.iter().all(|row| !trained.contains(&groups[*row])));
}

#[test]
fn targets_of_time_steps_have_no_empty_axis() {
    let folder = tempdir().unwrap();
    let step = ReadOptions { target: Some(TargetOf::Step), ..window(2, 2) };
    for shape in [&[2, 0][..], &[2, 0, 2], &[2, 4, 0]] {
        let path = npz(folder.path(), &[("x", series()), ("y", f32s(shape, &[]))]);
        let message = refused(&path, &step);
        assert!(message.contains("targets of time steps are [N, T]"), "{shape:?}: {message}");
    }
}

#[test]
fn a_text_for_each_sample_of_one_time_step_is_its_class() {
    let folder = tempdir().unwrap();
    let text =
        |text: &str| text.chars().flat_map(|letter| u32::from(letter).to_le_bytes()).collect::<Vec<u8>>();
    let texts = |shape: &[u64], all: &str| npy("<U1", false, shape, &text(all));
    let step = ReadOptions { target: Some(TargetOf::Step), ..window(1, 1) };
    let x = f32s(&[3, 1, 1], &[0.0, 1.0, 2.0]);
    let path = npz(folder.path(), &[("x", x), ("y", texts(&[3, 1], "aba"))]);
    assert_eq!(load(&path, &step).unwrap().output_names(), ["a", "b"]);
    // With more steps each column has texts of its own.
    let path = npz(folder.path(), &[("x", series()), ("y", texts(&[2, 4], "aabbabba"))]);
    assert!(refused(&path, &step).contains("holds texts for each time step"));
}
