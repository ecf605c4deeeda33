//! How samples become training, validation and test parts.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};
use taxel_data::{
    Dataset, Fold, Length, Shares, Targets, Task, chronological_split, few_per_class, group_k_fold,
    random_group_split, random_split, stratified_k_fold,
};

use crate::error::{Error, Result};
use crate::problem::{Check, Problem, require, share, within};

/// The samples that a split spreads evenly or keeps together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Split {
    /// Classes are spread evenly; exact copies stay in one part.
    #[default]
    Stratified,
    /// No group (session, object, block) is in two parts.
    Group,
}

/// How samples become training, validation and test parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Protocol {
    /// Every sample is tested once per repetition (Kaewrakmuk and Srinonchat 2026: stratified, 5 folds).
    KFold {
        /// 2 to 1000. Default 5.
        #[serde(default = "five")]
        folds: usize,
        /// Samples that it spreads evenly or keeps together.
        #[serde(default)]
        split: Split,
        /// How often everything is repeated with other parts, 1 to 1000. Default 1.
        #[serde(default = "one")]
        repetitions: usize,
    },
    /// One random cut per repetition (Gandarias et al. 2019b: 80/10/10, 20 repetitions; Rouhafzay et al. 2021: 75/25).
    RandomSplits {
        /// Samples that it spreads evenly or keeps together.
        #[serde(default)]
        split: Split,
        /// How often everything is repeated with other parts, 1 to 1000. Default 1.
        #[serde(default = "one")]
        repetitions: usize,
        /// Share that is tested, (0, 1). Default 0.2.
        #[serde(default = "fifth")]
        test: f64,
        /// Share for validation, `[0, 1)`. Default 0.
        #[serde(default, skip_serializing_if = "crate::json_file::is_default")]
        validation: f64,
    },
    /// A learning curve (Pastor et al. 2019): per repetition one random test part, and from the rest as many
    /// training samples of each class as `per_class` says, the smaller sets inside the larger ones.
    FewSamples {
        /// Samples that it spreads evenly or keeps together.
        #[serde(default)]
        split: Split,
        /// How often everything is repeated with other parts, 1 to 1000. Default 1.
        #[serde(default = "one")]
        repetitions: usize,
        /// Share that is tested, (0, 1). Default 0.2.
        #[serde(default = "fifth")]
        test: f64,
        /// Training samples of each class, ascending. Default `[1, 2, 5, 10, 20]`. What a split never tears apart, the
        /// frames of a recording or exact copies, counts as one.
        #[serde(default = "few")]
        per_class: Vec<usize>,
    },
    /// Each group (object, session) is tested once, all others are trained on.
    LeaveGroupOut {
        /// Says nothing here: the groups are the parts.
        #[serde(default)]
        split: Split,
        /// 1: there is one cut only.
        #[serde(default = "one")]
        repetitions: usize,
    },
    /// Trains on the beginning of each group, a session or a day, and tests its end, in the order of the samples. Without groups
    /// the data set is one. Windows that reach across the cut are in neither part.
    Chronological {
        /// Share of each group that is tested, (0, 1). Default 0.2.
        #[serde(default = "fifth")]
        test: f64,
        /// 1: there is one cut only.
        #[serde(default = "one")]
        repetitions: usize,
    },
    /// A new simulated world in each repetition, with its own training and test recordings: repetitions are independent, and share
    /// neither samples nor starting weights.
    Fresh {
        /// Training recordings of a world, from 1.
        train: usize,
        /// Test recordings of a world, from 1.
        test: usize,
        /// Worlds, 1 to 1000. Default 5.
        #[serde(default = "five")]
        repetitions: usize,
        /// Makes a learning curve: training samples of each class, ascending, of those of the world, the smaller sets inside the
        /// larger ones. Default none: all are trained on.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        per_class: Vec<usize>,
    },
    /// The cut that the data set's authors made.
    Official {
        /// Samples that a held-back validation part keeps together.
        #[serde(default)]
        split: Split,
        /// 1: there is one cut only.
        #[serde(default = "one")]
        repetitions: usize,
    },
}

