//! Recordings that want an answer: labels, if there are any, only say whether it is right.

use crate::load::is_archive;
use crate::one_hot::settle;
use crate::options::Options;
use crate::raw::{Raw, name_of};
use crate::validate::channels;
use crate::{Error, Result, array, arrays, folder, ucr};
use ndarray::{ArrayD, Axis};
use std::path::{Path, PathBuf};

/// Recordings of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Recordings {
    /// The file or folder name without extension.
    pub name: String,
    /// Samples `[N, ...]` in C order, as stored.
    pub x: ArrayD<f32>,
    /// Where each sample comes from: its file, or `x[17]`.
    pub origins: Vec<String>,
    /// Names of each sample's classes `[N][attributes]`; none where nothing is said of them.
    pub truth: Option<Vec<Vec<String>>>,
}

/// Reads recordings for a model that takes samples of `rank` axes: every layout of [`load`](crate::load), with
/// or without labels, a folder of files without class folders, and a single CSV, NPY, MAT, PNG or JPEG file.
///
/// Of a single `.npy`, `rank` axes are one sample and one more are a batch.
///
/// # Errors
///
/// As [`load`](crate::load), labels left aside: classes may be missing, and more may be there than a model knows.
pub fn recordings(path: &Path, options: &Options, rank: usize) -> Result<Recordings> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
        let x = array::read_npy(path)?;
        if x.ndim() == rank + 1 {
            let origins = (0..x.len_of(Axis(0))).map(|i| format!("{}[{i}]", name_of(path))).collect();
            return Ok(Recordings { name: name_of(path), x, origins, truth: None });
        }
    }
    let (mut raw, is_labelled) = open(path, options)?;
    settle(&mut raw, options);
    let chosen = channels(&raw, options)?;
    let truth = is_labelled.then(|| truth(&raw)).filter(|rows| rows.len() == raw.x.len_of(Axis(0)));
    let x = match chosen {
        Some(channels) => raw.x.select(Axis(1), &channels),
        None => raw.x,
    };
    Ok(Recordings { name: raw.name, x, origins: raw.origins, truth })
}

/// What is at `path`, and whether it says anything of classes.
fn open(path: &Path, options: &Options) -> Result<(Raw, bool)> {
    if let Some(files) = ucr::find(path).filter(|_| !path.is_dir()) {
        return Ok((ucr::read(path, &files, options)?, true));
    }
    let file = path.display().to_string();
    let archive = |path: &Path| {
        let raw = arrays::read_unlabelled(path, options)?;
        let is_labelled = !raw.y.is_empty();
        Ok((raw, is_labelled))
    };
    if path.is_file() {
        if is_archive(path) && !is_one_recording(path, options) {
            return archive(path);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        return Ok((unsorted(folder, vec![path.to_path_buf()], options)?, false));
    }
    if !path.is_dir() {
        return Err(Error::NotFound { file });
    }
    let data = path.join("data.npz");
    if data.is_file() {
        return archive(&data);
    }
    let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) =
        folder::entries(path)?.into_iter().partition(|entry| entry.is_dir());
    match folders.is_empty() {
        false => Ok((folder::read(path, &folders, options)?, true)),
        true if files.is_empty() => Err(Error::NoDatasetInFolder { file, hint: String::new() }),
        true => Ok((unsorted(path, folder::in_order(files), options)?, false)),
    }
}

/// Files of which nobody says what class they are.
fn unsorted(root: &Path, files: Vec<PathBuf>, options: &Options) -> Result<Raw> {
    folder::read_files(root, &[files], vec![String::new()], options)
}

/// Whether a MATLAB file holds one recording and not a set of them.
fn is_one_recording(path: &Path, options: &Options) -> bool {
    crate::mat::is_named(path)
        && crate::mat::Archive::open(path).is_ok_and(|archive| !archive.arrays.contains(&options.x))
}

/// Names of the classes of each sample; a label that has no name goes by its number.
fn truth(raw: &Raw) -> Vec<Vec<String>> {
    let name = |(column, label): (usize, &i64)| {
        let names = raw.names.as_ref().and_then(|names| names.columns.get(column));
        let named = usize::try_from(*label).ok().and_then(|label| names?.get(label));
        named.cloned().unwrap_or_else(|| label.to_string())
    };
    raw.y.chunks_exact(raw.columns).map(|row| row.iter().enumerate().map(name).collect()).collect()
}
