//! A run before it begins: rows, folds and empty results.

use std::collections::BTreeMap;

use taxel_data::{Dataset, Fold, Shortcut};

use crate::encoding::Encoder;
use crate::error::Result;
use crate::estimator::candidate::{Candidate, Hardening};
use crate::problem::Problem;
use crate::progress::Progress;
use crate::run::leaks::Leak;
use crate::run::protocol::{Protocol, few_name};
use crate::run::records::FoldKey;
use crate::run::results::{NetworkResults, Results, ScoringContext};

/// One row of the table: a candidate, in a learning curve with one number of samples.
pub(crate) struct PlannedRow {
    /// Name of the row.
    pub name: String,
    /// Position of the candidate.
    pub candidate: usize,
    /// Training samples per class, and the fold that has so many.
    pub few: Option<(usize, usize)>,
}

/// Everything that a run needs to know before it begins.
pub(crate) struct RunPlan<'a> {
    pub dataset: &'a Dataset,
    pub encoder: Encoder<'a>,
    pub protocol: Protocol,
    pub seed: u64,
    pub candidates: Vec<Candidate>,
    pub rows: Vec<PlannedRow>,
    /// Folds of each repetition.
    pub folds: Vec<Vec<Fold>>,
    /// Every fold of every row, in the order in which they are run.
    pub keys: Vec<FoldKey>,
    /// Facts about the samples that scores need.
    pub frame: ScoringContext,
    /// Results without a score.
    pub results: Results,
    drawn: Vec<(String, Vec<String>)>,
}

impl<'a> RunPlan<'a> {
    /// Divides the samples and checks that every candidate can be trained on them; baselines that cannot be
    /// are left out.
    ///
    /// # Errors
    /// Folds that cannot be made, a network whose inputs the encoding does not make, a checkpoint of another
    /// network.
    pub fn new(
        name: String,
        title: Option<String>,
        protocol: Protocol,
        candidates: Vec<Candidate>,
        look_alikes: &BTreeMap<String, Vec<String>>,
        seed: u64,
        encoder: Encoder<'a>,
    ) -> Result<Self> {
        let dataset = encoder.dataset();
        dataset.refuse_one_class()?;
        let mut drawn = vec![];
        for candidate in &candidates {
            candidate.check_faults(dataset)?;
            if candidate.estimator.as_network().is_some() {
                candidate.check_samples(dataset.len(), &encoder)?;
                drawn.push((candidate.name.clone(), candidate.estimator.drawn()?));
            }
        }
        let folds: Vec<Vec<Fold>> = (0..protocol.repetitions())
            .map(|repetition| protocol.folds(dataset, seed, repetition))
            .collect::<Result<_>>()?;
        let (candidates, left_out) = able(candidates, &encoder, &folds);
        let rows = rows(&candidates, &protocol)?;
        let per_row = if protocol.per_class().is_some() { 1 } else { folds.first().map_or(0, Vec::len) };
        let drawn_of = |name: &str| {
            drawn.iter().find(|(candidate, _)| candidate == name).map(|(_, names)| names.clone())
        };
        let networks = rows
            .iter()
            .map(|row| {
                let candidate = &candidates[row.candidate];
                empty_row(row, candidate, drawn_of(&candidate.name).unwrap_or_default())
            })
            .collect();
        let results = Results {
            name,
            title,
            look_alikes: look_alikes.clone(),
            folds: per_row,
            left_out,
            leaks: Leak::all(dataset, &folds),
            networks,
            ..Results::empty(dataset, &protocol, seed)
        };
        let names = rows.iter().map(|row| row.name.as_str());
        Ok(RunPlan {
            dataset,
            keys: FoldKey::all(names, folds.len(), per_row),
            frame: ScoringContext::of(dataset, look_alikes)?,
            encoder,
            protocol,
            seed,
            candidates,
            rows,
            folds,
            results,
            drawn,
        })
    }

