//! Networks by name.

use taxel_base::names::hint;

use crate::entry::Entry;
use crate::error::{Error, Result};

/// Networks by name, in the order in which they were added.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    entries: Vec<Entry>,
}

impl Registry {
    /// Makes a registry of no network yet.
    pub fn empty() -> Self {
        Registry::default()
    }

    /// Adds a network.
    ///
    /// # Errors
    /// A name that another network has.
    pub fn add(&mut self, entry: Entry) -> Result<()> {
        if self.entries.iter().any(|other| other.name == entry.name) {
            return Err(Error::Twice { name: entry.name });
        }
        self.entries.push(entry);
        Ok(())
    }

    /// Returns the network called `name`.
    ///
    /// # Errors
    /// No such network; the error offers the nearest names.
    pub fn find(&self, name: &str) -> Result<&Entry> {
        self.entries
            .iter()
            .find(|entry| entry.name == name)
            .ok_or_else(|| Error::Unknown { name: name.into(), hint: self.hint(name) })
    }

    /// Iterates over all networks in the order in which they were added.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter()
    }

    fn hint(&self, name: &str) -> String {
        let known = self.entries.iter().map(|entry| entry.name.as_str());
        if self.entries.is_empty() { "none is registered".into() } else { hint(name, known) }
    }
}
