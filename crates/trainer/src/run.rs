//! An experiment from start to end: its candidates on its samples, into a run folder or a model.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use taxel_baselines::Method;
use taxel_data::{Dataset, Task};
use taxel_graph::{Graph, Weights, describe};
use taxel_learn::{
    Candidate, CrossValidation, Encoder, Estimator, Fit, FoldKey, Identity, Model, Problem, Progress,
    RunFolder, RunOptions, Trainable,
};
use taxel_zoo::{Entry, Registry, Settings, matlab};
use toml::{Table, Value};

use crate::config::Config;
use crate::error::{Error, Result};
use crate::experiment::{Experiment, Overrides};
use crate::merge::with_snake_keys;
use crate::network::Network;
use crate::network_file::read_network;

/// A network before its recipe is known.
struct SizedNetwork {
    graph: Graph,
    start: Option<Weights>,
    settings: Settings,
    paper: String,
}

/// A length that every network takes, for messages.
const SHORTER: usize = 1000;

/// Name of the file of a run folder that holds the resolved config.
pub const RUN_CONFIG: &str = "config.toml";

/// An experiment with what it needs to run.
pub struct Runner<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Where its networks come from.
    pub registry: &'a Registry,
    /// Its samples: [`Experiment::dataset`].
    pub dataset: &'a Dataset,
}

/// Runs `experiment` and writes its run folder, by default `runs/<name>`; a set `cancel` ends it between two
/// steps.
///
/// # Errors
/// Data that cannot be loaded or encoded, a network that does not fit them, a folder that holds
/// something else, training that diverges; [`taxel_learn::Error::Cancelled`] if `cancel` was set. Finished
/// folds are on disk in every case.
pub fn run(
    experiment: &Experiment,
    registry: &Registry,
    out: Option<&Path>,
    options: &RunOptions,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<RunFolder> {
    let dataset = experiment.dataset()?;
    Runner { experiment, registry, dataset: &dataset }.run(out, options, progress, cancel)
}

/// Opens the experiment of a run folder, with its samples, read or simulated again.
///
/// # Errors
/// A folder that holds no experiment, or data that cannot be loaded any more.
pub fn open(folder: &RunFolder, registry: &Registry) -> Result<(Experiment, Dataset)> {
    let experiment = Experiment::load(&folder.file(RUN_CONFIG), &Overrides::default(), registry)?;
    let dataset = experiment.dataset()?;
    Ok((experiment, dataset))
}

/// Returns one network or baseline of an experiment, sized by its samples, and the encoder that makes its inputs.
///
/// # Errors
/// No such network, data that cannot be encoded, or that the network does not take.
pub fn prepared<'d>(
    experiment: &Experiment,
    registry: &Registry,
    dataset: &'d Dataset,
    name: &str,
) -> Result<(Candidate, Encoder<'d>)> {
    dataset.refuse_one_class()?;
    let mut encoder = Encoder::new(&experiment.config().encoding, dataset);
    let candidate = Runner { experiment, registry, dataset }.candidate(name, &mut encoder)?;
    encoder.prepare(&candidate.inputs()).map_err(|error| experiment.located(error))?;
    Ok((candidate, encoder))
}

