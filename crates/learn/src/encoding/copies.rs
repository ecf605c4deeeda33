//! Copies among samples of which an encoding reads a part.

use taxel_data::Dataset;

use super::axes::reduced;
use super::settings::Encoding;
use crate::error::Result;
use crate::problem::Problem;

impl Encoding {
    /// Seeks exact copies among the samples in the part of them that is read ([`Encoding::reduce`]): what is equal there must
    /// not be torn between training and test.
    ///
    /// # Errors
    /// A reduction without a meaning for such samples.
    pub fn seek_copies(&self, dataset: &mut Dataset) -> Result<()> {
        if self.reduce.is_whole() || dataset.row_hash.is_empty() {
            return Ok(());
        }
        let read = reduced(&dataset.x, dataset.spec.layout, &self.reduce)
            .map_err(|e| Problem::new("encoding.reduce", "{ .. }", e.to_string()))?;
        dataset.seek_copies_in(&read);
        Ok(())
    }
}
