//! Sound and broken folders with one sub-folder per class.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, npy};
use image::{DynamicImage, GrayImage, Luma, Rgb, RgbImage, RgbaImage};
use std::path::Path;
use taxel_data::{Layout, Limits, ReadOptions, check, load};
use tempfile::{TempDir, tempdir};

fn refused_with(root: &Path, options: &ReadOptions) -> String {
    let message = load(root, options).unwrap_err().to_string();
    message.replace(&format!("{}/", root.display()), "").replace(&root.display().to_string(), "FOLDER")
}

/// The message for a folder of text files.
fn refused(list: &[(&str, &str)]) -> String {
    let folder = tempdir().unwrap();
    files(folder.path(), list);
    refused_with(folder.path(), &ReadOptions::default())
}

fn png(root: &Path, name: &str, image: impl Into<DynamicImage>) {
    let path = root.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    image.into().save(path).unwrap();
}

fn grey(width: u32, height: u32, value: u8) -> GrayImage {
    GrayImage::from_fn(width, height, |x, y| Luma([value + (10 * y + x) as u8]))
}

fn csv_set() -> TempDir {
    let folder = tempdir().unwrap();
    files(
        folder.path(),
        &[
            ("pear/take10.csv", "1,2\n3,4\n5,6\n"),
            ("pear/take9.csv", "thumb,index\n7,8\n9,10\n11,12\n"),
            ("apple/a.csv", "0,0\n0,1\n0,0\n"),
            ("apple/.hidden", ""),
            (".git/x", ""),
            ("README.md", "notes"),
        ],
    );
    folder
}

#[test]
fn csv_files_are_channels_by_time() {
    let folder = csv_set();
    let data = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.x.shape(), [3, 2, 3]);
    assert_eq!(data.x.as_slice().unwrap()[6..], [7., 9., 11., 8., 10., 12., 1., 3., 5., 2., 4., 6.]);
    assert_eq!(
        (data.output_names(), data.strata().to_vec()),
        (vec!["apple".into(), "pear".into()], vec![0, 1, 1])
    );
    assert_eq!(data.origins, ["apple/a.csv", "pear/take9.csv", "pear/take10.csv"]);
    assert_eq!((data.spec.layout, data.dtype.as_str()), (Layout::Series, "csv"));
    let blocks = ReadOptions { group_block: Some(1), channels: Some(vec![1]), ..ReadOptions::default() };
    let data = load(folder.path(), &blocks).unwrap();
    assert_eq!((data.groups, data.group_name.as_deref()), (Some(vec![0, 0, 1]), Some("position/1")));
    assert_eq!(data.x.shape(), [3, 1, 3]);
}

#[test]
fn npy_files_are_taken_as_stored() {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("a/x.npy", ""), ("b/y.npy", "")]);
    std::fs::write(folder.path().join("a/x.npy"), f32s(&[2, 3], &[0., 1., 2., 3., 4., 5.])).unwrap();
    let write = |bytes: Vec<u8>| std::fs::write(folder.path().join("b/y.npy"), bytes).unwrap();
    write(f32s(&[2, 3], &[9.; 6]));
    let data = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.x[[0, 1, 0]]), ([2, 2, 3].as_slice(), 3.0));
    let message = || refused_with(folder.path(), &ReadOptions::default());
    write(f32s(&[3, 2], &[9.; 6]));
    assert_eq!(
        message(),
        "b/y.npy: has shape [3, 2], but a/x.npy has [2, 3]; all must be equal but for time"
    );
    write(f32s(&[6], &[9.; 6]));
    assert_eq!(message(), "b/y.npy: has shape [6]; one recording is [C, T], [H, W] or [T, H, W]");
    write(f32s(&[2, 0], &[]));
    assert!(message().starts_with("b/y.npy: has shape [2, 0]: axis 1 is empty"));
    write(npy("|u1", false, &[2, 3], &[1; 6]));
    assert_eq!(message(), "b/y.npy: is |u1, but a/x.npy is <f4; use one kind in a data set");
    write(f32s(&[2, 3], &[9.; 5]));
    assert!(message().starts_with("b/y.npy: data end after 20 of 24 bytes"));
    write(f32s(&[2, 3], &[9., 9., 9., 9., f32::INFINITY, 9.]));
    assert_eq!(message(), "b/y.npy: value at [1, 1] is inf; repair the recording or leave it out");
}

