//! The tensors of a file, read when they are asked for.

use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Component, Path};

use half::{bf16, f16};
use taxel_graph::Tensor;

use crate::error::Cause;
use crate::proto::{self, EXTERNAL, dtype};

/// The most numbers of a list that describes a shape.
pub const MOST_AXES: usize = 64;

/// Values that may be read beyond those that the file holds: small tensors that several nodes share.
const SPARE: usize = 1 << 20;

/// Every stored tensor of a model.
pub struct StoredTensors<'a> {
    tensors: Vec<proto::Tensor>,
    /// Where files with values lie; none for a model that is not a file.
    folder: Option<&'a Path>,
    /// Files with values, by their names.
    files: HashMap<String, File>,
    /// Values that may still be read: no file becomes more memory than it is worth.
    left: usize,
}

impl<'a> StoredTensors<'a> {
    /// Makes a list without tensors yet, for a file of `length` bytes.
    pub fn new(folder: Option<&'a Path>, length: usize) -> Self {
        StoredTensors { tensors: vec![], folder, files: HashMap::new(), left: length / 2 + SPARE }
    }

    /// Adds a tensor; its number.
    pub fn add(&mut self, tensor: proto::Tensor) -> usize {
        self.tensors.push(tensor);
        self.tensors.len() - 1
    }

    /// Returns the name of a tensor in the file; none where it has none.
    pub fn name(&self, index: usize) -> Option<&str> {
        self.tensors[index].name.as_deref().filter(|name| !name.is_empty())
    }

    /// Returns the number of values and the axis sizes.
    fn shape(&self, index: usize) -> Result<(usize, Vec<usize>), Cause> {
        let dims = &self.tensors[index].dims;
        let shape: Option<Vec<usize>> = dims.iter().map(|&size| usize::try_from(size).ok()).collect();
        let count =
            shape.as_ref().and_then(|shape| shape.iter().try_fold(1usize, |n, size| n.checked_mul(*size)));
        shape
            .and_then(|shape| Some((count?, shape)))
            .ok_or_else(|| self.refuse(index, format!("has the shape {dims:?}")))
    }

    fn refuse(&self, index: usize, reason: impl Into<String>) -> Cause {
        let name = self.name(index).unwrap_or("without a name").into();
        Cause::Tensor { name, reason: reason.into() }
    }

