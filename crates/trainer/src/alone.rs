//! One network of an experiment by itself, on less of every sample or in another size.

use taxel_learn::{Problem, Reduction, clean};
use taxel_zoo::Registry;
use toml::{Table, Value};

use crate::config::Baseline;
use crate::error::Result;
use crate::experiment::Experiment;
use crate::network::Network;

/// What is changed of one network's experiment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Alone {
    /// What is left of a sample, beside what the experiment leaves already.
    pub reduce: Reduction,
    /// Settings of the network in place of its own.
    pub set: Table,
    /// Epochs in place of its own, and no least number of steps.
    pub epochs: Option<usize>,
}

impl Experiment {
    /// The experiment of one of its networks or baselines, by the name that tables give it, with `changes`. The network
    /// keeps its label, and the experiment is called as before with `-shrunk` behind it.
    ///
    /// # Errors
    /// No such network, or a change that it does not allow.
    pub fn alone(&self, name: &str, changes: &Alone, registry: &Registry) -> Result<Self> {
        let mut own = self.clone();
        let config = &mut own.config;
        let clean = if config.harden.is_some() { clean(name) } else { name };
        let known = |network: &&Network| network.label == clean;
        if let Some(network) = config.networks.iter().find(known).cloned() {
            (config.networks, config.baselines) = (vec![network], vec![]);
        } else if let Some(baseline) = config.baselines.iter().find(|own| own.0.name() == clean).copied() {
            (config.networks, config.baselines) = (vec![], vec![baseline]);
        } else {
            let labels = config.networks.iter().map(|own| own.label.as_str());
            let labels = labels.chain(config.baselines.iter().map(|Baseline(own)| own.name()));
            let reason =
                format!("is no network or baseline of this experiment; {}", taxel_names::hint(name, labels));
            return Err(self.refuse(Problem::new("network", format!("{name:?}"), reason)));
        }
        match &mut config.harden {
            Some(harden) if clean != name => {
                (harden.only, harden.leave_out) = (vec![clean.into()], vec![]);
                harden.leave_each_out = false;
            }
            _ => config.harden = None,
        }
        config.name = format!("{}-shrunk", config.name);
        config.expect = None;
        config.encoding.reduce = config.encoding.reduce.clone().and(changes.reduce.clone());
        // A guard would watch what is not read any more.
        config.encoding.guard &= config.encoding.reduce.is_whole();
        for network in &mut config.networks {
            network.published = None;
            network.set.extend(changes.set.iter().map(|(key, value)| (key.clone(), value.clone())));
            if let Some(epochs) = changes.epochs {
                (network.train.epochs, network.train.least_steps) = (epochs, None);
            }
        }
        own.config.check(registry).map_err(|problem| own.places.refuse(problem))?;
        Ok(own)
    }

    /// A whole number among the settings of one of its networks, such as a width: what the config says, or else the
    /// network's own default. None of a baseline, of a network from a file, and where it has no such setting.
    pub fn number(&self, name: &str, key: &str, registry: &Registry) -> Option<usize> {
        let label = |own: &&Network| own.label == name || own.label == clean(name);
        let network = self.config.networks.iter().find(label)?;
        if network.source().is_some() {
            return None;
        }
        let default = registry.find(&network.name).ok()?.number(key)?;
        let own = network.set.get(key).and_then(Value::as_integer);
        Some(own.and_then(|value| usize::try_from(value).ok()).unwrap_or(default))
    }
}
