//! Training parts with their inner folds, and one curve per axis.

use std::cell::OnceCell;

use taxel_data::{Dataset, Fold};
use taxel_judge::{Contrast, Primary, contrasts, knee};
use taxel_learn::{Converter, FoldRecord, Protocol, Reduction, Teacher};
use taxel_trainer::Variant;
use toml::Table;

use crate::cache::{Cache, Request};
use crate::error::{Error, Result};
use crate::ladder::{Cut, Ladder, LadderStep};
use crate::sensors::{Sensor, kept};
use crate::shrunk::{Curve, CurveStep};
use crate::words::{knee_words, roughly};

/// Inner folds are numbered so far from all others, for their own random choices.
const INNER: usize = 1_000_000;

/// Facts that each training part decides for itself.
#[derive(Debug, Clone)]
pub struct TrainingPart {
    /// Sensors, the most important first; empty where no axis needs it.
    pub ranking: Vec<usize>,
    /// Lowest and highest reading.
    pub range: [f32; 2],
}

/// A fold of the run with the inner folds of its training part.
pub struct Outer {
    /// Repetition and fold.
    pub place: (usize, usize),
    /// Its samples.
    pub fold: Fold,
    /// Folds of its training part alone.
    pub inner: Vec<Fold>,
    /// The whole on its test part.
    pub whole: FoldRecord,
    /// The whole on its inner folds.
    pub inner_whole: Vec<FoldRecord>,
    /// Facts of its training part.
    pub part: TrainingPart,
    /// Teacher of the smaller networks on it; empty until one needs it.
    pub teacher: OnceCell<Teacher>,
}

impl Outer {
    /// Returns the repetition and fold of its inner fold `at`.
    pub fn inner_place(&self, at: usize) -> (usize, usize) {
        inner_place(self.place, at)
    }
}

/// Returns the repetition and fold of the inner fold `at` of the fold at `place`.
pub fn inner_place((repetition, fold): (usize, usize), at: usize) -> (usize, usize) {
    (repetition, INNER * (at + 1) + fold)
}

/// Facts that all steps of the shrinking share.
pub struct Context<'a> {
    /// The network or baseline.
    pub name: &'a str,
    /// The samples.
    pub dataset: &'a Dataset,
    /// Its sensors.
    pub sensors: Vec<Sensor>,
    /// How the run was divided.
    pub protocol: Protocol,
    /// Seed of the run.
    pub seed: u64,
    /// Epochs in place of the run's.
    pub epochs: Option<usize>,
    /// The metric that settings are compared by.
    pub primary: Primary,
    /// A loss that would matter, in percentage points or in the metric's unit.
    pub margin: f64,
    /// A loss on inner folds after which nothing smaller is trained.
    pub hopeless: f64,
    /// Level of significance over a curve.
    pub alpha: f64,
    /// The most accurate method of the run: the teacher of smaller networks.
    pub best: String,
}

impl Context<'_> {
    /// Returns the settings that remain after `cuts`, for a part.
    pub fn changes(&self, cuts: &[&Cut], part: &TrainingPart) -> Variant {
        let mut changes = Variant { epochs: self.epochs, ..Variant::default() };
        for cut in cuts {
            let reduce = match cut {
                Cut::Keep(count) => kept(&self.sensors, &part.ranking, *count),
                Cut::Reduce(reduction) => reduction.clone(),
                Cut::Bits(bits) => {
                    let [low, high] = part.range;
                    let converter = Some(Converter { bits: *bits, low, high });
                    Reduction { converter, ..Reduction::default() }
                }
                Cut::Set(key, value) => {
                    changes.set.extend(Table::from_iter([((*key).to_string(), value.clone())]));
                    Reduction::default()
                }
            };
            changes.reduce = changes.reduce.and(reduce);
        }
        changes
    }

    /// Compares the settings with the whole, on inner folds or on test parts.
    pub fn beside(
        &self,
        outers: &[Outer],
        inner: bool,
        settings: &[Vec<FoldRecord>],
    ) -> Result<Vec<Option<Contrast>>> {
        let whole: Vec<FoldRecord> = if inner {
            outers.iter().flat_map(|outer| outer.inner_whole.iter().cloned()).collect()
        } else {
            outers.iter().map(|outer| outer.whole.clone()).collect()
        };
        Ok(contrasts(&whole, settings, self.dataset, &self.protocol, self.seed, self.alpha)?)
    }

    /// Returns the predictions of a setting on all inner folds, where it learns from labels only.
    pub fn on_inner(
        &self,
        cache: &mut Cache,
        outers: &[Outer],
        label: &str,
        cuts: &[&Cut],
    ) -> Result<Vec<FoldRecord>> {
        let mut records = vec![];
        for outer in outers {
            let changes = self.changes(cuts, &outer.part);
            for (at, fold) in outer.inner.iter().enumerate() {
                let place = outer.inner_place(at);
                let request =
                    Request { name: self.name, label, changes: &changes, place, fold, teacher: None };
                records.push(cache.predictions(request)?);
            }
        }
        Ok(records)
    }

    /// Returns the predictions of a setting on all test parts, trained on all of the training parts; a smaller network learns from a teacher
    /// too.
    pub fn on_outer(
        &self,
        cache: &mut Cache,
        outers: &[Outer],
        label: &str,
        cuts: &[&Cut],
    ) -> Result<Vec<FoldRecord>> {
        let is_smaller = cuts.iter().any(|cut| matches!(cut, Cut::Set(..)));
        let mut records = vec![];
        for outer in outers {
            let teacher = if is_smaller { Some(self.teacher(cache, outer)?) } else { None };
            let changes = self.changes(cuts, &outer.part);
            let (place, fold) = (outer.place, &outer.fold);
            let request = Request { name: self.name, label, changes: &changes, place, fold, teacher };
            records.push(cache.predictions(request)?);
        }
        Ok(records)
    }

    /// Returns the best method's outputs for a training part: of each inner fold by a model that has not seen it.
    fn teacher<'o>(&self, cache: &mut Cache, outer: &'o Outer) -> Result<&'o Teacher> {
        if let Some(teacher) = outer.teacher.get() {
            return Ok(teacher);
        }
        let mut teacher = Teacher::new(SHARE, self.dataset.len(), self.dataset.task().outputs());
        let changes = Variant::default();
        for (at, fold) in outer.inner.iter().enumerate() {
            let record = if self.best == self.name {
                outer.inner_whole[at].clone()
            } else {
                cache.expect(1);
                let (name, label, place) = (self.best.as_str(), "teacher", outer.inner_place(at));
                cache.predictions(Request { name, label, changes: &changes, place, fold, teacher: None })?
            };
            teacher.tell(&record.index, record.outcome.outputs());
        }
        Ok(outer.teacher.get_or_init(|| teacher))
    }
}

