//! Checkpoints as users have them; `scripts/fixtures/checkpoints.py` writes the files.

#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;

use common::{expected, file, refusal, same};
use half::{bf16, f16};
use taxel_checkpoint::{Cause, from_bytes, read, read_text, to_bytes, write};
use taxel_graph::{Tensor, Weights};

#[test]
fn every_float_type_gives_the_same_weights() {
    for name in ["float64.safetensors", "float16.safetensors", "bfloat16.safetensors"] {
        same(name);
    }
}

#[test]
fn num_batches_tracked_is_let_pass() {
    same("tracked.safetensors");
}

#[test]
fn what_cannot_be_read_says_how_to_fix_it() {
    assert!(refusal(&file("int64.safetensors")).contains("is I64; expected F32, F64, F16 or BF16"));
    assert!(refusal(&file("none.safetensors")).contains("No such file"));
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("w.safetensors");
    let whole = fs::read(file("float16.safetensors")).unwrap();
    for length in [0, 4, 20, whole.len() - 1] {
        fs::write(&broken, &whole[..length]).unwrap();
        assert!(refusal(&broken).contains("not a whole safetensors file"));
        assert!(read_text(&broken).unwrap_err().to_string().contains("not a whole safetensors file"));
    }
    fs::write(folder.path().join("w.onnx"), "").unwrap();
    assert!(refusal(&folder.path().join("w.onnx")).contains("expected .safetensors, .pth or .pt"));
}

#[cfg(not(feature = "pth"))]
#[test]
fn without_its_reader_pytorchs_format_is_refused_with_a_way_to_fix_it() {
    let message = refusal(&file("state_dict.pth"));
    assert!(
        message.contains("save it as .safetensors, or build taxel with `--features candle`"),
        "{message}"
    );
}

#[test]
fn what_is_written_is_read_and_equal_weights_are_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.safetensors"), folder.path().join("b.safetensors"));
    write(&a, &expected(), "trained on nothing").unwrap();
    let mut backwards = Weights::new();
    let tensors: Vec<_> = expected().iter().map(|(name, t)| (name.to_string(), t.clone())).collect();
    tensors.into_iter().rev().for_each(|(name, tensor)| backwards.insert(&name, tensor));
    write(&b, &backwards, "trained on nothing").unwrap();
    assert_eq!(fs::read(&a).unwrap(), fs::read(&b).unwrap());
    let (weights, text) = read(&a).unwrap();
    assert_eq!(text.as_deref(), Some("trained on nothing"));
    assert_eq!(read_text(&a).unwrap().as_deref(), Some("trained on nothing"));
    assert_eq!(weights.len(), expected().len());
    assert!(weights.iter().all(|(name, tensor)| expected().get(name) == Some(tensor)));
    let entries = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(entries, 2, "no temporary file stays");
    let message = write(&folder.path().join("no/w.safetensors"), &expected(), "").unwrap_err().to_string();
    assert!(message.contains("no/w.safetensors"), "{message}");
}

#[cfg(unix)] // where files may have holes
/// Values are not read: a file whose values are damaged, or larger than memory, still says what it is.
#[test]
fn the_text_comes_from_the_header_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    let header = r#"{"__metadata__":{"taxel":"long"},"w":{"dtype":"F32","shape":[4294967296,16],"data_offsets":[0,274877906944]}}"#;
    let file = fs::File::create(&path).unwrap();
    std::io::Write::write_all(&mut &file, &(header.len() as u64).to_le_bytes()).unwrap();
    std::io::Write::write_all(&mut &file, header.as_bytes()).unwrap();
    file.set_len(8 + header.len() as u64 + 274_877_906_944).unwrap();
    assert_eq!(read_text(&path).unwrap().as_deref(), Some("long"));
}

