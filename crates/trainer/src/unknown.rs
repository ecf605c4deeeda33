//! Trainings without some classes, to see whether a gate tells samples of them.

use std::sync::atomic::{AtomicBool, Ordering};

use taxel_data::{Fold, Task};
use taxel_learn::certainty::{UnknownDraw, UnknownScores, UnknownTrial, WithoutClasses};
use taxel_learn::{Candidate, Encoder, FoldKey, OneFold, Predictor, Progress, RunFolder};

use crate::error::Result;
use crate::run::Runner;

/// Samples that a model predicts at a time.
const BATCH: usize = 64;

impl Runner<'_> {
    /// Trains every row of the first repetition without some of the classes, as often as `trial` says, and scores its gate on
    /// them; finished trainings are kept in `unknown/` of the run folder, and the scores in `unknown.json`. Rows without logits, or
    /// with missing folds, are left out. None where fewer than three classes or values are learned.
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
        let folds = config.protocol.folds(dataset, config.seed, 0)?;
        let results = folder.results()?;
        let was_run = |name: &str| {
            results.networks.iter().any(|row| row.network == name && row.folds.len() >= folds.len())
        };
        let is_tried = |candidate: &Candidate| candidate.estimator.has_logits() && was_run(&candidate.name);
        let candidates: Vec<Candidate> = candidates.into_iter().filter(is_tried).collect();
        let draws = (0..trial.draws).map(|draw| trial.drawn(classes.len(), config.seed, draw));
        let Some(draws) = draws.collect::<Option<Vec<_>>>() else { return Ok(None) };
        let total = candidates.len() * draws.len() * folds.len();
        let (mut scores, mut done) = (vec![], 0);
        progress.start(total as u64);
        for candidate in &candidates {
            encoder.prepare(&candidate.inputs())?;
            let mut own = UnknownScores { network: candidate.name.clone(), draws: vec![] };
            for left_out in &draws {
                let mut trainings = vec![];
                for (number, fold) in folds.iter().enumerate() {
                    let key = FoldKey { network: candidate.name.clone(), repetition: 0, fold: number };
                    done += 1;
                    progress.fold(&key, done, total);
                    let (encoder, labels) = (&encoder, labels.as_slice());
                    let training =
                        Training { runner: self, encoder, candidate, left_out, labels, key, threads };
                    let found = training.kept_or_run(folder, fold, cancel)?;
                    let Some(found) = found.filter(|_| !cancel.load(Ordering::Relaxed)) else {
                        progress.finish();
                        let (done, folder) = (done - 1, folder.path().display().to_string());
                        return Err(taxel_learn::Error::Cancelled { done, total, folder }.into());
                    };
                    progress.step(1);
                    trainings.push(found);
                }
                own.draws.extend(UnknownDraw::of(&trainings, classes.len()));
            }
            scores.push(own);
        }
        progress.finish();
        folder.write_unknown(&scores)?;
        Ok(Some(scores))
    }
}

/// One training without some classes.
struct Training<'a> {
    runner: &'a Runner<'a>,
    /// Has prepared the candidate's inputs.
    encoder: &'a Encoder<'a>,
    candidate: &'a Candidate,
    left_out: &'a [u32],
    labels: &'a [u32],
    key: FoldKey,
    threads: usize,
}

impl Training<'_> {
    /// Returns the digest of all that it depends on.
    fn digest(&self, fold: &Fold) -> String {
        let Runner { dataset, experiment, .. } = self.runner;
        let config = experiment.config();
        let Fold { train, test, validation } = fold;
        let parts = serde_json::json!({
            "candidate": self.candidate.identity(), "encoding": config.encoding, "data": dataset.digest, "facts": dataset.facts(),
            "seed": config.seed, "fold": self.key.fold, "rows": [train, test, validation], "without": self.left_out,
            "taxel": env!("CARGO_PKG_VERSION"),
        });
        blake3::hash(parts.to_string().as_bytes()).to_hex().to_string()
    }

    /// Reads the training from a run folder, or trains and keeps it there; `None` if `cancel` was set.
    fn kept_or_run(
        &self,
        folder: &RunFolder,
        fold: &Fold,
        cancel: &AtomicBool,
    ) -> Result<Option<WithoutClasses>> {
        let of = self.digest(fold);
        if let Some(found) = folder.without_classes(&of)? {
            return Ok(Some(found));
        }
        let made = self.run(fold, cancel)?;
        made.iter().try_for_each(|made| folder.keep_without_classes(&of, made))?;
        Ok(made)
    }

    fn run(&self, fold: &Fold, cancel: &AtomicBool) -> Result<Option<WithoutClasses>> {
        let Runner { dataset, experiment, .. } = self.runner;
        let config = experiment.config();
        let is_kept = |row: &usize| !self.left_out.contains(&self.labels[*row]);
        let keep = |rows: &[usize]| rows.iter().copied().filter(is_kept).collect();
        let known = Fold { train: keep(&fold.train), test: vec![], validation: keep(&fold.validation) };
        let one = OneFold {
            candidate: self.candidate,
            protocol: &config.protocol,
            seed: config.seed,
            key: self.key.clone(),
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
            fold: self.key.fold as u32,
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
