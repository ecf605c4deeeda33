//! The tensors that `scripts/fixtures/checkpoints.py` put into every file of `tests/data`.

#![allow(dead_code, reason = "each test uses a part")]

use std::path::{Path, PathBuf};

use taxel_graph::{Graph, Tensor, Weights};

/// A file that the script wrote.
pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Returns the network of every file.
pub fn graph() -> Graph {
    let sizes = [("classes", 2), ("in_features", 4), ("hidden", 3)];
    let settings = sizes.into_iter().map(|(k, v)| (k.to_string(), v.into())).collect();
    taxel_zoo::find("mlp").unwrap().graph(&settings).unwrap()
}

/// The weights of every file.
pub fn expected() -> Weights {
    let mut weights = Weights::new();
    for (number, param) in graph().params().enumerate() {
        let data = (0..param.len()).map(|i| (i + 10 * number) as f32 / 8.0).collect();
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

/// Reads `name` and compares.
pub fn same(name: &str) {
    let (weights, text) = taxel_checkpoint::read(&file(name)).unwrap();
    weights.check(&graph()).unwrap();
    assert_eq!(text, None, "{name} is not taxel's own");
    for (tensor, want) in expected().iter() {
        assert_eq!(weights.get(tensor), Some(want), "{name}: {tensor}");
    }
    assert_eq!(weights.len(), expected().len(), "{name}");
    assert_eq!(taxel_checkpoint::read_text(&file(name)).unwrap(), None);
}

/// Returns the error of reading `path`, which names the file.
pub fn refusal(path: &Path) -> String {
    let message = taxel_checkpoint::read(path).unwrap_err().to_string();
    assert!(message.starts_with(&path.display().to_string()), "{message}");
    message
}
