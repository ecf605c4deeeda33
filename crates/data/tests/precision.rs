//! Numbers of 64 bits whose signal f32 cannot hold.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{labels, npy, npz, refused};
use taxel_data::{ReadOptions, load, recordings};
use tempfile::tempdir;

/// Four samples of two channels over 50 time steps, the second with an offset, in the order of C or of Fortran.
fn samples(offset: f64, signal: f64, is_fortran: bool) -> Vec<u8> {
    let value = |sample: usize, channel: usize, time: usize| {
        let wave = ((time * (sample + 1)) as f64 * 0.3).sin();
        if channel == 0 { wave } else { offset + signal * wave }
    };
    let mut bytes = vec![];
    for i in 0..400 {
        let (sample, channel, time) =
            if is_fortran { (i % 4, i / 4 % 2, i / 8) } else { (i / 100, i / 50 % 2, i % 50) };
        bytes.extend(value(sample, channel, time).to_le_bytes());
    }
    npy("<f8", is_fortran, &[4, 2, 50], &bytes)
}

#[test]
fn a_signal_on_a_large_offset_is_refused_by_channel() {
    let folder = tempdir().unwrap();
    for is_fortran in [false, true] {
        let path = npz(folder.path(), &[("x", samples(1e8, 1.0, is_fortran)), ("y", labels())]);
        let message = refused(&path, &ReadOptions::default());
        assert!(message.starts_with("grasps.npz: x: channel 1 "), "{message}");
        assert!(message.contains("f32") && message.contains("offset"), "{message}");
    }
}

#[test]
fn a_signal_that_f32_holds_is_read_and_so_is_a_channel_that_does_not_change() {
    let folder = tempdir().unwrap();
    // The pressure of air in pascal; a constant but for the rounding of f64; nothing at all.
    for (offset, signal) in [(101_325.0, 100.0), (0.1, 1e-17), (1e8, 0.0), (0.0, 1e-9)] {
        let path = npz(folder.path(), &[("x", samples(offset, signal, false)), ("y", labels())]);
        load(&path, &ReadOptions::default()).unwrap();
    }
}

#[test]
fn one_recording_is_watched_along_its_channels() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("press.npy");
    let values: Vec<u8> = (0..100)
        .flat_map(|i| (if i < 50 { 0.0 } else { 1e8 } + f64::from(i % 50) * 0.02).to_le_bytes())
        .collect();
    std::fs::write(&path, npy("<f8", false, &[2, 50], &values)).unwrap();
    let message = recordings(&path, &ReadOptions::default(), 2).unwrap_err().to_string();
    assert!(message.contains("press.npy: channel 1 "), "{message}");
}
