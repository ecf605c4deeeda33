//! One CSV table of many recordings, long and wide. The irregular one is NumPy's (`scripts/fixtures/tables.py`).
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{files, refused};
use proptest::prelude::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use taxel_data::{Card, Dataset, Layout, Limits, ReadOptions, check, check_with, load, recordings};
use tempfile::tempdir;

const WIDE: &str = "id,object,f1,f2,slipped\n7,can,1,2,0\n8,can,3,4,1\n9,mug,5,6.5,0\n";
const LONG: &str = "recording,time_ms,a,b,label\nx,0,1,10,up\nx,10,2,20,up\ny,5,3,30,down\nx,20,4,40,up\n";

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn table(text: &str) -> ReadOptions {
    ReadOptions { table: text.parse().unwrap(), ..ReadOptions::default() }
}

fn slipped(text: &str) -> ReadOptions {
    ReadOptions { y: Some("slipped".into()), table: text.parse().unwrap(), ..ReadOptions::default() }
}

fn with<T>(text: &str, use_it: impl FnOnce(&Path) -> T) -> T {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("grasps.csv", text)]);
    use_it(&folder.path().join("grasps.csv"))
}

fn read(text: &str, options: &ReadOptions) -> Dataset {
    with(text, |path| load(path, options).unwrap())
}

fn card(text: &str, options: &ReadOptions) -> Card {
    with(text, |path| check_with(path, options).unwrap())
}

fn message(text: &str, options: &ReadOptions) -> String {
    with(text, |path| refused(path, options))
}

#[test]
fn a_row_of_a_wide_table_is_a_sample() {
    let options = slipped("ignore=id");
    let data = read(WIDE, &options);
    assert_eq!((data.x.shape(), data.spec.layout), ([3, 2].as_slice(), Layout::Features));
    assert_eq!(data.x.as_slice().unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.5]);
    assert_eq!(
        (data.output_names().join(" "), data.strata().to_vec().as_slice()),
        ("0 1".into(), [0, 1, 0].as_slice())
    );
    assert_eq!((data.groups.as_ref(), data.origins[1].as_str()), (None, "line 3"));
    let card = card(WIDE, &options);
    assert_eq!(card.read_as, ["a wide table: a row is a sample of 2 features, labels by \"slipped\""]);
    assert_eq!((card.other_arrays, card.ignored), (vec!["object".to_string()], vec!["column \"id\"".into()]));
    // A group of texts, tabs between columns, and row numbers without a name.
    let grouped = ReadOptions { group: Some("object".into()), ..slipped("ignore=id") };
    let tabs = WIDE.replace(',', "\t").replace("id\t", "\t").replace("f1", "f 1");
    let tabs = read(&tabs, &ReadOptions { group: Some("object".into()), ..slipped("wide") });
    assert_eq!((tabs.groups.as_deref(), tabs.group_name.as_deref()), (Some(&[0, 0, 1][..]), Some("object")));
    assert_eq!(tabs.digest, read(WIDE, &grouped).digest);
    // A recording names its sample, and its time is no feature.
    let named = read("recording,time,f,label\na,5,1,x\nb,6,2,y\n", &table("wide"));
    assert_eq!((named.x.shape(), named.origins.join(" ")), ([2, 1].as_slice(), "a b".into()));
}

#[test]
fn what_only_looks_like_a_reading_or_a_label_is_not_one() {
    let axes = "x,y,z,kind\n1,2,3,a\n4,5,6,b\n";
    assert!(
        message(axes, &ReadOptions::default()).contains("has no column \"label\""),
        "y is an axis beside x"
    );
    let data = read(axes, &ReadOptions { y: Some("kind".into()), ..ReadOptions::default() });
    assert_eq!((data.x.shape(), data.output_names().join(" ")), ([2, 3].as_slice(), "a b".into()));
    assert_eq!(read("f,y\n1,a\n2,b\n", &ReadOptions::default()).output_names(), ["a", "b"]);
    // Numbers of classes beside their names, groups that are not used.
    let twice = "label,class,f\nsoft,0,1\nhard,1,2\n";
    let card = card(twice, &ReadOptions::default());
    assert_eq!(
        (card.shape.as_slice(), card.ignored),
        ([2, 1].as_slice(), vec!["column \"class\"".to_string()])
    );
}

