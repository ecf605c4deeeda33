//! Baselines as estimators: fitted on labelled series, saved, read again.

use std::sync::Arc;
use std::time::Instant;

use serde_json::{Value, json};
use taxel_baselines::{Fitted as FittedMethod, Method, Saved, Series, Workspace};
use taxel_data::{Targets, Task};
use taxel_faults::TrainingFaults;
use taxel_graph::{Tensor, Weights};

use crate::encoding::{Encoder, Input, SERIES};
use crate::error::{Error, Result};
use crate::estimator::estimator::{Estimator, Fitted, Trained, TrainingSet};
use crate::estimator::series_shape::{read_as, shape_of};
use crate::metrics::Outcome;
use crate::model::ModelKind;
use crate::problem::{fault_problem, within};
use crate::run::records::{Costs, FoldRecord};
use crate::training::hooks::Hooks;
use crate::training::part::{TrainingKey, pool};
use crate::training::pass::TrainingPass;
use crate::training::raw_changes::RawChanges;

/// A baseline with its settings.
#[derive(Debug, Clone)]
pub(crate) struct Baseline {
    pub method: Method,
    /// Faults of the copies that it learns from, beside the clean samples. Default no copies.
    pub faults: Option<Box<TrainingFaults>>,
}

impl Estimator for Baseline {
    fn inputs(&self) -> Vec<&str> {
        vec![SERIES]
    }

    fn check(&self) -> Result<()> {
        match self.method {
            Method::MiniRocket { features } => within("features", features, 1, 1_000_000)?,
            Method::ExtraTrees { trees, min_samples_leaf } => {
                within("trees", trees, 1, 10_000)?;
                within("min_samples_leaf", min_samples_leaf, 1, 1_000_000)?;
            }
            _ => {}
        }
        match &self.faults {
            Some(faults) => Ok(faults.check().map_err(fault_problem)?),
            None => Ok(()),
        }
    }

    fn check_samples(&self, name: &str, samples: usize, encoder: &Encoder) -> Result<()> {
        match self.unfit(samples, encoder) {
            Some(reason) => Err(Error::Input { network: name.into(), input: SERIES.into(), reason }),
            None => Ok(()),
        }
    }

    fn unfit(&self, samples: usize, encoder: &Encoder) -> Option<String> {
        let of_values = encoder.dataset().targets.values().is_some();
        if of_values && !self.method.learns_values() {
            return Some("learns classes, and the targets are values".into());
        }
        if !of_values && !self.method.learns_classes() {
            return Some("learns values, and the targets are classes".into());
        }
        if encoder.dataset().weights.is_some() && !self.method.takes_weights() {
            return Some("counts all samples alike, and these have weights".into());
        }
        let length = encoder.shape(SERIES).and_then(|shape| shape.last().copied()).unwrap_or(0);
        self.method.unfit(samples, length)
    }

    fn faults(&self) -> Option<&TrainingFaults> {
        self.faults.as_deref()
    }

    fn under(&self, faults: &TrainingFaults) -> Arc<dyn Estimator> {
        Arc::new(Baseline { faults: Some(Box::new(faults.clone())), ..self.clone() })
    }

    /// Checks whether training under faults changes what it learns: the other baselines keep every sample that they
    /// are given, or look at none.
    fn gains_by_faults(&self) -> bool {
        matches!(
            self.method,
            Method::MiniRocket { .. }
                | Method::SvmLinear { .. }
                | Method::SvmRbf { .. }
                | Method::ExtraTrees { .. }
        )
    }

    fn has_logits(&self) -> bool {
        matches!(self.method, Method::MiniRocket { .. } | Method::SvmLinear { .. } | Method::SvmRbf { .. })
    }

    fn costs(&self) -> Costs {
        Costs::default()
    }

    fn identify(&self, identity: &mut Value) {
        identity["baseline"] = json!(self.method);
        if let Some(faults) = &self.faults {
            identity["faults"] = json!(faults);
        }
    }

