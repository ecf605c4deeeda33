//! A run folder opened: its data, its folds and its models.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use taxel_data::{Dataset, Task};
use taxel_faults::Fault;
use taxel_learn::metrics::Levels;
use taxel_learn::{Card, FoldKey, FoldRecord, Model, NetworkResults, Results, RunFolder};

use crate::error::{Error, Result};
use crate::values::Primary;

/// A run folder with the samples that it was run on.
pub struct Case {
    /// The folder.
    pub folder: RunFolder,
    /// Its scores.
    pub results: Results,
    /// The samples, read or simulated again; equal to those of the run.
    pub dataset: Dataset,
    /// Finished folds, in the order of the run.
    records: Vec<FoldRecord>,
    /// Cards of the models that were read.
    cards: Mutex<BTreeMap<String, Arc<Card>>>,
}

impl Case {
    /// Opens a run folder with the data set that it was run on.
    ///
    /// # Errors
    /// A folder without finished folds or with damaged ones, or samples that are not those of the run.
    pub fn new(folder: RunFolder, dataset: Dataset) -> Result<Self> {
        let (results, records) = folder.finished(&dataset)?;
        if records.is_empty() {
            return Err(Error::run(&folder.file("results.json"), "has no finished fold; resume the run"));
        }
        Ok(Case { folder, results, dataset, records, cards: Mutex::default() })
    }

    /// Returns what is learned.
    pub fn task(&self) -> &Task {
        &self.results.task
    }

    /// Returns the metric that methods are compared by.
    pub fn primary(&self) -> Primary {
        Primary::of(self.task())
    }

    /// Returns the sizes of the attributes; none of values.
    pub fn levels(&self) -> Levels {
        Levels::of_task(self.task())
    }

    /// Returns the saved model of a finished fold.
    ///
    /// # Errors
    /// No such fold; a model that is missing, damaged or not the one that the fold wrote.
    pub fn model(&self, key: &FoldKey) -> Result<Model> {
        let record = self.records.iter().find(|record| record.key == *key);
        let unknown = || Error::run(self.folder.path(), format!("has no finished fold {key}"));
        let model = self.folder.model(record.ok_or_else(unknown)?)?;
        let mut cards = self.cards.lock().unwrap_or_else(PoisonError::into_inner);
        cards.entry(key.to_string()).or_insert_with(|| Arc::new(model.card().clone()));
        Ok(model)
    }

    /// Returns the saved model of the first finished fold of a row.
    ///
    /// # Errors
    /// As [`Case::model`].
    pub fn first_model(&self, network: &str) -> Result<Model> {
        let first = self.records.iter().find(|record| record.key.network == network);
        let unknown = || Error::run(self.folder.path(), format!("{network} has no finished fold"));
        self.model(&first.ok_or_else(unknown)?.key)
    }

    /// Returns the card of the saved model of a fold; its file is read once.
    ///
    /// # Errors
    /// As [`Case::model`].
    pub fn card(&self, key: &FoldKey) -> Result<Arc<Card>> {
        let known = self.cards.lock().unwrap_or_else(PoisonError::into_inner).get(&key.to_string()).cloned();
        match known {
            Some(card) => Ok(card),
            None => Ok(Arc::new(self.model(key)?.card().clone())),
        }
    }

    /// Returns the finished folds of `network`, in the order of the run.
    pub fn records(&self, network: &str) -> impl Iterator<Item = &FoldRecord> {
        self.records.iter().filter(move |record| record.key.network == network)
    }

    /// Returns the finished folds of the first repetition of `network`.
    pub fn first_repetition(&self, network: &str) -> impl Iterator<Item = &FoldRecord> {
        self.records(network).filter(|record| record.key.repetition == 0)
    }

    /// Lists the names of the networks and baselines that are compared further: of a learning curve's rows those with
    /// the most training samples.
    pub fn compared(&self) -> Vec<&str> {
        let most = self.results.networks.iter().filter_map(|n| n.per_class).max();
        let rows = self.results.networks.iter().filter(|n| n.per_class == most && !n.folds.is_empty());
        rows.filter(|n| left_out(n).is_none()).map(|n| n.network.as_str()).collect()
    }

    /// Returns the rows that were trained under all faults but one, with that fault: they tell how an unseen fault is
    /// borne.
    pub fn probes(&self) -> Vec<(&str, Fault)> {
        let rows = self.results.networks.iter().filter(|n| !n.folds.is_empty());
        rows.filter_map(|n| Some((n.network.as_str(), left_out(n)?))).collect()
    }
}

fn left_out(row: &NetworkResults) -> Option<Fault> {
    row.hardening.as_ref()?.unmet
}
