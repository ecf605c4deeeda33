//! Messages of bags: keys of JSON, names of channels, repeated stamps, compressed images, colours.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod writers;

use image::{DynamicImage, ImageFormat, Luma, Rgb};
use std::io::Cursor;
use std::path::Path;
use taxel_data::{Layout, ReadOptions, check, check_with, load, recordings};
use tempfile::{TempDir, tempdir};
use writers::{Cdr, Definition, bag, refused};

type Messages = Vec<(u64, Vec<u8>)>;

/// Bags of two classes, two of each.
fn set(definition: Option<Definition>, messages: impl Fn(usize) -> Messages) -> TempDir {
    let folder = tempdir().unwrap();
    for (at, name) in ["cup_1", "cup_2", "egg_1", "egg_2"].iter().enumerate() {
        bag(&folder.path().join(format!("{name}.mcap")), "/skin", definition, &messages(at));
    }
    folder
}

fn json(texts: &[String]) -> Messages {
    (0..).step_by(10).zip(texts.iter().map(|text| text.clone().into_bytes())).collect()
}

#[test]
fn json_messages_are_read_by_key() {
    let text = |at: usize, t: usize| {
        let (a, b) = (format!("\"left\": [{t}, 5]"), format!("\"right\": {{\"force\": {}}}", 100 + t));
        if (at + t).is_multiple_of(2) { format!("{{{a}, {b}}}") } else { format!("{{{b}, {a}}}") }
    };
    let root = set(None, |at| json(&(0..6).map(|t| text(at, t)).collect::<Vec<_>>()));
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.x.shape(), [4, 3, 6]);
    assert_eq!(data.spec.channel_names, ["left[0]", "left[1]", "right.force"]);
    for sample in 0..4 {
        for t in 0..6 {
            let got = [data.x[[sample, 0, t]], data.x[[sample, 1, t]], data.x[[sample, 2, t]]];
            assert_eq!(got, [t as f32, 5.0, 100.0 + t as f32], "bag {sample}, message {t}");
        }
    }
    // The order of a model counts, not that of the bag.
    let names = ["right.force", "left[0]", "left[1]"].map(String::from).to_vec();
    let options = ReadOptions { channel_names: names, ..ReadOptions::default() };
    let one = recordings(&root.path().join("cup_2.mcap"), &options, 2).unwrap();
    assert_eq!((one.x[[0, 0, 2]], one.x[[0, 1, 2]]), (102.0, 2.0));
    assert_eq!(one.facts.channel_names, ["right.force", "left[0]", "left[1]"], "as the bag has them");
}

#[test]
fn time_and_indices_in_messages_are_no_channels() {
    let text = |at: usize, t: usize| {
        let running = 6 * at + t;
        format!(
            "{{\"seq\": {running}, \"about\": {{\"time\": {running}.5, \"id\": 7}}, \"index\": {}, \"a\": {t}}}",
            9 - t
        )
    };
    let root = set(None, |at| json(&(0..6).map(|t| text(at, t)).collect::<Vec<_>>()));
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.spec.channel_names, ["index", "a"], "a finger does not count");
    assert_eq!((data.x[[1, 0, 2]], data.x[[1, 1, 2]]), (7.0, 2.0));
    let ignored = check(root.path()).unwrap().ignored.join("; ");
    assert_eq!(
        ignored,
        "seq of topic /skin (an index); about.time of topic /skin (time); about.id of topic /skin (an index)"
    );
    // Who names a field means it; a model reads what it was trained on.
    let seq = ReadOptions { topics: vec!["/skin.seq".into()], ..ReadOptions::default() };
    assert_eq!(load(root.path(), &seq).unwrap().x[[1, 0, 0]], 6.0);
    let model = ReadOptions { channel_names: vec!["a".into(), "seq".into()], ..ReadOptions::default() };
    let one = recordings(&root.path().join("egg_1.mcap"), &model, 2).unwrap();
    assert_eq!((one.x[[0, 0, 1]], one.x[[0, 1, 1]]), (1.0, 13.0));
    let alone = set(None, |_| json(&(0..6).map(|t| format!("{{\"seq\": {t}}}")).collect::<Vec<_>>()));
    let message = refused(alone.path(), &ReadOptions::default());
    assert!(message.contains("topic /skin holds no channel: seq of topic /skin (an index)"), "{message}");
}

