//! The variant of an experiment with one of its networks, on less of every sample or in another size.

use taxel_learn::{Problem, Reduction, clean};
use taxel_zoo::{Entry, Registry, WIDTH_MULT, WITHOUT_BLOCKS, WITHOUT_LAYERS};
use toml::{Table, Value};

use crate::baseline::Baseline;
use crate::error::Result;
use crate::experiment::Experiment;
use crate::network::Network;

/// Changes to the experiment of one network.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Variant {
    /// Reduction of a sample, besides that of the experiment.
    pub reduce: Reduction,
    /// Settings of the network in place of its own.
    pub set: Table,
    /// Epochs in place of its own, and no least number of steps.
    pub epochs: Option<usize>,
}

/// Blocks or layers that a network may leave out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth {
    /// The setting that holds the count: [`WITHOUT_BLOCKS`] or [`WITHOUT_LAYERS`].
    pub key: &'static str,
    /// Count that is left out already.
    pub out: usize,
    /// Count that could be left out besides, at least 1.
    pub left: usize,
}

impl Experiment {
    /// Returns the experiment of one of its networks or baselines, by its name in the tables, with `changes`. The network
    /// keeps its label; `-shrunk` is added to the name of the experiment.
    ///
    /// # Errors
    /// No such network, or a change that it does not allow.
    pub fn variant(&self, name: &str, changes: &Variant, registry: &Registry) -> Result<Self> {
        let mut variant = self.clone();
        let config = &mut variant.config;
        let clean = if config.harden.is_some() { clean(name) } else { name };
        let known = |network: &&Network| network.label == clean;
        if config.averages.iter().any(|average| average.label == name) {
            let reason = "is an average, which has no smaller size; name one of the rows that it averages";
            return Err(self.refuse(Problem::new("network", format!("{name:?}"), reason)));
        }
        config.averages = vec![];
        if let Some(network) = config.networks.iter().find(known).cloned() {
            (config.networks, config.baselines) = (vec![network], vec![]);
        } else if let Some(method) =
            config.methods_of_values().into_iter().find(|method| method.name() == clean)
        {
            (config.networks, config.baselines) = (vec![], vec![Baseline(method)]);
        } else {
            let labels = config.networks.iter().map(|network| network.label.as_str());
            let labels = labels.chain(config.baselines.iter().map(|Baseline(method)| method.name()));
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
        variant.config.check(registry).map_err(|problem| variant.positions.refuse(problem))?;
        Ok(variant)
    }

    /// Returns the same without the settings that inner folds choose among.
    pub(crate) fn without_search(mut self) -> Self {
        self.config.choose = None;
        self
    }

    /// Returns a whole number among the settings of one of its networks, such as a width: the config's, or else the
    /// network's default. None of a baseline, of a network from a file, and where it has no such setting.
    pub fn number(&self, name: &str, key: &str, registry: &Registry) -> Option<usize> {
        let (network, entry) = self.registered(name, registry)?;
        let default = entry.number(key)?;
        let set = network.set.get(key).and_then(Value::as_integer);
        Some(set.and_then(|value| usize::try_from(value).ok()).unwrap_or(default))
    }

    /// Returns the factor on the channels of one of its networks ([`WIDTH_MULT`]). None of a baseline, and of a network that is
    /// not from the registry or has no such setting.
    pub fn width_mult(&self, name: &str, registry: &Registry) -> Option<f64> {
        let (network, entry) = self.registered(name, registry)?;
        let default = entry.width_mult()?;
        let set = network.set.get(WIDTH_MULT);
        let set = set.and_then(|value| value.as_float().or(value.as_integer().map(|whole| whole as f64)));
        Some(set.unwrap_or(default))
    }

    /// Returns how one of its networks becomes shallower: without identity blocks where it has any, else without plain
    /// layers. None of a baseline, of a network that is not from the registry, and of one that has neither.
    pub fn depth(&self, name: &str, registry: &Registry) -> Option<Depth> {
        let (network, entry) = self.registered(name, registry).filter(|(_, entry)| entry.is_resizable())?;
        let graph = entry.graph(&network.settings()).ok()?;
        let (blocks, layers) = (graph.identity_blocks(), graph.plain_layers());
        let (key, left) = if blocks > 0 { (WITHOUT_BLOCKS, blocks) } else { (WITHOUT_LAYERS, layers) };
        let out = network.set.get(key).and_then(Value::as_integer).unwrap_or(0);
        (left > 0).then_some(Depth { key, out: usize::try_from(out).ok()?, left })
    }

    /// Returns one of its networks by its name in the tables, fault-augmented or not. None of a baseline.
    pub fn network(&self, name: &str) -> Option<&Network> {
        self.config.networks.iter().find(|network| network.label == name || network.label == clean(name))
    }

    /// Returns the same with its entry, if it is one of the registry.
    fn registered<'a>(&'a self, name: &str, registry: &'a Registry) -> Option<(&'a Network, &'a Entry)> {
        let network = self.network(name).filter(|network| network.source().is_none())?;
        Some((network, registry.find(&network.name).ok()?))
    }
}