/// Weight of a teacher's outputs beside the labels.
pub const SHARE: f32 = 0.5;

/// Returns the primary metric over all records together, for a first look.
fn score(context: &Context, records: &[FoldRecord]) -> f64 {
    let outcomes = records.iter().map(|record| &record.outcome);
    context.primary.metric().pooled(&context.dataset.task(), outcomes)
}

/// Trains every setting of a ladder; the knee is found on inner folds.
///
/// # Errors
/// An error that ends the shrinking; a setting that cannot be trained keeps its reason.
pub fn curve(context: &Context, cache: &mut Cache, outers: &[Outer], ladder: &Ladder) -> Result<Curve> {
    let whole: Vec<FoldRecord> = outers.iter().flat_map(|outer| outer.inner_whole.iter().cloned()).collect();
    let (primary, whole) = (&context.primary, score(context, &whole));
    let (mut inner, mut outer, mut refused) = (vec![], vec![], vec![]);
    let mut over: Option<String> = None;
    for step in &ladder.steps {
        let label = format!("{} {}", ladder.axis, step.short);
        let done = match &over {
            Some(reason) => Err(reason.clone()),
            None => match one(context, cache, outers, &label, &step.cut) {
                Ok(both) => Ok(both),
                Err(error) if error.is_of_setting() => Err(format!("could not be tried: {}", said(&error))),
                Err(error) => return Err(error),
            },
        };
        match done {
            Ok((on_inner, on_outer)) => {
                let lost = primary.worsening(score(context, &on_inner), whole);
                if lost > context.hopeless {
                    let lost = roughly(primary, lost);
                    over.get_or_insert(format!("not tried: {} lost {lost} on inner folds", step.label));
                }
                inner.push(on_inner);
                outer.push(on_outer);
                refused.push(None);
            }
            Err(reason) => {
                inner.push(vec![]);
                outer.push(vec![]);
                refused.push(Some(reason));
            }
        }
    }
    let (inner, outer) = (context.beside(outers, true, &inner)?, context.beside(outers, false, &outer)?);
    let at = knee(&inner, context.margin, primary);
    let steps =
        ladder.steps.iter().zip(inner).zip(outer).zip(refused).map(|(((step, inner), outer), refused)| {
            CurveStep {
                label: step.label.clone(),
                short: step.short.clone(),
                kept: kept_by(context, outers, step),
                inner,
                outer,
                refused,
            }
        });
    let mut curve = Curve {
        axis: ladder.axis.name().into(),
        title: ladder.axis.title().into(),
        whole: ladder.whole.clone(),
        short: ladder.short.clone(),
        steps: steps.collect(),
        knee: at,
        words: String::new(),
    };
    curve.words = knee_words(&curve, primary, context.margin);
    Ok(curve)
}

/// Trains a setting on inner folds, then for test parts.
fn one(
    context: &Context,
    cache: &mut Cache,
    outers: &[Outer],
    label: &str,
    cut: &Cut,
) -> Result<(Vec<FoldRecord>, Vec<FoldRecord>)> {
    let inner = context.on_inner(cache, outers, label, &[cut])?;
    Ok((inner, context.on_outer(cache, outers, label, &[cut])?))
}

/// Returns the sensors that each training part keeps, for reductions that they choose.
fn kept_by(context: &Context, outers: &[Outer], step: &LadderStep) -> Vec<String> {
    match step.cut {
        Cut::Keep(_) => {
            outers.iter().map(|outer| context.changes(&[&step.cut], &outer.part).reduce.words()).collect()
        }
        _ => vec![],
    }
}

/// Says why a setting cannot be trained, on one line.
pub fn said(error: &Error) -> String {
    error.to_string().lines().next().unwrap_or_default().to_string()
}