#[test]
fn images_are_planes_of_their_stored_values() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    png(root, "a/1.png", grey(4, 2, 0));
    png(root, "b/1.png", grey(4, 2, 100));
    let data = load(root, &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.spec.layout), ([2, 2, 4].as_slice(), Layout::Image));
    assert_eq!(data.x.as_slice().unwrap()[..8], [0., 1., 2., 3., 10., 11., 12., 13.]);
    assert_ne!(data.row_hash[0], data.row_hash[1]);
    let halved = ReadOptions { resize: Some([1, 2]), ..ReadOptions::default() };
    let small = load(root, &halved).unwrap();
    assert_eq!(small.x.shape(), [2, 1, 2]);
    // A triangle over the halved axis weighs 3:3:1 at the edge.
    let edge = |row: f32| (3. * row + 3. * (row + 1.) + row + 2.) / 7.;
    assert!((small.x[[0, 0, 0]] - (edge(0.) + edge(10.)) / 2.).abs() < 1e-4, "{}", small.x[[0, 0, 0]]);
    assert_ne!(small.row_hash, data.row_hash, "copies are sought in what is trained on");

    let rgb = RgbImage::from_fn(3, 2, |x, y| Rgb([x as u8, 50 + y as u8, 200]));
    png(root, "a/1.png", rgb.clone());
    png(root, "b/1.png", DynamicImage::ImageRgb8(rgb).to_rgba8());
    let data = load(root, &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.spec.layout), ([2, 3, 2, 3].as_slice(), Layout::Colour));
    let plane = data.x.as_slice().unwrap();
    assert_eq!(plane[..8], [0., 1., 2., 0., 1., 2., 50., 50.]);
    assert_eq!(plane[12..24], [[200.; 6], [0., 1., 2., 0., 1., 2.]].concat());
    assert_eq!(load(root, &halved).unwrap().x.shape(), [2, 3, 1, 2]);
}

#[test]
fn a_broken_image_is_refused() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    png(root, "a/1.png", grey(4, 2, 0));
    let message = || refused_with(root, &ReadOptions::default());
    let form = "set resize = [height, width], or use grey or colour throughout";
    png(root, "b/1.png", grey(2, 4, 0));
    assert_eq!(
        message(),
        format!("b/1.png: has shape [4, 2], but a/1.png has [2, 4]; all must be equal: {form}")
    );
    png(root, "b/1.png", RgbImage::new(4, 2));
    assert!(message().starts_with("b/1.png: has shape [3, 2, 4], but a/1.png has [2, 4]"));
    png(root, "b/1.png", image::ImageBuffer::<Luma<u16>, _>::new(4, 2));
    assert_eq!(message(), "b/1.png: is png/jpeg u16, but a/1.png is png/jpeg u8; use one kind in a data set");
    png(root, "b/1.png", RgbaImage::new(4, 2));
    assert_eq!(message(), "b/1.png: has transparent pixels; save it as grey or RGB");
    let whole = std::fs::read(root.join("a/1.png")).unwrap();
    for bytes in [&whole[..whole.len() / 2], b"not an image"] {
        std::fs::write(root.join("b/1.png"), bytes).unwrap();
        assert!(message().starts_with("b/1.png: is not readable as PNG or JPEG ("), "{}", message());
    }
    png(root, "b/1.png", grey(4, 2, 0));
    let limits = Limits { max_values: 15, ..Limits::default() };
    let message = refused_with(root, &ReadOptions { limits, ..ReadOptions::default() });
    assert!(message.starts_with("FOLDER: shape [2, 2, 4] is more than the 15 values allowed; shrink"));
    let limits = Limits { max_values: 7, ..Limits::default() };
    let message = refused_with(root, &ReadOptions { limits, ..ReadOptions::default() });
    assert!(message.starts_with("a/1.png: shape [1, 2, 4] is more than the 7 values allowed"), "{message}");
    for size in [[0, 2], [2, 1 << 40]] {
        let message = refused_with(root, &ReadOptions { resize: Some(size), ..ReadOptions::default() });
        assert_eq!(message, "FOLDER: resize: is [height, width] in pixels, each 1..16384");
    }
}