    fn fit(&self, set: &TrainingSet, _hooks: &mut Hooks) -> Result<Option<Trained>> {
        let TrainingSet { dataset, inputs, fold, .. } = *set;
        let threads = pool(set.threads)?;
        let start = Instant::now();
        let fitted = threads.install(|| FittedBaseline::fit(self, set))?;
        let train_seconds = start.elapsed().as_secs_f64();
        let mut test = vec![];
        inputs[0].encoded.gather(&fold.test, &mut test);
        let start = Instant::now();
        let (mut outputs, mut test_loss) = (vec![], 0.0);
        let mut test_seconds = 0.0;
        if !fold.test.is_empty() {
            outputs = threads.install(|| fitted.outputs(&test))?;
            test_seconds = start.elapsed().as_secs_f64();
            let outcome = Outcome::new(&dataset.targets, &fold.test, outputs.clone());
            test_loss = outcome.loss(&dataset.task())?;
        }
        let samples = fold.train.len() as u64;
        let fitted = Box::new(fitted);
        Ok(Some(Trained { fitted, outputs, spread: vec![], test_loss, train_seconds, test_seconds, samples }))
    }
}

/// A baseline that has seen its training part: one fitted method per attribute, or one for all values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FittedBaseline {
    pub method: Method,
    /// Channels and length of a recording.
    pub shape: [usize; 2],
    each: Vec<FittedMethod>,
    /// Outputs of each.
    sizes: Vec<usize>,
}

/// Targets of training samples, and the outputs of each method that is fitted to them.
enum Goal {
    Labels(Vec<u32>, Vec<usize>),
    Values(Vec<f32>, usize),
}

impl Goal {
    fn of(targets: &Targets, rows: &[usize]) -> Self {
        match targets {
            Targets::Classes { labels, .. } | Targets::Levels(labels) => {
                Goal::Labels(labels.of(rows), labels.sizes())
            }
            Targets::Values(values) => Goal::Values(values.of(rows), values.quantities().len()),
        }
    }

    /// Repeats the targets for each of so many faulty copies.
    fn repeat(&mut self, times: usize) {
        match self {
            Goal::Labels(labels, _) => *labels = labels.repeat(times),
            Goal::Values(values, _) => *values = values.repeat(times),
        }
    }
}

/// Returns the recordings of the training part, clean ones first and then every faulty copy, and how many times each is
/// there.
fn recordings(set: &TrainingSet, faults: Option<&TrainingFaults>) -> Result<(Vec<f32>, usize)> {
    let (series, rows) = (&set.inputs[0], &set.fold.train);
    let mut values = vec![];
    series.encoded.gather(rows, &mut values);
    let Some(faults) = faults else { return Ok((values, 1)) };
    let read = (set.dataset, rows.as_slice());
    let Some(mut changes) = RawChanges::new(Some(faults), None, read, &[series], set.part)? else {
        return Ok((values, 1));
    };
    let clean = values.clone();
    for copy in 0..faults.copies {
        let mut faulty = [clean.clone()];
        let pass = TrainingPass { occasion: &format!("copy{copy}"), augment: None };
        changes.fill(rows, &pass, &mut faulty)?;
        values.extend_from_slice(&faulty[0]);
    }
    Ok((values, 1 + faults.copies))
}

/// Returns recordings of a shape for training, with weights where they have some.
fn series<'v>(
    values: &'v [f32],
    shape: [usize; 2],
    weights: Option<&'v [f32]>,
) -> taxel_baselines::Result<Series<'v>> {
    let series = Series::new(values, shape[0], shape[1])?;
    weights.map_or(Ok(series), |weights| series.weighted(weights))
}

