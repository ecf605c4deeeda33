//! Training parts with their inner folds, and one curve per axis.

use std::cell::OnceCell;

use taxel_data::{Dataset, Fold};
use taxel_judge::{Contrast, Primary, contrasts, knee};
use taxel_learn::{Converter, FoldRecord, Protocol, Reduction, Teacher};
use taxel_trainer::Variant;
use toml::Table;

use crate::desk::{Ask, Desk};
use crate::error::{Error, Result};
use crate::ladder::{Cut, Ladder, Step};
use crate::sensors::{Sensor, kept};
use crate::shrunk::{Curve, Rung};
use crate::words::{knee_words, roughly};

/// Inner folds are numbered so far from all others, for their own random choices.
const INNER: usize = 1_000_000;

/// What depends on a training part.
#[derive(Debug, Clone)]
pub struct Part {
    /// The most important sensor first; empty where nobody has asked.
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
    /// What its training part says.
    pub part: Part,
    /// Whose answers smaller networks learn from on it; empty until one asks.
    pub teacher: OnceCell<Teacher>,
}

impl Outer {
    /// Repetition and fold of its inner fold `at`.
    pub fn inner_place(&self, at: usize) -> (usize, usize) {
        inner_place(self.place, at)
    }
}

/// Repetition and fold of the inner fold `at` of the fold at `place`.
pub fn inner_place((repetition, fold): (usize, usize), at: usize) -> (usize, usize) {
    (repetition, INNER * (at + 1) + fold)
}

/// What all parts of the work know.
pub struct Shared<'a> {
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
    /// The most accurate method of the run, from whose answers smaller networks learn.
    pub best: String,
}

impl Shared<'_> {
    /// What `cuts` leave, for a part.
    pub fn changes(&self, cuts: &[&Cut], part: &Part) -> Variant {
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

    /// The settings beside the whole, on inner folds or on test parts.
    pub fn beside(
        &self,
        outers: &[Outer],
        inner: bool,
        settings: &[Vec<FoldRecord>],
    ) -> Result<Vec<Option<Contrast>>> {
        let whole: Vec<FoldRecord> = match inner {
            true => outers.iter().flat_map(|outer| outer.inner_whole.iter().cloned()).collect(),
            false => outers.iter().map(|outer| outer.whole.clone()).collect(),
        };
        Ok(contrasts(&whole, settings, self.dataset, &self.protocol, self.seed, self.alpha)?)
    }

    /// Answers of a setting on all inner folds: for those it learns from labels alone.
    pub fn on_inner(
        &self,
        desk: &mut Desk,
        outers: &[Outer],
        label: &str,
        cuts: &[&Cut],
    ) -> Result<Vec<FoldRecord>> {
        let mut records = vec![];
        for outer in outers {
            let changes = self.changes(cuts, &outer.part);
            for (at, fold) in outer.inner.iter().enumerate() {
                let place = outer.inner_place(at);
                let ask = Ask { name: self.name, label, changes: &changes, place, fold, teacher: None };
                records.push(desk.answers(ask)?);
            }
        }
        Ok(records)
    }

    /// Answers of a setting on all test parts, trained on all of the training parts; a smaller network learns from a teacher
    /// too.
    pub fn on_outer(
        &self,
        desk: &mut Desk,
        outers: &[Outer],
        label: &str,
        cuts: &[&Cut],
    ) -> Result<Vec<FoldRecord>> {
        let is_smaller = cuts.iter().any(|cut| matches!(cut, Cut::Set(..)));
        let mut records = vec![];
        for outer in outers {
            let teacher = if is_smaller { Some(self.teacher(desk, outer)?) } else { None };
            let changes = self.changes(cuts, &outer.part);
            let (place, fold) = (outer.place, &outer.fold);
            let ask = Ask { name: self.name, label, changes: &changes, place, fold, teacher };
            records.push(desk.answers(ask)?);
        }
        Ok(records)
    }

    /// The best method's answers to a training part: on inner folds, each by a model that has not seen them.
    fn teacher<'o>(&self, desk: &mut Desk, outer: &'o Outer) -> Result<&'o Teacher> {
        if let Some(teacher) = outer.teacher.get() {
            return Ok(teacher);
        }
        let mut teacher = Teacher::new(SHARE, self.dataset.len(), self.dataset.task().outputs());
        let changes = Variant::default();
        for (at, fold) in outer.inner.iter().enumerate() {
            let record = match self.best == self.name {
                true => outer.inner_whole[at].clone(),
                false => {
                    desk.expect(1);
                    let (name, label, place) = (self.best.as_str(), "teacher", outer.inner_place(at));
                    desk.answers(Ask { name, label, changes: &changes, place, fold, teacher: None })?
                }
            };
            teacher.tell(&record.index, record.outcome.outputs());
        }
        Ok(outer.teacher.get_or_init(|| teacher))
    }
}

