//! Reads `.npz` archives: arrays by name.

use crate::dataset::raw::DATA;
use crate::formats::archive::{NamedArrays, Take};
use crate::formats::npy::{self, Header};
use crate::layout::arrays::ArrayFile;
use crate::reader::Format;
use crate::{Error, Result};
use npyz::npz::{array_name_from_file_name, file_name_from_array_name};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use zip::ZipArchive;

/// Reads `.npz` archives, and folders with a `data.npz`.
pub(crate) const NPZ: ArrayFile = ArrayFile {
    format: &Format {
        name: "NumPy archive",
        endings: &["npz"],
        holds: "`x` [N, F], [N, C, T], [N, H, W] or [N, T, H, W]; `y` [N], one-hot or [N, k]; optional groups and marks \
                of test samples; also as `data.npz` in a folder",
        becomes: "as stored; class names are the texts, or from `labels.json` beside it",
    },
    inside: Some(DATA),
    recording: None,
    open: |path| Ok(Box::new(NpzArchive::open(path)?)),
};

/// An open archive.
struct NpzArchive {
    file: String,
    zip: ZipArchive<BufReader<File>>,
    /// Names of the arrays in the order in which they were saved.
    saved: Vec<String>,
}

impl NpzArchive {
    fn open(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let io = Error::io(path);
        let mut start = Vec::new();
        let open = File::open(path).map_err(&io)?;
        open.take(4).read_to_end(&mut start).map_err(&io)?;
        if start.is_empty() {
            return Err(Error::EmptyFile { file });
        }
        let reader = BufReader::new(File::open(path).map_err(io)?);
        let refuse = |e: zip::result::ZipError| {
            let why = e.to_string().to_lowercase();
            let reason = if start.starts_with(b"PK") {
                format!("is cut short or damaged ({why}); copy it again")
            } else {
                format!("is not a .npz archive ({why}); write it with numpy.savez")
            };
            Error::file(&file, reason)
        };
        let zip = ZipArchive::new(reader).map_err(refuse)?;
        let mut saved = vec![];
        for entry in zip.file_names() {
            saved.extend(array_name_from_file_name(&entry.map_err(refuse)?).map(str::to_string));
        }
        Ok(Self { file, zip, saved })
    }
}

impl NamedArrays for NpzArchive {
    fn file(&self) -> &str {
        &self.file
    }

    fn saved(&self) -> Vec<String> {
        self.saved.clone()
    }

    fn header(&mut self, array: &str) -> Option<Header> {
        let mut entry = self.zip.by_name(&file_name_from_array_name(array)).ok()?;
        npy::read_header(&mut entry, "").ok()
    }

    fn stream(&mut self, array: &str, at: &str, take: Take) -> Result<()> {
        if !self.saved.iter().any(|saved| saved == array) {
            return Ok(());
        }
        let damaged = |why: String| Error::Damaged { at: at.into(), why };
        let entry = file_name_from_array_name(array);
        let mut entry = self.zip.by_name(&entry).map_err(|e| damaged(e.to_string().to_lowercase()))?;
        let header = npy::read_header(&mut entry, at)?;
        take(&header, &mut entry, at)
    }
}
