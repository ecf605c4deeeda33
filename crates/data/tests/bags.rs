//! Bags of ROS 2 in MCAP against what its reference library wrote; sound and broken.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::damaged;
use serde_json::Value;
use std::path::{Path, PathBuf};
use taxel_data::{Layout, ReadOptions, check, check_with, load, recordings};
use tempfile::{TempDir, tempdir};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// A folder of copies of fixtures.
fn with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempdir().unwrap();
    for (to, from) in files {
        let to = folder.path().join(to);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        if from.ends_with(".mcap") {
            std::fs::copy(fixture(from), to).unwrap();
        } else {
            std::fs::write(to, from).unwrap();
        }
    }
    folder
}

fn topics(names: &[&str]) -> ReadOptions {
    ReadOptions { topics: names.iter().map(ToString::to_string).collect(), ..ReadOptions::default() }
}

fn refused(path: &Path, options: &ReadOptions) -> String {
    let message = load(path, options).unwrap_err().to_string();
    message.replace(&format!("{}/", path.display()), "").replace(&path.display().to_string(), "FOLDER")
}

/// One bag read with `options` is what the twin says.
fn agrees(bag: &str, options: &ReadOptions, twin: &str) {
    let text = std::fs::read_to_string(fixture("bags.json")).unwrap();
    let twin = serde_json::from_str::<Value>(&text).unwrap()[twin].clone();
    let floats = |v: &Value| v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    let read = recordings(&fixture(bag), options, 2).unwrap();
    let shape: Vec<usize> = floats(&twin["shape"]).iter().map(|n| *n as usize).collect();
    assert_eq!(read.x.shape()[1..], shape, "{bag}");
    for (got, want) in read.x.iter().zip(floats(&twin["values"])) {
        assert!((f64::from(*got) - want).abs() < 1e-5 * want.abs().max(1.0), "{bag}: {got} for {want}");
    }
    assert_eq!((read.origins, read.truth), (vec![bag.to_string()], None));
}

#[test]
fn topics_agree_with_the_reference_library() {
    agrees("press.mcap", &topics(&["/tactile"]), "tactile");
    agrees("press.mcap", &topics(&["/ft"]), "wrench");
    agrees("press.mcap", &topics(&["/camera"]), "camera");
    agrees("press.mcap", &topics(&["/tactile.data", "/joint_states.effort"]), "joined");
    // The one topic of a bag need not be named; own types are read by their definition, all compressions alike.
    for bag in ["plain.mcap", "lz4.mcap", "text.mcap"] {
        agrees(bag, &ReadOptions::default(), "taxels");
    }
}

#[test]
fn bags_say_their_class_by_name_or_folder_and_the_card_how_they_were_taken() {
    let flat = with(&[
        ("cup_1.mcap", "plain.mcap"),
        ("cup_02.mcap", "lz4.mcap"),
        ("ball_1.mcap", "text.mcap"),
        (".x", ""),
    ]);
    let data = load(flat.path(), &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.output_names().join(" "), data.strata().to_vec().as_slice()),
        ("ball cup".into(), &[0, 1, 1][..])
    );
    assert_eq!(data.origins, ["ball_1.mcap", "cup_1.mcap", "cup_02.mcap"]);
    assert_eq!((data.spec.layout, data.spec.rate), (Layout::Series, Some(50.0)));
    assert_eq!(data.spec.topics, ["/taxels"], "a model will ask for it");
    let card = check(flat.path()).unwrap();
    assert_eq!(
        card.read_as,
        [
            "classes by the names of bags, as ball_1.mcap is of ball",
            "bags: /taxels (7 channels), messages by the time at which they were recorded",
            "time stamps give 50 Hz"
        ]
    );
    let truth = recordings(flat.path(), &ReadOptions::default(), 2).unwrap().truth.unwrap();
    assert_eq!(truth, [["ball"], ["cup"], ["cup"]]);

    let days: Vec<(String, &str)> = ["day1/cup_1", "day1/ball_1", "day2/cup_1", "day2/ball_1"]
        .iter()
        .map(|name| (format!("{name}.mcap"), "plain.mcap"))
        .collect();
    let days: Vec<(&str, &str)> = days.iter().map(|(name, from)| (name.as_str(), *from)).collect();
    let data = load(with(&days).path(), &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.output_names().join(" "), data.strata().to_vec(), data.groups),
        ("ball cup".into(), vec![0, 1, 0, 1], Some(vec![0, 0, 1, 1]))
    );
    // Folders that differ in name are the classes, whatever the bags are called.
    let classes = with(&[
        ("cup/left_1.mcap", "plain.mcap"),
        ("ball/left_1.mcap", "plain.mcap"),
        ("ball/right_1.mcap", "lz4.mcap"),
    ]);
    let data = load(classes.path(), &ReadOptions::default()).unwrap();
    assert_eq!((data.output_names().join(" "), data.strata().to_vec()), ("ball cup".into(), vec![0, 0, 1]));
}

