//! The values at rest that are taken off recordings.

#![allow(clippy::unwrap_used)]

mod common;

use common::{f32s, files, i64s, npz, refused};
use taxel_data::{Layout, Length, ReadOptions, TableOptions, Tare, load, recordings, whole_recordings};
use tempfile::tempdir;

fn tared(text: &str) -> ReadOptions {
    ReadOptions { tare: Some(text.parse().unwrap()), ..ReadOptions::default() }
}

/// Two recordings of two channels and four readings, with the same presses on other levels at rest.
const SERIES: [f32; 16] =
    [1.0, 3.0, 6.0, 2.0, 10.0, 12.0, 10.0, 11.0, 101.0, 103.0, 106.0, 102.0, 20.0, 22.0, 20.0, 21.0];

#[test]
fn the_first_readings_of_each_recording_are_taken_off_each_channel() {
    let folder = tempdir().unwrap();
    let arrays = [("x", f32s(&[2, 2, 4], &SERIES)), ("y", f32s(&[2], &[0.5, 0.7]))];
    let path = npz(folder.path(), &arrays);
    let data = load(&path, &tared("recording")).unwrap();
    let once: Vec<f32> = vec![0.0, 2.0, 5.0, 1.0, 0.0, 2.0, 0.0, 1.0];
    assert_eq!(data.x.iter().copied().collect::<Vec<_>>(), [once.clone(), once].concat());
    assert_eq!(data.spec.tare, Some(Tare::Recording { steps: 1 }));
    let mean = load(&path, &tared("recording:2")).unwrap();
    let once: Vec<f32> = vec![-1.0, 1.0, 4.0, 0.0, -1.0, 1.0, -1.0, 0.0];
    assert_eq!(mean.x.iter().copied().collect::<Vec<_>>(), [once.clone(), once].concat());
    assert_ne!(mean.digest, data.digest);
    // What a model reads is tared alike, and copies are sought in it: these two are one.
    let read = recordings(&path, &tared("recording:2"), 2).unwrap();
    assert_eq!(read.x, mean.x);
    assert_eq!(data.row_hash[0], data.row_hash[1]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().spec.tare, None);
}

#[test]
fn windows_are_cut_from_recordings_that_are_tared_already() {
    let folder = tempdir().unwrap();
    let rows: Vec<f32> = (0..6).flat_map(|t| [t as f32, 10.0 * t as f32]).collect();
    let arrays = [
        ("x", f32s(&[6, 2], &rows)),
        ("y", f32s(&[6], &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6])),
        ("run", i64s(&[6], &[4, 4, 4, 5, 5, 5])),
        ("rest", f32s(&[6, 2], &[1.0; 12])),
    ];
    let path = npz(folder.path(), &arrays);
    let windows = Length::Window { to: 2, hop: Some(1) };
    let joined = ReadOptions { recording: Some("run".into()), length: Some(windows), ..tared("recording") };
    let data = load(&path, &joined).unwrap();
    assert_eq!(data.x.index_axis(ndarray::Axis(0), 1).as_slice().unwrap(), [1.0, 2.0, 10.0, 20.0]);
    assert_eq!(data.x.index_axis(ndarray::Axis(0), 2).as_slice().unwrap(), [0.0, 1.0, 0.0, 10.0]);
    let by_array = ReadOptions { tare: Some(Tare::Array("rest".into())), ..joined };
    let data = load(&path, &by_array).unwrap();
    assert_eq!(data.x.index_axis(ndarray::Axis(0), 2).as_slice().unwrap(), [2.0, 3.0, 29.0, 39.0]);
    assert_eq!(data.spec.tare, Some(Tare::Array("rest".into())));
}

