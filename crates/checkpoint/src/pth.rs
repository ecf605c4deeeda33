//! PyTorch's `state_dict`s, through candle's reader of a restricted pickle, which runs none of it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use candle_core::pickle::{PthTensors, TensorInfo};
use candle_core::{DType, Error};
use taxel_graph::{Tensor, Weights};

use crate::error::Cause;
use crate::pickle;
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
        let missing = || Error::Msg("its values are missing".into());
        let read = || {
            let tensor = file.get(name)?.ok_or_else(missing)?;
            tensor.to_dtype(DType::F32)?.flatten_all()?.to_vec1()
        };
        let data = read().map_err(|e| Cause::Pth(format!("tensor `{name}`: {e}")))?;
        weights.insert(name, Tensor { shape: dims.to_vec(), data });
    }
    Ok(weights)
}

fn refuse(error: Error) -> Cause {
    Cause::Pth(error.to_string())
}