fn one() -> usize {
    1
}

fn five() -> usize {
    5
}

fn fifth() -> f64 {
    0.2
}

fn few() -> Vec<usize> {
    vec![1, 2, 5, 10, 20]
}

impl Default for Protocol {
    fn default() -> Self {
        Protocol::k_fold(five())
    }
}

impl Protocol {
    /// Makes a stratified cross-validation, once.
    pub fn k_fold(folds: usize) -> Self {
        Protocol::KFold { folds, split: Split::Stratified, repetitions: 1 }
    }

    /// Makes a cross-validation in which no group is in two parts.
    pub fn group_k_fold(folds: usize) -> Self {
        Protocol::KFold { folds, split: Split::Group, repetitions: 1 }
    }

    /// Returns the number of repetitions, each with other parts.
    pub fn repetitions(&self) -> usize {
        match self {
            Protocol::KFold { repetitions, .. }
            | Protocol::RandomSplits { repetitions, .. }
            | Protocol::FewSamples { repetitions, .. }
            | Protocol::LeaveGroupOut { repetitions, .. }
            | Protocol::Fresh { repetitions, .. }
            | Protocol::Chronological { repetitions, .. }
            | Protocol::Official { repetitions, .. } => *repetitions,
        }
    }

    /// Returns the number of worlds and of the training and test recordings of each; none for other protocols.
    pub fn worlds(&self) -> Option<(usize, [usize; 2])> {
        match self {
            Protocol::Fresh { train, test, repetitions, .. } => Some((*repetitions, [*train, *test])),
            _ => None,
        }
    }

    /// Returns the training samples per class of a learning curve's rows; none for other protocols.
    pub fn per_class(&self) -> Option<&[usize]> {
        match self {
            Protocol::FewSamples { per_class, .. } => Some(per_class),
            Protocol::Fresh { per_class, .. } if !per_class.is_empty() => Some(per_class),
            _ => None,
        }
    }

    /// Lists the rows of a candidate in the table by name. Of a learning curve it has one for each number of training samples per
    /// class: that number, and the fold of a repetition that has so many.
    pub fn rows_of(&self, name: &str) -> Vec<(String, Option<(usize, usize)>)> {
        match self.per_class() {
            None => vec![(name.into(), None)],
            Some(counts) => {
                let row = |(fold, &count): (usize, &usize)| (few_name(name, count), Some((count, fold)));
                counts.iter().enumerate().map(row).collect()
            }
        }
    }

    /// Checks whether a group (session, object) is never on both sides of a cut.
    pub fn keeps_groups(&self) -> bool {
        matches!(self, Protocol::LeaveGroupOut { .. }) || self.split() == Split::Group
    }

    fn split(&self) -> Split {
        match self {
            Protocol::KFold { split, .. }
            | Protocol::RandomSplits { split, .. }
            | Protocol::FewSamples { split, .. }
            | Protocol::LeaveGroupOut { split, .. }
            | Protocol::Official { split, .. } => *split,
            Protocol::Fresh { .. } | Protocol::Chronological { .. } => Split::Stratified,
        }
    }

    /// Makes the cross-validation within the training part `rows` of one of its own folds.
    ///
    /// # Errors
    /// Groups that are not there, or a training part of a single one.
    pub(crate) fn inner(&self, folds: usize, dataset: &Dataset, rows: &[usize]) -> Result<Self> {
        let grouped = matches!(self, Protocol::LeaveGroupOut { .. }) || self.split() == Split::Group;
        let (mut split, mut folds) = (Split::Stratified, folds);
        if let (true, Some(groups)) = (grouped, self.inseparable(dataset)?) {
            let members: std::collections::BTreeSet<u32> = rows.iter().map(|&row| groups[row]).collect();
            let reason = "leaves one group to train on, which has no inner folds; use more folds";
            require(members.len() > 1, "protocol.folds", members.len(), reason)?;
            (split, folds) = (Split::Group, folds.min(members.len()));
        }
        Ok(Protocol::KFold { folds, split, repetitions: 1 })
    }

