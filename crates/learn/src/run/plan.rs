//! A run before it begins: rows, folds and empty results.

use std::collections::BTreeMap;

use taxel_data::{Dataset, Fold, Shortcut};
use taxel_graph::Loss;

use crate::encoding::{Encoder, SERIES};
use crate::error::{Error, Result};
use crate::estimator::candidate::{Candidate, Estimator, Hardening, Trainable};
use crate::problem::{Problem, fault_problem, require};
use crate::progress::Progress;
use crate::run::protocol::Protocol;
use crate::run::records::{Costs, FoldKey};
use crate::run::results::{Frame, NetworkResults, Results};

/// One row of the table: a candidate, in a learning curve with one number of samples.
pub(crate) struct Row {
    /// Name of the row.
    pub name: String,
    /// Position of the candidate.
    pub candidate: usize,
    /// Training samples per class, and the fold that has so many.
    pub few: Option<(usize, usize)>,
}

/// Everything that a run needs to know before it begins.
pub(crate) struct Plan<'a> {
    pub dataset: &'a Dataset,
    pub encoder: Encoder<'a>,
    pub protocol: Protocol,
    pub seed: u64,
    pub candidates: Vec<Candidate>,
    pub rows: Vec<Row>,
    /// Folds of each repetition.
    pub folds: Vec<Vec<Fold>>,
    /// Every fold of every row, in the order in which they are run.
    pub keys: Vec<FoldKey>,
    /// What scores need to know about the samples.
    pub frame: Frame,
    /// Results without a score.
    pub results: Results,
    drawn: Vec<(String, Vec<String>)>,
}

impl<'a> Plan<'a> {
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
            check_faults(candidate, dataset)?;
            if let Estimator::Network(network) = &candidate.estimator {
                check_network(candidate, network, &encoder)?;
                drawn.push((candidate.name.clone(), network.drawn()?));
            }
        }
        let folds: Vec<Vec<Fold>> = (0..protocol.repetitions())
            .map(|repetition| protocol.folds(dataset, seed, repetition))
            .collect::<Result<_>>()?;
        let (candidates, left_out) = able(candidates, &encoder, &folds);
        let rows = rows(&candidates, &protocol)?;
        let per_row = if protocol.per_class().is_some() { 1 } else { folds.first().map_or(0, Vec::len) };
        let drawn_of = |name: &str| drawn.iter().find(|(own, _)| own == name).map(|(_, names)| names.clone());
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
            networks,
            ..Results::empty(dataset, &protocol, seed)
        };
        let names = rows.iter().map(|row| row.name.as_str());
        Ok(Plan {
            dataset,
            keys: FoldKey::all(names, folds.len(), per_row),
            frame: Frame::of(dataset, look_alikes, seed)?,
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
            let (drawn, classes) = (drawn.join(", "), self.dataset.classes.len());
            progress.say(&format!("{name}: drawn fresh, for {classes} classes: {drawn}"));
        }
    }

    /// The row of a fold.
    pub fn row(&self, key: &FoldKey) -> Option<&Row> {
        self.rows.iter().find(|row| row.name == key.network)
    }

    /// The samples of a fold.
    pub fn fold(&self, key: &FoldKey) -> Option<&Fold> {
        let few = self.row(key)?.few;
        self.folds.get(key.repetition)?.get(few.map_or(key.fold, |(_, fold)| fold))
    }
}

/// One row per candidate; of a learning curve one per number of samples. Rows name files: no two are alike.
fn rows(candidates: &[Candidate], protocol: &Protocol) -> Result<Vec<Row>> {
    let mut rows: Vec<Row> = vec![];
    for (candidate, own) in candidates.iter().enumerate() {
        match protocol.per_class() {
            None => rows.push(Row { name: own.name.clone(), candidate, few: None }),
            Some(counts) => rows.extend(counts.iter().enumerate().map(|(fold, &count)| Row {
                name: few_name(&own.name, count),
                candidate,
                few: Some((count, fold)),
            })),
        }
    }
    for (i, row) in rows.iter().enumerate() {
        if rows[..i].iter().any(|other| other.name == row.name) {
            let reason = "two rows of the learning curve would go by this name; give one another label";
            return Err(Problem::new("label", format!("{:?}", row.name), reason).into());
        }
    }
    Ok(rows)
}

