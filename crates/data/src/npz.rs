//! A `.npz` archive: arrays by name.

use crate::npy::{self, Header};
use crate::{Error, Result};
use npyz::npz::NpzArchive;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// An open archive.
pub(crate) struct Archive {
    npz: NpzArchive<BufReader<File>>,
    /// Names of the arrays, sorted.
    pub arrays: Vec<String>,
}

impl Archive {
    pub fn open(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let io = |e: std::io::Error| Error::Io { file: file.clone(), kind: e.kind() };
        let mut start = Vec::new();
        let open = File::open(path).map_err(io)?;
        open.take(4).read_to_end(&mut start).map_err(io)?;
        if start.is_empty() {
            return Err(Error::EmptyFile { file });
        }
        let reader = BufReader::new(File::open(path).map_err(io)?);
        let npz = NpzArchive::new(reader).map_err(|e| {
            let (file, why) = (file.clone(), e.to_string().to_lowercase());
            if start.starts_with(b"PK") {
                Error::DamagedArchive { file, why }
            } else {
                Error::NotAnArchive { file, why }
            }
        })?;
        let mut arrays: Vec<String> = npz.array_names().map(str::to_string).collect();
        arrays.sort();
        Ok(Self { npz, arrays })
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    pub fn with<T>(
        &mut self,
        array: &str,
        at: &str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        let damaged = |why: String| Error::Damaged { at: at.into(), why };
        let entry = npyz::npz::file_name_from_array_name(array);
        let mut entry =
            self.npz.zip_archive().by_name(&entry).map_err(|e| damaged(e.to_string().to_lowercase()))?;
        let header = npy::read_header(&mut entry, at)?;
        read(&header, &mut entry, at)
    }
}
