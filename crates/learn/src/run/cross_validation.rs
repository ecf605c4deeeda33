//! Networks and baselines compared on the same folds: what is run, on what, how it is divided.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use taxel_data::{Dataset, Fold};

use crate::encoding::{Encoder, Encoding};
use crate::error::{Error, Result};
use crate::estimator::candidate::{Candidate, file_name};
use crate::problem::{Problem, require};
use crate::progress::{Progress, Silent};
use crate::run::folder::{Identity, RunFolder};
use crate::run::options::RunOptions;
use crate::run::plan::RunPlan;
use crate::run::protocol::Protocol;
use crate::run::records::FoldKey;
use crate::run::results::Results;
use crate::run::run::ActiveRun;
use crate::run::work::RowWork;

/// Networks and baselines that are trained and tested on the same folds of one data set.
///
/// ```
/// use taxel_baselines::Method;
/// use taxel_data::Dataset;
/// use taxel_base::Layout;
/// use taxel_learn::{Candidate, CrossValidation, Protocol};
/// # let value = |at: ndarray::IxDyn| (at[0] % 2) as f32 + 0.001 * (at[0] + 10 * at[2]) as f32;
/// # let x = ndarray::ArrayD::from_shape_fn(vec![12, 1, 10], value);
/// # let labels: Vec<&str> = (0..12).map(|i| ["soft", "hard"][i % 2]).collect();
///
/// let presses = Dataset::new("presses", Layout::Series, x, &labels)?;
/// let results = CrossValidation::new(&presses)
///     .protocol(Protocol::k_fold(3))
///     .candidate(Candidate::baseline(Method::NearestNeighbours { k: 1 }))
///     .run()?;
/// let mean = results.networks[0].mean.as_ref();
/// assert_eq!(mean.and_then(|mean| mean.get("accuracy")), Some(100.0));
/// # Ok::<(), taxel_learn::Error>(())
/// ```
pub struct CrossValidation<'a> {
    /// Name of the run: letters, digits, `.`, `_`, `-`.
    pub name: String,
    /// One line for tables and reports.
    pub title: Option<String>,
    /// How samples are divided.
    pub protocol: Protocol,
    /// The compared networks and baselines, in the order of the table.
    pub candidates: Vec<Candidate>,
    /// Groups of classes that look alike, by name: the results tell mistakes within from those between.
    pub look_alikes: BTreeMap<String, Vec<String>>,
    /// Networks that cannot take such samples, and why: the results name them.
    pub left_out: BTreeMap<String, String>,
    /// Seed of every random choice.
    pub seed: u64,
    encoding: Encoding,
    encoder: Encoder<'a>,
}

impl<'a> CrossValidation<'a> {
    /// Makes a stratified 5-fold cross-validation without candidates, on z-scored signals, with seed 0.
    pub fn new(dataset: &'a Dataset) -> Self {
        CrossValidation {
            name: dataset.name.clone(),
            title: None,
            protocol: Protocol::default(),
            candidates: vec![],
            look_alikes: BTreeMap::new(),
            left_out: BTreeMap::new(),
            seed: 0,
            encoding: Encoding::default(),
            encoder: Encoder::new(&Encoding::default(), dataset),
        }
    }

    /// Adds a network or baseline.
    pub fn candidate(mut self, candidate: Candidate) -> Self {
        self.candidates.push(candidate);
        self
    }

    /// Divides samples otherwise.
    pub fn protocol(self, protocol: Protocol) -> Self {
        CrossValidation { protocol, ..self }
    }

    /// Encodes samples otherwise.
    pub fn encoding(self, encoding: Encoding) -> Self {
        let encoder = Encoder::new(&encoding, self.encoder.dataset());
        CrossValidation { encoding, encoder, ..self }
    }

    /// Sets the seed.
    pub fn seed(self, seed: u64) -> Self {
        CrossValidation { seed, ..self }
    }