#[test]
fn rows_of_a_long_table_are_readings_over_time() {
    let options = ReadOptions { length: Some("pad:3".parse().unwrap()), ..ReadOptions::default() };
    let data = read(LONG, &options);
    assert_eq!((data.x.shape(), data.spec.layout), ([2, 2, 3].as_slice(), Layout::Series));
    assert_eq!(data.x.as_slice().unwrap()[..9], [1.0, 2.0, 4.0, 10.0, 20.0, 40.0, 3.0, 0.0, 0.0]);
    assert_eq!((data.spec.rate, data.origins.join(" ")), (Some(100.0), "x y".into()));
    assert_eq!((data.output_names().join(" "), data.strata().to_vec()), ("down up".into(), vec![1, 0]));
    assert_eq!(
        card(LONG, &options).read_as,
        [
            "a long table: a row is a reading of 2 channels, recordings by \"recording\", time by \"time_ms\" in ms, \
             labels by \"label\"",
            "time stamps give 100 Hz"
        ]
    );
    let error = message(LONG, &ReadOptions::default());
    assert!(error.contains("recordings have 1 to 3 readings; say what to do"), "{error}");
    // Under other names, without time.
    let other = "grasp;kind;a\n1;up;1\n1;up;2\n2;down;3\n2;down;4\n";
    let other = read(other, &ReadOptions { y: Some("kind".into()), ..table("long,recording=grasp") });
    assert_eq!((other.x.shape(), other.spec.rate), ([2, 1, 2].as_slice(), None));
    // Rounded stamps are regular.
    let rounded: String =
        (0..24).map(|i| format!("{},{:.3},{i},{}\n", i / 12, f64::from(i % 12) / 120.0, i / 12)).collect();
    let rounded = read(&format!("series_id,t,a,label\n{rounded}"), &ReadOptions::default());
    let rate = rounded.spec.rate.unwrap();
    assert!((rate - 120.0).abs() < 0.5 && rounded.x.shape() == [2, 1, 12], "{rate}");
}

#[test]
fn irregular_time_stamps_are_interpolated_as_numpy_does() {
    let twin: Value = serde_json::from_str(&std::fs::read_to_string(fixture("long.json")).unwrap()).unwrap();
    let longest = twin["recordings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|recording| recording["length"].as_u64().unwrap())
        .max();
    let rule = format!("pad:{}", longest.unwrap());
    let options = ReadOptions { length: Some(rule.parse().unwrap()), ..ReadOptions::default() };
    let data = load(&fixture("long.csv"), &options).unwrap();
    let rate = data.spec.rate.unwrap();
    assert!((rate / twin["rate"].as_f64().unwrap() - 1.0).abs() < 1e-5, "{rate}");
    assert_eq!(
        (data.groups.as_deref(), data.output_names().join(" ")),
        (Some(&[0, 1, 0][..]), "hard soft".into())
    );
    for (sample, recording) in data.x.outer_iter().zip(twin["recordings"].as_array().unwrap()) {
        let length = recording["length"].as_u64().unwrap() as usize;
        let values: Vec<f64> =
            recording["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
        for channel in 0..2 {
            for t in 0..length {
                let (got, want) = (f64::from(sample[[channel, t]]), values[channel * length + t]);
                assert!(
                    (got - want).abs() <= 1e-4 * want.abs().max(1.0),
                    "{recording} [{channel}, {t}]: {got} {want}"
                );
            }
        }
    }
    let how = &check(&fixture("long.csv")).unwrap().read_as[1];
    assert!(how.contains("irregular, 6.000 to 50.000 ms apart: linearly interpolated to"), "{how}");
}

#[test]
fn recordings_for_a_model_are_brought_to_its_rate() {
    // A straight line of 3 per second shows where each reading was taken; the model has seen 50 Hz.
    let at = |times: &[f64]| -> String {
        let row = |time: &f64| format!("x,{time},{},up\n", 3.0 * time);
        format!("recording,time,a,label\n{}", times.iter().map(row).collect::<String>())
    };
    let known = |text: &str| with(text, |path| recordings(path, &ReadOptions::default(), 2).unwrap().x);
    let for_model = |text: &str| {
        let options = ReadOptions { stamped: Some(50.0), ..ReadOptions::default() };
        with(text, |path| recordings(path, &options, 2).unwrap().x)
    };
    let line = |step: f32, count: usize| (0..count).map(|i| 3.0 * step * i as f32).collect::<Vec<f32>>();
    let close = |got: ndarray::ArrayD<f32>, want: Vec<f32>| {
        assert_eq!(got.shape(), [1, 1, want.len()]);
        assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() < 1e-5), "{got}");
    };
    let irregular = at(&[0.0, 0.01, 0.02, 0.045, 0.055, 0.065, 0.08]);
    close(known(&irregular), line(0.01, 9));
    close(for_model(&irregular), line(0.02, 5));
    // Regular ones of another rate, too; a clock that is a little off is left alone.
    close(for_model(&at(&[0.0, 0.01, 0.02, 0.03, 0.04])), line(0.02, 3));
    close(for_model(&at(&[0.0, 0.0201, 0.0402])), line(0.0201, 3));
    let message = with(&at(&[0.0, 1e6, 2e6]), |path| {
        let options = ReadOptions { stamped: Some(50.0), ..ReadOptions::default() };
        recordings(path, &options, 2).unwrap_err().to_string()
    });
    assert!(message.contains("at equal steps of 20.000 ms, those of the model, its 3 readings"), "{message}");
}