#[test]
fn the_card_says_how_much_of_joined_topics_is_left_out() {
    let options = topics(&["/tactile.data", "/joint_states.effort"]);
    let root = with(&[("a_1.mcap", "press.mcap"), ("b_1.mcap", "press.mcap")]);
    let card = check_with(root.path(), &options).unwrap();
    let how = "to which the others are linearly interpolated, cut to the time that all topics share: 8 of 40 messages of \
               /tactile.data lie outside it";
    assert!(card.read_as[1].ends_with(how), "{:?}", card.read_as);
}

#[test]
fn bags_for_a_model_are_brought_to_its_rate() {
    let read = |stamped| {
        let options = ReadOptions { stamped, ..topics(&["/tactile"]) };
        recordings(&fixture("press.mcap"), &options, 2).unwrap().x.shape()[2]
    };
    let all = read(None) as f64;
    let half = read(Some(98.7 / 2.0)) as f64;
    assert!((half - all / 2.0).abs() <= 1.0, "{half} of {all}");
}

#[test]
fn rosbag2_folders_are_bags_and_a_table_cuts_them() {
    let root = with(&[
        ("soft_1/metadata.yaml", "rosbag2_bagfile_information:"),
        ("soft_1/soft_1_0.mcap", "plain.mcap"),
        ("stiff_1/metadata.yaml", "rosbag2_bagfile_information:"),
        ("stiff_1/stiff_1_0.mcap", "lz4.mcap"),
    ]);
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.output_names().join(" "), data.origins),
        ("soft stiff".into(), vec!["soft_1".into(), "stiff_1".into()])
    );
    let one = recordings(&root.path().join("soft_1"), &ReadOptions::default(), 2).unwrap();
    assert_eq!((one.origins, one.x.shape()), (vec!["soft_1".into()], &[1, 7, 7][..]));

    let table = "file,start,end,label,group\nlong.mcap,0,0.06,press,1\nlong.mcap,0.06,0.12,slip,2\nlong.mcap,0.0,0.04,press,2\n";
    let root = with(&[("labels.csv", table), ("long.mcap", "plain.mcap")]);
    let data =
        load(root.path(), &ReadOptions { length: Some("crop:2".parse().unwrap()), ..ReadOptions::default() })
            .unwrap();
    assert_eq!(data.origins, ["long.mcap[0..0.06 s]", "long.mcap[0.06..0.12 s]", "long.mcap[0..0.04 s]"]);
    assert_eq!(
        (data.x.shape(), data.strata().to_vec(), data.groups),
        (&[3, 7, 2][..], vec![0, 1, 0], Some(vec![0, 1, 1]))
    );
    assert_eq!(
        data.x.as_slice().unwrap()[14 + 4..14 + 6],
        [900.0, 1200.0],
        "the second part begins with message 3"
    );
    for (rows, why) in [
        ("long.mcap,0,1,a,1\nlong.mcap,0,1,b,1\n", "labels.csv: lines 2 and 3 are both \"long.mcap\""),
        ("long.mcap,1,0,a,1\n", "labels.csv: line 2: end is not after start (1 to 0 s)"),
        ("long.mcap,0,x,a,1\n", "labels.csv: line 2: start and end are \"0 to x\", not two numbers"),
        ("long.mcap,5,6,a,1\n", "long.mcap: has no messages from 5 to 6 s after its first"),
    ] {
        let root = with(&[
            ("labels.csv", &format!("file,start,end,label,group\n{rows}")),
            ("long.mcap", "plain.mcap"),
        ]);
        assert!(
            refused(root.path(), &ReadOptions::default()).contains(why),
            "{}",
            refused(root.path(), &ReadOptions::default())
        );
    }
}

