//! Classes made of values by a threshold: rest, and an event.

use crate::dataset::problems::Problems;
use crate::dataset::raw::Raw;
use crate::dataset::targets::{Targets, Values};
use crate::options::{ReadOptions, refuse_set};
use crate::targets::event::Event;
use crate::targets::options::TaskKind;
use crate::{Error, Result};

impl Event {
    /// Returns options that read its array or column as values; refuses settings that name other targets.
    pub(crate) fn options(&self, options: &ReadOptions, file: &str) -> Result<ReadOptions> {
        let others = [
            ("y", options.y.is_some()),
            ("quantities", options.quantities.is_some()),
            ("task", options.task.is_some()),
            ("attribute", options.attribute.is_some()),
            ("attributes", !options.attributes.is_empty()),
        ];
        let why = "speaks of other targets than event, which names its array and makes two classes of it; leave one of them \
                   out";
        refuse_set(file, &others, why)?;
        let y = Some(vec![self.name().to_string()].into());
        Ok(ReadOptions { y, task: Some(TaskKind::Values), ..options.clone() })
    }

    /// Refuses an array of several values a sample.
    pub(crate) fn refuse_several(&self, raw: &Raw) -> Result<()> {
        let columns = raw.values.as_ref().map_or(1, |values| values.quantities().len());
        if columns == 1 {
            return Ok(());
        }
        let name = self.name();
        Err(Error::file(
            &raw.file,
            format!(
                "event = \"{self}\" takes one number for each sample, and {name} holds {columns}; name an array of one, or \
                 save {name}[:, 0] under a name of its own"
            ),
        ))
    }

    /// Returns 1 for values that are events and 0 for others; NaN stays.
    pub(crate) fn marks(&self, values: &Values) -> Values {
        let mark =
            |value: &f32| if value.is_nan() { *value } else { f32::from(u8::from(self.is_in(*value))) };
        Values::new(values.quantities().to_vec(), values.values().iter().map(mark).collect())
    }

    /// Returns the classes of samples with these values; notes where all are of one.
    pub(crate) fn targets(&self, values: &[f32], raw: &Raw, faults: &mut Problems) -> Targets {
        let y: Vec<u32> = values.iter().map(|value| u32::from(self.is_in(*value))).collect();
        let events = y.iter().filter(|label| **label == 1).count();
        let is_missing = values.iter().any(|value| value.is_nan());
        if (events == 0 || events == y.len()) && !is_missing {
            let least = values.iter().copied().fold(f32::INFINITY, f32::min);
            let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let (count, samples, name) = (if events == 0 { "none" } else { "all" }, y.len(), self.name());
            faults.push(Error::file(
                &raw.file,
                format!(
                    "event = \"{self}\" is true of {count} of {samples} samples: {name} lies between {least} and {most}; \
                     choose a number between them"
                ),
            ));
        }
        Targets::classes(&self.classes(), &y)
    }
}
