//! The tables of an experiment's TOML file, resolved.
//!
//! Nothing here is optional that has a default: defaults are those of the values themselves ([`Recipe`],
//! [`Protocol`], [`Encoding`]), put below what the file says.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use taxel_baselines::Method;
use taxel_data::SampleSpec;
use taxel_faults::{Fault, TrainingFaults};
use taxel_graph::Loss;
use taxel_learn::certainty::UnknownTrial;
use taxel_learn::{
    Candidate, Check, Combination, Criterion, Encoding, Problem, Protocol, Recipe, Search, file_name,
    require, share, within,
};
use taxel_zoo::Registry;
use toml::{Table, Value};

use crate::average::{AverageRow, known};
use crate::baseline::Baseline;
use crate::data::Data;
use crate::data_schema::WholeData;
use crate::merge::merged;
use crate::misread::Misread;
use crate::network::{Network, RawNetwork};
use crate::read::{read, table_of};

/// One experiment: data, encoding, protocol, training, networks.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Config {
    /// Name of the run folder: letters, digits, `.`, `_`, `-`.
    pub name: String,
    /// One line for tables and reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The result that the author expects, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expect: Option<String>,
    /// Seed of every random choice, 0 to 2^63 - 1. Default 0.
    #[schemars(default)]
    pub seed: u64,
    /// Where the samples come from.
    #[schemars(with = "WholeData")]
    pub data: Data,
    /// The inputs of the networks.
    #[schemars(with = "Option<Encoding>")]
    pub encoding: Encoding,
    /// How samples are divided into training and test.
    #[schemars(with = "Option<Protocol>")]
    pub protocol: Protocol,
    /// How a network is trained that says nothing else.
    #[schemars(with = "Option<Recipe>")]
    pub train: Recipe,
    /// Settings of the training that each fold chooses by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choose: Option<Choose>,
    /// The networks, in the order of the table; none where baselines are all that is compared.
    pub networks: Vec<Network>,
    /// Methods that cost almost nothing and stand in the table too. Default all for classes.
    #[schemars(with = "Option<Vec<Baseline>>")]
    pub baselines: Vec<Baseline>,
    /// Rows that average what networks and baselines predict. Default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(default)]
    pub averages: Vec<AverageRow>,
    /// Trains everything once more, under faults.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub harden: Option<Harden>,
    /// Trains every row without some of the classes, to see whether its gate tells them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown: Option<UnknownTrial>,
    /// Tables of a paper that this run reproduces, for its page. Default none: all networks in one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(default)]
    pub tables: Vec<TableView>,
}

/// One of `[[tables]]`: some networks of the run under a title of their own, as a paper prints them. A network
/// is trained once, whatever number of tables it stands in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableView {
    /// `Table 2: light networks`.
    pub title: String,
    /// Labels of networks, or names of baselines, in the order of the table.
    pub networks: Vec<String>,
}

/// The `[harden]` table: every network, MiniRocket, the SVM and the extra trees are trained once more, fault-augmented, as
/// `<label>.hardened`, and stand beside those trained on clean samples.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Harden {
    /// Faults of the training samples. Default every kind that has a meaning for them.
    pub faults: TrainingFaults,
    /// Labels of the networks and names of the baselines that are trained so. Default all that can be.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub only: Vec<String>,
    /// Kinds that are left out of one more training each, as `<label>.without-<kind>`: how a fault-augmented
    /// network predicts under an unseen fault. A training for each kind. Default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leave_out: Vec<Fault>,
    /// Whether every kind of the training is left out once, in place of those of `leave_out`. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub leave_each_out: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

/// The `[choose]` table: recipes that each fold chooses from by a validation part, never by its test part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Choose {
    /// Keys below `[train]` and the values to try: `"optimizer.lr" = [0.01, 0.001]`.
    #[schemars(with = "BTreeMap<String, Vec<serde_json::Value>>")]
    pub grid: BTreeMap<String, Vec<Value>>,
    /// Share of the training part that is held back where the protocol has no validation part, (0, 1).
    /// Default 0.2.
    #[serde(default = "fifth")]
    pub validation: f64,
    /// `loss` (default), or a metric of the task: `accuracy`.
    #[serde(default)]
    pub by: Criterion,
}

fn fifth() -> f64 {
    0.2
}

/// The file as it is written, before defaults and overrides meet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: String,
    title: Option<String>,
    expect: Option<String>,
    #[serde(default)]
    seed: u64,
    data: Table,
    #[serde(default)]
    encoding: Encoding,
    #[serde(default)]
    protocol: Table,
    #[serde(default)]
    train: Table,
    choose: Option<Choose>,
    networks: Vec<RawNetwork>,
    baselines: Option<Vec<Value>>,
    #[serde(default)]
    averages: Vec<AverageRow>,
    harden: Option<Harden>,
    unknown: Option<UnknownTrial>,
    #[serde(default)]
    tables: Vec<TableView>,
}

