//! An experiment that nobody wrote: chosen by the facts of the recordings, written as a config to edit.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use taxel_data::{Dataset, ReadOptions, Task};
use taxel_zoo::Registry;

use crate::data::settings;
use crate::error::Result;
use crate::experiment::{Experiment, Overrides, name_of};
use crate::start::families::{AVERAGE, Family, ROCKET};

/// Folds where there are enough groups, or enough samples of each class.
const FOLDS: usize = 5;

/// The experiment that a data set starts with.
///
/// Samples without a config get the encoding, networks, baselines and recipe that suit their layout and size, and folds that keep
/// groups whole. Each method is fault-augmented too. [`Start::to_toml`] is the config of it, with a comment for each choice.
///
/// ```
/// use ndarray::Array3;
/// use taxel_data::{Dataset, Layout, ReadOptions};
/// use taxel_trainer::Start;
///
/// let x = Array3::from_shape_fn((60, 4, 30), |(i, channel, t)| (i * channel + t) as f32);
/// let labels: Vec<usize> = (0..60).map(|i| i % 3).collect();
/// let dataset = Dataset::new("cups", Layout::Series, x.into_dyn(), &labels)?.with_groups(&[0, 1, 2, 3].repeat(15))?;
/// let text = Start::new(&dataset, "cups.npz".as_ref(), &ReadOptions::default()).to_toml();
/// assert!(text.contains("dilated-resnet-rocket-1d") && text.contains("folds = 4"));
/// # Ok::<(), taxel_data::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    pub(super) name: String,
    /// The facts that the choices follow from.
    pub(super) facts: Vec<String>,
    /// Lines of `[data]`.
    pub(super) data: Vec<String>,
    /// Lines of `[protocol]`.
    pub(super) protocol: Vec<String>,
    /// Folds of the protocol.
    pub(super) folds: usize,
    pub(super) family: Family,
    /// Whether each row has a fault-augmented twin.
    pub(super) is_hardened: bool,
    /// Samples that are trained on in a fold.
    pub(super) trained: usize,
    /// About how long it takes; none where nobody measured.
    pub(super) minutes: Option<f64>,
}

impl Start {
    /// Makes the experiment of recordings that were read from `path` under `options`.
    pub fn new(dataset: &Dataset, path: &Path, options: &ReadOptions) -> Self {
        let (name, task, spec) = (name_of(path), dataset.task(), &dataset.spec);
        let data = settings(options).into_iter();
        let data = data.filter_map(|line| Some(line.strip_prefix("data.")?.replacen('=', " = ", 1)));
        let path = format!("path = {}", toml::Value::String(path.display().to_string()));
        let family = Family::of(spec.layout, &spec.shape, &task, dataset.len());
        let (protocol, folds, tested) = protocol(dataset);
        let shape: Vec<String> = spec.shape.iter().map(usize::to_string).collect();
        let groups = groups(dataset).map_or("no groups".into(), |groups| format!("{groups} groups"));
        let facts = vec![format!(
            "{} samples, each {} of {}; {}; {groups}.",
            dataset.len(),
            spec.layout.describe(),
            shape.join(" × "),
            task.counted()
        )];
        Start {
            name,
            facts,
            data: std::iter::once(path).chain(data).collect(),
            protocol,
            folds,
            family,
            is_hardened: true,
            trained: dataset.len() - tested.min(dataset.len()),
            minutes: None,
        }
    }

    /// Reads the recordings at `path`, as a config does that has the values `set`, such as `data.layout="image"`. Values of other tables
    /// say nothing of them.
    ///
    /// # Errors
    /// Recordings that cannot be read, a value that is refused.
    pub fn read(path: &Path, options: &ReadOptions, set: &[String], registry: &Registry) -> Result<Dataset> {
        let of_data: Vec<&String> =
            set.iter().filter(|value| value.trim_start().starts_with("data.")).collect();
        if of_data.is_empty() {
            return Ok(taxel_data::load(path, options)?);
        }
        // A path of a config starts at its folder.
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
        let path = toml::Value::String(absolute.display().to_string());
        let text = format!(
            "name = \"recordings\"\nbaselines = [\"majority\"]\nnetworks = []\n[data]\npath = {path}\n"
        );
        let set = settings(options).into_iter().chain(of_data.into_iter().cloned()).collect();
        let overrides = Overrides { set, ..Overrides::default() };
        Experiment::parse(&text, "recordings.toml", &overrides, registry)?.dataset()
    }