#[test]
fn a_large_image_is_refused_by_its_head() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    png(root, "a/1.png", GrayImage::new(40, 30));
    png(root, "b/1.png", GrayImage::new(40, 30));
    // Only the head of the first is whole: what follows is never looked at.
    let whole = std::fs::read(root.join("a/1.png")).unwrap();
    std::fs::write(root.join("a/1.png"), &whole[..60]).unwrap();
    let limits = Limits { max_pixels: 1199, ..Limits::default() };
    assert_eq!(
        refused_with(root, &ReadOptions { limits, ..ReadOptions::default() }),
        "a/1.png: is 30 × 40 pixels, more than the 1199 that one image may have; set resize = [height, width], \
         or raise limits.max_pixels"
    );
    let limits = Limits { max_values: 2399, ..Limits::default() };
    let message = refused_with(root, &ReadOptions { limits, ..ReadOptions::default() });
    assert!(
        message.starts_with("FOLDER: shape [2, 30, 40] is more than the 2399 values allowed"),
        "{message}"
    );
    std::fs::write(root.join("a/1.png"), whole).unwrap();
    let limits = Limits { max_pixels: 1199, ..Limits::default() };
    let small = load(root, &ReadOptions { resize: Some([3, 4]), limits, ..ReadOptions::default() }).unwrap();
    assert_eq!(small.x.shape(), [2, 3, 4]);
}

#[test]
fn a_head_that_so_few_bytes_cannot_hold_is_damaged() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    // As black as can be: what packs best is read.
    for name in ["a/1.png", "a/1.jpg"] {
        png(root, name, GrayImage::new(2000, 2000));
    }
    std::fs::rename(root.join("a/1.jpg"), root.join("1.jpg")).unwrap();
    png(root, "b/1.png", GrayImage::from_pixel(2000, 2000, Luma([255])));
    assert_eq!(load(root, &ReadOptions::default()).unwrap().x.shape(), [2, 2000, 2000]);
    std::fs::rename(root.join("1.jpg"), root.join("a/1.jpg")).unwrap();
    std::fs::remove_file(root.join("a/1.png")).unwrap();
    std::fs::remove_dir_all(root.join("b")).unwrap();
    png(root, "b/1.jpg", GrayImage::from_pixel(2000, 2000, Luma([255])));
    assert_eq!(load(root, &ReadOptions::default()).unwrap().x.shape(), [2, 2000, 2000]);

    png(root, "a/1.jpg", GrayImage::new(8, 8));
    let mut jpeg = std::fs::read(root.join("a/1.jpg")).unwrap();
    // Height and width follow the marker, a length and the bits of a value.
    let at = jpeg.windows(2).position(|pair| pair == [0xFF, 0xC0]).unwrap() + 5;
    jpeg[at..at + 4].copy_from_slice(&[0x0F, 0xA0, 0x0F, 0xA0]);
    std::fs::write(root.join("a/1.jpg"), &jpeg).unwrap();
    let damaged = |name: &str, bytes: usize| {
        format!(
            "{name}: is 4000 × 4000 pixels by its head, more than its {bytes} bytes can hold; it is damaged"
        )
    };
    assert_eq!(refused_with(root, &ReadOptions::default()), damaged("a/1.jpg", jpeg.len()));
    let small = ReadOptions { resize: Some([2, 2]), ..ReadOptions::default() };
    assert_eq!(refused_with(root, &small), damaged("a/1.jpg", jpeg.len()));

    std::fs::remove_dir_all(root.join("b")).unwrap();
    std::fs::remove_file(root.join("a/1.jpg")).unwrap();
    png(root, "a/1.png", GrayImage::new(8, 8));
    png(root, "b/1.png", GrayImage::new(8, 8));
    let mut whole = std::fs::read(root.join("a/1.png")).unwrap();
    whole[16..24].copy_from_slice(&[0, 0, 0x0F, 0xA0, 0, 0, 0x0F, 0xA0]);
    let sum = crc(&whole[12..29]);
    whole[29..33].copy_from_slice(&sum.to_be_bytes());
    std::fs::write(root.join("a/1.png"), &whole).unwrap();
    assert_eq!(refused_with(root, &ReadOptions::default()), damaged("a/1.png", whole.len()));
}

/// The checksum of a part of a PNG file.
fn crc(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 };
    !bytes.iter().fold(u32::MAX, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), step))
}

