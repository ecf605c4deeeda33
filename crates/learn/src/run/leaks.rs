//! Finds what makes the scores of a run doubtful: samples that are on both sides, classes that nobody could learn,
//! recordings that say their class before anything is touched.

use std::collections::{BTreeSet, HashSet};
use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};
use taxel_data::{Dataset, EarlyClass, Fold, RowHash};

/// A way in which the score of a run may come from elsewhere than from touch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Leak {
    /// Test samples that are exact copies of training samples, over all folds.
    Copies {
        /// Test samples with a copy in the training part of their fold.
        copied: usize,
        /// Test samples of all folds.
        tested: usize,
        /// The first of them and its copy, by origin.
        example: [String; 2],
    },
    /// Classes with test samples, but without a training sample in some fold: no network can answer them there.
    Untrained {
        /// Their names.
        classes: Vec<String>,
        /// Folds in which one of them is not trained.
        folds: usize,
        /// All folds.
        of: usize,
    },
    /// The beginning of a recording alone tells its class.
    Beginning(EarlyClass),
    /// Samples lie in blocks of one class.
    Blocks {
        /// Runs of one class in the order of the samples.
        runs: usize,
        /// Runs to expect where the order has nothing to do with the class.
        expected: f64,
    },
}

impl Leak {
    /// Finds what is doubtful about testing on these folds, over all repetitions.
    pub(crate) fn all(dataset: &Dataset, folds: &[Vec<Fold>]) -> Vec<Self> {
        let folds: Vec<&Fold> = folds.iter().flatten().collect();
        let mut found: Vec<Leak> =
            copies(dataset, &folds).into_iter().chain(untrained(dataset, &folds)).collect();
        // A simulated world has no recording that could differ.
        if !dataset.source.is_simulated() {
            let early = EarlyClass::of(dataset).into_iter().filter(EarlyClass::is_suspicious);
            found.extend(early.map(Leak::Beginning));
            found.extend(blocks(dataset));
        }
        found
    }
}

fn copies(dataset: &Dataset, folds: &[&Fold]) -> Option<Leak> {
    let hashes = &dataset.row_hash;
    if hashes.len() != dataset.len() {
        return None;
    }
    let (mut copied, mut tested, mut example) = (0, 0, None);
    for fold in folds {
        let trained: HashSet<&RowHash> = fold.train.iter().map(|row| &hashes[*row]).collect();
        tested += fold.test.len();
        for row in fold.test.iter().filter(|row| trained.contains(&hashes[**row])) {
            copied += 1;
            example.get_or_insert_with(|| {
                let other = fold.train.iter().find(|other| hashes[**other] == hashes[*row]);
                [*row, other.copied().unwrap_or(*row)].map(|row| dataset.origins[row].clone())
            });
        }
    }
    example.map(|example| Leak::Copies { copied, tested, example })
}

fn untrained(dataset: &Dataset, folds: &[&Fold]) -> Option<Leak> {
    dataset.targets.labels()?;
    let (mut names, mut bad) = (BTreeSet::new(), 0);
    for fold in folds {
        let outputs = |rows: &[usize]| dataset.outputs_of(rows);
        let missing: Vec<usize> = outputs(&fold.test).difference(&outputs(&fold.train)).copied().collect();
        bad += usize::from(!missing.is_empty());
        names.extend(missing);
    }
    let known = dataset.output_names();
    let classes: Vec<String> = names.into_iter().map(|at| known[at].clone()).collect();
    (!classes.is_empty()).then_some(Leak::Untrained { classes, folds: bad, of: folds.len() })
}

/// Finds blocks of one class where the order of the samples was somebody's choice. Files that lie in a folder of their class,
/// or are called after it, have none to tell.
fn blocks(dataset: &Dataset) -> Option<Leak> {
    dataset.targets.labels()?;
    let y = dataset.strata();
    let runs = 1 + y.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let counts = dataset.class_counts();
    let n = y.len() as f64;
    let same: f64 = counts.iter().map(|count| (*count as f64 / n).powi(2)).sum();
    let expected = 1.0 + (n - 1.0) * (1.0 - same);
    let is_blocked = runs as f64 <= 0.25 * expected && y.len() >= 40;
    (is_blocked && !is_sorted_by_name(dataset)).then_some(Leak::Blocks { runs, expected })
}

/// Checks whether a part of the path of each sample begins with its class.
fn is_sorted_by_name(dataset: &Dataset) -> bool {
    let names = dataset.output_names();
    let is_of = |(origin, class): (&String, &u32)| {
        let name = names.get(*class as usize);
        name.is_some_and(|name| origin.split('/').any(|part| part.starts_with(name.as_str())))
    };
    dataset.origins.iter().zip(dataset.strata().iter()).all(is_of)
}

impl Display for Leak {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Leak::Copies { copied, tested, example: [test, train] } => write!(
                f,
                "{copied} of {tested} test samples are copies of training samples ({test} of {train}): the scores tell \
                 what was seen before; split by group, or set data.drop = [\"duplicates\"]"
            ),
            Leak::Untrained { classes, folds, of } => write!(
                f,
                "{} {} tested but not trained in {folds} of {of} folds: no network can answer them there",
                classes.join(", "),
                if classes.len() == 1 { "is" } else { "are" }
            ),
            Leak::Beginning(early) => {
                write!(f, "{early}: they were recorded in blocks of one class, or begin in contact")
            }
            Leak::Blocks { runs, expected } => write!(
                f,
                "the samples lie in {runs} runs of one class ({expected:.0} to expect in a mixed order): if they were recorded \
                 so, a drift of the sensor tells the class"
            ),
        }
    }
}