impl Runner<'_> {
    /// Runs the experiment as [`run()`], on samples that are loaded already.
    ///
    /// # Errors
    /// As [`run()`].
    pub fn run(
        &self,
        out: Option<&Path>,
        options: &RunOptions,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<RunFolder> {
        let validation = self.validation()?;
        let text = self.experiment.to_toml();
        let compared = |mut table: Table| {
            // Tried after the run, on trainings of its own.
            table.remove("unknown");
            Value::Table(table)
        };
        let now = compared(parsed(&text));
        let difference = |path: &Path, before: &str| {
            let before: Table = toml::from_str(before).map_err(|e| taxel_learn::Error::Damaged {
                file: path.display().to_string(),
                reason: format!("is no TOML: {}", e.message()),
            })?;
            Ok(difference("", &compared(before), &now))
        };
        let identity = Identity { file: RUN_CONFIG, text, difference: &difference };
        let out = out.map_or_else(|| self.experiment.default_out(), PathBuf::from);
        validation
            .run_as(&out, &identity, options, progress, cancel)
            .map_err(|error| self.experiment.located(error))
    }

    /// Returns every fold of the run, in order, for [`RunOptions::only`].
    ///
    /// # Errors
    /// As [`run()`], before anything is trained.
    pub fn keys(&self) -> Result<Vec<FoldKey>> {
        self.validation()?.keys().map_err(|error| self.experiment.located(error))
    }

    /// Returns the folds within any of `parts`, which [`FoldKey::is_within`] reads.
    ///
    /// # Errors
    /// As [`run()`], before anything is trained; a part that no fold is within.
    pub fn keys_within(&self, parts: &[String]) -> Result<Vec<FoldKey>> {
        let keys = self.keys()?;
        if let Some(part) = parts.iter().find(|part| !keys.iter().any(|key| key.is_within(part))) {
            let mut rows: Vec<&str> = keys.iter().map(|key| key.network.as_str()).collect();
            rows.dedup();
            let reason = format!(
                "is neither a row nor a part of the name of a fold, such as {}; {}",
                keys[0],
                taxel_base::names::hint(part, rows)
            );
            return Err(self.experiment.refuse(Problem::new("only", format!("{part:?}"), reason)));
        }
        Ok(keys.into_iter().filter(|key| parts.iter().any(|part| key.is_within(part))).collect())
    }

    pub(crate) fn validation(&self) -> Result<CrossValidation<'_>> {
        // Before a network blames its number of classes.
        self.dataset.refuse_one_class()?;
        let config = self.experiment.config();
        let mut validation = CrossValidation::new(self.dataset).encoding(config.encoding.clone());
        validation.name = config.name.clone();
        validation.title = config.title.clone();
        validation.protocol = config.protocol.clone();
        validation.look_alikes = config.data.look_alikes.clone();
        validation.seed = config.seed;
        (validation.candidates, validation.left_out) = self.candidates(validation.encoder())?;
        Ok(validation)
    }

    /// Trains one network or baseline of the experiment on all samples, by the name that tables give it; `None`
    /// if `cancel` was set. `session` is where the training is saved from time to time, where it is to be.
    ///
    /// # Errors
    /// No such network, data that cannot be encoded, training that diverges.
    pub fn fit(
        &self,
        name: &str,
        options: &RunOptions,
        session: Option<&Path>,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<Option<Model>> {
        self.dataset.refuse_one_class()?;
        let config = self.experiment.config();
        let mut encoder = Encoder::new(&config.encoding, self.dataset);
        let candidate = self.candidate(name, &mut encoder)?;
        let fit = Fit {
            candidate: &candidate,
            protocol: &config.protocol,
            seed: config.seed,
            options: options.clone(),
            session: session.map(PathBuf::from),
        };
        progress.start(fit.samples(self.dataset) as u64);
        let mut tick = |samples: usize| progress.step(samples as u64);
        let model = fit.run(&mut encoder, &mut tick, cancel);
        progress.finish();
        model.map_err(|error| self.experiment.located(error))
    }

    fn candidate(&self, name: &str, encoder: &mut Encoder) -> Result<Candidate> {
        let Config { networks, averages, harden, .. } = self.experiment.config();
        let baselines = self.baselines();
        if let Some(i) = networks.iter().position(|network| network.label == name) {
            return self.network(i, &networks[i], encoder);
        }
        if let Some(method) = baselines.iter().find(|method| method.name() == name) {
            return Ok(Candidate::baseline(*method));
        }
        if let Some(average) = averages.iter().find(|average| average.label == name) {
            let members = average.of.iter().map(|name| self.candidate(name, encoder));
            let members: Vec<Candidate> = members.collect::<Result<_>>()?;
            return Ok(Candidate::average(average.label.clone(), &members));
        }
        if let (Some(harden), Some((clean, _))) = (harden, name.rsplit_once('.')) {
            let clean = self.candidate(clean, encoder)?;
            let augmented = harden.fault_augmented(&clean, &self.dataset.spec);
            if let Some(candidate) = augmented.into_iter().find(|candidate| candidate.name == name) {
                return Ok(candidate);
            }
        }
        let known = networks.iter().map(|network| network.label.as_str());
        let known = known.chain(baselines.iter().map(|method| method.name()));
        let known = known.chain(averages.iter().map(|average| average.label.as_str()));
        let hint = taxel_base::names::hint(name, known);
        let reason = format!("is no network or baseline of this experiment; {hint}");
        Err(taxel_learn::Error::from(Problem::new("network", format!("{name:?}"), reason)).into())
    }

    /// Returns the baselines of the experiment; for targets that are values all that learn them, where it names none.
    fn baselines(&self) -> Vec<Method> {
        let config = self.experiment.config();
        if self.dataset.targets.values().is_some() { config.methods_of_values() } else { config.methods() }
    }

    /// Returns the networks, then the baselines, sized by the samples; and the networks that take no such samples, with
    /// the reason.
    ///
    /// # Errors
    /// Any other error of a network, and the first reason where no network is left: a run that asks for networks is not
    /// one of baselines alone.
    pub(crate) fn candidates(
        &self,
        encoder: &mut Encoder,
    ) -> Result<(Vec<Candidate>, BTreeMap<String, String>)> {
        let config = self.experiment.config();
        if config.unknown.is_some() {
            let what = match self.dataset.task() {
                Task::Classes(classes) if classes.len() > 2 => None,
                Task::Classes(classes) => {
                    Some(format!("there are {}, of which two have to be left", classes.len()))
                }
                task => Some(format!("the targets are {}", task.noun())),
            };
            if let Some(what) = what {
                let reason = format!("leaves classes out, and {what}; leave the table out");
                return Err(self.experiment.refuse(Problem::new("unknown", "{ .. }", reason)));
            }
        }
        let networks = &config.networks;
        let (mut candidates, mut refused, mut first) = (vec![], BTreeMap::new(), None);
        for (i, network) in networks.iter().enumerate() {
            match self.network(i, network, encoder) {
                Ok(candidate) => candidates.push(candidate),
                Err(Error::Zoo(error)) => match *error {
                    taxel_zoo::Error::Graph { source, .. } => {
                        let reason = reason(&source);
                        first.get_or_insert(format!("{}: {reason}", network.label));
                        refused.insert(network.label.clone(), reason);
                    }
                    other => return Err(other.into()),
                },
                Err(other) => return Err(other),
            }
        }
        if let (true, Some(reason)) = (candidates.is_empty(), first) {
            return Err(Error::Unfit { reason });
        }
        candidates.extend(self.baselines().into_iter().map(Candidate::baseline));
        for average in &config.averages {
            match average.candidate(&candidates) {
                Ok(candidate) => candidates.push(candidate),
                Err(member) => {
                    refused.insert(average.label.clone(), format!("averages {member}, which is left out"));
                }
            }
        }
        if let Some(harden) = &self.experiment.config().harden {
            let spec = &self.dataset.spec;
            let more: Vec<Candidate> =
                candidates.iter().flat_map(|candidate| harden.fault_augmented(candidate, spec)).collect();
            candidates.extend(more);
        }
        Ok((candidates, refused))
    }

    fn network(&self, i: usize, network: &Network, encoder: &mut Encoder) -> Result<Candidate> {
        let config = self.experiment.config();
        let SizedNetwork { graph, start, settings, paper } = match self.experiment.network_path(i)? {
            Some((key, path)) => {
                self.filed(&format!("networks.{i}.{key}"), &path, self.outputs(network), encoder)?
            }
            None => {
                let entry = self.registry.find(&network.name)?;
                let (settings, graph) = self.sized(network, entry, encoder)?;
                SizedNetwork { graph, start: None, settings, paper: entry.paper.clone() }
            }
        };
        let refuse = |problem| self.experiment.refuse(problem);
        let mut recipe = network.train.clone();
        recipe.frozen = self.frozen(i, &recipe.frozen, &graph)?;
        let mut search = config.search(&network.train).map_err(refuse)?;
        for combination in search.iter_mut().flat_map(|search| &mut search.grid) {
            combination.recipe.frozen = self.frozen(i, &combination.recipe.frozen, &graph)?;
        }
        let start = start.filter(|_| !network.fresh).map(Arc::new);
        let mut trainable = Trainable { graph, recipe, search, start };
        if let Some(path) = self.experiment.weights_path(i)? {
            let refuse = |reason: String| {
                let (key, value) = (format!("networks.{i}.weights"), format!("{:?}", path.display()));
                self.experiment.refuse(Problem::new(key, value, reason))
            };
            let weights = taxel_learn::read_weights(&path).map_err(|e| refuse(e.to_string()))?;
            trainable.start = Some(Arc::new(weights));
            trainable.drawn().map_err(|e| refuse(e.to_string()))?;
        }
        Ok(Candidate {
            name: network.label.clone(),
            estimator: Arc::new(trainable),
            zoo: network.name.clone(),
            paper,
            settings,
            published: network.published.clone(),
            twin: None,
        })
    }

    /// Returns the number of outputs that the targets need of a network.
    fn outputs(&self, network: &Network) -> usize {
        let task = self.dataset.task();
        task.outputs() * network.train.outputs_per_target(&task)
    }

    /// Reads a network from a file, with a head of so many outputs; `key` names the file in the config.
    fn filed(&self, key: &str, path: &Path, outputs: usize, encoder: &mut Encoder) -> Result<SizedNetwork> {
        let refuse = |reason: String| {
            self.experiment.refuse(Problem::new(key, format!("{:?}", path.display()), reason))
        };
        let (graph, weights) = read_network(path).map_err(|e| refuse(e.to_string()))?;
        let graph = graph.with_classes(outputs).map_err(|e| refuse(e.to_string()))?;
        let names: Vec<&str> = graph.inputs().map(|node| node.name.as_str()).collect();
        encoder.prepare(&names).map_err(|error| self.experiment.located(error))?;
        for node in graph.inputs() {
            let wanted = describe(&node.shape);
            let Some(shape) = encoder.shape(&node.name) else {
                let reason = format!(
                    "reads `{}` of {wanted}, and the experiment encodes no such input: `signal` is channels × length, \
                     `image` channels × rows × columns (encoding.image), `tensor` four axes (encoding.tensor), `rocket` \
                     features (encoding.rocket)",
                    node.name
                );
                return Err(refuse(reason));
            };
            let flat = node.shape.len() == 1 && node.shape[0] == shape.iter().product::<usize>();
            if !flat && shape != node.shape {
                let reason = format!(
                    "reads `{}` of {wanted}, the samples become {}: export the network for that shape, or bring the \
                     samples to its own (data.length, encoding.image.resize)",
                    node.name,
                    describe(&shape)
                );
                return Err(refuse(reason));
            }
        }
        Ok(SizedNetwork { graph, start: Some(weights), settings: Settings::new(), paper: String::new() })
    }

    /// Returns the network's settings and graph for the shapes that the encoding makes.
    fn sized(&self, network: &Network, entry: &Entry, encoder: &mut Encoder) -> Result<(Settings, Graph)> {
        let names: Vec<&str> = entry.inputs.iter().map(|input| input.name.as_str()).collect();
        encoder.prepare(&names).map_err(|error| self.experiment.located(error))?;
        let mut settings = entry.fit(self.outputs(network), |input| encoder.shape(input))?;
        settings.extend(network.settings());
        let graph = entry.graph(&settings)?;
        Ok((settings, graph))
    }

    /// Returns frozen nodes by name: ranges of MATLAB layers, as in Rouhafzay et al. 2021, are resolved here.
    fn frozen(&self, i: usize, frozen: &[String], graph: &Graph) -> Result<Vec<String>> {
        let names = matlab::resolve(graph, frozen);
        let checked = names.and_then(|names| graph.covered(&names).map(|_| names));
        checked.map_err(|error| {
            let (key, value) = (format!("networks.{i}.train.frozen"), format!("{frozen:?}"));
            let reason = format!("{error}; `taxel cost {}` lists and numbers them", graph.name());
            self.experiment.refuse(Problem::new(key, value, reason))
        })
    }
}

