//! Trainings without some classes, in a run folder: `unknown/` and their scores in `unknown.json`.

use crate::certainty::{UnknownScores, WithoutClasses};
use crate::error::Result;
use crate::json_file::{read_json, write_json};
use crate::run::folder::RunFolder;
use crate::run::kept::{read_kept, write_kept};

/// Scores of the gates of all rows.
const SCORES: &str = "unknown.json";
/// Folder of the trainings.
const TRAININGS: &str = "unknown";

impl RunFolder {
    /// Reads the training that was kept under a digest.
    ///
    /// # Errors
    /// A damaged file.
    pub fn without_classes(&self, of: &str) -> Result<Option<WithoutClasses>> {
        read_kept(&self.file(TRAININGS), of)
    }

    /// Keeps a training under a digest.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep_without_classes(&self, of: &str, without: &WithoutClasses) -> Result<()> {
        write_kept(&self.file(TRAININGS), of, without)
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
