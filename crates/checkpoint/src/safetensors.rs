//! The safetensors format: eight bytes with the header's length, a JSON header, values.
//!
//! `safetensors::Metadata` checks the header (offsets without gaps or overlaps, sizes that fit types and shapes);
//! values are then taken from the file by range, so that no header can reach past its end.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;

use ::safetensors::tensor::{Dtype, Metadata, View, serialize};
use half::{bf16, f16};
use taxel_graph::{Tensor, Weights};

use crate::eight_bits::{SCALE, together};
use crate::error::Cause;
use crate::stored::StoredTensor;

/// The metadata key under which taxel keeps its own text. One key only: the format keeps metadata in
/// no fixed order, and equal runs must give equal bytes.
const KEY: &str = "taxel";

/// Bytes that say how long the header is.
const LENGTH: usize = 8;

/// Reads the bytes of a `.safetensors`, as [`read`](crate::read) does.
///
/// # Errors
/// Bytes of another kind, cut or damaged, and tensors that are not floating point.
pub fn from_bytes(bytes: &[u8]) -> Result<(Weights, Option<String>), Cause> {
    let (length, rest) = bytes.split_first_chunk().ok_or_else(cut)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| cut())?;
    let (header, values) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = parse(header)?;
    if header.data_len() != values.len() {
        return Err(cut());
    }
    let mut tensors: Vec<_> = header.tensors().into_iter().collect();
    tensors.sort_by(|a, b| a.0.cmp(&b.0));
    let mut weights = Weights::new();
    for (name, info) in tensors {
        if name.ends_with("num_batches_tracked") {
            continue;
        }
        let (from, to) = info.data_offsets;
        let bytes = values.get(from..to).ok_or_else(cut)?;
        let tensor = name.strip_suffix(SCALE).and_then(|tensor| header.info(tensor));
        if tensor.is_some_and(|tensor| tensor.dtype == Dtype::I8) {
            continue;
        }
        let data = match info.dtype {
            Dtype::I8 => whole(&header, values, &name, bytes),
            dtype => floats(dtype, bytes),
        };
        let Some(data) = data else {
            return Err(Cause::Type { tensor: name, dtype: format!("{:?}", info.dtype) });
        };
        weights.insert(&name, Tensor { shape: info.shape.clone(), data });
    }
    Ok((weights, text(&header)))
}

/// Reads the text in the header of a file of `length` bytes; `file` stands at its start.
pub(crate) fn read_text(file: &mut impl Read, length: u64) -> Result<Option<String>, Cause> {
    let mut start = [0; LENGTH];
    let room = length.checked_sub(LENGTH as u64).ok_or_else(cut)?;
    file.read_exact(&mut start)?;
    // The header is no longer than the file, so a damaged length takes no memory.
    let wanted = u64::from_le_bytes(start);
    let size = usize::try_from(wanted).ok().filter(|_| wanted <= room).ok_or_else(cut)?;
    let mut header = vec![0; size];
    file.read_exact(&mut header)?;
    let header = parse(&header)?;
    if header.data_len() as u64 != room - wanted {
        return Err(cut());
    }
    Ok(text(&header))
}

fn cut() -> Cause {
    Cause::NotSafetensors("its length is not what its header says".into())
}

fn parse(header: &[u8]) -> Result<Metadata, Cause> {
    serde_json::from_slice(header).map_err(|e| Cause::NotSafetensors(e.to_string()))
}

fn text(header: &Metadata) -> Option<String> {
    header.metadata().as_ref().and_then(|m| m.get(KEY).cloned())
}

/// Returns the values of a tensor in eight bits, if it has its scales.
fn whole(header: &Metadata, values: &[u8], name: &str, bytes: &[u8]) -> Option<Vec<f32>> {
    let (info, scales) = (header.info(name)?, header.info(&format!("{name}{SCALE}"))?);
    let (from, to) = scales.data_offsets;
    let outputs = info.shape.first().copied()?;
    let given = floats(scales.dtype, values.get(from..to)?).filter(|_| scales.shape == [outputs])?;
    let bytes: Vec<i8> = bytes.iter().map(|b| b.cast_signed()).collect();
    Some(together(&bytes, &given))
}

/// Decodes numbers; none of another type than floats.
pub(crate) fn floats(dtype: Dtype, bytes: &[u8]) -> Option<Vec<f32>> {
    let halves = || bytes.as_chunks().0.iter();
    Some(match dtype {
        Dtype::F32 => bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
        Dtype::F64 => bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b) as f32).collect(),
        Dtype::F16 => halves().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
        Dtype::BF16 => halves().map(|b| bf16::from_le_bytes(*b).to_f32()).collect(),
        _ => return None,
    })
}

/// Returns the bytes of a `.safetensors`: equal weights and text give equal bytes, in whatever order the weights came.
///
/// # Errors
/// A tensor whose values are not as many as its shape says.
pub fn to_bytes(weights: &Weights, text: &str) -> Result<Vec<u8>, Cause> {
    let floats =
        weights.iter().map(|(name, tensor)| (name.to_string(), StoredTensor::Floats(tensor.clone())));
    to_bytes_of(&floats.collect::<Vec<_>>(), text)
}

/// Returns [`to_bytes`] of tensors of several types.
pub(crate) fn to_bytes_of(stored: &[(String, StoredTensor)], text: &str) -> Result<Vec<u8>, Cause> {
    for (name, stored) in stored {
        let tensor = stored.tensor();
        let len = tensor.shape.iter().try_fold(1usize, |len, axis| len.checked_mul(*axis));
        if len != Some(tensor.data.len()) {
            let (tensor, shape, values) = (name.clone(), tensor.shape.clone(), tensor.data.len());
            return Err(Cause::Shape { tensor, shape, values });
        }
    }
    let metadata = HashMap::from([(KEY.to_string(), text.to_string())]);
    let views = stored.iter().map(|(name, stored)| (name, TensorBytes(stored)));
    serialize(views, Some(metadata)).map_err(|e| Cause::Unwritable(e.to_string()))
}

/// A tensor as the format wants it: little-endian bytes.
struct TensorBytes<'a>(&'a StoredTensor);

impl View for TensorBytes<'_> {
    fn dtype(&self) -> Dtype {
        match self.0 {
            StoredTensor::Floats(_) => Dtype::F32,
            StoredTensor::Halves(_) => Dtype::BF16,
            StoredTensor::Bytes(_) => Dtype::I8,
        }
    }

    fn shape(&self) -> &[usize] {
        &self.0.tensor().shape
    }

    fn data(&self) -> Cow<'_, [u8]> {
        match self.0 {
            StoredTensor::Floats(tensor) => {
                tensor.data.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>().into()
            }
            StoredTensor::Halves(tensor) => {
                tensor.data.iter().flat_map(|v| bf16::from_f32(*v).to_le_bytes()).collect::<Vec<_>>().into()
            }
            StoredTensor::Bytes(tensor) => {
                tensor.data.iter().map(|v| (*v as i8).cast_unsigned()).collect::<Vec<_>>().into()
            }
        }
    }

    fn data_len(&self) -> usize {
        match self.0 {
            StoredTensor::Floats(tensor) => 4 * tensor.data.len(),
            StoredTensor::Halves(tensor) => 2 * tensor.data.len(),
            StoredTensor::Bytes(tensor) => tensor.data.len(),
        }
    }
}
