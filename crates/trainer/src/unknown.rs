//! Trainings without some classes, to see whether a gate tells samples of them.

use std::sync::atomic::{AtomicBool, Ordering};

use taxel_data::{Fold, Task};
use taxel_learn::certainty::{UnknownDraw, UnknownScores, UnknownTrial, WithoutClasses};
use taxel_learn::{Candidate, Encoder, FoldKey, NetworkResults, OneFold, Predictor, Progress, RunFolder};

use crate::error::Result;
use crate::run::Runner;

/// Samples that a model predicts at a time.
const BATCH: usize = 64;

impl Runner<'_> {
    /// Trains every row without some of the classes, as often as `trial` says, and scores its gate on them: on the test parts of
    /// the first repetition, or of all where each has one. Finished trainings are kept in `unknown/` of the run folder, and the
    /// scores in `unknown.json`. Rows without logits, with missing folds or with one test part are left out. None where fewer than
    /// three classes or values are learned.
    ///
    /// # Errors
    /// Data that cannot be encoded, training that diverges, files that cannot be read or written;
    /// [`taxel_learn::Error::Cancelled`] if `cancel` was set.
    pub fn try_unknown(
        &self,
        folder: &RunFolder,
        trial: &UnknownTrial,
        threads: usize,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<Option<Vec<UnknownScores>>> {
        let (dataset, config) = (self.dataset, self.experiment.config());
        let Task::Classes(classes) = dataset.task() else { return Ok(None) };
        let labels: Vec<u32> = dataset.targets.labels().map_or(vec![], |labels| labels.values().to_vec());
        let mut encoder = Encoder::new(&config.encoding, dataset);
        let (candidates, _) = self.candidates(&mut encoder)?;
        let draws = trial.drawn(classes.len(), config.seed);
        if draws.is_empty() {
            return Ok(None);
        }
        let rows = self.rows(&candidates, folder, progress)?;
        let total = draws.len() * rows.iter().map(|row| row.parts.len()).sum::<usize>();
        let (mut scores, mut done) = (vec![], 0);
        progress.start(total as u64);
        for Row { name, candidate, parts } in &rows {
            encoder.prepare(&candidate.inputs())?;
            let mut of_row = UnknownScores { network: name.clone(), draws: vec![] };
            for left_out in &draws {
                let mut trainings = vec![];
                for part in parts {
                    done += 1;
                    progress.fold(&part.key, done, total);
                    let (encoder, labels) = (&encoder, labels.as_slice());
                    let training =
                        Training { runner: self, encoder, candidate, left_out, labels, part, threads };
                    let found = training.kept_or_run(folder, cancel)?;
                    let Some(found) = found.filter(|_| !cancel.load(Ordering::Relaxed)) else {
                        progress.finish();
                        let (done, folder) = (done - 1, folder.path().display().to_string());
                        return Err(taxel_learn::Error::Cancelled { done, total, folder }.into());
                    };
                    progress.step(1);
                    trainings.push(found);
                }
                let groups = dataset.groups.as_deref().filter(|_| config.protocol.keeps_groups());
                let raw = (dataset.spec.layout, &*dataset.x);
                of_row.draws.extend(UnknownDraw::of(&trainings, classes.len(), groups, raw));
            }
            scores.push(of_row);
        }
        progress.finish();
        folder.write_unknown(&scores)?;
        Ok(Some(scores))
    }

    /// Lists the rows of a run whose gates can be tried.
    fn rows<'c>(
        &self,
        candidates: &'c [Candidate],
        folder: &RunFolder,
        progress: &dyn Progress,
    ) -> Result<Vec<Row<'c>>> {
        let protocol = &self.experiment.config().protocol;
        let folds = |repetition| protocol.folds(self.dataset, self.experiment.config().seed, repetition);
        let first = folds(0)?;
        let results = folder.results()?;
        let mut rows = vec![];
        for candidate in candidates.iter().filter(|candidate| candidate.estimator.has_logits()) {
            for (name, few) in protocol.rows_of(&candidate.name) {
                let key = |repetition, fold| FoldKey { network: name.clone(), repetition, fold };
                let parts: Vec<Part> = if few.is_some() || first.len() == 1 {
                    let place = few.map_or(0, |(_, fold)| fold);
                    let part = |repetition: usize| {
                        let fold = folds(repetition)?.swap_remove(place);
                        Ok(Part { number: repetition as u32, key: key(repetition, 0), fold })
                    };
                    (0..protocol.repetitions()).map(part).collect::<Result<_>>()?
                } else {
                    let part = |(number, fold): (usize, &Fold)| Part {
                        number: number as u32,
                        key: key(0, number),
                        fold: fold.clone(),
                    };
                    first.iter().enumerate().map(part).collect()
                };
                let was_run = |row: &NetworkResults| row.network == name && row.folds.len() >= parts.len();
                if !results.networks.iter().any(was_run) {
                    continue;
                }
                if parts.len() < 2 {
                    progress.say(&format!(
                        "{name}: the gate for unknown classes is not tried, for it is fitted on other test parts and there is one; \
                         use k-fold or more repetitions"
                    ));
                    continue;
                }
                rows.push(Row { name, candidate, parts });
            }
        }
        Ok(rows)
    }
}

