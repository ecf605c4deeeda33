//! PyTorch's own files; `scripts/fixtures/checkpoints.py` writes them.

#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;

use common::{expected, file, refusal, same};
use taxel_checkpoint::read;

const WAY_OUT: &str = "save it again with torch.save(model.state_dict(), path)";

#[test]
fn a_state_dict_is_read() {
    same("state_dict.pth");
    let (weights, _) = read(&file("state_dict.pth")).unwrap();
    let names: Vec<&str> = weights.iter().map(|(name, _)| name).collect();
    assert!(names.is_sorted(), "the reader keeps no order of its own: {names:?}");
}

/// `scripts/fixtures/strided_pth.py` writes the file: channels_last, a transposed tensor, and a part of one.
#[test]
fn values_are_read_in_the_order_of_their_strides() {
    let (weights, _) = read(&file("strided.pth")).unwrap();
    for (name, shape) in [("x", &[2, 3, 2, 2][..]), ("turned", &[3, 2]), ("part", &[2, 2])] {
        let tensor = weights.get(name).unwrap();
        let want: Vec<f32> = (0..shape.iter().product::<usize>()).map(|i| i as f32 / 8.0).collect();
        assert_eq!((tensor.shape.as_slice(), &tensor.data), (shape, &want), "{name}");
    }
}

#[test]
fn what_cannot_be_read_says_how_to_fix_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("w.pt");
    fs::write(&text, "weights").unwrap();
    let cases = [
        (file("whole_module.pth"), "holds no state_dict, perhaps a whole module"),
        (
            file("legacy.pth"),
            "is in PyTorch's old format (before 1.6, or _use_new_zipfile_serialization=False)",
        ),
        (file("legacy4.pth"), "is in PyTorch's old format"),
        (text, "is no file of torch.save"),
    ];
    for (path, what) in cases {
        let message = refusal(&path);
        assert!(message.contains(what) && message.ends_with(WAY_OUT), "{message}");
    }
    assert!(refusal(&folder.path().join("none.pth")).contains("No such file"));
}

/// Every byte of a file, changed in a few ways: read, or refused with the file's name, never a panic.
#[test]
fn damaged_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.pth");
    let whole = fs::read(file("state_dict.pth")).unwrap();
    let mut refused = 0;
    for at in 0..whole.len() {
        for change in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= change;
            fs::write(&path, bytes).unwrap();
            match read(&path) {
                Ok((weights, _)) => assert!(weights.len() <= expected().len()),
                Err(error) => {
                    refused += 1;
                    assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
                }
            }
        }
    }
    assert!(refused > whole.len() / 2, "{refused} changes were seen");
}

/// candle 0.11 takes the arguments of a tensor for granted.
#[test]
fn a_panic_inside_the_reader_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.pth");
    fs::write(&path, archive(b"\x80\x02}X\x01\0\0\0wctorch._utils\n_rebuild_tensor_v2\n)Rs.")).unwrap();
    let message = refusal(&path);
    assert!(message.ends_with(&format!("is damaged: its pickle makes no sense; {WAY_OUT}")), "{message}");
}

/// This test's own process runs the one above again, and listens to what it says.
#[test]
fn a_panic_inside_the_reader_is_not_heard() {
    let program = std::env::current_exe().unwrap();
    let test = "a_panic_inside_the_reader_is_an_error";
    let output = std::process::Command::new(program).args(["--exact", test, "--nocapture"]).output().unwrap();
    let (said, results) = (String::from_utf8_lossy(&output.stderr), String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success() && results.contains("1 passed"), "{results}");
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn a_tensor_larger_than_its_file_takes_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.pth");
    // {"w": _rebuild_tensor_v2(("storage", FloatStorage, "0", "cpu", 4), 0, (n, n, n), (0, 0, 0))}
    let n = b"J\xff\xff\xff\x7f".as_slice();
    let storage = b"(X\x07\0\0\0storagectorch\nFloatStorage\nX\x01\0\0\x000X\x03\0\0\0cpuK\x04tQ";
    let pickle = [
        b"\x80\x02}X\x01\0\0\0wctorch._utils\n_rebuild_tensor_v2\n(".as_slice(),
        storage,
        b"K\0",
        n,
        n,
        n,
        b"\x87K\0K\0K\0\x87tRs.",
    ];
    fs::write(&path, archive(&pickle.concat())).unwrap();
    let message = refusal(&path);
    assert!(message.contains("tensor `w` [2147483647, 2147483647, 2147483647] is larger"), "{message}");
}

/// A text of 4 GB that is not there, and a tuple of two tuples of two tuples, thirty deep.
#[test]
fn a_pickle_that_would_fill_the_memory_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.pth");
    let doubled: Vec<u8> = (0..30u8).flat_map(|at| [b'q', at, b'h', at, 0x86]).collect();
    for pickle in [b"\x80\x02X\xff\xff\xff\xffw.".to_vec(), [b"\x80\x02)", &doubled[..], b"."].concat()] {
        fs::write(&path, archive(&pickle)).unwrap();
        let message = refusal(&path);
        assert!(message.ends_with(&format!("is damaged: its pickle makes no sense; {WAY_OUT}")), "{message}");
    }
}

/// A zip archive that holds `data.pkl` alone, uncompressed.
fn archive(pickle: &[u8]) -> Vec<u8> {
    let name = b"w/data.pkl";
    let sum = crc32(pickle).to_le_bytes();
    let size = (pickle.len() as u32).to_le_bytes();
    let name_size = (name.len() as u16).to_le_bytes();
    // Version, flags, method, time and date, then what both records share.
    let shared = [&[20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0], &sum[..], &size, &size, &name_size, &[0, 0]].concat();
    let local = [b"PK\x03\x04", &shared[..], name, pickle].concat();
    let central = [b"PK\x01\x02\x14\0", &shared[..], &[0; 14], name].concat();
    let offset = (local.len() as u32).to_le_bytes();
    let length = (central.len() as u32).to_le_bytes();
    let end = [b"PK\x05\x06\0\0\0\0\x01\0\x01\0", &length[..], &offset, &[0, 0]].concat();
    [local, central, end].concat()
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    })
}