#[test]
fn resampled_values_are_those_of_a_copy_in_floats() {
    use image::imageops::{FilterType, resize};
    let folder = tempdir().unwrap();
    let root = folder.path();
    let bytes = |x: u32, y: u32, c: u32| ((x * 37 + y * 101 + c * 59) % 256) as u8;
    let rgb = RgbImage::from_fn(23, 17, |x, y| Rgb([bytes(x, y, 0), bytes(x, y, 1), bytes(x, y, 2)]));
    png(root, "a/1.png", rgb.clone());
    png(root, "b/1.png", RgbImage::new(23, 17));
    for (height, width) in [(5, 7), (17, 23), (40, 30)] {
        let options = ReadOptions { resize: Some([height, width]), ..ReadOptions::default() };
        let data = load(root, &options).unwrap();
        let unit =
            image::ImageBuffer::from_fn(23, 17, |x, y| Rgb(rgb.get_pixel(x, y).0.map(|v| v as f32 / 255.)));
        let want = resize::<image::Rgb32FImage>(&unit, width as u32, height as u32, FilterType::Triangle);
        for (x, y, pixel) in want.enumerate_pixels() {
            for (colour, value) in pixel.0.iter().enumerate() {
                assert_eq!(data.x[[0, colour, y as usize, x as usize]], value * 255.0);
            }
        }
    }
}

