//! The folder of result pages: where they are, and how they are read and written.

use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// Titles of the papers' sections, by number: authors and year, then the subject.
pub(crate) const TITLES: [(&str, &str); 5] = [
    ("000", "Kaewrakmuk and Srinonchat 2026: hardness of grasped objects from fingertips (Hybrid-CNN)"),
    ("001", "Rouhafzay et al. 2021: vision networks for touch (visuotactile transfer)"),
    ("002", "Gandarias et al. 2019b: deformable objects squeezed by hand (TactNet3D)"),
    ("003", "Pastor et al. 2019: objects in an underactuated gripper (TactNet3D against 2D networks)"),
    ("004", "Zhang et al. 2022: elasticity and hardness levels from two fingers (multi-scale CNN)"),
];

/// Returns authors and year of a paper by its number; the number itself of one that is not listed.
pub(crate) fn cited(paper: &str) -> &str {
    let title = TITLES.iter().find(|(number, _)| *number == paper);
    title.and_then(|(_, title)| title.split_once(": ")).map_or(paper, |(authors, _)| authors)
}

/// A folder of result pages, `docs/results` of the repository.
#[derive(Debug, Clone)]
pub struct Pages {
    folder: PathBuf,
}

impl Pages {
    /// Opens the folder of the pages.
    ///
    /// # Errors
    /// No such folder.
    pub fn at(folder: &Path) -> Result<Self> {
        if folder.is_dir() {
            return Ok(Pages { folder: folder.to_path_buf() });
        }
        Err(Error::file(folder, "is no folder of result pages; run from the repository or give --pages"))
    }

    /// Returns the path of a file below the folder.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Returns the path of a page.
    pub(crate) fn page(&self, name: &str) -> PathBuf {
        self.file(&format!("{name}.md"))
    }

    /// Returns a link to a page, or its plain name where there is none.
    pub(crate) fn linked(&self, name: &str) -> String {
        if self.page(name).exists() { format!("[{name}]({name}.md)") } else { name.into() }
    }

    /// Reads a TOML file.
    pub(crate) fn read<T: DeserializeOwned>(&self, name: &str) -> Result<T> {
        let path = self.file(name);
        let text = read(&path)?;
        toml::from_str(&text).map_err(|e| Error::file(&path, e))
    }

    /// Writes a file, whole or not at all.
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<PathBuf> {
        let path = self.file(name);
        taxel::base::files::write_whole(&path, text.as_bytes()).map_err(|e| Error::file(&path, e))?;
        Ok(path)
    }
}

/// Reads a text file.
pub(crate) fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path).map_err(|e| Error::file(path, e))
}

/// Returns a row of a Markdown table.
pub(crate) fn row<T: AsRef<str>>(cells: &[T]) -> String {
    let cells: Vec<&str> = cells.iter().map(AsRef::as_ref).collect();
    format!("| {} |", cells.join(" | "))
}

/// Returns the text with its first letter as a capital.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