    /// Says which tensors of a checkpoint are not used.
    pub fn say(&self, progress: &dyn Progress) {
        for (name, drawn) in self.drawn.iter().filter(|(_, drawn)| !drawn.is_empty()) {
            let (drawn, classes) = (drawn.join(", "), self.dataset.task().outputs());
            progress.say(&format!("{name}: drawn fresh, for {classes} classes: {drawn}"));
        }
    }

    /// Returns the row of a fold.
    pub fn row(&self, key: &FoldKey) -> Option<&PlannedRow> {
        self.rows.iter().find(|row| row.name == key.network)
    }

    /// Returns the samples of a fold.
    pub fn fold(&self, key: &FoldKey) -> Option<&Fold> {
        let few = self.row(key)?.few;
        self.folds.get(key.repetition)?.get(few.map_or(key.fold, |(_, fold)| fold))
    }
}

/// Makes one row per candidate; of a learning curve one per number of samples. Rows name files: two that are alike
/// are refused.
fn rows(candidates: &[Candidate], protocol: &Protocol) -> Result<Vec<PlannedRow>> {
    let mut rows: Vec<PlannedRow> = vec![];
    for (candidate, one) in candidates.iter().enumerate() {
        let row = |(name, few)| PlannedRow { name, candidate, few };
        rows.extend(protocol.rows_of(&one.name).into_iter().map(row));
    }
    for (i, row) in rows.iter().enumerate() {
        if rows[..i].iter().any(|other| other.name == row.name) {
            let reason = "two rows of the learning curve would go by this name; give one another label";
            return Err(Problem::new("label", format!("{:?}", row.name), reason).into());
        }
    }
    Ok(rows)
}

/// Returns the candidates that can be fitted to these samples, and why others cannot.
fn able(
    candidates: Vec<Candidate>,
    encoder: &Encoder,
    folds: &[Vec<Fold>],
) -> (Vec<Candidate>, BTreeMap<String, String>) {
    let most = folds.iter().flatten().map(|fold| fold.train.len()).max().unwrap_or(0);
    let mut left_out = BTreeMap::new();
    let able = candidates.into_iter().filter(|candidate| match candidate.estimator.unfit(most, encoder) {
        None => true,
        Some(reason) => {
            left_out.insert(candidate.name.clone(), reason);
            false
        }
    });
    let able = able.collect();
    (able, left_out)
}

/// Counts the samples that a few global statistics tell apart, where they are so many that real recordings become
/// suspicious. A simulated world has no recording that could differ.
pub(crate) fn shortcut(dataset: &Dataset) -> Option<Shortcut> {
    if dataset.source.is_simulated() || dataset.targets.labels().is_none() {
        return None;
    }
    let found =
        Shortcut::of(&dataset.x, &dataset.strata(), dataset.groups.as_deref(), dataset.units.as_deref());
    found.filter(Shortcut::is_suspicious)
}

/// Returns the fault augmentation of the row; in a learning curve its twin has as many samples.
fn hardening(row: &PlannedRow, candidate: &Candidate) -> Option<Hardening> {
    let of_twin = |clean: &String| match row.few {
        Some((count, _)) => few_name(clean, count),
        None => clean.clone(),
    };
    Some(Hardening {
        faults: candidate.faults()?.clone(),
        clean: candidate.twin.as_ref().map(|twin| of_twin(&twin.clean)),
        unmet: candidate.twin.as_ref().and_then(|twin| twin.unmet),
    })
}

fn empty_row(row: &PlannedRow, candidate: &Candidate, drawn: Vec<String>) -> NetworkResults {
    NetworkResults {
        network: row.name.clone(),
        candidate: candidate.name.clone(),
        zoo: candidate.zoo.clone(),
        per_class: row.few.map(|(count, _)| count),
        paper: candidate.paper.clone(),
        settings: candidate.settings.clone(),
        drawn,
        costs: candidate.estimator.costs(),
        published: candidate.published.clone(),
        hardening: hardening(row, candidate),
        ..NetworkResults::default()
    }
}