#[test]
fn labels_json_speaks_of_folders_too() {
    let folder = csv_set();
    let facts = r#"{"unit": "N", "rate": 100, "classes": ["pear", "apple"]}"#;
    files(folder.path(), &[("labels.json", facts)]);
    let data = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!((data.spec.unit.as_deref(), data.spec.rate), (Some("N"), Some(100.0)));
    assert_eq!(
        (data.output_names().join(" "), data.strata().to_vec()),
        ("pear apple".to_string(), vec![0, 0, 1])
    );
    assert_eq!(data.origins[2], "apple/a.csv");
    files(folder.path(), &[("labels.json", r#"{"full_scale": 1023}"#)]);
    let data = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!((data.spec.full_scale, data.strata().to_vec()), (Some(1023.0), vec![0, 1, 1]));
    for wrong in [
        r#"["apple"]"#,
        r#"["apple", "fig"]"#,
        r#"["apple", "pear", "fig"]"#,
        r#"[["apple", "pear"], ["a"]]"#,
    ] {
        files(folder.path(), &[("labels.json", wrong)]);
        let message = refused_with(folder.path(), &ReadOptions::default());
        assert!(message.starts_with("labels.json: names the classes apple"), "{message}");
        assert!(message.contains("but they are apple, pear"), "{message}");
    }
}

#[test]
fn a_broken_layout_is_refused() {
    let one = ("a/1.csv", "1,2\n");
    assert_eq!(refused(&[]), "FOLDER: holds neither data.npz nor class folders");
    assert_eq!(
        refused(&[("z.npz", ""), ("y.npz", ""), ("notes.txt", "")]),
        "FOLDER: holds neither data.npz nor class folders; give one of y.npz, z.npz"
    );
    assert_eq!(refused(&[one, ("b/.keep", "")]), "b: class folder holds no files; fill or remove it");
    assert_eq!(
        refused(&[("a/session1/more/1.csv", "1\n")]),
        "a/session1/more: a folder where recordings are expected; recordings lie in class/file or in \
         class/session/file"
    );
    let message = refused(&[one, ("b/notes.txt", "x")]);
    assert!(message.starts_with("b/notes.txt: unknown kind of recording; use .csv, .npy, "), "{message}");
    for ending in [".mat", ".h5", ".hdf5", ".mcap", ".png", ".jpg or .jpeg"] {
        assert!(message.contains(ending), "{ending}: {message}");
    }
    assert!(!message.contains(".npz") && !message.contains(".parquet"), "{message}");
    assert_eq!(
        refused(&[one, ("b/1.png", "x")]),
        "b/1.png: is an image, but a/1.csv is CSV; use one kind in a data set"
    );
    assert_eq!(refused(&[one, ("b/1.csv", "")]), "b/1.csv: is empty (0 bytes); copy or record it again");
    assert_eq!(
        refused(&[one, ("b/1.csv", "1,2\n3,4\n"), ("c/1.csv", "1\n")]),
        "c/1.csv: has shape [1, 1], but a/1.csv has [2, 1]; all must be equal but for time (channels, time): use \
         the same channels throughout"
    );
    assert_eq!(refused(&[one, ("b/1.csv", "1,2\n3\n")]), "b/1.csv: line 2 has 1 columns, line 1 has 2");
    assert_eq!(refused(&[one, ("b/1.csv", "1,?\n")]), "b/1.csv: line 1, column 2: \"?\" is not a number");
    assert_eq!(
        refused(&[one, ("b/1.csv", "1,nan\n")]),
        "b/1.csv: value at [1, 0] is NaN; repair the recording or leave it out"
    );
}

#[test]
fn options_for_other_layouts_are_refused() {
    let folder = csv_set();
    let default = ReadOptions::default;
    let arrays = "names an array of a .npz; a folder per class has none (group_block divides the \
                  position of each file in its class folder)";
    let cases = [
        ("x", ReadOptions { x: Some("images".into()), ..default() }),
        ("y", ReadOptions { y: Some("labels".into()), ..default() }),
        ("group", ReadOptions { group: Some("session".into()), ..default() }),
    ];
    for (key, options) in cases {
        assert_eq!(refused_with(folder.path(), &options), format!("FOLDER: {key}: {arrays}"));
    }
    assert_eq!(
        refused_with(folder.path(), &ReadOptions { resize: Some([2, 2]), ..default() }),
        "FOLDER: resize: applies to PNG and JPEG files and to bags of images only; leave it out"
    );
    let limits = Limits { max_file_bytes: 11, ..Limits::default() };
    assert_eq!(
        refused_with(folder.path(), &ReadOptions { limits, ..default() }),
        "apple/a.csv: has 12 bytes, more than the 11 allowed; raise limits.max-file-bytes"
    );
}

#[test]
fn the_card_of_a_folder_names_files() {
    let folder = csv_set();
    files(folder.path(), &[("apple/b.csv", "4,4\n4,4\n4,4\n"), ("pear/z.csv", "4,4\n4,4\n4,4\n")]);
    let card = check(folder.path()).unwrap();
    assert_eq!(card.problems, [""; 0]);
    assert_eq!(card.constant_samples, [1, 4]);
    assert!(card.warnings[0].contains("apple/b.csv (apple) = pear/z.csv (pear)"), "{:?}", card.warnings);
}

#[test]
fn columns_are_matched_by_their_header() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    files(root, &[("a/0.csv", "thumb,index\n1,10\n2,20\n"), ("b/0.csv", "index,thumb\n30,3\n40,4\n")]);
    let data = load(root, &ReadOptions::default()).unwrap();
    assert_eq!(data.spec.channel_names, ["thumb", "index"]);
    assert_eq!(data.x.as_slice().unwrap(), [1., 2., 10., 20., 3., 4., 30., 40.]);
    // A column more is no column less: nothing is left out unseen.
    for (header, row) in [("index,thumb,wrist", "30,3,7"), ("thumb", "3")] {
        files(root, &[("b/0.csv", &format!("{header}\n{row}\n{row}\n"))]);
        let message = refused_with(root, &ReadOptions::default());
        assert!(message.starts_with("b/0.csv: ") && message.contains("a/0.csv"), "{message}");
    }
    files(root, &[("b/0.csv", "index,wrist\n30,3\n40,4\n")]);
    let message = refused_with(root, &ReadOptions::default());
    assert!(message.starts_with("b/0.csv: has no channel \"thumb\"; it has index, wrist"), "{message}");
}

#[test]
fn folders_of_a_split_are_parts_and_no_classes() {
    let folder = tempdir().unwrap();
    let set = [
        ("Test/pear/s1/2.csv", "1\n2\n"),
        ("Test/apple/s3/1.csv", "3\n4\n"),
        ("train/apple/s1/1.csv", "5\n6\n"),
        ("train/pear/s2/1.csv", "7\n8\n"),
        ("val/pear/s2/3.csv", "9\n1\n"),
    ];
    files(folder.path(), &set);
    let data = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.output_names(), ["apple", "pear"]);
    assert_eq!(
        data.origins,
        [
            "train/apple/s1/1.csv",
            "train/pear/s2/1.csv",
            "val/pear/s2/3.csv",
            "Test/apple/s3/1.csv",
            "Test/pear/s1/2.csv"
        ]
    );
    assert_eq!(data.strata().to_vec(), [0, 1, 1, 0, 1]);
    assert_eq!(data.official, Some(vec![false, false, false, true, true]));
    let said = check(folder.path()).unwrap().read_as.join("; ");
    assert!(said.contains("a split by folders: train and val to train on, Test to test on"), "{said}");
    // Without a test the validation is one.
    std::fs::remove_dir_all(folder.path().join("Test")).unwrap();
    let data = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.official, Some(vec![false, false, true]));
    assert_eq!(data.groups, Some(vec![0, 1, 1]));
    let classes = [("train/1.csv", "1\n"), ("test/1.csv", "2\n")];
    assert!(refused(&classes).starts_with("train: is a part of a split, and holds no class folders"));
    let beside = [("train/a/1.csv", "1\n"), ("test/a/1.csv", "2\n"), ("cup/1.csv", "2\n")];
    assert!(
        refused(&beside).starts_with("cup: lies beside folders called train and test"),
        "{}",
        refused(&beside)
    );
}