    /// Checks all numbers of the protocol.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn check(&self) -> Check {
        within("repetitions", self.repetitions(), 1, 1000)?;
        let once = |repetitions: &usize| {
            let reason = "this kind of protocol has one cut only: repeat it with another seed";
            require(*repetitions == 1, "repetitions", repetitions, reason)
        };
        match self {
            Protocol::KFold { folds, .. } => within("folds", *folds, 2, 1000),
            Protocol::RandomSplits { test, validation, .. } => {
                share("test", *test)?;
                if *validation != 0.0 {
                    share("validation", *validation)?;
                }
                let reason = "test and validation together leave nothing to train on";
                require(test + validation < 1.0, "validation", validation, reason)
            }
            Protocol::FewSamples { test, per_class, .. } => {
                share("test", *test)?;
                ascending(per_class)
            }
            Protocol::Fresh { train, test, per_class, .. } => {
                within("train", *train, 1, 10_000_000)?;
                within("test", *test, 1, 10_000_000)?;
                if per_class.is_empty() { Ok(()) } else { ascending(per_class) }
            }
            Protocol::Chronological { test, repetitions } => {
                share("test", *test)?;
                once(repetitions)
            }
            Protocol::LeaveGroupOut { repetitions, .. } | Protocol::Official { repetitions, .. } => {
                once(repetitions)
            }
        }
    }

    /// Describes the protocol in a few words, for captions: `stratified 5-fold, 2 repetitions`.
    pub fn words(&self, task: &Task) -> String {
        let split = match self.split() {
            Split::Stratified => "stratified",
            Split::Group => "grouped",
        };
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let mut words = match self {
            Protocol::KFold { folds, .. } => format!("{split} {folds}-fold"),
            Protocol::RandomSplits { test, validation, .. } if *validation > 0.0 => {
                let (test, validation) = (percent(*test), percent(*validation));
                format!("{split} random splits ({test} test, {validation} validation)")
            }
            Protocol::RandomSplits { test, .. } => {
                format!("{split} random splits ({} test)", percent(*test))
            }
            Protocol::FewSamples { test, .. } => {
                format!("few samples per {}, {split} random {} test", task.stratum(), percent(*test))
            }
            Protocol::LeaveGroupOut { .. } => "leave one group out".into(),
            Protocol::Official { .. } => "the data set's own split".into(),
            Protocol::Chronological { test, .. } => format!("the last {} of each group", percent(*test)),
            Protocol::Fresh { train, test, repetitions, per_class } => {
                let few = if per_class.is_empty() {
                    String::new()
                } else {
                    format!(", few samples per {} of them", task.stratum())
                };
                return format!(
                    "{repetitions} fresh worlds of {train} training{few} and {test} test recordings"
                );
            }
        };
        if self.repetitions() > 1 {
            words.push_str(&format!(", {} repetitions", self.repetitions()));
        }
        words
    }

    /// Returns the number of each sample's inseparable group, which no two parts share: groups under `split = "group"`,
    /// otherwise exact copies, if there can be any.
    ///
    /// # Errors
    /// Groups that are asked for and not there.
    pub fn inseparable<'d>(&self, dataset: &'d Dataset) -> Result<Option<&'d [u32]>> {
        let (key, value) = match self {
            Protocol::LeaveGroupOut { .. } => ("protocol.kind", "\"leave-group-out\""),
            _ if self.split() == Split::Group => ("protocol.split", "\"group\""),
            _ => return Ok(dataset.units.as_deref()),
        };
        let groups = dataset.groups.as_deref().ok_or_else(|| {
            let reason = format!(
                "{} has no groups; name the array that holds them (data.group = \"session\") or use split = \
                 \"stratified\"",
                dataset.source
            );
            Problem::new(key, value, reason)
        })?;
        Ok(Some(groups))
    }

    /// Makes the folds of one repetition; of a learning curve one per number of training samples per class.
    ///
    /// # Errors
    /// Groups or an official split that are not there, or too few samples or groups for the protocol.
    pub fn folds(&self, dataset: &Dataset, seed: u64, repetition: usize) -> Result<Vec<Fold>> {
        let is_of_values = matches!(dataset.targets, Targets::Values(_));
        self.cuts(dataset, seed, repetition).map_err(|error| match error {
            Error::Data(data) => match *data {
                taxel_data::Error::TooFewOfClass { samples, count, .. } if is_of_values => {
                    let reason = format!(
                        "a part of the range of the values has {samples} samples to train on; ask for fewer or record more"
                    );
                    Problem::new("protocol.per_class", count.to_string(), reason).into()
                }
                data => data.with_names(&dataset.output_names()).into(),
            },
            other => other,
        })
    }

    /// Makes the folds of [`Protocol::folds`]; classes go by their labels in errors.
    fn cuts(&self, dataset: &Dataset, seed: u64, repetition: usize) -> Result<Vec<Fold>> {
        let units = self.inseparable(dataset)?;
        let (y, repetition) = (&*dataset.strata(), repetition as u32);
        match self {
            Protocol::KFold { folds, split: Split::Group, .. } => {
                Ok(group_k_fold(grouped(units), y, *folds, seed, repetition)?)
            }
            Protocol::KFold { folds, .. } => match stratified_k_fold(y, *folds, seed, repetition, units) {
                Err(taxel_data::Error::ClassTooSmall { .. }) if has_rare_strata(dataset) => {
                    Ok(group_k_fold(&atoms(dataset, units), y, *folds, seed, repetition)?)
                }
                other => Ok(other?),
            },
            Protocol::LeaveGroupOut { .. } => {
                let groups = grouped(units);
                let mut names = groups.to_vec();
                names.sort_unstable();
                names.dedup();
                Ok(group_k_fold(groups, y, names.len(), seed, repetition)?)
            }
            Protocol::RandomSplits { split, test, validation, .. } => {
                let shares = Shares { test: *test, validation: *validation };
                Ok(vec![cut(dataset, *split, units, shares, seed, repetition)?])
            }
            Protocol::FewSamples { split, test, per_class, .. } => {
                let shares = Shares { test: *test, validation: 0.0 };
                let whole = cut(dataset, *split, units, shares, seed, repetition)?;
                few_of(&whole, per_class, dataset, seed, repetition)
            }
            Protocol::Official { .. } => official(dataset).map(|fold| vec![fold]),
            Protocol::Chronological { test, .. } => {
                let whole = vec![0; dataset.len()];
                let groups = dataset.groups.as_deref().unwrap_or(&whole);
                let fold = chronological_split(groups, *test, reach(dataset))?;
                refuse_torn_recordings(dataset, &fold)?;
                Ok(vec![fold])
            }
            Protocol::Fresh { per_class, .. } => {
                let whole = world(dataset, repetition)?;
                if per_class.is_empty() {
                    return Ok(vec![whole]);
                }
                few_of(&whole, per_class, dataset, seed, repetition)
            }
        }
    }
}