#[test]
fn keys_that_are_missing_new_or_doubled_are_named() {
    for (odd, wanted) in [
        ("{\"a\": 1}", "message 2 has no number \"b\""),
        ("{\"a\": 1, \"b\": \"x\"}", "message 2 has no number \"b\""),
        ("{\"a\": 1, \"b\": 2, \"c\": 3}", "message 2 has \"c\""),
        ("{\"a\": 1, \"a\": 2, \"b\": 2}", "message 2 has \"a\" twice"),
        ("{\"a\": 1, \"b\": [2, 3]}", "message 2 has no number \"b\""),
    ] {
        let all = |at: usize| {
            let mut texts = vec!["{\"a\": 1, \"b\": 2}".to_string(); 4];
            if at == 2 {
                texts[2] = odd.into();
            }
            json(&texts)
        };
        let message = refused(set(None, all).path(), &ReadOptions::default());
        assert!(message.starts_with("egg_1.mcap: topic /skin: ") && message.contains(wanted), "{message}");
    }
    // Another bag has other keys.
    let keys = |at: usize| vec![format!("{{\"a\": 1, \"{}\": 2}}", if at == 3 { "z" } else { "b" }); 3];
    let message = refused(set(None, |at| json(&keys(at))).path(), &ReadOptions::default());
    assert!(message.starts_with("egg_2.mcap: has no channel \"b\""), "{message}");
}

const PRESS: Definition = (
    "own/msg/Press",
    "Pair[2] forces\nfloat64 heat\nuint8[] bits\n===\nMSG: own/Pair\nfloat64 x\nfloat64 y\n",
);

#[test]
fn channels_of_messages_have_the_names_of_their_fields() {
    let message = |t: usize| {
        let cdr = (0..5).fold(Cdr::default(), |cdr, i| cdr.f64((10 * t + i) as f64));
        (10 * t as u64, cdr.bytes(&[1, 2]).finish())
    };
    let root = set(Some(PRESS), |_| (0..5).map(message).collect());
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    let names = ["forces[0].x", "forces[0].y", "forces[1].x", "forces[1].y", "heat", "bits[0]", "bits[1]"];
    assert_eq!(data.spec.channel_names, names);
    let options =
        ReadOptions { topics: vec!["/skin.heat".into(), "/skin.forces".into()], ..ReadOptions::default() };
    let two = load(root.path(), &options).unwrap();
    assert_eq!(two.spec.channel_names[..2], ["/skin.heat", "/skin.forces[0].x"]);
}

const JOINTS: Definition = (
    "sensor_msgs/msg/JointState",
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n===\n\
     MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
     MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
);

#[test]
fn joints_are_read_by_their_names() {
    let message = |t: u64| {
        let (names, values) = if t.is_multiple_of(2) {
            (["elbow", "wrist"], [1.0, 2.0])
        } else {
            (["wrist", "elbow"], [2.0, 1.0])
        };
        let cdr = Cdr::default().header().word(2).text(names[0]).text(names[1]).word(2);
        let cdr = values.iter().fold(cdr, |cdr, value| cdr.f64(*value));
        (10 * t, cdr.word(0).word(0).finish())
    };
    let root = set(Some(JOINTS), |_| (0..6).map(message).collect());
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.spec.channel_names, ["position.elbow", "position.wrist"]);
    assert!(data.x.as_slice().unwrap()[..12] == [[1.0; 6], [2.0; 6]].concat(), "{:?}", data.x);
    let text = |t: usize| match t % 2 {
        0 => r#"{"name": ["elbow", "wrist"], "position": [1, 2]}"#.to_string(),
        _ => r#"{"position": [2, 1], "name": ["wrist", "elbow"]}"#.to_string(),
    };
    let root = set(None, |_| json(&(0..6).map(text).collect::<Vec<_>>()));
    for topics in [vec![], vec!["/skin.position".to_string()]] {
        let data = load(root.path(), &ReadOptions { topics, ..ReadOptions::default() }).unwrap();
        assert_eq!(data.spec.channel_names, ["position.elbow", "position.wrist"]);
        assert!(data.x.as_slice().unwrap()[..12] == [[1.0; 6], [2.0; 6]].concat(), "{:?}", data.x);
    }
}

