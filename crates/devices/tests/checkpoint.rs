//! Checkpoints as users have them; `scripts/fixtures/checkpoints.py` writes the files.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use taxel_devices::checkpoint::{read, write};
use taxel_graph::{Graph, Tensor, Weights};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn graph() -> Graph {
    let sizes = [("classes", 2), ("in_features", 4), ("hidden", 3)];
    let settings = sizes.into_iter().map(|(k, v)| (k.to_string(), v.into())).collect();
    taxel_zoo::find("mlp").unwrap().graph(&settings).unwrap()
}

/// What the script put into every file.
fn expected() -> Weights {
    let mut weights = Weights::new();
    for (number, param) in graph().params().enumerate() {
        let data = (0..param.len()).map(|i| (i + 10 * number) as f32 / 8.0).collect();
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

fn same(name: &str) {
    let (weights, text) = read(&file(name)).unwrap();
    weights.check(&graph()).unwrap();
    assert_eq!(text, None, "{name} is not taxel's own");
    for (tensor, want) in expected().iter() {
        assert_eq!(weights.get(tensor), Some(want), "{name}: {tensor}");
    }
    assert_eq!(weights.len(), expected().len(), "{name}");
}

#[test]
fn a_state_dict_and_every_float_type_give_the_same_weights() {
    for name in ["state_dict.pth", "float64.safetensors", "float16.safetensors", "bfloat16.safetensors"] {
        same(name);
    }
}

#[test]
fn num_batches_tracked_is_let_pass() {
    same("tracked.safetensors");
}

#[test]
fn what_cannot_be_read_says_the_way_out() {
    let refusal = |path: &Path| {
        let message = read(path).unwrap_err().to_string();
        assert!(message.starts_with(&path.display().to_string()), "{message}");
        message
    };
    for name in ["whole_module.pth", "legacy.pth"] {
        let message = refusal(&file(name));
        assert!(message.ends_with("save it again with torch.save(model.state_dict(), path)"), "{message}");
    }
    assert!(refusal(&file("int64.safetensors")).contains("is I64; expected F32, F64, F16 or BF16"));
    assert!(refusal(&file("none.safetensors")).contains("No such file"));
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("w.safetensors");
    let whole = fs::read(file("float16.safetensors")).unwrap();
    for length in [0, 4, 20, whole.len() - 1] {
        fs::write(&broken, &whole[..length]).unwrap();
        assert!(refusal(&broken).contains("not a whole safetensors file"));
    }
    fs::write(folder.path().join("w.onnx"), "").unwrap();
    assert!(refusal(&folder.path().join("w.onnx")).contains("expected .safetensors, .pth or .pt"));
}

#[test]
fn what_is_written_is_read_and_equal_weights_are_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.safetensors"), folder.path().join("b.safetensors"));
    write(&a, &expected(), "trained on nothing").unwrap();
    write(&b, &expected(), "trained on nothing").unwrap();
    assert_eq!(fs::read(&a).unwrap(), fs::read(&b).unwrap());
    let (weights, text) = read(&a).unwrap();
    assert_eq!(text.as_deref(), Some("trained on nothing"));
    assert!(weights.iter().all(|(name, tensor)| expected().get(name) == Some(tensor)));
    let entries = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(entries, 2, "no temporary file stays");
    let message = write(&folder.path().join("no/w.safetensors"), &expected(), "").unwrap_err().to_string();
    assert!(message.contains("no/w.safetensors"), "{message}");
}
