//! Which trials are on the same data set: by the config's `[data]` table, and by the samples that it leads to.

use std::collections::HashMap;

use crate::trial::DataOf;

/// The data sets seen so far. A table with several seeds is one, and so are tables with the same samples.
#[derive(Default)]
pub(crate) struct DataSets {
    /// Place of each table.
    tables: HashMap<String, usize>,
    /// Place of a table that has led to these samples.
    samples: HashMap<String, usize>,
    /// For each place an earlier one of the same data set; the first one's is its own.
    earlier: Vec<usize>,
}

impl DataSets {
    /// Returns the place of the `[data]` table of a trial.
    pub fn place(&mut self, data: &DataOf) -> usize {
        let next = self.earlier.len();
        let place = *self.tables.entry(data.set.clone()).or_insert(next);
        if place == next {
            self.earlier.push(place);
        }
        let other = *self.samples.entry(data.digest.clone()).or_insert(place);
        let (a, b) = (self.data_set(place), self.data_set(other));
        self.earlier[a.max(b)] = a.min(b);
        place
    }

    /// Returns the data set of a table: the place of its first table.
    pub fn data_set(&self, mut place: usize) -> usize {
        while self.earlier[place] != place {
            place = self.earlier[place];
        }
        place
    }
}