    /// Returns the name of the experiment, which is that of the recordings.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Checks whether it takes longer than that, as far as is known.
    pub fn exceeds(&self, budget: Duration) -> bool {
        self.minutes.is_some_and(|minutes| minutes * 60.0 > budget.as_secs_f64())
    }

    /// Says in a line what is tried, and how long it takes.
    pub fn summary(&self) -> String {
        let takes =
            self.minutes.map_or(String::new(), |minutes| format!(", about {minutes:.0} min on this machine"));
        let faults = if self.is_hardened { ", each also fault-augmented" } else { "" };
        let averaged = self.family.averaged.join(" and ");
        let average = if averaged.is_empty() { averaged } else { format!(", the mean of {averaged}") };
        format!(
            "{}: {} and {} baselines{average}{faults}; {} epochs, {} folds{takes}",
            self.name,
            self.family.networks.join(", "),
            self.family.baselines.len(),
            self.family.epochs,
            self.folds
        )
    }

    /// Writes the config, with a comment for each choice. Reading it gives the experiment.
    pub fn to_toml(&self) -> String {
        let Family { encoding, networks, baselines, averaged, .. } = &self.family;
        let takes = self.minutes.map(|minutes| format!("Takes about {minutes:.0} min where it was written."));
        let comments = self.facts.iter().cloned().chain(takes).map(|line| format!("# {line}\n"));
        let mut text: String = comments.collect();
        text += &format!("name = {:?}\nseed = 0\nbaselines = {baselines:?}\n", self.name);
        text += &format!("\n[data]\n{}\n", self.data.join("\n"));
        if !encoding.is_empty() {
            text += &format!("\n[encoding]\n{}\n", encoding.join("\n"));
        }
        text += &format!("\n[protocol]\n{}\n", self.protocol.join("\n"));
        text += &format!("\n[train]\n{}", self.family.recipe());
        if self.is_hardened {
            text += "\n[harden]                                # each row once more, fault-augmented\n";
            let augmented = self.family.augmented(self.trained);
            if baselines.contains(&ROCKET) && !augmented.contains(&ROCKET) {
                let about = "mini-rocket's ridge takes gigabytes on so many copies";
                text += &format!("only = {augmented:?}   # {about}\n");
            }
        }
        for network in networks {
            text += &format!("\n[[networks]]\nname = {network:?}\n");
        }
        if !averaged.is_empty() {
            let about = "they err in different ways";
            text += &format!("\n[[averages]]                             # {about}\nlabel = {AVERAGE:?}\n");
            text += &format!("of = {averaged:?}\n");
        }
        text
    }
}

/// Counts the groups of a data set; none without.
fn groups(dataset: &Dataset) -> Option<usize> {
    let groups = dataset.groups.as_ref()?;
    Some(groups.iter().collect::<BTreeSet<_>>().len())
}

/// Chooses the protocol: the authors' split, whole groups, or classes spread evenly. Returns its lines, its folds, and how many samples
/// a fold tests.
fn protocol(dataset: &Dataset) -> (Vec<String>, usize, usize) {
    if let Some(test) = &dataset.official {
        let tested = test.iter().filter(|is_tested| **is_tested).count();
        let line = "kind = \"official\"                     # the authors' split".into();
        return (vec![line], 1, tested);
    }
    let of_groups = groups(dataset).filter(|groups| *groups > 1);
    let folds = match of_groups {
        Some(groups) => groups.min(FOLDS),
        None => FOLDS.min(smallest_stratum(dataset)).max(2),
    };
    let split = match of_groups {
        Some(_) => "split = \"group\"                       # a group that is tested was never seen",
        None => {
            "split = \"stratified\"                  # give recordings a group (object, session) to test new ones"
        }
    };
    let lines = vec!["kind = \"k-fold\"".into(), format!("folds = {folds}"), split.into()];
    (lines, folds, dataset.len() / folds)
}

/// Counts the samples of the class that has the fewest; values have no classes.
fn smallest_stratum(dataset: &Dataset) -> usize {
    match dataset.task() {
        Task::Classes(_) => dataset.class_counts().into_iter().filter(|count| *count > 0).min().unwrap_or(0),
        _ => dataset.len(),
    }
}