/// Returns the name of the row of a learning curve with `count` training samples per class.
pub(crate) fn few_name(name: &str, count: usize) -> String {
    format!("{name}.n{count}")
}

fn ascending(per_class: &[usize]) -> Check {
    let is_ascending = per_class.windows(2).all(|pair| pair[0] < pair[1]);
    let is_positive = per_class.first().is_some_and(|least| *least > 0);
    let reason = "must be ascending numbers from 1, such as [1, 2, 5, 10, 20]";
    require(is_ascending && is_positive, "per_class", format!("{per_class:?}"), reason)
}

/// Makes the folds of a learning curve of one cut, one for each number of training samples of a class.
fn few_of(
    whole: &Fold,
    per_class: &[usize],
    dataset: &Dataset,
    seed: u64,
    repetition: u32,
) -> Result<Vec<Fold>> {
    let (y, units) = (&*dataset.strata(), dataset.units.as_deref());
    let few = |&count: &usize| -> Result<Fold> {
        let train = few_per_class(&whole.train, y, count, seed, repetition, units)?;
        Ok(Fold { train, ..whole.clone() })
    };
    per_class.iter().map(few).collect()
}

/// Returns the groups that [`Protocol::inseparable`] insisted on.
fn grouped(units: Option<&[u32]>) -> &[u32] {
    #[expect(clippy::expect_used, reason = "a data set without groups was refused")]
    units.expect("groups")
}

