//! Damaged `.safetensors`: read or refused, never a panic.

#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;

use common::{expected, file};
use proptest::prelude::*;
use taxel_checkpoint::{Cause, from_bytes, read_text, to_bytes};
use taxel_graph::{Tensor, Weights};

/// Reads `bytes`; what is read fills its shape.
fn outcome(bytes: &[u8]) -> Result<(Weights, Option<String>), Cause> {
    let read = from_bytes(bytes);
    if let Ok((weights, _)) = &read {
        for (name, tensor) in weights.iter() {
            assert_eq!(tensor.shape.iter().product::<usize>(), tensor.data.len(), "{name}");
        }
    }
    read
}

fn with_header(header: &str, values: usize) -> Vec<u8> {
    [&(header.len() as u64).to_le_bytes(), header.as_bytes(), &vec![0; values]].concat()
}

#[test]
fn every_byte_may_be_wrong() {
    for name in ["float64.safetensors", "float16.safetensors", "tracked.safetensors"] {
        let whole = fs::read(file(name)).unwrap();
        for at in 0..whole.len() {
            for value in 0..=u8::MAX {
                let mut bytes = whole.clone();
                bytes[at] = value;
                // A damaged value is another value; a damaged header is mostly refused.
                let _ = outcome(&bytes);
            }
            assert!(outcome(&whole[..at]).is_err(), "{name}, cut at {at}");
        }
        assert!(outcome(&[&whole[..], &[0]].concat()).is_err(), "{name}, with a byte too many");
    }
}

#[test]
fn headers_that_reach_elsewhere_are_refused() {
    let entry = |name: &str, count: usize, from: u64, to: u64| {
        format!(r#""{name}":{{"dtype":"F32","shape":[{count}],"data_offsets":[{from},{to}]}}"#)
    };
    let whole = entry("a", 2, 0, 8);
    assert!(outcome(&with_header(&format!("{{{whole}}}"), 8)).is_ok());
    let cases = [
        ("beyond the end", entry("a", 3, 0, 12)),
        ("overlap", format!("{whole},{}", entry("b", 1, 4, 8))),
        ("a gap", entry("a", 1, 4, 8)),
        ("backwards", entry("a", 1, 8, 4)),
        ("another size than the shape's", entry("a", 1, 0, 8)),
        ("one name twice", format!("{},{}", entry("a", 1, 0, 4), entry("a", 1, 4, 8))),
        ("two texts", format!(r#""__metadata__":{{}},"__metadata__":{{}},{whole}"#)),
        ("no such type", whole.replace("F32", "F31")),
        ("negative", whole.replace("[2]", "[-2]")),
        ("a product too large", whole.replace("[2]", "[4294967296,4294967296]")),
    ];
    for (what, entries) in cases {
        let read = outcome(&with_header(&format!("{{{entries}}}"), 8));
        assert!(matches!(read, Err(Cause::NotSafetensors(_))), "{what}: {read:?}");
    }
}

/// The sizes fit one by one; with the header's length their sum is above what 64 bits hold.
#[test]
fn sizes_that_add_up_to_too_much_are_refused() {
    let part = 1u64 << 60;
    let entry = |number: u64| {
        let (from, to) = (number * part, if number == 15 { u64::MAX } else { (number + 1) * part });
        format!(r#""{number}":{{"dtype":"U8","shape":[{}],"data_offsets":[{from},{to}]}}"#, to - from)
    };
    let entries: Vec<String> = (0..16).map(entry).collect();
    assert!(outcome(&with_header(&format!("{{{}}}", entries.join(",")), 8)).is_err());
}

#[test]
fn a_header_longer_than_the_file_takes_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    for length in [9, 1 << 40, u64::MAX] {
        let bytes = [&length.to_le_bytes()[..], b"{}      "].concat();
        assert!(outcome(&bytes).is_err());
        fs::write(&path, &bytes).unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("not a whole safetensors file"));
    }
}

proptest! {
    #[test]
    fn any_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        let _ = outcome(&bytes);
        let _ = outcome(&[&(bytes.len() as u64).to_le_bytes()[..], &bytes].concat());
    }

    #[test]
    fn several_wrong_bytes_are_answered(changes in prop::collection::vec((0usize..400, any::<u8>()), 1..8)) {
        let mut bytes = to_bytes(&expected(), "{\"seed\": 7}").unwrap();
        for (at, value) in changes {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        let _ = outcome(&bytes);
    }

    #[test]
    fn what_goes_in_comes_out(
        shapes in prop::collection::vec(prop::collection::vec(0usize..4, 0..4), 0..5),
        text in ".*",
    ) {
        let mut weights = Weights::new();
        for (number, shape) in shapes.into_iter().enumerate() {
            let data = (0..shape.iter().product()).map(|i| i as f32 - 0.1).collect();
            weights.insert(&format!("\"{number}\"/é"), Tensor { shape, data });
        }
        let (read, kept) = outcome(&to_bytes(&weights, &text).unwrap()).unwrap();
        prop_assert_eq!(kept, Some(text));
        prop_assert_eq!(read, weights);
    }
}
