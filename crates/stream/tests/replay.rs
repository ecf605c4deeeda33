//! Recordings and lines of files, time step by time step.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use taxel_data::{Layout, Npz, ReadOptions, SampleSpec};
use taxel_stream::{LineColumns, Next, Pace, SourceSettings, StreamSource, start};

/// Everything that came of a file: values and stamps of time steps, beginnings, its end, and the warnings.
#[derive(Debug, Default, PartialEq)]
struct Came {
    readings: Vec<(Vec<f32>, Option<f64>)>,
    begins: Vec<String>,
    /// Time steps before each wish for a new level at rest.
    tares: Vec<usize>,
    error: Option<String>,
    said: Vec<String>,
}

fn replayed(path: &Path, spec: &SampleSpec, rate: Option<f64>, pace: Pace) -> Came {
    let columns = LineColumns::new(spec, None, None);
    let options = ReadOptions { layout: Some(spec.layout), ..ReadOptions::default() };
    let settings = SourceSettings { spec: spec.clone(), columns, pace, rate, options, as_is: false };
    let said = Arc::new(Mutex::new(vec![]));
    let heard = Arc::clone(&said);
    let stream = start(StreamSource::Path(path.into()), settings, move |what| {
        heard.lock().unwrap().push(what.to_string())
    })
    .unwrap();
    let mut came = Came::default();
    loop {
        match stream.next(Duration::from_secs(60)) {
            Next::Reading(arrival) => came.readings.push((arrival.values, arrival.stamp)),
            Next::Begin(name) => came.begins.push(name),
            Next::Tare => came.tares.push(came.readings.len()),
            Next::End(how) => {
                came.error = how.err().map(|e| e.to_string());
                came.said = said.lock().unwrap().clone();
                return came;
            }
            Next::Quiet => panic!("nothing came"),
        }
    }
}

/// An archive of `x`, each value its own place.
fn counted(folder: &Path, shape: &[usize]) -> PathBuf {
    let x: Vec<f32> = (0..shape.iter().product()).map(|i: usize| i as f32).collect();
    let mut npz = Npz::default();
    npz.add("x", shape, &x).unwrap();
    let path = folder.join("x.npz");
    std::fs::write(&path, npz.finish().unwrap()).unwrap();
    path
}

fn values(came: &Came) -> Vec<Vec<f32>> {
    came.readings.iter().map(|(values, _)| values.clone()).collect()
}

#[test]
fn recordings_of_any_layout_come_instant_by_instant() {
    let folder = tempfile::tempdir().unwrap();
    let at = |shape: &[usize], spec: &SampleSpec| {
        replayed(&counted(folder.path(), shape), spec, Some(10.0), Pace::Fast)
    };
    // [N, C, T], longer than the model's samples.
    let series = at(&[2, 2, 3], &SampleSpec::new(Layout::Series, &[2, 2]));
    assert_eq!(values(&series), [[0.0, 3.0], [1.0, 4.0], [2.0, 5.0], [6.0, 9.0], [7.0, 10.0], [8.0, 11.0]]);
    assert_eq!(series.begins.len(), 2);
    let stamps: Vec<f64> = series.readings.iter().map(|(_, stamp)| stamp.unwrap()).collect();
    assert_eq!(stamps, [0.0, 0.1, 0.2, 0.0, 0.1, 0.2], "each recording has its own time");
    // [N, T, H, W]: a frame lies as it is.
    let frames = at(&[1, 3, 1, 2], &SampleSpec::new(Layout::Sequence, &[2, 1, 2]));
    assert_eq!(values(&frames), [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]);
    // [N, F, C, T].
    let fingers = at(&[1, 2, 2, 2], &SampleSpec::new(Layout::Fingers, &[2, 2, 2]));
    assert_eq!(values(&fingers), [[0.0, 2.0, 4.0, 6.0], [1.0, 3.0, 5.0, 7.0]]);
    // Some channels of whole recordings.
    let some = SampleSpec { channels: Some(vec![2, 0]), ..SampleSpec::new(Layout::Series, &[2, 2]) };
    assert_eq!(values(&at(&[1, 3, 2], &some)), [[4.0, 0.0], [5.0, 1.0]]);
    let second = SampleSpec { channels: Some(vec![1]), ..SampleSpec::new(Layout::Fingers, &[1, 2, 2]) };
    assert_eq!(values(&at(&[1, 2, 2, 2], &second)), [[4.0, 6.0], [5.0, 7.0]]);
    // Single images are one stream.
    let images = at(&[3, 1, 2], &SampleSpec::new(Layout::Image, &[1, 2]));
    assert_eq!(values(&images), [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]);
    assert_eq!((images.begins.len(), images.readings[2].1), (0, Some(0.2)));
}

