//! A run folder opened again: its results, and behind every score the record that it follows from.

use taxel_data::Dataset;

use crate::error::{Error, Result};
use crate::run::folder::RunFolder;
use crate::run::records::{FoldKey, FoldRecord};
use crate::run::results::{NetworkResults, Results, ScoringContext};
use crate::run::run_models::older;

impl RunFolder {
    /// Reads the results, and the records of all folds that have scores in them, in the order of the run. Checks all
    /// that other code takes for granted: the samples are those of the run, every label, sample and probability of a
    /// record is there, and the scores are what the records give. Intervals are computed again: those of older versions
    /// were bootstrap intervals, which are too narrow.
    ///
    /// # Errors
    /// Other samples than those of the run; a file that is missing, damaged or does not fit the others.
    pub fn finished(&self, dataset: &Dataset) -> Result<(Results, Vec<FoldRecord>)> {
        let mut results = self.results()?;
        self.same_data("results.json", &results.data_digest, results.data_facts.as_deref(), dataset)?;
        let refuse = |what: String| {
            let reason = format!("{what}; resume the run, which writes it anew");
            Error::damaged(&self.file("results.json"), reason)
        };
        self.keys_of(&results)?;
        if (results.samples, &results.task, &results.sample_shape)
            != (dataset.len(), &dataset.task(), &dataset.spec.shape)
        {
            return Err(refuse("names other samples or classes than the data have".into()));
        }
        let frame = ScoringContext::of(dataset, &results.look_alikes).map_err(|e| refuse(e.to_string()))?;
        let mut records = vec![];
        for network in &mut results.networks {
            let of_row = self.records_of(network, dataset)?;
            let each: Vec<&FoldRecord> = of_row.iter().collect();
            let follows = network.follows_from(&each, &frame);
            if !follows.map_err(|e| refuse(e.to_string()))? {
                let what =
                    format!("its scores of {} are not those of the records in folds/", network.network);
                return Err(refuse(what));
            }
            network.set_interval(&each, &frame);
            records.extend(of_row);
        }
        Ok((results, records))
    }

    /// Refuses samples that are not those whose digest `file` holds, or about which other facts are known than those with
    /// the digest `facts`.
    pub(crate) fn same_data(
        &self,
        file: &str,
        then: &str,
        facts: Option<&str>,
        dataset: &Dataset,
    ) -> Result<()> {
        if then == dataset.digest {
            return match facts {
                Some(facts) if facts != dataset.facts().digest() => Err(self.other_facts(file, dataset)),
                _ => Ok(()),
            };
        }
        let reason = format!(
            "was run on other data than {} holds now (digest {then} in {file}, {} now); bring the data back, or \
             run it again in another folder",
            dataset.source, dataset.digest
        );
        Err(Error::folder(self.path(), reason))
    }

    /// Refuses samples about which `file` was told other facts.
    fn other_facts(&self, file: &str, dataset: &Dataset) -> Error {
        let before = self.environment().ok().and_then(|environment| environment.facts);
        let changed = before.map_or(vec![], |before| before.differences(&dataset.facts()));
        let changed = if changed.is_empty() {
            "layout, channels, unit, rate, full scale or targets".into()
        } else {
            changed.join("; ")
        };
        let reason = format!(
            "was run on the same readings with other facts ({file}): {changed}; bring the facts back, or run it again \
             in another folder"
        );
        Error::folder(self.path(), reason)
    }

    /// Refuses a record that is not about this fold of these samples.
    pub(crate) fn check(&self, record: &FoldRecord, key: &FoldKey, dataset: &Dataset) -> Result<()> {
        let reason = |what| format!("{what}; delete it and resume the run");
        wrong(record, key, dataset).map_err(|what| Error::damaged(&self.record_path(key), reason(what)))
    }

    /// Reads and checks the record of every fold of a row.
    fn records_of(&self, network: &NetworkResults, dataset: &Dataset) -> Result<Vec<FoldRecord>> {
        let mut records = vec![];
        for fold in &network.folds {
            let (network, repetition) = (network.network.clone(), fold.repetition);
            let key = FoldKey { network, repetition, fold: fold.fold };
            let path = self.record_path(&key);
            let record = self.record(&key)?.ok_or_else(|| {
                Error::damaged(&path, "is not there, and results.json has its scores; resume the run")
            })?;
            match (&record.data, &record.model) {
                (Some(data), Some(_)) => {
                    self.same_data(&format!("folds/{key}.json"), data, record.facts.as_deref(), dataset)?;
                }
                _ => return Err(older(&path)),
            }
            self.check(&record, &key, dataset)?;
            records.push(record);
        }
        Ok(records)
    }
}

/// Checks a record; returns the first contradiction.
fn wrong(record: &FoldRecord, key: &FoldKey, dataset: &Dataset) -> std::result::Result<(), String> {
    if record.key != *key {
        return Err(format!("is the record of {}", record.key));
    }
    let tested = record.index.len();
    if tested == 0 || record.index.iter().any(|&row| row >= dataset.len()) {
        return Err("tests samples that the data do not have".into());
    }
    let task = dataset.task();
    if record.outcome.outputs().len() != tested * task.outputs() {
        return Err("does not hold one probability for each sample and class".into());
    }
    if !record.outcome.fits(&task, tested) || !record.outcome.is_about(&dataset.targets, &record.index) {
        return Err("holds labels that the data do not have".into());
    }
    match record.best_epoch {
        Some(best) if best >= record.epochs.len() => Err("names a best epoch that it does not have".into()),
        _ => Ok(()),
    }
}
