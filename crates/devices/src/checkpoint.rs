//! Weights on disk: `.safetensors` both ways, PyTorch's `.pth` inwards.
//!
//! The `.pth` reader understands a restricted pickle and runs none of it.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::path::Path;

use candle_core::{DType, Device, pickle};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use taxel_graph::{Tensor, Weights};

use crate::error::{Error, Result};

/// The metadata key under which taxel keeps its own text. One key only: the format keeps metadata in
/// no fixed order, and equal runs must give equal bytes.
const KEY: &str = "taxel";

/// Reads `.safetensors` or `.pth`/`.pt`; the text is taxel's metadata, if the file has some.
///
/// # Errors
/// A file that is missing, broken or of another kind, and tensors that are not floating point.
pub fn read(path: &Path) -> Result<(Weights, Option<String>)> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("safetensors") => read_safetensors(path),
        Some("pth" | "pt") => Ok((read_pth(path)?, None)),
        _ => Err(refuse(path, "unknown kind of weights; expected .safetensors, .pth or .pt")),
    }
}

fn read_safetensors(path: &Path) -> Result<(Weights, Option<String>)> {
    let bytes = std::fs::read(path).map_err(|e| refuse(path, e))?;
    let broken = |e| refuse(path, format!("not a whole safetensors file: {e}"));
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(broken)?;
    let text = header.metadata().as_ref().and_then(|m| m.get(KEY).cloned());
    let file = SafeTensors::deserialize(&bytes).map_err(broken)?;
    let mut names: Vec<String> = file.names().into_iter().map(String::from).collect();
    names.sort();
    let mut weights = Weights::new();
    for name in names {
        let view = file.tensor(&name).map_err(broken)?;
        if name.ends_with("num_batches_tracked") {
            continue;
        }
        let data = floats(&view).ok_or_else(|| {
            refuse(path, format!("tensor `{name}` is {:?}; expected F32, F64, F16 or BF16", view.dtype()))
        })?;
        weights.insert(&name, Tensor { shape: view.shape().to_vec(), data });
    }
    Ok((weights, text))
}

fn floats(view: &TensorView) -> Option<Vec<f32>> {
    let bytes = view.data();
    let half = |dtype| {
        let tensor = candle_core::Tensor::from_raw_buffer(
            bytes,
            dtype,
            &[view.shape().iter().product()],
            &Device::Cpu,
        );
        tensor.and_then(|t| t.to_dtype(DType::F32)?.to_vec1()).ok()
    };
    match view.dtype() {
        Dtype::F32 => Some(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
        Dtype::F64 => Some(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b) as f32).collect()),
        Dtype::F16 => half(DType::F16),
        Dtype::BF16 => half(DType::BF16),
        _ => None,
    }
}

fn read_pth(path: &Path) -> Result<Weights> {
    let way_out = "save it again with torch.save(model.state_dict(), path)";
    let tensors = pickle::read_all(path).map_err(|e| refuse(path, format!("{e}; {way_out}")))?;
    if tensors.is_empty() {
        return Err(refuse(path, format!("holds no state_dict, perhaps a whole module; {way_out}")));
    }
    let mut weights = Weights::new();
    for (name, tensor) in tensors {
        if name.ends_with("num_batches_tracked") {
            continue;
        }
        let data = tensor.to_dtype(DType::F32).and_then(|t| t.flatten_all()?.to_vec1());
        let data = data.map_err(|e| refuse(path, format!("tensor `{name}`: {e}")))?;
        weights.insert(&name, Tensor { shape: tensor.dims().to_vec(), data });
    }
    Ok(weights)
}

/// Writes `.safetensors` under a temporary name and renames it: a reader never sees half a file.
/// Equal weights and text give equal bytes.
///
/// # Errors
/// The folder is missing or cannot be written.
pub fn write(path: &Path, weights: &Weights, text: &str) -> Result<()> {
    let raw: Vec<(&str, Vec<u8>, &[usize])> = weights
        .iter()
        .map(|(name, t)| (name, t.data.iter().flat_map(|v| v.to_le_bytes()).collect(), t.shape.as_slice()))
        .collect();
    let mut views = Vec::with_capacity(raw.len());
    for (name, bytes, shape) in &raw {
        let view = TensorView::new(Dtype::F32, shape.to_vec(), bytes).map_err(|e| refuse(path, e))?;
        views.push((*name, view));
    }
    let metadata = HashMap::from([(KEY.to_string(), text.to_string())]);
    let bytes = serialize(views, Some(metadata)).map_err(|e| refuse(path, e))?;
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let written = File::create(&part).and_then(|mut file| {
        file.write_all(&bytes)?;
        file.sync_all()
    });
    written.and_then(|()| std::fs::rename(&part, path)).map_err(|e| refuse(path, e))
}

fn refuse(path: &Path, reason: impl ToString) -> Error {
    Error::Checkpoint { path: path.into(), reason: reason.to_string() }
}