/// Refuses a network that cannot be trained on the samples: its inputs, its outputs, its recipes.
///
/// # Errors
/// The first input that the encoding does not make, another number of outputs, a loss or an augmentation
/// that the samples do not allow.
pub(crate) fn check_network(candidate: &Candidate, network: &Trainable, encoder: &Encoder) -> Result<()> {
    check_inputs(candidate, network, encoder)?;
    let classes = encoder.dataset().classes.len();
    let shape = network.graph.outputs().first().map_or(&[][..], |(_, id)| &network.graph.nodes()[*id].shape);
    let outputs = shape.iter().product::<usize>();
    if outputs != classes {
        return Err(Error::Outputs { network: candidate.name.clone(), outputs, classes });
    }
    let several = encoder.dataset().labels.attributes().len() > 1;
    let tried = network.search.iter().flat_map(|search| &search.grid).map(|own| &own.recipe);
    for recipe in tried.chain([&network.recipe]) {
        let reason =
            "several attributes need \"multi-label-soft-margin\", \"hinge\" or \"mean-squared-error\"";
        let fits = !several || recipe.loss != Loss::SoftmaxCrossEntropy;
        require(fits, "loss", "\"softmax-cross-entropy\"", reason)?;
        let reason = "moves pixels: it needs encoding.image of kind \"raw\" or \"frame\", or encoding.tensor";
        require(recipe.augment.is_none() || encoder.is_warpable(), "augment", "{ .. }", reason)?;
    }
    Ok(())
}

/// Refuses faults without a meaning for the samples.
///
/// # Errors
/// The first of them.
pub(crate) fn check_faults(candidate: &Candidate, dataset: &Dataset) -> Result<()> {
    let Some(faults) = candidate.faults() else { return Ok(()) };
    faults.plan(dataset.reading.layout, &dataset.reading.shape).map_err(fault_problem)?;
    Ok(())
}

/// Refuses a network whose inputs are not what the encoding makes.
///
/// # Errors
/// The first such input.
fn check_inputs(candidate: &Candidate, network: &Trainable, encoder: &Encoder) -> Result<()> {
    for node in network.graph.inputs() {
        let refuse = |reason: String| Error::Input {
            network: candidate.name.clone(),
            input: node.name.clone(),
            reason,
        };
        let shape =
            encoder.shape(&node.name).ok_or_else(|| refuse("the encoding makes no such input".into()))?;
        // `[n]` and `[1, n]` take the whole sample as one row.
        let row = matches!(*node.shape, [n] | [1, n] if n == shape.iter().product::<usize>());
        if node.shape != shape && !row {
            return Err(refuse(format!("it takes {:?}, the samples are {shape:?}", node.shape)));
        }
    }
    Ok(())
}

/// The candidates that can be fitted to these samples, and why others cannot.
fn able(
    candidates: Vec<Candidate>,
    encoder: &Encoder,
    folds: &[Vec<Fold>],
) -> (Vec<Candidate>, BTreeMap<String, String>) {
    let most = folds.iter().flatten().map(|fold| fold.train.len()).max().unwrap_or(0);
    let length = encoder.shape(SERIES).and_then(|shape| shape.last().copied()).unwrap_or(0);
    let mut left_out = BTreeMap::new();
    let able = candidates.into_iter().filter(|candidate| {
        let Estimator::Baseline { method, .. } = &candidate.estimator else { return true };
        match method.unfit(most, length) {
            None => true,
            Some(reason) => {
                left_out.insert(candidate.name.clone(), reason);
                false
            }
        }
    });
    let able = able.collect();
    (able, left_out)
}

/// How many samples a few global statistics tell apart, where that is so many that it makes real
/// recordings suspicious. A simulated world has no recording that could differ.
pub(crate) fn shortcut(dataset: &Dataset) -> Option<Shortcut> {
    if dataset.source.is_simulated() {
        return None;
    }
    let found = Shortcut::of(&dataset.x, &dataset.y, dataset.groups.as_deref(), dataset.units.as_deref());
    found.filter(Shortcut::is_suspicious)
}

/// How the row was trained under faults; in a learning curve its twin has as many samples.
fn hardening(row: &Row, candidate: &Candidate) -> Option<Hardening> {
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

fn few_name(name: &str, count: usize) -> String {
    format!("{name}.n{count}")
}

fn empty_row(row: &Row, candidate: &Candidate, drawn: Vec<String>) -> NetworkResults {
    let costs = match &candidate.estimator {
        Estimator::Network(network) => network.graph.cost().into(),
        Estimator::Baseline { .. } => Costs { parameters: 0, bytes: 0, macs: 0, flops: 0 },
    };
    NetworkResults {
        network: row.name.clone(),
        candidate: candidate.name.clone(),
        zoo: candidate.zoo.clone(),
        per_class: row.few.map(|(count, _)| count),
        paper: candidate.paper.clone(),
        settings: candidate.settings.clone(),
        drawn,
        changes: vec![],
        other_statistics: None,
        diverged: 0,
        costs,
        folds: vec![],
        mean: None,
        sd: None,
        interval: None,
        confusion: None,
        look_alikes: None,
        attributes: vec![],
        published: candidate.published.clone(),
        hardening: hardening(row, candidate),
        quantized: None,
    }
}
