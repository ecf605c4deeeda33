//! A `.npz` archive: arrays by name.

use crate::dataset::raw::DATA;
use crate::formats::archive::{self, NamedArrays, Take};
use crate::formats::npy;
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
    open: |path| Archive::open(path).map(archive::Archive::new),
};

/// An open archive.
struct Archive {
    zip: ZipArchive<BufReader<File>>,
    /// Names of the arrays in the order in which they were saved.
    saved: Vec<String>,
}

impl Archive {
    fn open(path: &Path) -> Result<Self> {
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
        let mut saved = vec![];
        for entry in zip.file_names() {
            saved.extend(array_name_from_file_name(&entry.map_err(refuse)?).map(str::to_string));
        }
        Ok(Self { zip, saved })
    }
}

impl NamedArrays for Archive {
    fn saved(&self) -> Vec<String> {
        self.saved.clone()
    }

    fn recordings(&self) -> Vec<String> {
        let mut names = self.saved.clone();
        names.sort();
        names
    }

    fn described(&mut self) -> Vec<String> {
        let mut all = vec![];
        for name in self.recordings() {
            let mut form = "(damaged)".to_string();
            // What cannot be read is damaged, and said to be.
            let _ = self.with(&name, "", &mut |header, _, _| {
                form = header.described();
                Ok(())
            });
            all.push(format!("{name} {form}"));
        }
        all
    }

    fn with(&mut self, array: &str, at: &str, take: Take) -> Result<()> {
        let damaged = |why: String| Error::Damaged { at: at.into(), why };
        let entry = file_name_from_array_name(array);
        let mut entry = self.zip.by_name(&entry).map_err(|e| damaged(e.to_string().to_lowercase()))?;
        let header = npy::read_header(&mut entry, at)?;
        take(&header, &mut entry, at)
    }
}
