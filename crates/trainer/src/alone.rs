//! One network of an experiment by itself, on less of every sample or in another size.

use taxel_learn::{Problem, Reduction, clean};
use taxel_zoo::{Entry, Registry, WIDTH_MULT, WITHOUT_BLOCKS, WITHOUT_LAYERS};
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

/// What a network may leave out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth {
    /// The setting that says how much: [`WITHOUT_BLOCKS`] or [`WITHOUT_LAYERS`].
    pub key: &'static str,
    /// What is left out already.
    pub out: usize,
    /// What could be left out besides, at least 1.
    pub left: usize,
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
            let reason = format!(
                "is no network or baseline of this experiment; {}",
                taxel_base::names::hint(name, labels)
            );
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
        let (network, entry) = self.registered(name, registry)?;
        let default = entry.number(key)?;
        let own = network.set.get(key).and_then(Value::as_integer);
        Some(own.and_then(|value| usize::try_from(value).ok()).unwrap_or(default))
    }

    /// What multiplies the channels of one of its networks ([`WIDTH_MULT`]). None of a baseline, and of a network that is
    /// not from the registry or has no such setting.
    pub fn width_mult(&self, name: &str, registry: &Registry) -> Option<f64> {
        let (network, entry) = self.registered(name, registry)?;
        let default = entry.width_mult()?;
        let own = network
            .set
            .get(WIDTH_MULT)
            .and_then(|own| own.as_float().or(own.as_integer().map(|own| own as f64)));
        Some(own.unwrap_or(default))
    }

    /// How one of its networks becomes shallower: without blocks that hand on their input where it has any, else without
    /// plain layers. None of a baseline, of a network that is not from the registry, and of one that has neither.
    pub fn depth(&self, name: &str, registry: &Registry) -> Option<Depth> {
        let (network, entry) = self.registered(name, registry).filter(|(_, entry)| entry.is_resizable())?;
        let graph = entry.graph(&network.settings()).ok()?;
        let (blocks, layers) = (graph.identity_blocks(), graph.plain_layers());
        let (key, left) = if blocks > 0 { (WITHOUT_BLOCKS, blocks) } else { (WITHOUT_LAYERS, layers) };
        let out = network.set.get(key).and_then(Value::as_integer).unwrap_or(0);
        (left > 0).then_some(Depth { key, out: usize::try_from(out).ok()?, left })
    }

    /// One of its networks by the name that tables give it, trained under faults or not. None of a baseline.
    pub fn network(&self, name: &str) -> Option<&Network> {
        self.config.networks.iter().find(|own| own.label == name || own.label == clean(name))
    }

    /// The same with its entry, if it is one of the registry.
    fn registered<'a>(&'a self, name: &str, registry: &'a Registry) -> Option<(&'a Network, &'a Entry)> {
        let network = self.network(name).filter(|own| own.source().is_none())?;
        Some((network, registry.find(&network.name).ok()?))
    }
}