/// A row whose gate is tried.
struct Row<'c> {
    name: String,
    candidate: &'c Candidate,
    parts: Vec<Part>,
}

/// A test part of a row.
struct Part {
    number: u32,
    key: FoldKey,
    fold: Fold,
}

/// One training without some classes.
struct Training<'a> {
    runner: &'a Runner<'a>,
    /// Has prepared the candidate's inputs.
    encoder: &'a Encoder<'a>,
    candidate: &'a Candidate,
    left_out: &'a [u32],
    labels: &'a [u32],
    part: &'a Part,
    threads: usize,
}

impl Training<'_> {
    /// Returns the digest of all that it depends on.
    fn digest(&self) -> String {
        let Runner { dataset, experiment, .. } = self.runner;
        let config = experiment.config();
        let Part { key, fold: Fold { train, test, validation }, .. } = self.part;
        let parts = serde_json::json!({
            "candidate": self.candidate.identity(), "encoding": config.encoding, "data": dataset.digest, "facts": dataset.facts(),
            "seed": config.seed, "row": key.network, "repetition": key.repetition, "fold": key.fold, "rows": [train, test, validation],
            "without": self.left_out,
            "taxel": env!("CARGO_PKG_VERSION"),
        });
        blake3::hash(parts.to_string().as_bytes()).to_hex().to_string()
    }

    /// Reads the training from a run folder, or trains and keeps it there; `None` if `cancel` was set.
    fn kept_or_run(&self, folder: &RunFolder, cancel: &AtomicBool) -> Result<Option<WithoutClasses>> {
        let of = self.digest();
        if let Some(found) = folder.without_classes(&of)? {
            return Ok(Some(found));
        }
        let made = self.run(cancel)?;
        made.iter().try_for_each(|made| folder.keep_without_classes(&of, made))?;
        Ok(made)
    }

    fn run(&self, cancel: &AtomicBool) -> Result<Option<WithoutClasses>> {
        let Runner { dataset, experiment, .. } = self.runner;
        let Part { number, key, fold } = self.part;
        let config = experiment.config();
        let is_kept = |row: &usize| !self.left_out.contains(&self.labels[*row]);
        let keep = |rows: &[usize]| rows.iter().copied().filter(is_kept).collect();
        let known = Fold { train: keep(&fold.train), test: vec![], validation: keep(&fold.validation) };
        let one = OneFold {
            candidate: self.candidate,
            protocol: &config.protocol,
            seed: config.seed,
            key: key.clone(),
            fold: &known,
            teacher: None,
            threads: self.threads,
        };
        let Some(tested) = one.run(self.encoder, &mut |_| {}, cancel)? else { return Ok(None) };
        let predictor = tested.model.predictor(BATCH, self.threads)?;
        // Logits of two networks do not lie in the same place.
        let places = match tested.model.card().graph() {
            Some(_) => {
                let (rows, logits) = answers(&predictor, dataset, &known.train)?;
                let truth: Vec<u32> = rows.iter().map(|row| self.labels[*row]).collect();
                WithoutClasses::places_of(self.left_out, dataset.output_names().len(), &logits, &truth)
            }
            None => None,
        };
        let (rows, logits) = answers(&predictor, dataset, &fold.test)?;
        Ok(Some(WithoutClasses {
            classes: self.left_out.to_vec(),
            fold: *number,
            truth: rows.iter().map(|row| self.labels[*row]).collect(),
            rows,
            logits,
            places,
        }))
    }
}

/// Returns the samples of `rows` that can be encoded, and their logits.
fn answers(
    predictor: &Predictor,
    dataset: &taxel_data::Dataset,
    rows: &[usize],
) -> Result<(Vec<usize>, Vec<f32>)> {
    if let Ok(logits) = predictor.logits(&dataset.select(rows).x) {
        return Ok((rows.to_vec(), logits));
    }
    let one = |row: &usize| Some((*row, predictor.logits(&dataset.select(&[*row]).x).ok()?));
    let (rows, logits): (Vec<usize>, Vec<Vec<f32>>) = rows.iter().filter_map(one).unzip();
    Ok((rows, logits.concat()))
}