impl FittedBaseline {
    fn fit(baseline: &Baseline, set: &TrainingSet) -> Result<Self> {
        let method = baseline.method;
        let refuse = |source| Error::Baseline { baseline: method.name().into(), source };
        let shape = read_as(&method, set.dataset.spec.layout, shape_of(&set.inputs[0].encoded)?);
        let (values, times) = recordings(set, baseline.faults.as_deref())?;
        let weights = set.weights().map(|weights| weights.repeat(times));
        let train = series(&values, shape, weights.as_deref()).map_err(refuse)?;
        let mut goal = Goal::of(&set.dataset.targets, &set.fold.train);
        goal.repeat(times);
        let TrainingKey { seed, repetition, fold } = set.part;
        let (each, sizes) = match goal {
            Goal::Values(values, outputs) => {
                let purpose = format!("r{repetition}/f{fold}");
                let fitted = method.fit_values(&train, &values, outputs, seed, &purpose).map_err(refuse)?;
                (vec![fitted], vec![outputs])
            }
            Goal::Labels(labels, sizes) => {
                let mut each = vec![];
                for (i, &size) in sizes.iter().enumerate() {
                    let y: Vec<u32> = labels.iter().skip(i).step_by(sizes.len()).copied().collect();
                    let purpose = format!("r{repetition}/f{fold}/{i}");
                    each.push(method.fit(&train, &y, size, seed, &purpose).map_err(refuse)?);
                }
                (each, sizes)
            }
        };
        Ok(FittedBaseline { method, shape, each, sizes })
    }

    /// Returns the outputs `[n, outputs]` for recordings `[n, channels, length]`, row-major.
    ///
    /// # Errors
    /// Recordings of another shape, or that are not finite.
    pub fn outputs(&self, recordings: &[f32]) -> Result<Vec<f32>> {
        let mut outputs = self.decide(recordings)?;
        self.soften(&mut outputs);
        Ok(outputs)
    }

    /// Returns what [`FittedBaseline::soften`] turns into outputs.
    ///
    /// # Errors
    /// As [`FittedBaseline::outputs`].
    pub fn decide(&self, recordings: &[f32]) -> Result<Vec<f32>> {
        let refuse = |source| Error::Baseline { baseline: self.method.name().into(), source };
        let x = Series::new(recordings, self.shape[0], self.shape[1]).map_err(refuse)?;
        let each: Vec<Vec<f32>> =
            self.each.iter().map(|fitted| fitted.decide(&x).map_err(refuse)).collect::<Result<_>>()?;
        let mut rows = vec![];
        for sample in 0..x.len() {
            for (outputs, &size) in each.iter().zip(&self.sizes) {
                rows.extend_from_slice(&outputs[sample * size..(sample + 1) * size]);
            }
        }
        Ok(rows)
    }

    /// Turns rows of decision values into outputs, in place.
    pub fn soften(&self, mut decided: &mut [f32]) {
        for (fitted, &size) in self.each.iter().zip(&self.sizes).cycle() {
            if decided.len() < size || size == 0 {
                return;
            }
            let (own, rest) = decided.split_at_mut(size);
            fitted.soften(own);
            decided = rest;
        }
    }

    /// Checks whether it decides by values without bounds.
    pub fn has_decisions(&self) -> bool {
        self.each.iter().all(FittedMethod::has_decisions)
    }

    /// Makes memory for [`FittedBaseline::decide_one`], one of each method.
    pub fn workspaces(&self) -> Vec<Workspace> {
        self.each.iter().map(FittedMethod::workspace).collect()
    }

    /// Computes [`FittedBaseline::decide`] of one recording; nothing is allocated after the first.
    ///
    /// # Errors
    /// A recording of another shape or that is not finite, workspaces of another baseline.
    pub fn decide_one(
        &self,
        recording: &[f32],
        workspaces: &mut [Workspace],
        mut outputs: &mut [f32],
    ) -> Result<()> {
        for ((fitted, workspace), &size) in self.each.iter().zip(workspaces).zip(&self.sizes) {
            let (to, rest) = outputs.split_at_mut(size);
            outputs = rest;
            fitted
                .decide_one(recording, workspace, to)
                .map_err(|source| Error::Baseline { baseline: self.method.name().into(), source })?;
        }
        Ok(())
    }