#[test]
fn one_repeated_stamp_is_dropped_and_counted() {
    let at = |t: usize| if t > 20 { t - 1 } else { t };
    let messages = |_| (0..40).map(|t| (10 * at(t) as u64, format!("{{\"a\": {t}}}").into_bytes())).collect();
    let root = set(None, messages);
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.spec.rate), (&[4, 1, 39][..], Some(100.0)));
    assert_eq!((data.x[[0, 0, 20]], data.x[[0, 0, 21]]), (20.0, 22.0), "the first is kept");
    let read_as = check(root.path()).unwrap().read_as.join("; ");
    assert!(read_as.contains("4 of 160 time steps repeat"), "{read_as}");
    let all = |_| (0..40).map(|t| (10 * (t / 2), b"{\"a\": 1}".to_vec())).collect();
    let message = refused(set(None, all).path(), &ReadOptions::default());
    assert!(message.starts_with("cup_1.mcap: ") && message.contains("20 of the 40 time steps"), "{message}");
}

const COMPRESSED: Definition = (
    "sensor_msgs/msg/CompressedImage",
    "std_msgs/Header header\nstring format\nuint8[] data\n===\nMSG: std_msgs/Header\n\
     builtin_interfaces/Time stamp\nstring frame_id\n===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
);

fn encoded(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(vec![]);
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn compressed(image: &DynamicImage) -> Vec<u8> {
    Cdr::default().header().text("png").bytes(&encoded(image)).finish()
}

fn grey(t: u64) -> DynamicImage {
    DynamicImage::ImageLuma8(image::ImageBuffer::from_fn(3, 2, |x, y| {
        Luma([(10 * t + 3 * u64::from(y) + u64::from(x)) as u8])
    }))
}

fn red() -> DynamicImage {
    DynamicImage::ImageRgb8(image::ImageBuffer::from_fn(3, 2, |x, _| Rgb([200, 10 * x as u8, 30])))
}

#[test]
fn compressed_images_are_decoded() {
    let root = set(Some(COMPRESSED), |_| (0..5).map(|t| (10 * t, compressed(&grey(t)))).collect());
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.spec.layout), (&[4, 5, 2, 3][..], Layout::Sequence));
    assert_eq!((data.x[[0, 4, 1, 2]], data.spec.depth), (45.0, Some(8)));
    let small = ReadOptions { resize: Some([1, 3]), ..ReadOptions::default() };
    assert_eq!(load(root.path(), &small).unwrap().x.shape(), [4, 5, 1, 3]);
    let broken =
        set(Some(COMPRESSED), |_| vec![(0, Cdr::default().header().text("png").bytes(b"no image").finish())]);
    let message = refused(broken.path(), &ReadOptions::default());
    assert!(
        message.starts_with("cup_1.mcap: topic /skin: message 0 is not readable as PNG or JPEG"),
        "{message}"
    );
}

#[test]
fn colours_of_single_frames_are_kept() {
    for definition in [COMPRESSED, RAW] {
        let one = |_| vec![(0, if definition == RAW { raw() } else { compressed(&red()) })];
        let data = load(set(Some(definition), one).path(), &ReadOptions::default()).unwrap();
        assert_eq!((data.x.shape(), data.spec.layout), (&[4, 3, 2, 3][..], Layout::Colour));
        assert_eq!((data.x[[0, 0, 1, 2]], data.x[[0, 1, 1, 2]], data.x[[0, 2, 0, 0]]), (200.0, 20.0, 30.0));
    }
}

const RAW: Definition = (
    "sensor_msgs/msg/Image",
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n\
     ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
     MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
);

/// The red picture as blue, green, red.
fn raw() -> Vec<u8> {
    let rows: Vec<u8> = red().to_rgb8().pixels().flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect();
    let cdr = Cdr::default().header().word(2).word(3).text("bgr8").byte(0).word(9);
    cdr.bytes(&rows).finish()
}

