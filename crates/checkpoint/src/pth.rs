//! PyTorch's `state_dict`s, through candle's reader of a restricted pickle, which runs none of it.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use ::safetensors::tensor::Dtype;
use candle_core::pickle::{PthTensors, TensorInfo};
use candle_core::{DType, Error};
use taxel_graph::{Tensor, Weights};
use zip::ZipArchive;

use crate::error::Cause;
use crate::pickle;
use crate::safetensors::floats;
use taxel_base::quiet::caught;

/// The number 0x1950a86a20f9469cfc6c, of which PyTorch's old format has a pickle first, of any protocol.
const LEGACY: [u8; 10] = *b"\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19";

/// Bytes of a file that are looked at for it.
const START: u64 = 32;

/// How a zip archive begins.
const ZIP: [u8; 4] = *b"PK\x03\x04";

/// Reads a `.pth`; tensors come in the order of their names.
pub(crate) fn read(path: &Path) -> Result<Weights, Cause> {
    let mut start = vec![];
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    file.take(START).read_to_end(&mut start)?;
    if start.windows(LEGACY.len()).any(|bytes| bytes == LEGACY) {
        return Err(Cause::LegacyPth);
    }
    if !start.starts_with(&ZIP) {
        return Err(Cause::Pth("is no file of torch.save".into()));
    }
    pickle::check(path, length)?;
    // The reader takes much of a pickle for granted. Nothing of it outlives the call.
    caught(|| tensors(path, length))
        .unwrap_or_else(|| Err(Cause::Pth("is damaged: its pickle makes no sense".into())))
}

fn tensors(path: &Path, length: u64) -> Result<Weights, Cause> {
    let file = PthTensors::new(path, None).map_err(refuse)?;
    if file.tensor_infos().is_empty() {
        return Err(Cause::Pth("holds no state_dict, perhaps a whole module".into()));
    }
    let mut infos: Vec<&TensorInfo> = file.tensor_infos().values().collect();
    infos.sort_by(|a, b| a.name.cmp(&b.name));
    let mut archive =
        ZipArchive::new(BufReader::new(File::open(path)?)).map_err(|e| Cause::Pth(e.to_string()))?;
    let mut weights = Weights::new();
    for info in infos {
        let name = &info.name;
        if name.ends_with("num_batches_tracked") {
            continue;
        }
        if !matches!(info.dtype, DType::F32 | DType::F64 | DType::F16 | DType::BF16) {
            return Err(Cause::Type { tensor: name.clone(), dtype: format!("{:?}", info.dtype) });
        }
        // Values lie in the archive as they are, so a larger tensor is damage, and would take memory.
        let dims = info.layout.dims();
        let bytes = dims.iter().try_fold(info.dtype.size_in_bytes(), |bytes, axis| bytes.checked_mul(*axis));
        if bytes.is_none_or(|bytes| bytes as u64 > length) {
            return Err(Cause::Pth(format!("is damaged: tensor `{name}` {dims:?} is larger than the file")));
        }
        let data =
            values(&mut archive, info, length).map_err(|e| Cause::Pth(format!("tensor `{name}`: {e}")))?;
        weights.insert(name, Tensor { shape: dims.to_vec(), data });
    }
    Ok(weights)
}

/// Reads the values of a tensor, row-major, in whatever order its strides say that they lie; candle takes only two orders.
fn values(
    archive: &mut ZipArchive<BufReader<File>>,
    info: &TensorInfo,
    length: u64,
) -> Result<Vec<f32>, String> {
    let (dims, strides) = (info.layout.dims(), info.layout.stride());
    let (size, start) = (info.dtype.size_in_bytes(), info.layout.start_offset());
    let reach = || {
        let mut last = 0usize;
        for (axis, stride) in dims.iter().zip(strides) {
            last = last.checked_add(axis.checked_sub(1)?.checked_mul(*stride)?)?;
        }
        last.checked_add(1)?.checked_mul(size)
    };
    // An empty axis holds nothing.
    let reach = if dims.contains(&0) { Some(0) } else { reach() };
    let end = reach.and_then(|reach| reach.checked_add(start)).filter(|end| *end as u64 <= length);
    let end = end.filter(|_| dims.len() == strides.len()).ok_or("its values lie outside the file")?;
    let mut bytes = Vec::with_capacity(end);
    let file = archive.by_name(&info.path).map_err(|e| e.to_string())?;
    file.take(end as u64).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    let stored = bytes.get(start..end).and_then(|bytes| floats(stored_type(info.dtype)?, bytes));
    let stored = stored.ok_or("its values end too early")?;
    let count = dims.iter().product();
    let mut data = Vec::with_capacity(count);
    let mut index = vec![0; dims.len()];
    for _ in 0..count {
        let at: usize = index.iter().zip(strides).map(|(i, stride)| i * stride).sum();
        data.push(*stored.get(at).ok_or("its values end too early")?);
        for (place, axis) in index.iter_mut().zip(dims).rev() {
            *place += 1;
            if *place < *axis {
                break;
            }
            *place = 0;
        }
    }
    Ok(data)
}

/// Returns the type of stored numbers in the words of safetensors; none of others than floats.
fn stored_type(dtype: DType) -> Option<Dtype> {
    match dtype {
        DType::F32 => Some(Dtype::F32),
        DType::F64 => Some(Dtype::F64),
        DType::F16 => Some(Dtype::F16),
        DType::BF16 => Some(Dtype::BF16),
        _ => None,
    }
}

fn refuse(error: Error) -> Cause {
    Cause::Pth(error.to_string())
}