impl Config {
    /// Lists the methods of its baselines.
    pub(crate) fn methods(&self) -> Vec<Method> {
        self.baselines.iter().map(|Baseline(method)| *method).collect()
    }

    /// Lists the same for targets that are values, with all methods that learn these where it names none that does, or has the
    /// list that a config without names gets.
    pub(crate) fn methods_of_values(&self) -> Vec<Method> {
        let mut methods = self.methods();
        if methods == Method::all() || !methods.iter().any(Method::learns_values) {
            methods.retain(|method| !method.learns_values());
            methods.extend(Method::of_values());
        }
        methods
    }

    /// Resolves a raw table: fills in every default, merges every override.
    ///
    /// # Errors
    /// An unknown key or a value of the wrong type, by its key.
    pub(crate) fn resolve(table: &Table) -> Result<Self, Misread> {
        if table.contains_key("rivals") {
            return Err(Misread::renamed("rivals", "baselines"));
        }
        let raw: Raw = read("", Value::Table(table.clone()))?;
        let train = merged(&table_of(&Recipe::default()), &raw.train);
        let protocol = merged(&table_of(&Protocol::default()), &raw.protocol);
        let networks = raw.networks.into_iter().enumerate().map(|(i, network)| network.resolve(i, &train));
        let networks = networks.collect::<Result<_, _>>()?;
        let baselines = match raw.baselines {
            Some(values) => values
                .into_iter()
                .enumerate()
                .map(|(i, value)| Baseline::read(i, value))
                .collect::<Result<_, _>>()?,
            None => Method::all().map(Baseline).to_vec(),
        };
        Ok(Config {
            name: raw.name,
            title: raw.title,
            expect: raw.expect,
            seed: raw.seed,
            data: Data::read(raw.data)?,
            encoding: raw.encoding,
            protocol: read("protocol", Value::Table(protocol))?,
            train: read("train", Value::Table(train.clone()))?,
            choose: raw.choose,
            networks,
            baselines,
            averages: raw.averages,
            harden: raw.harden,
            unknown: raw.unknown,
            tables: raw.tables,
        })
    }

    /// Checks all values; the first one outside its range is the error.
    ///
    /// # Errors
    /// Key, value and allowed values.
    pub(crate) fn check(&self, registry: &Registry) -> Check {
        file_name("name", &self.name)?;
        let most = i64::MAX as u64;
        require(self.seed <= most, "seed", self.seed, format!("must be in 0..={most}"))?;
        let below = |parent: &'static str| move |problem: Problem| problem.below(parent);
        self.data.check().map_err(below("data"))?;
        self.encoding.check().map_err(below("encoding"))?;
        self.protocol.check().map_err(below("protocol"))?;
        self.train.check().map_err(below("train"))?;
        let some = !self.networks.is_empty() || !self.baselines.is_empty();
        require(some, "networks", "[]", "name at least one network or baseline")?;
        if let Some(choose) = &self.choose {
            choose.check(&self.train)?;
        }
        let mut labels = BTreeSet::new();
        for (i, network) in self.networks.iter().enumerate() {
            let at = format!("networks.{i}");
            network.check(registry).map_err(|problem| problem.below(&at))?;
            self.check_training(&network.train).map_err(|problem| problem.below(&format!("{at}.train")))?;
            self.search(&network.train)?;
            let reason = "two networks go by this name; give one of them a label of its own";
            let fresh = labels.insert(network.label.as_str());
            require(fresh, &format!("{at}.label"), format!("{:?}", network.label), reason)?;
        }
        for (i, Baseline(method)) in self.baselines.iter().enumerate() {
            let reason = "two rows of the table would go by this name; leave one of them out";
            let fresh = labels.insert(method.name());
            require(fresh, &format!("baselines.{i}"), format!("{:?}", method.name()), reason)?;
        }
        for (i, average) in self.averages.iter().enumerate() {
            average.check(&labels).map_err(|problem| problem.below(&format!("averages.{i}")))?;
        }
        labels.extend(self.averages.iter().map(|average| average.label.as_str()));
        for (i, view) in self.tables.iter().enumerate() {
            view.check(&labels).map_err(|problem| problem.below(&format!("tables.{i}")))?;
        }
        if let Some(unknown) = &self.unknown {
            unknown.check().map_err(below("unknown"))?;
        }
        match &self.harden {
            Some(harden) => harden.check(&labels).map_err(below("harden")),
            None => Ok(()),
        }
    }

    /// Checks a recipe against the experiment's samples.
    fn check_training(&self, recipe: &Recipe) -> Check {
        recipe.check()?;
        let moves = recipe.augment.is_some_and(|augment| augment.changes_images());
        let reason = "moves pixels: it needs encoding.image of kind \"raw\" or \"frame\", or encoding.tensor; \
                      readings have \"gain\", \"jitter\", \"time_shift\" and \"time_warp\"";
        require(!moves || self.encoding.is_warpable(), "augment", "{ .. }", reason)?;
        let several = self.data.attributes.len() > 1 && recipe.loss == Some(Loss::SoftmaxCrossEntropy);
        let reason = "several attributes (data.attributes) need \"multi-label-soft-margin\", \
                      \"cumulative-logits\", \"hinge\" or \"mean-squared-error\"";
        require(!several, "loss", "\"softmax-cross-entropy\"", reason)
    }

