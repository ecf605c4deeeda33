//! Facts of image files beside their pixels: which way up they are, and how deep.
#![cfg(feature = "image")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::fs::File;
use std::path::Path;
use taxel_data::{ReadOptions, check, load, recordings};
use tempfile::{TempDir, tempdir};

/// EXIF that says an orientation, and nothing else.
fn exif(orientation: u8) -> Vec<u8> {
    [b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".as_slice(), &[orientation, 0, 0, 0, 0, 0, 0, 0]]
        .concat()
}

/// A picture of two rows and three columns, 0 to 5 from left to right and down.
fn write(path: &Path, orientation: Option<u8>, is_deep: bool) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let mut encoder = PngEncoder::new(File::create(path).unwrap());
    if let Some(orientation) = orientation {
        encoder.set_exif_metadata(exif(orientation)).unwrap();
    }
    let (bytes, kind) = if is_deep {
        ((0u16..6).flat_map(|value| (1000 * value).to_ne_bytes()).collect(), ExtendedColorType::L16)
    } else {
        ((0..6).collect::<Vec<u8>>(), ExtendedColorType::L8)
    };
    encoder.write_image(&bytes, 3, 2, kind).unwrap();
}

fn set(orientation: impl Fn(usize) -> Option<u8>, is_deep: bool) -> TempDir {
    let folder = tempdir().unwrap();
    for at in 0..4 {
        let class = ["flat", "edge"][at % 2];
        write(&folder.path().join(format!("{class}/{at}.png")), orientation(at), is_deep);
    }
    folder
}

#[test]
fn images_are_turned_as_their_exif_says_and_the_card_says_it() {
    let turned = set(|at| [None, Some(3)][at / 2], false);
    let data = load(turned.path(), &ReadOptions::default()).unwrap();
    let of = |origin: &str| {
        let at = data.origins.iter().position(|name| name == origin).unwrap();
        data.x.as_slice().unwrap()[6 * at..6 * at + 6].to_vec()
    };
    assert_eq!(
        (of("flat/0.png"), of("flat/2.png")),
        (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], vec![5.0, 4.0, 3.0, 2.0, 1.0, 0.0])
    );
    let read_as = check(turned.path()).unwrap().read_as.join("; ");
    assert!(read_as.contains("2 of 4 images") && read_as.contains("EXIF"), "{read_as}");
    let quarter = set(|_| Some(6), false);
    let data = load(quarter.path(), &ReadOptions::default()).unwrap();
    assert_eq!(data.x.shape(), [4, 3, 2], "rows and columns change places");
    assert_eq!(data.x.as_slice().unwrap()[..6], [3.0, 0.0, 4.0, 1.0, 5.0, 2.0]);
    let small = ReadOptions { resize: Some([2, 2]), ..ReadOptions::default() };
    assert_eq!(load(quarter.path(), &small).unwrap().x.shape(), [4, 2, 2]);
    assert!(check(set(|_| None, false).path()).unwrap().read_as.is_empty());
}

#[test]
fn the_depth_of_pixels_is_a_fact_of_the_set_and_of_recordings() {
    for (is_deep, depth) in [(false, 8), (true, 16)] {
        let folder = set(|_| None, is_deep);
        let data = load(folder.path(), &ReadOptions::default()).unwrap();
        assert_eq!((data.spec.depth, data.spec.full_scale), (Some(depth), None));
        let read = recordings(&folder.path().join("flat"), &ReadOptions::default(), 2).unwrap();
        assert_eq!((read.facts.depth, read.facts.dtype), (Some(depth), format!("png/jpeg u{depth}")));
    }
}