/// Against the definition of the types, for every half there is.
#[test]
fn halves_are_what_their_bits_say() {
    let all: Vec<u16> = (0..=u16::MAX).collect();
    let bytes: Vec<u8> = all.iter().flat_map(|bits| bits.to_le_bytes()).collect();
    for (dtype, exponent_bits) in [("F16", 5), ("BF16", 8)] {
        let header = format!(r#"{{"w":{{"dtype":"{dtype}","shape":[65536],"data_offsets":[0,131072]}}}}"#);
        let file = [&(header.len() as u64).to_le_bytes(), header.as_bytes(), &bytes].concat();
        let (weights, _) = from_bytes(&file).unwrap();
        for (bits, got) in all.iter().zip(&weights.get("w").unwrap().data) {
            let want = meaning(*bits, exponent_bits);
            assert!(want == f64::from(*got) || want.is_nan() && got.is_nan(), "{dtype} {bits:#x}: {got}");
        }
    }
    // The sign of zero is lost in `==`.
    assert!(f16::NEG_ZERO.to_f32().is_sign_negative() && bf16::NEG_ZERO.to_f32().is_sign_negative());
}

/// IEEE 754: sign, exponent, fraction.
fn meaning(bits: u16, exponent_bits: u32) -> f64 {
    let fraction_bits = 15 - exponent_bits;
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let exponent = i32::from(bits >> fraction_bits & ((1 << exponent_bits) - 1));
    let fraction = f64::from(bits & ((1 << fraction_bits) - 1)) / f64::from(1u32 << fraction_bits);
    let bias = (1 << (exponent_bits - 1)) - 1;
    match exponent {
        0 => sign * fraction * 2f64.powi(1 - bias),
        e if e == (1 << exponent_bits) - 1 => {
            if fraction == 0.0 {
                sign * f64::INFINITY
            } else {
                f64::NAN
            }
        }
        e => sign * (1.0 + fraction) * 2f64.powi(e - bias),
    }
}

#[test]
fn a_tensor_that_does_not_fill_its_shape_is_not_written() {
    for shape in [vec![2, 2], vec![usize::MAX, 2], vec![]] {
        let mut weights = Weights::new();
        weights.insert("w", Tensor { shape, data: vec![0.0; 3] });
        assert!(matches!(to_bytes(&weights, ""), Err(Cause::Shape { values: 3, .. })));
    }
}

/// A file that taxel did not write, with one tensor of three values.
fn foreign(name: &str, values: [f32; 3]) -> Vec<u8> {
    let header = format!(r#"{{"{name}":{{"dtype":"F32","shape":[3,1],"data_offsets":[0,12]}}}}"#);
    let values = values.iter().flat_map(|value| value.to_le_bytes());
    (header.len() as u64).to_le_bytes().into_iter().chain(header.bytes()).chain(values).collect()
}

#[test]
fn values_that_no_training_gives_are_refused_by_tensor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    for (name, values, why) in [
        ("a.weight", [0.5, f32::NAN, 1.0], Some("tensor `a.weight` is NaN at [1, 0]; the training diverged")),
        ("a.bias", [f32::NEG_INFINITY, 0.0, 1.0], Some("tensor `a.bias` is -inf at [0, 0]")),
        (
            "bn.running_var",
            [0.5, 0.0, -1e-3],
            Some("tensor `bn.running_var` is -0.001 at [2, 0], a variance below 0"),
        ),
        ("bn.running_mean", [0.5, 0.0, -1e-3], None),
    ] {
        fs::write(&path, foreign(name, values)).unwrap();
        match why {
            Some(why) => assert!(refusal(&path).contains(why), "{}", refusal(&path)),
            None => assert!(read(&path).is_ok()),
        }
    }
}

#[test]
fn names_with_a_prefix_of_a_wrapper_say_it() {
    for prefix in ["module.", "_orig_mod.", "_orig_mod.module.", "net."] {
        let mut weights = Weights::new();
        expected()
            .iter()
            .for_each(|(name, tensor)| weights.insert(&format!("{prefix}{name}"), tensor.clone()));
        let first = expected().iter().next().unwrap().0.to_string();
        let message = weights.check(&common::graph()).unwrap_err().to_string();
        assert!(message.contains(&format!("`{first}` is missing")), "{message}");
        assert!(message.contains(&format!("The file has it as `{prefix}{first}`")), "{message}");
        assert!(message.contains(&format!("k.removeprefix(\"{prefix}\")")), "{message}");
    }
}