    /// Returns the recipes that a network's folds choose from.
    pub(crate) fn search(&self, recipe: &Recipe) -> Result<Option<Search>, Problem> {
        let Some(choose) = &self.choose else { return Ok(None) };
        let mut grid = vec![];
        for set in choose.combinations() {
            let changed = choose.recipe(recipe, &set)?;
            self.check_training(&changed).map_err(|problem| problem.below("choose.grid"))?;
            let json = |(key, value): (String, Value)| (key, serde_json::json!(value));
            grid.push(Combination { set: set.into_iter().map(json).collect(), recipe: changed });
        }
        Ok(Some(Search { grid, validation: choose.validation, by: choose.by.clone() }))
    }
}

impl TableView {
    fn check(&self, labels: &BTreeSet<&str>) -> Check {
        require(!self.networks.is_empty(), "networks", "[]", "name the networks of the table")?;
        known("networks", &self.networks, labels)
    }
}

impl Harden {
    fn check(&self, labels: &BTreeSet<&str>) -> Check {
        let recipe = Recipe { faults: Some(self.faults.clone()), ..Recipe::default() };
        recipe.check()?;
        let reason = "trains on clean samples; leave the table [harden] out";
        require(!self.faults.is_clean(), "faults.probability", "0", reason)?;
        known("only", &self.only, labels)?;
        let both = self.leave_each_out && !self.leave_out.is_empty();
        let reason = "leaves every kind out already; remove one of the two keys";
        require(!both, "leave_each_out", "true", reason)
    }

    /// Returns the candidate fault-augmented, and once more without each kind that is to be unseen; nothing where it is
    /// trained on clean samples only. `spec` is that of the samples.
    pub(crate) fn fault_augmented(&self, candidate: &Candidate, spec: &SampleSpec) -> Vec<Candidate> {
        let named = self.only.contains(&candidate.name);
        let wanted = named || self.only.is_empty() && candidate.estimator.gains_by_faults();
        if candidate.faults().is_some() || !wanted {
            return vec![];
        }
        let seen: Vec<Fault> =
            self.faults.plan(spec.layout, &spec.shape).map_or(vec![], |plan| plan.kinds().collect());
        let left_out = seen.iter().filter(|kind| self.leave_each_out || self.leave_out.contains(kind));
        let unseen = left_out.map(|&kind| candidate.hardened(&self.faults, Some(kind)));
        std::iter::once(candidate.hardened(&self.faults, None)).chain(unseen).collect()
    }
}

impl Choose {
    fn check(&self, recipe: &Recipe) -> Check {
        share("choose.validation", self.validation)?;
        let reason = "name what is chosen: grid = { \"optimizer.lr\" = [0.01, 0.001] }";
        require(!self.grid.is_empty(), "choose.grid", "{}", reason)?;
        for (key, values) in &self.grid {
            let reason = "needs values to choose from";
            require(!values.is_empty(), &format!("choose.grid.{key}"), "[]", reason)?;
        }
        let combinations = self.combinations();
        within("choose.grid", combinations.len(), 1, 1000)?;
        combinations.iter().try_for_each(|set| self.recipe(recipe, set).map(|_| ()))
    }

    /// Returns every combination of the grid, first key slowest.
    fn combinations(&self) -> Vec<BTreeMap<String, Value>> {
        let mut found = vec![BTreeMap::new()];
        for (key, values) in &self.grid {
            let longer = |before: &BTreeMap<String, Value>| {
                let before = before.clone();
                values.iter().map(move |value| {
                    let mut longer = before.clone();
                    longer.insert(key.clone(), value.clone());
                    longer
                })
            };
            found = found.iter().flat_map(longer).collect();
        }
        found
    }

    /// Returns `recipe` with other values at dotted keys.
    fn recipe(&self, recipe: &Recipe, set: &BTreeMap<String, Value>) -> Result<Recipe, Problem> {
        let mut table = table_of(recipe);
        for (key, value) in set {
            // As one network's own value would be written.
            let mut nested = value.clone();
            for part in key.rsplit('.') {
                nested = Value::Table(Table::from_iter([(part.to_string(), nested)]));
            }
            if let Value::Table(nested) = nested {
                table = merged(&table, &nested);
            }
        }
        read("", Value::Table(table)).map_err(|misread: Misread| {
            let known = set.keys().find(|key| misread.key == **key).or(set.keys().next());
            let key = known.map_or(String::new(), |key| format!(".{key}"));
            let value = known.map(|key| set[key].to_string()).unwrap_or_default();
            Problem::new(format!("choose.grid{key}"), value, misread.message)
        })
    }
}
