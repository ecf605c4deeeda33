//! Frames of recordings as samples of their own.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{f32s, i64s, npz};
use taxel_data::{Dataset, Layout, ReadOptions, load};

/// Three squeezes of two frames of 1 × 3 taxels, the last a copy of the first.
fn squeezes(groups: bool) -> Dataset {
    let folder = tempfile::tempdir().unwrap();
    let mut x: Vec<f32> = (0..12).map(|v| v as f32).collect();
    x.extend_from_within(..6);
    let (x, y, group) = (f32s(&[3, 2, 1, 3], &x), i64s(&[3], &[0, 1, 0]), i64s(&[3], &[7, 7, 9]));
    let mut arrays = vec![("x", x), ("y", y)];
    if groups {
        arrays.push(("group", group));
    }
    let file = npz(folder.path(), &arrays);
    load(&file, &ReadOptions { layout: Some(Layout::Sequence), ..ReadOptions::default() }).unwrap()
}

#[test]
fn every_frame_is_a_sample_in_the_order_of_the_recordings() {
    let whole = squeezes(true);
    let each = whole.clone().each_frame().unwrap();
    assert_eq!((each.spec.layout, each.x.shape()), (Layout::Image, &[6, 1, 3][..]));
    assert_eq!(each.sample_shape(), [1, 3]);
    assert!(each.x.iter().eq(whole.x.iter()));
    assert_eq!(each.strata().to_vec(), [0, 0, 1, 1, 0, 0]);
    assert_eq!(each.targets.labels().unwrap().of(&[0, 2, 4]), whole.targets.labels().unwrap().of(&[0, 1, 2]));
    assert_eq!(each.groups.as_deref(), Some(&[7, 7, 7, 7, 9, 9][..]));
    assert!(each.origins[3].ends_with(", frame 1"), "{:?}", each.origins);
    assert_ne!(each.digest, whole.digest);
    // The last squeeze is a copy of the first: their frames belong together.
    assert_eq!(each.units.as_deref(), Some(&[0, 0, 2, 2, 0, 0][..]));
}

#[test]
fn without_groups_a_recording_is_a_group() {
    let each = squeezes(false).each_frame().unwrap();
    assert_eq!(each.groups.as_deref(), Some(&[0, 0, 1, 1, 2, 2][..]));
    assert_eq!(each.group_name.as_deref(), Some("recording"));
}

#[test]
fn what_has_no_frames_is_refused() {
    let each = squeezes(true).each_frame().unwrap();
    let message = each.each_frame().unwrap_err().to_string();
    assert!(
        message.contains("of shape [1, 3] is an image [H, W], and has no frames to take apart"),
        "{message}"
    );
}