    /// Returns the encoder, whose shapes a caller needs before it builds networks.
    pub fn encoder(&mut self) -> &mut Encoder<'a> {
        &mut self.encoder
    }

    /// Returns every fold of every row, in the order in which they are run; baselines that the samples do not allow
    /// are left out.
    ///
    /// # Errors
    /// As [`CrossValidation::run_in`], before anything is trained.
    pub fn keys(self) -> Result<Vec<FoldKey>> {
        Ok(self.plan()?.keys)
    }

    /// Counts the trainings of each row, on the folds of the run and on `further` ones.
    ///
    /// # Errors
    /// As [`CrossValidation::run_in`], before anything is trained.
    pub fn work(self, further: &[Fold]) -> Result<Vec<RowWork>> {
        Ok(self.plan()?.work(further))
    }

    /// Trains and tests everything in memory: no file is written, no model kept.
    ///
    /// # Errors
    /// As [`CrossValidation::run_in`].
    pub fn run(self) -> Result<Results> {
        let (plan, options) = (self.plan()?, RunOptions::default());
        let mut run = ActiveRun::new(plan, &options, None);
        run.all(&Silent, &AtomicBool::new(false))?;
        run.into_results()
    }

    /// Trains and tests everything and writes the run folder `out`; a set `cancel` ends it between two
    /// steps. The folder remembers what was run, and a resumed run must be the same.
    ///
    /// # Errors
    /// Settings out of range, data that cannot be encoded, a network that does not fit them, a folder that
    /// holds something else, training that diverges; [`Error::Cancelled`] if `cancel` was set. Finished folds
    /// are on disk in every case.
    pub fn run_in(
        self,
        out: &Path,
        options: &RunOptions,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<RunFolder> {
        let now = self.identity();
        let differs = |path: &Path, before: &str| {
            let before: Value = serde_json::from_str(before)
                .map_err(|e| Error::damaged(path, format!("cannot be read: {e}")))?;
            Ok(difference("", &before, &now))
        };
        let identity = Identity { file: "run.json", text: format!("{now:#}\n"), difference: &differs };
        self.run_as(out, &identity, options, progress, cancel)
    }

    /// Does what [`CrossValidation::run_in`] does, with another text that makes two runs the same.
    ///
    /// # Errors
    /// As [`CrossValidation::run_in`].
    pub fn run_as(
        self,
        out: &Path,
        identity: &Identity,
        options: &RunOptions,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<RunFolder> {
        let plan = self.plan()?;
        for key in options.only.iter().flatten() {
            let reason = "is no fold of this run";
            require(plan.keys.contains(key), "only", key, reason)?;
        }
        plan.say(progress);
        let (folder, lock) = RunFolder::prepare(out, identity, options.resume)?;
        let mut run = ActiveRun::new(plan, options, Some(folder.clone()));
        run.begin(progress)?;
        let outcome = run.all(progress, cancel);
        progress.finish();
        // Also after an error: what was finished must be readable.
        run.assemble()?;
        drop(lock);
        outcome.map(|()| folder)
    }

    fn plan(mut self) -> Result<RunPlan<'a>> {
        file_name("name", &self.name)?;
        self.protocol.check().map_err(|problem| problem.below("protocol"))?;
        self.encoding.check().map_err(|problem| problem.below("encoding"))?;
        for (i, candidate) in self.candidates.iter().enumerate() {
            candidate.check()?;
            if self.candidates[..i].iter().any(|other| other.name == candidate.name) {
                let reason = "two candidates go by this name; give one of them another";
                return Err(Problem::new("name", format!("{:?}", candidate.name), reason).into());
            }
        }
        let names: Vec<&str> = self.candidates.iter().flat_map(Candidate::inputs).collect();
        self.encoder.prepare(&names)?;
        let mut plan = RunPlan::new(
            self.name,
            self.title,
            self.protocol,
            self.candidates,
            &self.look_alikes,
            self.seed,
            self.encoder,
        )?;
        plan.results.left_out.extend(self.left_out);
        Ok(plan)
    }

    /// Returns everything that the results depend on besides the samples.
    fn identity(&self) -> Value {
        let candidate = |candidate: &Candidate| {
            let mut identity = json!({ "name": candidate.name });
            candidate.estimator.identify(&mut identity);
            identity
        };
        json!({
            "name": self.name, "seed": self.seed, "protocol": self.protocol, "encoding": self.encoding,
            "look_alikes": self.look_alikes,
            "candidates": self.candidates.iter().map(candidate).collect::<Vec<_>>(),
        })
    }
}

/// Says in words which dotted key is the first whose values differ; `None` where none does.
fn difference(at: &str, before: &Value, now: &Value) -> Option<String> {
    let below = |key: &str| if at.is_empty() { key.to_string() } else { format!("{at}.{key}") };
    match (before, now) {
        (a, b) if a == b => None,
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            a.iter().find_map(|(key, value)| difference(&below(key), value, &b[key]))
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut pairs = a.iter().zip(b).enumerate();
            pairs.find_map(|(i, (a, b))| difference(&below(&i.to_string()), a, b))
        }
        // Whole tables and lists would fill pages.
        (Value::Object(_) | Value::Array(_), _) | (_, Value::Object(_) | Value::Array(_)) => {
            Some(format!("{at} is another"))
        }
        (a, b) => Some(format!("{at} was {a}, is now {b}")),
    }
}
