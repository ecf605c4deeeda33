//! Facts about the readings travel from files and options into the data set.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, labels, npy, npz, refused, samples};
use image::RgbImage;
use taxel_data::{Dataset, Layout, ReadOptions, SampleSpec, Source, check, load};
use tempfile::tempdir;

fn read(path: &std::path::Path) -> Dataset {
    load(path, &ReadOptions::default()).unwrap()
}

#[test]
fn the_file_of_names_says_what_readings_are() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    let unknown = SampleSpec::new(Layout::Series, &[2, 3]);
    assert_eq!(read(&path).spec, unknown, "a guess and nothing else");
    let text = r#"{"classes": ["a", "b"], "layout": "image", "unit": "kPa", "rate": 62.5, "full_scale": 34}"#;
    files(folder.path(), &[("labels.json", text)]);
    let spec = read(&path).spec;
    let known = SampleSpec {
        layout: Layout::Image,
        unit: Some("kPa".into()),
        rate: Some(62.5),
        full_scale: Some(34.0),
        ..unknown.clone()
    };
    assert_eq!(spec, known);
    let null = r#"{"classes": ["a", "b"], "layout": null, "unit": null, "rate": null, "source": null}"#;
    files(folder.path(), &[("grasps.classes.json", null)]);
    assert_eq!(read(&path).spec, unknown, "the nearer file counts, and null says nothing");
}