#[test]
fn colours_over_time_are_grey_or_frames_as_the_layout_says() {
    let root = set(Some(RAW), |_| (0..4).map(|t| (10 * t, raw())).collect());
    let message = refused(root.path(), &ReadOptions::default());
    assert!(
        message.contains("layout = \"sequence\"") && message.contains("layout = \"colour\""),
        "{message}"
    );
    let of = |layout| ReadOptions { layout: Some(layout), ..ReadOptions::default() };
    let grey = load(root.path(), &of(Layout::Sequence)).unwrap();
    assert_eq!(grey.x.shape(), [4, 4, 2, 3]);
    let said = check_with(root.path(), &of(Layout::Sequence)).unwrap().read_as.join("; ");
    assert!(said.contains("colours as grey"), "{said}");
    std::fs::write(root.path().join("labels.json"), r#"{"layout": "colour"}"#).unwrap();
    assert_eq!(load(root.path(), &ReadOptions::default()).unwrap().x.shape(), [16, 3, 2, 3]);
    let frames = load(root.path(), &of(Layout::Colour)).unwrap();
    assert_eq!((frames.x.shape(), frames.spec.layout), (&[16, 3, 2, 3][..], Layout::Colour));
    assert_eq!(frames.groups.unwrap()[3..5], [0, 1], "frames of one bag stay together");
    assert_eq!(frames.origins[5], "cup_2.mcap[1]");
}

#[test]
fn f64_with_an_offset_that_f32_cannot_hold_is_refused() {
    let message = |t: usize| {
        let cdr = (0..4).fold(Cdr::default(), |cdr, i| cdr.f64(1e9 + (i + t) as f64 / 100.0));
        (10 * t as u64, cdr.f64(20.0 + t as f64).bytes(&[1, 2]).finish())
    };
    let root = set(Some(PRESS), |_| (0..9).map(message).collect());
    let message = refused(root.path(), &ReadOptions::default());
    assert!(
        message.starts_with("cup_1.mcap: ") && message.contains("forces[0].x") && message.contains("offset"),
        "{message}"
    );
    let heat = ReadOptions { topics: vec!["/skin.heat".into()], ..ReadOptions::default() };
    load(root.path(), &heat).unwrap();
}

#[test]
fn other_files_of_recorders_say_how_to_convert_them() {
    let folder = tempdir().unwrap();
    for (name, command) in [
        ("a.mcap.zstd", "zstd -d"),
        ("a.mcap.zst", "zstd -d"),
        ("a.bag", "rosbags-convert"),
        ("a.db3", "mcap convert"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, "x").unwrap();
        let alone = load(&path, &ReadOptions::default()).unwrap_err().to_string();
        let one = recordings(&path, &ReadOptions::default(), 2).unwrap_err().to_string();
        let set = folder.path().join(format!("set-{name}"));
        for class in ["cup", "egg"] {
            std::fs::create_dir_all(set.join(class)).unwrap();
            std::fs::write(set.join(class).join(name), "x").unwrap();
        }
        let flat = folder.path().join(format!("flat-{name}"));
        std::fs::create_dir_all(&flat).unwrap();
        std::fs::write(flat.join(format!("cup_1{}", &name[1..])), "x").unwrap();
        std::fs::write(flat.join(format!("egg_1{}", &name[1..])), "x").unwrap();
        let below = |path: &Path| load(path, &ReadOptions::default()).unwrap_err().to_string();
        for message in [alone, one, below(&set), below(&flat)] {
            assert!(message.contains(command), "{name}: {message}");
        }
    }
    // The folder of a recorder of ROS 2 that wrote SQLite.
    let recorded = folder.path().join("recorded");
    std::fs::create_dir_all(&recorded).unwrap();
    std::fs::write(recorded.join("metadata.yaml"), "rosbag2_bagfile_information:").unwrap();
    std::fs::write(recorded.join("recorded_0.db3"), "x").unwrap();
    let message = load(&recorded, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("ros2 bag convert"), "{message}");
}