#[test]
fn an_array_has_the_rest_of_each_sample() {
    let folder = tempdir().unwrap();
    let rest = f32s(&[2, 2], &[1.0, 10.0, 101.0, 20.0]);
    let arrays = [("x", f32s(&[2, 2, 4], &SERIES)), ("y", f32s(&[2], &[0.5, 0.7])), ("tare", rest)];
    let path = npz(folder.path(), &arrays);
    let (by_array, by_start) =
        (load(&path, &tared("array:tare")).unwrap(), load(&path, &tared("recording")).unwrap());
    assert_eq!(by_array.x, by_start.x);
    let (whole, _) = whole_recordings(&path, &tared("array:tare"), 2).unwrap();
    assert_eq!(whole[1].values, [0.0, 2.0, 5.0, 1.0, 0.0, 2.0, 0.0, 1.0]);
    assert!(refused(&path, &tared("array:rest")).contains("rest"));
    let short =
        [("x", f32s(&[2, 2, 4], &SERIES)), ("y", f32s(&[2], &[0.5, 0.7])), ("tare", f32s(&[2], &[0.0; 2]))];
    let message = refused(&npz(folder.path(), &short), &tared("array:tare"));
    assert!(message.contains("tare: has shape [2]; resting values have the shape of x"), "{message}");
}

#[test]
fn a_tare_that_cannot_be_taken_is_refused() {
    let folder = tempdir().unwrap();
    let features = [("x", f32s(&[4, 2], &[0.0; 8])), ("y", f32s(&[4], &[0.1, 0.2, 0.3, 0.4]))];
    let path = npz(folder.path(), &features);
    let of_features = ReadOptions { layout: Some(Layout::Features), ..tared("recording") };
    assert!(refused(&path, &of_features).contains("these samples have no time"));
    let series = [("x", f32s(&[2, 2, 4], &SERIES)), ("y", f32s(&[2], &[0.5, 0.7]))];
    let path = npz(folder.path(), &series);
    assert!(load(&path, &tared("recording:4")).is_ok(), "a recording may be all rest");
    let message = refused(&path, &tared("recording:5"));
    assert!(message.contains("x[0]: has 4 readings, and tare is the mean of the first 5"), "{message}");
    let table = "recording,a,y\np,1,0.5\np,2,0.5\nq,1,0.7\nq,3,0.7\n";
    files(folder.path(), &[("t.csv", table)]);
    let path = folder.path().join("t.csv");
    assert!(refused(&path, &tared("array:rest")).contains("write recording:N"));
    let long = ReadOptions { table: TableOptions::default(), ..tared("recording") };
    assert_eq!(load(&path, &long).unwrap().x.iter().copied().collect::<Vec<_>>(), [0.0, 1.0, 0.0, 2.0]);
    for text in ["first", "recording:0", "recording:x", "array:", "10", ""] {
        let message = text.parse::<Tare>().unwrap_err().to_string();
        assert!(message.contains("write recording, recording:18"), "{message}");
    }
    let of_table: ReadOptions = serde_json::from_str(r#"{"tare": {"array": "rest"}}"#).unwrap();
    assert_eq!(of_table.tare, Some(Tare::Array("rest".into())));
}

#[test]
fn what_the_file_of_names_says_holds_until_somebody_says_other() {
    let folder = tempdir().unwrap();
    for (class, level) in [("cup", 100), ("pot", 7)] {
        std::fs::create_dir(folder.path().join(class)).unwrap();
        for take in 0..2 {
            let rows: String =
                (0..6).map(|t| format!("{},{}\n", 0.01 * f64::from(t), level + take + t)).collect();
            let path = folder.path().join(class).join(format!("{take}.csv"));
            std::fs::write(path, format!("time,a\n{rows}")).unwrap();
        }
    }
    let write = |text: &str| std::fs::write(folder.path().join("labels.json"), text).unwrap();
    write(r#"{"unit": "N", "tare": "recording:2"}"#);
    let said = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!(said.x, load(folder.path(), &tared("recording:2")).unwrap().x);
    assert_eq!(said.spec.tare, Some(Tare::Recording { steps: 2 }));
    assert_eq!(said.x.iter().next(), Some(&-0.5));
    let off = load(folder.path(), &tared("off")).unwrap();
    assert_eq!((off.x.iter().next(), &off.spec.tare), (Some(&100.0), &None));
    assert_ne!(off.digest, said.digest);
    // A model says itself what it takes off.
    assert_eq!(recordings(folder.path(), &ReadOptions::default(), 2).unwrap().x, off.x);
    for wrong in [r#"{"tare": 2}"#, r#"{"tare": "array:rest"}"#, r#"{"tare": "recording:0"}"#] {
        write(wrong);
        let message = load(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("labels.json") && message.contains("recording:18"), "{message}");
    }
}