/// Says why a network takes no such samples, and how to fix it where they are too long.
fn reason(error: &taxel_graph::Error) -> String {
    let length = |key: &str| ["length", "frames"].contains(&key);
    match error {
        taxel_graph::Error::Config { key, .. } if length(key) => format!(
            "{error}; shorten the recordings: data.length = {{ kind = \"resample\", to = {SHORTER} }}"
        ),
        _ => error.to_string(),
    }
}

fn parsed(text: &str) -> Table {
    #[expect(clippy::expect_used, reason = "it was written as TOML a moment ago")]
    let mut table = toml::from_str(text).expect("a resolved config is TOML");
    with_snake_keys(&mut table);
    table
}

/// Describes the first dotted key, in order of the alphabet, whose values differ.
fn difference(prefix: &str, before: &Value, now: &Value) -> Option<String> {
    let shown = |value: Option<&Value>| value.map_or("not set".into(), ToString::to_string);
    let join = |key: &str| if prefix.is_empty() { key.into() } else { format!("{prefix}.{key}") };
    let words = |key: String, a: Option<&Value>, b: Option<&Value>| {
        format!("{key} was {}, is now {}", shown(a), shown(b))
    };
    match (before, now) {
        (Value::Table(a), Value::Table(b)) => {
            let names: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            names.into_iter().find_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(&join(key), a, b),
                (a, b) => Some(words(join(key), a, b)),
            })
        }
        (Value::Array(a), Value::Array(b)) if a.iter().chain(b).any(Value::is_table) => {
            (0..a.len().max(b.len())).find_map(|i| match (a.get(i), b.get(i)) {
                (Some(a), Some(b)) => difference(&join(&i.to_string()), a, b),
                (a, b) => Some(words(join(&i.to_string()), a, b)),
            })
        }
        (a, b) if a == b => None,
        (a, b) => Some(words(prefix.into(), Some(a), Some(b))),
    }
}