    /// Reads what [`Fitted::tensors`] gave.
    ///
    /// # Errors
    /// A tensor that is missing or does not fit, by name.
    pub fn read(
        method: Method,
        shape: [usize; 2],
        task: &Task,
        weights: &Weights,
    ) -> taxel_baselines::Result<Self> {
        let (mut each, mut sizes) = (vec![], vec![]);
        for (prefix, size) in parts(task) {
            let mut saved = Saved::default();
            for (name, tensor) in weights.iter() {
                if let Some(name) = name.strip_prefix(&prefix) {
                    saved.insert(name, &tensor.data);
                }
            }
            each.push(match task {
                Task::Values(_) => FittedMethod::read_values(&method, shape, size, &saved)?,
                Task::Classes(_) | Task::Levels(_) => FittedMethod::read(&method, shape, size, &saved)?,
            });
            sizes.push(size);
        }
        Ok(FittedBaseline { method, shape, each, sizes })
    }

    /// Returns what one prediction costs.
    fn costs(&self) -> Costs {
        let sum = |cost: fn(&FittedMethod) -> u64| self.each.iter().map(cost).sum::<u64>();
        let (parameters, macs) = (sum(FittedMethod::parameters), sum(FittedMethod::macs));
        Costs { parameters, bytes: 4 * parameters, macs, flops: 2 * macs }
    }
}

impl Fitted for FittedBaseline {
    fn kind(&self) -> ModelKind {
        ModelKind::Baseline { method: self.method, series: self.shape }
    }

    fn tensors(&self, task: &Task) -> Weights {
        let mut weights = Weights::new();
        for (fitted, (prefix, _)) in self.each.iter().zip(parts(task)) {
            for (name, shape, data) in fitted.tensors() {
                weights.insert(&format!("{prefix}{name}"), Tensor { shape, data });
            }
        }
        weights
    }

    fn inputs<'i>(&self, inputs: &'i [Input]) -> Vec<&'i Input> {
        inputs.iter().collect()
    }

    fn left_out(&self, set: &TrainingSet) -> Result<Option<Vec<f32>>> {
        let refuse = |source| Error::Baseline { baseline: self.method.name().into(), source };
        let rows = &set.fold.train;
        let mut values = vec![];
        set.inputs[0].encoded.gather(rows, &mut values);
        let weights = set.weights();
        let train = series(&values, self.shape, weights.as_deref()).map_err(refuse)?;
        let [fitted] = self.each.as_slice() else { return Ok(None) };
        let units: Vec<u32> = match set.units {
            Some(units) => rows.iter().map(|row| units[*row]).collect(),
            None => (0..rows.len() as u32).collect(),
        };
        match &set.dataset.targets {
            Targets::Classes { labels, .. } => fitted.left_out(&train, &labels.of(rows), &units),
            Targets::Values(values) => {
                fitted.left_out_values(&train, &values.of(rows), values.quantities().len(), &units)
            }
            Targets::Levels(_) => Ok(None),
        }
        .map_err(refuse)
    }

    fn complete(&self, record: FoldRecord) -> Result<FoldRecord> {
        Ok(FoldRecord { costs: Some(self.costs()), ..record })
    }
}

/// Returns how the tensors of each method begin, and its outputs: those of one attribute go by their own names, those of
/// several by the attribute's before it; one method gives all values.
fn parts(task: &Task) -> Vec<(String, usize)> {
    match task {
        Task::Classes(classes) => vec![(String::new(), classes.len())],
        Task::Levels(attributes) => attributes
            .iter()
            .map(|attribute| (format!("{}.", attribute.name), attribute.classes.len()))
            .collect(),
        Task::Values(quantities) => vec![(String::new(), quantities.len())],
    }
}