    /// Returns a list of integers, or a single one without an axis; none where it is something else.
    pub fn ints(&self, index: usize) -> Option<(Vec<i64>, bool)> {
        let tensor = &self.tensors[index];
        let (count, shape) = self.shape(index).ok()?;
        if shape.len() > 1 || count > MOST_AXES || tensor.location == Some(EXTERNAL) {
            return None;
        }
        let raw = tensor.raw.as_deref();
        let values: Vec<i64> = match (tensor.dtype?, raw) {
            (dtype::INT64, Some(raw)) => raw.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b)).collect(),
            (dtype::INT32, Some(raw)) => {
                raw.as_chunks().0.iter().map(|b| i32::from_le_bytes(*b).into()).collect()
            }
            (dtype::INT64, None) => tensor.int64s.clone(),
            (dtype::INT32, None) => tensor.int32s.iter().map(|&v| v.into()).collect(),
            _ => return None,
        };
        (values.len() == count).then_some((values, shape.is_empty()))
    }

    /// Returns a single truth value; none where it is something else.
    pub fn flag(&self, index: usize) -> Option<bool> {
        let tensor = &self.tensors[index];
        let is_one = tensor.dims.iter().all(|size| *size == 1) && tensor.location != Some(EXTERNAL);
        if tensor.dtype != Some(dtype::BOOL) || !is_one {
            return None;
        }
        match (tensor.raw.as_deref(), tensor.int32s.as_slice()) {
            (Some([byte]), _) => Some(*byte != 0),
            (None, [number]) => Some(*number != 0),
            _ => None,
        }
    }

    /// Returns a tensor's values as single-precision numbers.
    ///
    /// # Errors
    /// Another type, values that do not fill the shape, a file beside the model that is missing or cut.
    pub fn floats(&mut self, index: usize) -> Result<Tensor, Cause> {
        let (count, shape) = self.shape(index)?;
        let kind = self.tensors[index].dtype.unwrap_or_default();
        let Some(size) = size(kind) else {
            let reason = format!(
                "is {}; taxel reads float32, float64, float16 and bfloat16 (export the network before it is quantised)",
                type_name(kind)
            );
            return Err(self.refuse(index, reason));
        };
        let external = self.tensors[index].location == Some(EXTERNAL);
        let bytes = count.checked_mul(size);
        let bytes = bytes.ok_or_else(|| self.refuse(index, format!("has the shape {shape:?}")))?;
        let file = if external { Some(self.open(index)?) } else { None };
        self.left = self.left.checked_sub(count).ok_or_else(|| {
            self.refuse(
                index,
                "is read so often, with others, that weights take more memory than the file is worth",
            )
        })?;
        let tensor = &self.tensors[index];
        let data = match file {
            Some(location) => self.external(index, &location, bytes).map(|raw| floats(kind, &raw))?,
            None => match &tensor.raw {
                Some(raw) if raw.len() == bytes => floats(kind, raw),
                Some(raw) => {
                    let reason = format!("holds {} bytes, its shape {shape:?} takes {bytes}", raw.len());
                    return Err(self.refuse(index, reason));
                }
                None => plain(kind, tensor),
            },
        };
        if data.len() != count {
            let reason = format!("holds {} values, which do not fill its shape {shape:?}", data.len());
            return Err(self.refuse(index, reason));
        }
        Ok(Tensor { shape, data })
    }

    fn entry(&self, index: usize, key: &str) -> Option<&str> {
        let entries = self.tensors[index].external.iter();
        entries.filter(|entry| entry.key.as_deref() == Some(key)).find_map(|entry| entry.value.as_deref())
    }

    /// Opens the file that holds a tensor's values; its name.
    fn open(&mut self, index: usize) -> Result<String, Cause> {
        let location = self.entry(index, "location").unwrap_or_default().to_string();
        if self.files.contains_key(&location) {
            return Ok(location);
        }
        let Some(folder) = self.folder else {
            let reason = format!("has its values in the file {location:?}; read the model from its file");
            return Err(self.refuse(index, reason));
        };
        let inside = |part: Component| matches!(part, Component::Normal(_));
        if location.is_empty() || !Path::new(&location).components().all(inside) {
            let reason = format!("has its values in {location:?}, which is not below the model's folder");
            return Err(self.refuse(index, reason));
        }
        let path = folder.join(&location);
        if leads_out(folder, &path) {
            let reason = format!(
                "has its values in {location:?}, which is a link out of the model's folder; put the file itself there"
            );
            return Err(self.refuse(index, reason));
        }
        let open = || {
            let file = File::open(&path)?;
            let length = file.metadata()?.len();
            std::io::Result::Ok((file, length))
        };
        let (file, length) = open().map_err(|e| {
            let reason = format!(
                "has its values in {}, which cannot be read: {e}; keep that file beside the model",
                path.display()
            );
            self.refuse(index, reason)
        })?;
        self.left = self.left.saturating_add(usize::try_from(length / 2).unwrap_or(usize::MAX));
        self.files.insert(location.clone(), file);
        Ok(location)
    }

    /// Reads a tensor's bytes out of an opened file.
    fn external(&self, index: usize, location: &str, bytes: usize) -> Result<Vec<u8>, Cause> {
        let refuse = |reason: String| self.refuse(index, format!("in {location:?} {reason}"));
        let number = |key| match self.entry(index, key) {
            None => Ok(None),
            Some(text) => text.parse().map(Some).map_err(|_| refuse(format!("has the {key} {text:?}"))),
        };
        let (offset, length): (Option<u64>, Option<u64>) = (number("offset")?, number("length")?);
        if length.is_some_and(|length| length != bytes as u64) {
            return Err(refuse(format!("has not the {bytes} bytes of its shape")));
        }
        let Some(mut file) = self.files.get(location) else { return Err(refuse("is not open".into())) };
        let offset = offset.unwrap_or(0);
        let whole = file.metadata().map(|data| data.len())?;
        if offset.checked_add(bytes as u64).is_none_or(|end| end > whole) {
            return Err(refuse(format!(
                "ends after byte {whole}, the end of that file: it is cut or another's"
            )));
        }
        let mut raw = vec![0; bytes];
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(&mut raw)?;
        Ok(raw)
    }
}

/// Checks whether a path leads out of its folder by a symbolic link; one that cannot be followed does not.
fn leads_out(folder: &Path, path: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (folder.canonicalize(), path.canonicalize()) {
        (Ok(folder), Ok(path)) => !path.starts_with(folder),
        _ => false,
    }
}

/// Returns the size of a number in bytes, of the types that taxel reads.
fn size(kind: i32) -> Option<usize> {
    match kind {
        dtype::FLOAT => Some(4),
        dtype::DOUBLE => Some(8),
        dtype::FLOAT16 | dtype::BFLOAT16 => Some(2),
        _ => None,
    }
}

fn floats(kind: i32, raw: &[u8]) -> Vec<f32> {
    match kind {
        dtype::FLOAT => raw.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
        dtype::DOUBLE => raw.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b) as f32).collect(),
        dtype::FLOAT16 => raw.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
        _ => raw.as_chunks().0.iter().map(|b| bf16::from_le_bytes(*b).to_f32()).collect(),
    }
}

/// Returns the values in a field of their own type; halves are there as the bits of integers.
fn plain(kind: i32, tensor: &proto::Tensor) -> Vec<f32> {
    let bits = tensor.int32s.iter().map(|&bits| bits as u16);
    match kind {
        dtype::FLOAT => tensor.floats.clone(),
        dtype::DOUBLE => tensor.doubles.iter().map(|&v| v as f32).collect(),
        dtype::FLOAT16 => bits.map(|bits| f16::from_bits(bits).to_f32()).collect(),
        _ => bits.map(|bits| bf16::from_bits(bits).to_f32()).collect(),
    }
}

/// Returns the name of a type for messages.
pub fn type_name(kind: i32) -> String {
    let names = [
        "undefined",
        "float32",
        "uint8",
        "int8",
        "uint16",
        "int16",
        "int32",
        "int64",
        "string",
        "bool",
        "float16",
        "float64",
        "uint32",
        "uint64",
        "complex64",
        "complex128",
        "bfloat16",
    ];
    let name = usize::try_from(kind).ok().and_then(|kind| names.get(kind));
    name.map_or_else(|| format!("of type {kind}"), |name| name.to_string())
}