/// Makes one random cut.
fn cut(
    dataset: &Dataset,
    split: Split,
    units: Option<&[u32]>,
    shares: Shares,
    seed: u64,
    repetition: u32,
) -> Result<Fold> {
    let y = &*dataset.strata();
    if let (Split::Group, Some(groups)) = (split, units) {
        return Ok(random_group_split(groups, y, shares, seed, repetition)?);
    }
    match random_split(y, shares, seed, repetition, units) {
        Err(taxel_data::Error::ClassNotInPart { .. }) if has_rare_strata(dataset) => {
            Ok(random_group_split(&atoms(dataset, units), y, shares, seed, repetition)?)
        }
        other => Ok(other?),
    }
}

/// Refuses a cut through recordings that have one class each, whose windows or frames are the samples.
fn refuse_torn_recordings(dataset: &Dataset, fold: &Fold) -> Result<()> {
    let (Some(units), Some(_), None) = (&dataset.units, dataset.targets.labels(), dataset.targets.steps())
    else {
        return Ok(());
    };
    let hash = |row: usize| dataset.row_hash.get(row);
    let trained: HashMap<u32, usize> = fold.train.iter().map(|row| (units[*row], *row)).collect();
    // Copies are told by their hashes; frames of a recording have none.
    let differ = |a: usize, b: usize| hash(a).is_none() || hash(a) != hash(b);
    let is_torn = |row: &usize| trained.get(&units[*row]).is_some_and(|other| differ(*other, *row));
    match fold.test.iter().find(|row| is_torn(row)) {
        Some(row) => {
            let reason = format!(
                "cuts recordings such as {}, whose class is that of all its windows or frames: its end says nothing that its \
                 beginning has not said; use k-fold",
                dataset.origins.get(*row).map_or("", String::as_str)
            );
            Err(Problem::new("protocol.kind", "\"chronological\"", reason).into())
        }
        None => Ok(()),
    }
}

/// Counts the windows that share time steps with the next one.
fn reach(dataset: &Dataset) -> usize {
    match dataset.spec.length {
        Some(Length::Window { to, hop }) => (to - 1) / hop.unwrap_or(to).max(1),
        _ => 0,
    }
}

fn official(dataset: &Dataset) -> Result<Fold> {
    let test = dataset.official.as_ref().ok_or_else(|| {
        let reason = format!(
            "{} has no split of its own; name the array that marks test samples (data.test = \"test\") or use \
             kind = \"k-fold\"",
            dataset.source
        );
        Problem::new("protocol.kind", "\"official\"", reason)
    })?;
    let (test, train) = (0..dataset.len()).partition(|&row| test[row]);
    Ok(Fold { train, test, validation: vec![] })
}

/// Returns the cut of one world: its samples are a group, of which some are marked for testing.
fn world(dataset: &Dataset, number: u32) -> Result<Fold> {
    let whole = official(dataset)?;
    let groups = dataset.groups.as_deref().unwrap_or_default();
    let of_world =
        |rows: Vec<usize>| rows.into_iter().filter(|row| groups.get(*row) == Some(&number)).collect();
    Ok(Fold { train: of_world(whole.train), test: of_world(whole.test), validation: vec![] })
}

/// Checks whether the strata are combinations of levels or parts of a range: rare ones need not be in every part.
fn has_rare_strata(dataset: &Dataset) -> bool {
    matches!(dataset.targets, Targets::Levels(_) | Targets::Values(_))
}

/// Returns the smallest units of a split: exact copies, or each sample by itself.
fn atoms(dataset: &Dataset, units: Option<&[u32]>) -> Vec<u32> {
    units.map_or_else(|| (0..dataset.len() as u32).collect(), <[u32]>::to_vec)
}
