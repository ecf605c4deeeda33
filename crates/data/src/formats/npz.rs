//! A `.npz` archive: arrays by name.

use crate::formats::npy::{self, Header};
use crate::{Error, Result};
use npyz::npz::{array_name_from_file_name, file_name_from_array_name};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use zip::ZipArchive;

/// An open archive.
pub(crate) struct Archive {
    zip: ZipArchive<BufReader<File>>,
    /// Names of the arrays, sorted.
    pub arrays: Vec<String>,
    /// The same in the order in which they were saved.
    pub saved: Vec<String>,
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
        let refuse = |e: zip::result::ZipError| {
            let (file, why) = (file.clone(), e.to_string().to_lowercase());
            if start.starts_with(b"PK") {
                Error::DamagedArchive { file, why }
            } else {
                Error::NotAnArchive { file, why }
            }
        };
        let zip = ZipArchive::new(reader).map_err(refuse)?;
        let mut arrays = vec![];
        for entry in zip.file_names() {
            arrays.extend(array_name_from_file_name(&entry.map_err(refuse)?).map(str::to_string));
        }
        let saved = arrays.clone();
        arrays.sort();
        Ok(Self { zip, arrays, saved })
    }

    /// Name, type and shape of each array.
    pub fn described(&mut self) -> Vec<String> {
        let names = self.arrays.clone();
        let own = |name: String| {
            let form = self.with(&name, "", |header, _, _| Ok(header.described()));
            form.map_or_else(|_| format!("{name} (damaged)"), |form| format!("{name} {form}"))
        };
        names.into_iter().map(own).collect()
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    pub fn with<T>(
        &mut self,
        array: &str,
        at: &str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        let damaged = |why: String| Error::Damaged { at: at.into(), why };
        let entry = file_name_from_array_name(array);
        let mut entry = self.zip.by_name(&entry).map_err(|e| damaged(e.to_string().to_lowercase()))?;
        let header = npy::read_header(&mut entry, at)?;
        read(&header, &mut entry, at)
    }
}