#[test]
fn options_override_the_file_and_the_file_the_format() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    files(folder.path(), &[("labels.json", r#"{"classes": ["a", "b"], "layout": "image", "rate": 50}"#)]);
    let options = ReadOptions { layout: Some(Layout::Series), rate: Some(100.0), ..ReadOptions::default() };
    let spec = load(&path, &options).unwrap().spec;
    assert_eq!((spec.layout, spec.rate), (Layout::Series, Some(100.0)));

    let csv = tempdir().unwrap();
    files(csv.path(), &[("a/1.csv", "1,2\n3,4\n"), ("b/1.csv", "5,6\n7,8\n")]);
    assert_eq!(read(csv.path()).spec.layout, Layout::Series);
    let image = ReadOptions { layout: Some(Layout::Image), ..ReadOptions::default() };
    assert_eq!(load(csv.path(), &image).unwrap().spec.layout, Layout::Image);
}

#[test]
fn a_rate_against_the_time_stamps_is_refused() {
    let recording = |step: usize| {
        let rows = (0..5).map(|i| format!("{},{}\n", i * step, i % 3));
        format!("time_ms,thumb\n{}", rows.collect::<String>())
    };
    let folder = tempdir().unwrap();
    let facts = |rate: f64| format!(r#"{{"rate": {rate}}}"#);
    let [one, other] = [recording(10), recording(10)];
    files(folder.path(), &[("a/1.csv", &one), ("b/1.csv", &other), ("labels.json", &facts(101.0))]);
    assert_eq!(read(folder.path()).spec.rate, Some(101.0), "a clock is no better");
    files(folder.path(), &[("labels.json", &facts(50.0))]);
    let error = refused(folder.path(), &ReadOptions::default());
    for word in ["labels.json", "rate = 50", "100 Hz", "--rate"] {
        assert!(error.contains(word), "{word}: {error}");
    }
    let said = ReadOptions { rate: Some(100.0), ..ReadOptions::default() };
    let spec = load(folder.path(), &said).unwrap().spec;
    assert_eq!((spec.rate, spec.overruled), (Some(100.0), vec!["rate".to_string()]));

    let table = tempdir().unwrap();
    let rows = |id: usize| (0..4).map(move |i| format!("{id},{},{},{id}\n", 10 * i, i + id));
    let text = format!("recording,time_ms,thumb,label\n{}", rows(0).chain(rows(1)).collect::<String>());
    files(table.path(), &[("grasps.csv", &text), ("labels.json", &facts(1000.0))]);
    let error = refused(&table.path().join("grasps.csv"), &ReadOptions::default());
    assert!(error.contains("rate = 1000") && error.contains("100 Hz"), "{error}");
}

#[test]
fn a_layout_is_guessed_from_rank_and_type_alone() {
    let folder = tempdir().unwrap();
    let y = || ("y", i64s(&[2], &[0, 1]));
    let cases: [(&[u64], Layout, Layout); 3] = [
        (&[2, 6], Layout::Features, Layout::Features),
        (&[2, 2, 3], Layout::Series, Layout::Image),
        (&[2, 3, 2, 1], Layout::Sequence, Layout::Sequence),
    ];
    for (shape, of_floats, of_bytes) in cases {
        let values: Vec<u8> = (0..12).collect();
        let floats: Vec<f32> = values.iter().map(|v| f32::from(*v)).collect();
        let layout = |x| read(&npz(folder.path(), &[("x", x), y()])).spec.layout;
        assert_eq!(layout(f32s(shape, &floats)), of_floats, "{shape:?}");
        assert_eq!(layout(npy("|u1", false, shape, &values)), of_bytes, "{shape:?}");
    }
}

#[test]
fn an_image_of_which_planes_are_left_out_is_no_colour_image() {
    let folder = tempdir().unwrap();
    for (class, value) in [("a", 10), ("b", 200)] {
        std::fs::create_dir(folder.path().join(class)).unwrap();
        let image = RgbImage::from_fn(4, 2, |x, y| image::Rgb([value, x as u8, y as u8]));
        image.save(folder.path().join(class).join("1.png")).unwrap();
    }
    let whole = SampleSpec { depth: Some(8), ..SampleSpec::new(Layout::Colour, &[3, 2, 4]) };
    assert_eq!(read(folder.path()).spec, whole);
    let red = ReadOptions { channels: Some(vec![0]), ..ReadOptions::default() };
    let spec = load(folder.path(), &red).unwrap().spec;
    let left = SampleSpec::new(Layout::Sequence, &[1, 2, 4]);
    let kept = SampleSpec { channels: Some(vec![0]), depth: Some(8), ..left };
    assert_eq!(spec, kept);
    let colour = ReadOptions { layout: Some(Layout::Colour), ..red };
    let message = load(folder.path(), &colour).unwrap_err().to_string();
    let end = ": layout is colour, but a sample of shape [1, 2, 4] is not a colour image [3, H, W]";
    assert!(message.ends_with(end), "{message}");
}

#[test]
fn a_wrong_fact_is_refused_by_file_and_key() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    let none = "none of features, series, image, colour, sequence, fingers";
    let cases = [
        (r#""layout": "strip""#, format!("layout is \"strip\", {none}")),
        (r#""layout": 2"#, format!("layout is 2, {none}")),
        (r#""unit": 5"#, "unit is 5, not a text".into()),
        (r#""rate": "fast""#, "rate is \"fast\", not a number above 0".into()),
        (r#""rate": 0"#, "rate is 0, not a number above 0".into()),
        (r#""full_scale": 1e300"#, "full_scale is 1e+300, not a number above 0".into()),
        (r#""source": ["glove"]"#, "source is [\"glove\"], not a text".into()),
        (
            r#""layout": "colour""#,
            "layout is colour, but a sample of shape [2, 3] is not a colour image [3, H, W]".into(),
        ),
    ];
    for (fact, why) in cases {
        files(folder.path(), &[("labels.json", &format!(r#"{{"classes": ["a", "b"], {fact}}}"#))]);
        assert_eq!(refused(&path, &ReadOptions::default()), format!("labels.json: {why}"));
    }
    std::fs::remove_file(folder.path().join("labels.json")).unwrap();
    let options = ReadOptions { layout: Some(Layout::Sequence), ..ReadOptions::default() };
    assert_eq!(
        refused(&path, &options),
        "grasps.npz: layout is sequence, but a sample of shape [2, 3] is not a sequence of images [T, H, W]"
    );
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = ReadOptions { rate: Some(rate), ..ReadOptions::default() };
        let why = "rate: is in readings per second (Hz), above 0";
        assert_eq!(refused(&path, &options), format!("grasps.npz: {why}"));
    }
}

#[test]
fn a_saved_scene_is_still_simulated_and_everything_else_is_real() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    assert_eq!(read(&path).source, Source::real("grasps"));
    let cases = [
        ("simulated: fingertip without noise", "simulated: fingertip without noise (grasps)"),
        ("real: glove", "real: grasps"),
        ("the glove of 2019", "real: grasps"),
    ];
    for (word, source) in cases {
        files(
            folder.path(),
            &[("labels.json", &format!(r#"{{"classes": ["a", "b"], "source": "{word}"}}"#))],
        );
        assert_eq!(read(&path).source.to_string(), source);
    }
}

#[test]
fn a_source_is_written_and_read_as_one_text() {
    for source in [Source::real("glove"), Source::simulated("fingertip without noise (a: b)")] {
        let json = serde_json::to_string(&source).unwrap();
        assert_eq!(json, format!("\"{source}\""));
        assert_eq!(serde_json::from_str::<Source>(&json).unwrap(), source);
        assert_eq!(source.is_simulated(), json.starts_with("\"simulated: "));
    }
    let error = serde_json::from_str::<Source>("\"measured: glove\"").unwrap_err().to_string();
    let why = "source = \"measured: glove\": is neither \"simulated: NAME\" nor \"real: NAME\"";
    assert!(error.starts_with(why), "{error}");
}

#[test]
fn a_reading_is_written_without_what_nobody_said() {
    let bare = SampleSpec::new(Layout::Sequence, &[10, 14, 25]);
    let json = r#"{"layout":"sequence","shape":[10,14,25]}"#;
    assert_eq!(serde_json::to_string(&bare).unwrap(), json);
    assert_eq!(serde_json::from_str::<SampleSpec>(json).unwrap(), bare);
    let full = SampleSpec {
        unit: Some("N".into()),
        rate: Some(100.0),
        full_scale: Some(20.0),
        rest: Some(vec![0.5, 0.25]),
        ..bare
    };
    let json = serde_json::to_string(&full).unwrap();
    assert_eq!(serde_json::from_str::<SampleSpec>(&json).unwrap(), full);
    assert!(serde_json::from_str::<SampleSpec>(r#"{"layout":"image","shape":[2,2],"hz":3}"#).is_err());
}

#[test]
fn a_full_scale_far_below_the_samples_is_refused() {
    let folder = tempdir().unwrap();
    let of = |values: &[f32], full_scale: f32| {
        let path = npz(folder.path(), &[("x", f32s(&[4, 1, 500], values)), ("y", i64s(&[4], &[0, 1, 0, 1]))]);
        files(
            folder.path(),
            &[("labels.json", &format!(r#"{{"classes": ["a", "b"], "full_scale": {full_scale}}}"#))],
        );
        load(&path, &ReadOptions::default())
            .map(|data| data.spec.full_scale)
            .map_err(|error| error.to_string())
    };
    let count = |at: usize| (at % 1000) as f32;
    let counts: Vec<f32> = (0..2000).map(count).collect();
    let message = of(&counts, 1.0).unwrap_err();
    assert!(
        message.contains(
            "labels.json: full_scale is 1, values reach 999, 99.8 % of those that are not 0 above 2"
        )
    );
    assert_eq!(of(&counts, 500.0), Ok(Some(500.0)), "an overshoot");
    let pulls: Vec<f32> = counts.iter().map(|value| -value).collect();
    assert!(of(&pulls, 1.0).unwrap_err().contains("values reach 999, 99.8 %"));
    // A skin of which little is touched is scaled wrongly as well; a damaged reading is none of the sensor.
    let touched: Vec<f32> = (0..2000).map(|at| if at % 100 == 0 { 50.0 } else { 0.0 }).collect();
    assert!(of(&touched, 1.0).unwrap_err().contains("values reach 50, 100.0 %"));
    let damaged: Vec<f32> = (0..2000).map(|at| if at == 7 { 1e9 } else { count(at) + 1.0 }).collect();
    assert_eq!(of(&damaged, 1023.0), Ok(Some(1023.0)));
    let broken: Vec<f32> = (0..2000).map(|at| if at < 5 { f32::INFINITY } else { count(at) }).collect();
    assert!(of(&broken, 1023.0).is_err());
    let problems = check(&folder.path().join("grasps.npz")).unwrap().problems.join("\n");
    assert!(problems.contains("inf") && !problems.contains("full_scale"), "{problems}");
}
