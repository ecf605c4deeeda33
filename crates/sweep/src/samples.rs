//! Samples in memory: loaded once for all trials that use them at the time.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use taxel_data::Dataset;
use taxel_trainer::{Config, Experiment, Origin};

use crate::error::Result;
use crate::trial::{hashed, toml_of};

/// Samples that some trial of this process has in use.
#[derive(Default)]
pub(crate) struct TrialSamples {
    known: Mutex<HashMap<String, Weak<Dataset>>>,
}

/// Who goes from trial to trial, and keeps the samples of the last one: the next has often the same.
pub(crate) struct Loader<'a> {
    samples: &'a TrialSamples,
    last: Option<Arc<Dataset>>,
}

impl TrialSamples {
    pub fn loader(&self) -> Loader<'_> {
        Loader { samples: self, last: None }
    }
}

impl Loader<'_> {
    /// Returns the samples of an experiment.
    ///
    /// # Errors
    /// Data that cannot be loaded.
    pub fn of(&mut self, experiment: &Experiment) -> Result<Arc<Dataset>> {
        let key = data_key(experiment.config());
        let mut known = self.samples.known.lock().unwrap_or_else(PoisonError::into_inner);
        let dataset = match known.get(&key).and_then(Weak::upgrade) {
            Some(dataset) => dataset,
            None => {
                let dataset = Arc::new(experiment.dataset()?);
                known.retain(|_, other| other.strong_count() > 0);
                known.insert(key, Arc::downgrade(&dataset));
                dataset
            }
        };
        self.last = Some(Arc::clone(&dataset));
        Ok(dataset)
    }
}

/// Returns a key for all that the samples of a config depend on: its `[data]`, the seed of a scene, and the encoding, which says
/// what the axes of recordings are.
pub(crate) fn data_key(config: &Config) -> String {
    let seed = match config.data.origin {
        Origin::Scene(_) => config.seed.to_string(),
        Origin::Recordings(_) => String::new(),
    };
    hashed(&[&toml_of(&config.data), &seed, &toml_of(&config.encoding)])
}
