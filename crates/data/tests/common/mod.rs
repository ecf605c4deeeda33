//! Builders of small data sets, sound and broken.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::io::Write;
use std::path::{Path, PathBuf};
use taxel_data::{ReadOptions, load};
use tempfile::tempdir;

/// One `.npy` file: `descr` without quotes, `data` as is.
pub fn npy(descr: &str, fortran: bool, shape: &[u64], data: &[u8]) -> Vec<u8> {
    let axes: String = shape.iter().map(|n| format!("{n},")).collect();
    let order = if fortran { "True" } else { "False" };
    let quote = if descr.starts_with('[') { "" } else { "'" };
    let mut header =
        format!("{{'descr': {quote}{descr}{quote}, 'fortran_order': {order}, 'shape': ({axes}), }}");
    while !(header.len() + 11).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

pub fn f32s(shape: &[u64], values: &[f32]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    npy("<f4", false, shape, &data)
}

pub fn i64s(shape: &[u64], values: &[i64]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    npy("<i8", false, shape, &data)
}

/// `[n, 2, 3]`, every value its own.
pub fn samples(n: u64) -> Vec<u8> {
    let values: Vec<f32> = (0..n * 6).map(|v| v as f32).collect();
    f32s(&[n, 2, 3], &values)
}

/// A deflated archive of `arrays`.
pub fn npz(folder: &Path, arrays: &[(&str, Vec<u8>)]) -> PathBuf {
    let path = folder.join("grasps.npz");
    let mut writer = npyz::npz::NpzWriter::create(&path).unwrap();
    let zip = writer.zip_writer();
    for (name, bytes) in arrays {
        zip.start_file(format!("{name}.npy"), Default::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
    path
}

/// The bytes of an archive of `arrays` as `numpy.savez` writes it: stored, not deflated.
pub fn stored(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in arrays {
        let name = format!("{name}.npy");
        let offset = out.len() as u32;
        let mut common = Vec::new();
        common.extend([20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0]);
        common.extend(crc32(bytes).to_le_bytes());
        common.extend((bytes.len() as u32).to_le_bytes());
        common.extend((bytes.len() as u32).to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        out.extend(b"PK\x03\x04");
        out.extend(&common);
        out.extend(name.as_bytes());
        out.extend(bytes);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = out.len() as u32;
    out.extend(&directory);
    out.extend(b"PK\x05\x06\0\0\0\0");
    for _ in 0..2 {
        out.extend((arrays.len() as u16).to_le_bytes());
    }
    out.extend((directory.len() as u32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0, 0]);
    out
}

fn crc32(bytes: &[u8]) -> u32 {
    let step =
        |crc: u32, byte: &u8| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 }
            })
        };
    !bytes.iter().fold(!0, step)
}

/// Writes files below `root`, folders included.
pub fn files(root: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        let path = root.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

/// The message for `path`, without the folder it lies in.
pub fn refused(path: &Path, options: &ReadOptions) -> String {
    let message = load(path, options).unwrap_err().to_string();
    let folder = path.parent().unwrap().display().to_string();
    message.replace(&format!("{folder}/"), "").replace(&folder, "FOLDER")
}

/// The message for an archive of `arrays`.
pub fn refused_arrays(arrays: &[(&str, Vec<u8>)]) -> String {
    let folder = tempdir().unwrap();
    refused(&npz(folder.path(), arrays), &ReadOptions::default())
}

/// Labels of four samples.
pub fn labels() -> Vec<u8> {
    i64s(&[4], &[0, 1, 1, 0])
}

/// Copies of a file that are cut short every `cut` bytes, and then copies with one byte changed every `change` bytes.
pub fn damaged(whole: &[u8], cut: usize, change: usize) -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = (0..whole.len()).step_by(cut).map(|end| whole[..end].to_vec()).collect();
    for at in (0..whole.len()).step_by(change) {
        for value in [whole[at] ^ 0x10, 0xFF, 0] {
            let mut damaged = whole.to_vec();
            damaged[at] = value;
            all.push(damaged);
        }
    }
    all
}