#[test]
fn images_are_shrunk_where_that_is_asked_for() {
    let options = ReadOptions { resize: Some([2, 3]), ..topics(&["/camera"]) };
    let read = recordings(&fixture("press.mcap"), &options, 3).unwrap();
    assert_eq!(read.x.shape()[2..], [2, 3]);
    let root = with(&[("a_1.mcap", "press.mcap"), ("b_1.mcap", "press.mcap")]);
    let card = check_with(root.path(), &options).unwrap();
    assert!(card.read_as[1].starts_with("bags: /camera (grey images of 2 × 3)"), "{:?}", card.read_as);
    assert_eq!(
        refused(root.path(), &ReadOptions { resize: Some([2, 3]), ..topics(&["/ft"]) }),
        "a_1.mcap: topic /ft holds no images, to which resize applies; leave it out"
    );
}

#[test]
fn what_is_not_clear_is_refused_with_what_the_bag_holds() {
    let root = with(&[("a_1.mcap", "press.mcap"), ("b_1.mcap", "press.mcap")]);
    let message = refused(root.path(), &ReadOptions::default());
    let wanted = "a_1.mcap: has several topics; name one or more with topics = [\"/tactile\"]. It has /tactile \
                  (std_msgs/msg/Float32MultiArray, 20 messages, 98.7 Hz)";
    assert!(message.starts_with(wanted), "{message}");
    assert!(message.contains("/rosout (rcl_interfaces/msg/Log, 1 message)"), "{message}");
    let message = refused(root.path(), &topics(&["/tactil"]));
    assert!(message.starts_with("a_1.mcap: has no messages of topic /tactil; it has "), "{message}");
    assert_eq!(refused(root.path(), &topics(&["/tactile.x"])), "a_1.mcap: topic /tactile.x holds no numbers");
    let message = refused(root.path(), &topics(&["/tactile", "/camera"]));
    assert!(message.contains("images are read alone, from one topic"), "{message}");

    let one = with(&[("press.mcap", "press.mcap"), ("press_2.mcap", "press.mcap")]);
    assert!(
        refused(one.path(), &topics(&["/ft"]))
            .starts_with("FOLDER: holds bags but no classes; name bags by class")
    );
    assert!(
        refused(&one.path().join("press.mcap"), &topics(&["/ft"]))
            .starts_with("FOLDER: is one bag, which says no class")
    );
    let tables = with(&[("a/1.csv", "1,2\n3,4\n"), ("b/1.csv", "1,2\n3,4\n")]);
    assert_eq!(
        refused(tables.path(), &topics(&["/ft"])),
        "FOLDER: topics: names topics of bags, of which there are none; leave it out"
    );
    let mixed = with(&[("a/1.csv", "1,2\n3,4\n"), ("b/1.mcap", "plain.mcap")]);
    assert!(
        refused(mixed.path(), &ReadOptions::default()).contains("b/1.mcap: is a bag, but a/1.csv"),
        "{}",
        refused(mixed.path(), &ReadOptions::default())
    );
}

#[test]
fn a_bag_that_is_damaged_anywhere_is_read_or_refused_by_name() {
    for name in ["press.mcap", "plain.mcap", "lz4.mcap", "text.mcap"] {
        let whole = std::fs::read(fixture(name)).unwrap();
        let folder = tempdir().unwrap();
        let path = folder.path().join(name);
        let options = if name == "press.mcap" { topics(&["/tactile"]) } else { ReadOptions::default() };
        for bytes in damaged(&whole, 53, 29) {
            std::fs::write(&path, &bytes).unwrap();
            let cut = bytes.len() < whole.len();
            match recordings(&path, &options, 2) {
                Ok(_) => assert!(!cut, "{name} of {} bytes", bytes.len()),
                Err(error) => assert!(error.to_string().contains(name), "{error}"),
            }
        }
    }
    let other = with(&[("a_1.mcap", "not a bag at all"), ("b_1.mcap", "")]);
    assert_eq!(
        refused(other.path(), &ReadOptions::default()),
        "a_1.mcap: is no MCAP file; record bags with ros2 bag record --storage mcap, or convert them"
    );
}