#[test]
fn a_row_of_taxels_has_the_shape_that_is_said() {
    let skin = "a,b,c,d,e,f,label\n1,2,3,4,5,6,up\n7,8,9,10,11,12,down\n";
    let image = read(skin, &table("shape=2x3"));
    assert_eq!((image.x.shape(), image.spec.layout), ([2, 2, 3].as_slice(), Layout::Image));
    assert_eq!(image.x.as_slice().unwrap()[6..], [7.0, 8.0, 9.0, 10.0, 11.0, 12.0]);
    let card = card(skin, &table("shape=2x3"));
    assert_eq!(card.read_as, ["a wide table: a row is a sample of 2 × 3 readings, labels by \"label\""]);
    // Taxels in another order, axes that the layout names.
    let turned = table("shape=1x3,column=c,column=b,column=a");
    assert_eq!(read(skin, &turned).x.as_slice().unwrap()[..3], [3.0, 2.0, 1.0]);
    let given = |text: &str, layout| ReadOptions { layout: Some(layout), ..table(text) };
    let colour = read(skin, &given("shape=3x1x2", Layout::Colour));
    assert_eq!((colour.x.shape(), colour.spec.layout), ([2, 3, 1, 2].as_slice(), Layout::Colour));
    assert_eq!(read(skin, &given("shape=2x3", Layout::Series)).spec.layout, Layout::Series);
    // Frames of a recording, one of them between those of another.
    let squeezes = "recording,t,a,b,c,d,label\nx,0,1,2,3,4,up\ny,0,-1,-2,-3,-4,down\nx,1,5,6,7,8,up\ny,1,-5,-6,-7,-8,down\n";
    let frames = read(squeezes, &table("shape=2x2"));
    assert_eq!((frames.x.shape(), frames.spec.layout), ([2, 2, 2, 2].as_slice(), Layout::Sequence));
    assert_eq!(frames.x.as_slice().unwrap()[..8], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert_eq!(frames.spec.rate, Some(1.0));
    // What a model of images knows of its table reads another one, columns by their names.
    let known = ReadOptions { table: image.spec.table.clone().unwrap(), ..ReadOptions::default() };
    let other_order = "f,e,d,c,b,a\n6,5,4,3,2,1\n";
    let reordered = with(other_order, |path| recordings(path, &known, 2).unwrap());
    assert_eq!(reordered.x.as_slice().unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    // What does not fit.
    let why = message(skin, &table("shape=2x4"));
    assert!(why.contains("has 6 channels in a row, and table.shape [2, 4] takes 8"), "{why}");
    let why = message(skin, &table("shape=1x1x2x3"));
    assert!(why.contains("is wide, whose rows have one to three axes"), "{why}");
    let why = message(squeezes, &table("shape=4"));
    assert!(why.contains("is long, whose rows have two axes"), "{why}");
    let huge = format!("shape={}x{}", usize::MAX, usize::MAX);
    assert!(message(skin, &table(&huge)).contains("takes"));
}

#[test]
fn what_is_said_beside_a_table_counts() {
    let folder = tempdir().unwrap();
    let facts = r#"{"classes": ["stable", "slip"], "unit": "counts", "full_scale": 4095}"#;
    files(folder.path(), &[("grasps.csv", WIDE), ("labels.json", facts)]);
    let path = folder.path().join("grasps.csv");
    let data = load(&path, &slipped("ignore=id")).unwrap();
    assert_eq!(
        (data.output_names().join(" "), data.strata().to_vec()),
        ("stable slip".into(), vec![0, 1, 0])
    );
    assert_eq!((data.spec.unit.as_deref(), data.spec.full_scale), (Some("counts"), Some(4095.0)));
    files(folder.path(), &[("labels.json", r#"{"classes": ["mug", "can"], "rate": 50}"#)]);
    let data = load(&path, &ReadOptions { y: Some("object".into()), ..table("ignore=id") }).unwrap();
    assert_eq!((data.output_names().join(" "), data.strata().to_vec()), ("mug can".into(), vec![1, 1, 0]));
    // Marks of samples to test on.
    let marked =
        WIDE.replace("id,", "held,").replace("7,", "train,").replace("8,", "test,").replace("9,", "test,");
    let data = read(&marked, &ReadOptions { test: Some("held".into()), ..slipped("wide") });
    assert_eq!(data.official, Some(vec![false, true, true]));
}

#[test]
fn a_table_without_labels_is_answered() {
    let unlabelled = "f1,f2\n1,2\n3,4\n";
    let read = with(unlabelled, |path| recordings(path, &ReadOptions::default(), 1).unwrap());
    assert_eq!((read.x.shape(), read.truth, read.origins[0].as_str()), ([2, 2].as_slice(), None, "line 2"));
    let long = with(LONG, |path| {
        recordings(path, &ReadOptions { length: Some("pad:3".parse().unwrap()), ..ReadOptions::default() }, 2)
            .unwrap()
    });
    assert_eq!((long.x.shape(), long.truth.unwrap()[1][0].as_str()), ([2, 2, 3].as_slice(), "down"));
    // Without a column that names recordings it is one of them.
    let one = with(unlabelled, |path| recordings(path, &ReadOptions::default(), 2).unwrap());
    assert_eq!(one.x.shape(), [1, 2, 2]);
}

#[test]
fn a_broken_table_is_refused_by_line_and_column() {
    let wide = |text: &str| message(text, &slipped("ignore=id"));
    let cell = |text: &str| wide(&WIDE.replace("6.5", text));
    assert_eq!(
        cell("x"),
        "grasps.csv: line 4, column f2: \"x\" is not a number; correct it, or name a column that is no channel with \
         table.ignore"
    );
    assert_eq!(cell(""), "grasps.csv: line 4, column f2: \"\" is empty; fill it in or leave its row out");
    assert_eq!(
        cell("\"6,5\""),
        "grasps.csv: line 4, column f2: \"6,5\" is not a number; write decimals with points"
    );
    assert_eq!(cell("6,5"), "grasps.csv: line 4 has 6 columns, line 1 has 5");
    assert!(cell("NaN").contains("line 4: value at [1] is NaN"), "{}", cell("NaN"));
    // The first cell of a channel, too.
    assert!(wide(&WIDE.replace("can,1", "can,?")).contains("line 2, column f1: \"?\" is not a number"));
    let held = "It has id, object, f1, f2, slipped";
    for (options, want) in [
        (ReadOptions::default(), format!("has no column \"label\"; name one with y. {held}")),
        (
            ReadOptions { y: Some("slip".into()), ..ReadOptions::default() },
            format!("has no column \"slip\"; name one with y. {held}"),
        ),
        (slipped("long"), format!("has no column \"recording\"; name one with table.recording. {held}")),
        (slipped("time=stamp"), format!("has no column \"stamp\"; name one with table.time. {held}")),
        (slipped("ignore=x"), format!("has no column \"x\"; name one with table.ignore. {held}")),
        (
            ReadOptions { group: Some("day".into()), ..slipped("wide") },
            format!("has no column \"day\"; name one with group. {held}"),
        ),
        (
            ReadOptions { x: Some("f1".into()), ..slipped("wide") },
            "x: does not apply to a table, whose channels are its other columns; leave it out".into(),
        ),
        (
            ReadOptions { group_block: Some(2), ..slipped("wide") },
            "group_block: needs a column to divide into blocks; name it with group = \"trial\"".into(),
        ),
        (
            ReadOptions { limits: Limits { max_samples: 2, ..Limits::default() }, ..slipped("wide") },
            "3 samples are more than the 2 allowed".into(),
        ),
    ] {
        let got = message(WIDE, &options);
        assert!(got.contains(&want), "{got}\n{want}");
    }
    assert!(
        wide("1,2,3\n4,5,6\n")
            .contains("its first line is all numbers; write the names of the columns there")
    );
    assert!(wide("a,a,slipped\n1,2,0\n").contains("two columns are named \"a\""));
    assert!(wide("id,slipped\n1,0\n").contains("has no column of numbers beside labels and groups"));
    assert!(wide("id,f,slipped\n").contains("has no column of numbers"));
    assert!(wide("id,f,slipped\n1,2,\n").contains("line 2, column slipped: \"\" is empty"));
}

#[test]
fn a_broken_long_table_names_recording_and_lines() {
    let long = |text: &str| message(text, &ReadOptions::default());
    assert!(long(&LONG.replace("x,20,4,40,up", "x,20,4,40,down")).contains(
        "lines 2 and 5 are both recording \"x\", but label is \"up\" and \"down\"; say one for all its rows"
    ));
    assert!(
        long(&LONG.replace("x,20", "x,5"))
            .contains("line 5: recording \"x\" has a time that goes back, from 10 to 5")
    );
    assert!(
        long(&LONG.replace("x,20", "x,noon")).contains("line 5, column time_ms: \"noon\" is no time stamp")
    );
    assert!(long(&LONG.replace("x,20", ",20")).contains("line 5, column recording: \"\" is empty"));
    assert!(
        long(&LONG.replace("recording", "take"))
            .contains("has a column \"time_ms\" but none that says which recording")
    );
    // A gap that no memory would hold.
    let far = "recording,time,a,label\nx,0,1,u\nx,0.001,1,u\nx,0.002,1,u\nx,1e15,2,u\ny,0,1,d\n";
    assert!(long(far).contains("most of them in gaps of up to 1.000e15 s"), "{}", long(far));
    for (first, last) in [("-1e308", "1e308"), ("0", "1e-310"), ("0", "1e300")] {
        let stamps = format!("recording,time,a,label\nx,{first},1,u\nx,{last},1,u\ny,0,1,d\n");
        assert!(long(&stamps).contains("its time stamps give no rate, being"), "{}", long(&stamps));
    }
    for wrong in ["tall", "form=long", "clock=h", "ignore=", "shape=0x3", "shape=4x"] {
        assert!(wrong.parse::<taxel_data::TableOptions>().is_err(), "{wrong}");
    }
}

proptest! {
    /// Whatever cells hold, there is a data set or a message.
    #[test]
    fn no_table_is_a_panic(
        cells in proptest::collection::vec("x|y|[0-9]{1,3}|-?1e[0-9]{1,3}|nan|inf|\"|;|\n|é|", 0..40),
        header in 0..4usize,
    ) {
        let header = ["recording,time,a,label", "a,label", "series_id,t_ns,a,label,group", "label"][header];
        let rows: Vec<String> = cells.chunks(header.split(',').count()).map(|row| row.join(",")).collect();
        with(&format!("{header}\n{}\n", rows.join("\n")), |path| {
            let options = ReadOptions { length: Some("resample:5".parse().unwrap()), ..ReadOptions::default() };
            let _ = load(path, &options);
            let _ = check(path);
            let _ = recordings(path, &options, 2);
            let _ = load(path, &ReadOptions { table: "shape=1x1".parse().unwrap(), ..options });
        });
    }
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn biotac_sp_grasps_are_one_table() {
    let root = PathBuf::from(std::env::var_os("TAXEL_DATA").unwrap()).join("biotacsp-bts3");
    let options =
        ReadOptions { y: Some("slipped".into()), group: Some("object".into()), ..ReadOptions::default() };
    let data = load(&root.join("biotac-palmdown-grasps.csv"), &options).unwrap();
    assert_eq!((data.x.shape(), data.class_counts()), ([1276, 72].as_slice(), vec![667, 609]));
    assert_eq!(data.groups.unwrap().into_iter().collect::<std::collections::HashSet<_>>().len(), 41);
    // The 24 electrodes of each finger as a colour of its own.
    let shaped = ReadOptions {
        layout: Some(Layout::Colour),
        table: "shape=3x6x4".parse().unwrap(),
        ..options.clone()
    };
    let colour = load(&root.join("biotac-palmdown-grasps.csv"), &shaped).unwrap();
    assert_eq!(colour.x.shape(), [1276, 3, 6, 4]);
    assert_eq!(colour.x.as_slice().unwrap(), data.x.as_slice().unwrap());
    let error = load(&root, &options).unwrap_err().to_string();
    assert!(error.ends_with("give one of biotac-palmdown-grasps.csv, biotac-palmside-grasps.csv"), "{error}");
}

#[test]
fn a_model_finds_its_columns_by_name() {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("a.csv", "b,a,label\n1,2,u\n3,4,d\n"), ("new.csv", "id,a,c,b\n7,20,0,10\n")]);
    let known = load(&folder.path().join("a.csv"), &ReadOptions::default()).unwrap().spec.table.unwrap();
    assert_eq!(known.key(), r#"table = { columns = ["b", "a"] }"#);
    let options = ReadOptions { table: known, ..ReadOptions::default() };
    let new = recordings(&folder.path().join("new.csv"), &options, 1).unwrap();
    assert_eq!(new.x.as_slice().unwrap(), [10.0, 20.0]);
    files(folder.path(), &[("less.csv", "a,c\n1,2\n")]);
    let message = recordings(&folder.path().join("less.csv"), &options, 1).unwrap_err().to_string();
    assert!(message.contains("has no column \"b\"; name one with table.columns"), "{message}");
    // A recording without names is read as before.
    files(folder.path(), &[("one.csv", "1,2\n3,4\n")]);
    assert_eq!(recordings(&folder.path().join("one.csv"), &options, 2).unwrap().x.shape(), [1, 2, 2]);
}

#[test]
fn a_limit_of_samples_allows_as_many() {
    let two = "recording,time_ms,a,label\nx,0,1,up\nx,10,2,up\ny,0,3,down\ny,10,4,down\n";
    let of =
        |max_samples| ReadOptions { limits: Limits { max_samples, ..Limits::default() }, ..table("long") };
    assert_eq!(read(two, &of(2)).len(), 2);
    assert!(message(two, &of(1)).contains("2 samples are more than the 1 allowed"));
}

#[test]
fn a_form_or_a_shape_makes_a_table_of_a_file_whatever_columns_are_named() {
    let text = "a,b,c\n1,2,3\n4,5,6\n";
    let shape = |option: &str, rank| {
        with(text, |path| recordings(path, &table(option), rank).unwrap().x.shape().to_vec())
    };
    assert_eq!(shape("column=a,column=b", 2), [1, 2, 2], "one recording");
    assert_eq!(shape("wide,column=a,column=b", 2), [2, 2], "a sample in each row");
    assert_eq!(shape("column=a,column=b,shape=1x2", 2), [2, 1, 2], "likewise");
}