#[test]
fn what_cannot_be_replayed_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let file = counted(folder.path(), &[1, 3, 2]);
    let other = replayed(&file, &SampleSpec::new(Layout::Series, &[2, 2]), None, Pace::Fast);
    assert!(other.error.unwrap().contains("[3, 2], the model reads [2, 2] (channels × time)"));
    let series = SampleSpec::new(Layout::Series, &[3, 2]);
    assert!(replayed(&file, &series, None, Pace::Rate).error.unwrap().contains("say --rate"));
    let lines = folder.path().join("x.csv");
    std::fs::write(&lines, "1,2,3\n1,2,3\n").unwrap();
    assert!(replayed(&lines, &series, None, Pace::Rate).error.unwrap().contains("say --rate HZ"));
    assert_eq!(replayed(&lines, &series, Some(1e6), Pace::Rate).readings.len(), 2);
}

#[test]
fn lines_of_a_file_without_stamps_take_the_rate_and_skipped_ones_their_time() {
    let folder = tempfile::tempdir().unwrap();
    let lines = folder.path().join("x.csv");
    std::fs::write(&lines, "a,b\n1,2\n1,x\n\n3,4\n1,y\n").unwrap();
    let came = replayed(&lines, &SampleSpec::new(Layout::Series, &[2, 2]), Some(10.0), Pace::Fast);
    assert_eq!(came.readings, [(vec![1.0, 2.0], Some(0.0)), (vec![3.0, 4.0], Some(0.2))]);
    assert_eq!(came.said.len(), 1, "{:?}", came.said);
    assert!(came.said[0].contains("line 3: column 2: \"x\" is no number"));
    // A line that asks for the level at rest is no time step and takes no time; the first line may be a name of a column.
    std::fs::write(&lines, "1,2\ntare\n3,4\n TARE \n").unwrap();
    let came = replayed(&lines, &SampleSpec::new(Layout::Series, &[2, 2]), Some(10.0), Pace::Fast);
    assert_eq!((came.readings.len(), came.readings[1].1, came.tares), (2, Some(0.1), vec![1, 2]));
}

#[test]
fn channels_that_nobody_knows_come_with_their_names_and_with_what_was_skipped() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let (columns, channels) = LineColumns::any(None, None);
        let spec = SampleSpec::new(Layout::Series, &[1, 1]);
        let options = ReadOptions::default();
        let settings = SourceSettings { spec, columns, pace: Pace::Fast, rate: None, options, as_is: false };
        let stream = start(StreamSource::Path(path), settings, |_| {}).unwrap();
        let mut came = vec![];
        let how = loop {
            match stream.next(Duration::from_secs(60)) {
                Next::Reading(arrival) => came.push((arrival.values, arrival.stamp, arrival.skipped)),
                Next::End(how) => break how,
                other => panic!("{other:?}"),
            }
        };
        (came, channels.names().map(<[String]>::to_vec), how.err().map(|e| e.to_string()))
    };
    let rows = vec![(vec![1.0, 2.0], Some(0.5), 0), (vec![3.0, 4.0], Some(0.6), 2)];
    let names = Some(vec!["thumb".to_string(), "index".into()]);
    let (came, found, _) = read("a.csv", "thumb,time_ms,id,index\n1,500,7,2\noops\n1,2\n3,600,8,4\n");
    assert_eq!((came, found), (rows, names));
    let (came, found, _) = read("b.jsonl", "{\"t\":0.5,\"thumb\":1,\"index\":2}\n");
    assert_eq!((came.len(), found.map(|names| names.join(","))), (1, Some("thumb,index".into())));
    let (came, found, _) = read("c.csv", "1,2,3\n4,5,6\n");
    assert_eq!((came[1].0.clone(), found), (vec![4.0, 5.0, 6.0], Some(vec![])));
    let (_, found, error) = read("d.csv", "");
    assert!(found.is_none() && error.is_some_and(|why| why.contains("a line is a reading, as 0.5,1.5")));
}
