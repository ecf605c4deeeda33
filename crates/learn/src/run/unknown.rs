//! Trainings without some classes, in a run folder: `unknown/` and their scores in `unknown.json`.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::certainty::{UnknownScores, WithoutClasses};
use crate::error::{Error, Result};
use crate::json_file::{read_json, write_json};
use crate::run::folder::RunFolder;

/// Scores of the gates of all rows.
const SCORES: &str = "unknown.json";
/// Folder of the trainings.
const TRAININGS: &str = "unknown";

/// A training with the digest of all that it depends on.
#[derive(Serialize, Deserialize)]
struct Kept {
    of: String,
    without: WithoutClasses,
}

impl RunFolder {
    /// Reads the training that was kept under a digest.
    ///
    /// # Errors
    /// A damaged file.
    pub fn without_classes(&self, of: &str) -> Result<Option<WithoutClasses>> {
        let kept: Option<Kept> = read_json(&self.without_path(of))?;
        Ok(kept.filter(|kept| kept.of == of).map(|kept| kept.without))
    }

    /// Keeps a training under a digest.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep_without_classes(&self, of: &str, without: &WithoutClasses) -> Result<()> {
        let kept = Kept { of: of.into(), without: without.clone() };
        let folder = self.file(TRAININGS);
        std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, "written", e))?;
        write_json(&self.without_path(of), &kept, false).map(|_| ())
    }

    fn without_path(&self, of: &str) -> PathBuf {
        self.file(TRAININGS).join(format!("{}.json", of.get(..24).unwrap_or(of)))
    }

    /// Reads how well the gates tell classes that they have not learned; none where that was not tried.
    ///
    /// # Errors
    /// A damaged file.
    pub fn unknown(&self) -> Result<Option<Vec<UnknownScores>>> {
        read_json(&self.file(SCORES))
    }

    /// Writes how well the gates tell classes that they have not learned.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_unknown(&self, scores: &[UnknownScores]) -> Result<()> {
        write_json(&self.file(SCORES), &scores.to_vec(), true).map(|_| ())
    }
}