/// How much a teacher's answers count beside the labels.
pub const SHARE: f32 = 0.5;

/// Returns the primary metric over all records together, for a first look.
fn score(shared: &Shared, records: &[FoldRecord]) -> f64 {
    let outcomes = records.iter().map(|record| &record.outcome);
    shared.primary.metric().pooled(&shared.dataset.task(), outcomes)
}

/// Trains every setting of a ladder; the knee is found on inner folds.
///
/// # Errors
/// What stops everything; a setting that cannot be trained says so in its place.
pub fn curve(shared: &Shared, desk: &mut Desk, outers: &[Outer], ladder: &Ladder) -> Result<Curve> {
    let whole: Vec<FoldRecord> = outers.iter().flat_map(|outer| outer.inner_whole.iter().cloned()).collect();
    let (primary, whole) = (&shared.primary, score(shared, &whole));
    let (mut inner, mut outer, mut refused) = (vec![], vec![], vec![]);
    let mut over: Option<String> = None;
    for step in &ladder.steps {
        let label = format!("{} {}", ladder.axis, step.short);
        let done = match &over {
            Some(reason) => Err(reason.clone()),
            None => match one(shared, desk, outers, &label, &step.cut) {
                Ok(both) => Ok(both),
                Err(error) if error.is_of_setting() => Err(format!("could not be tried: {}", said(&error))),
                Err(error) => return Err(error),
            },
        };
        match done {
            Ok((on_inner, on_outer)) => {
                let lost = primary.worsening(score(shared, &on_inner), whole);
                if lost > shared.hopeless {
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
    let (inner, outer) = (shared.beside(outers, true, &inner)?, shared.beside(outers, false, &outer)?);
    let at = knee(&inner, shared.margin, primary);
    let rungs =
        ladder.steps.iter().zip(inner).zip(outer).zip(refused).map(|(((step, inner), outer), refused)| {
            Rung {
                label: step.label.clone(),
                short: step.short.clone(),
                kept: kept_by(shared, outers, step),
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
        rungs: rungs.collect(),
        knee: at,
        words: String::new(),
    };
    curve.words = knee_words(&curve, primary, shared.margin);
    Ok(curve)
}

/// A setting on inner folds, then on test parts.
fn one(
    shared: &Shared,
    desk: &mut Desk,
    outers: &[Outer],
    label: &str,
    cut: &Cut,
) -> Result<(Vec<FoldRecord>, Vec<FoldRecord>)> {
    let inner = shared.on_inner(desk, outers, label, &[cut])?;
    Ok((inner, shared.on_outer(desk, outers, label, &[cut])?))
}

/// What each training part keeps, where they choose.
fn kept_by(shared: &Shared, outers: &[Outer], step: &Step) -> Vec<String> {
    match step.cut {
        Cut::Keep(_) => {
            outers.iter().map(|outer| shared.changes(&[&step.cut], &outer.part).reduce.words()).collect()
        }
        _ => vec![],
    }
}

/// Why a setting cannot be trained, on one line.
pub fn said(error: &Error) -> String {
    error.to_string().lines().next().unwrap_or_default().to_string()
}
