//! Faults of training samples: they are drawn anew whenever a sample is used.
//!
//! # Reference
//!
//! The amounts are this project's own, chosen on inner folds of two series sets (`docs/faults.md`).

use std::collections::BTreeMap;

use ndarray::ArrayViewMutD;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::sensor::Sensor;
use crate::work::grid;
use crate::{Error, Layout, Result};

/// The random faults of a training sample, before it is encoded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct TrainingFaults {
    /// Probability that a sample has a fault, 0 to 1. Default 0.7; 0 trains on clean samples.
    pub probability: f64,
    /// Probability that it has one more, whether or not it has the first, 0 to 1. Default 0.14.
    pub second: f64,
    /// The kinds that are drawn. Default all from which something can be learned: all that have a meaning for the layout. For a
    /// single channel (a row of features is one) those are left out that leave nothing of it (`dead`, `stuck`) or that need a
    /// second one (`dead-line`, `crosstalk`, `swap`).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub kinds: Vec<Fault>,
    /// Kinds that are never drawn: what is left out of training can be tested as unknown. Default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<Fault>,
    /// Smallest and largest level of a kind in its own unit (`docs/faults.md`). Default [`Fault::trained_levels`].
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub levels: BTreeMap<Fault, [f32; 2]>,
    /// Faulty copies of the training part, beside the clean one, that a baseline learns from: it sees its samples only
    /// once. 1 to 100, default 4. Networks draw anew in every epoch.
    pub copies: usize,
}

impl Default for TrainingFaults {
    fn default() -> Self {
        TrainingFaults {
            probability: 0.7,
            second: 0.14,
            kinds: vec![],
            without: vec![],
            levels: BTreeMap::new(),
            copies: 4,
        }
    }
}

/// The distribution of a level between its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LevelScale {
    /// Its logarithm evenly: small levels are as likely as large ones.
    Logarithmic,
    /// Evenly.
    Even,
    /// Whole numbers evenly, both ends included.
    Whole,
}

impl Fault {
    /// Returns the smallest and largest level that training draws, in [`Fault::unit`].
    pub fn trained_levels(self) -> [f32; 2] {
        match self {
            Fault::Noise => [0.3, 20.0],
            Fault::Quantisation => [3.0, 8.0],
            Fault::Drift => [1.0, 40.0],
            Fault::Gain => [5.0, 60.0],
            Fault::Dead => [2.0, 50.0],
            Fault::Stuck => [1.0, 25.0],
            Fault::DeadLine => [1.0, 6.0],
            Fault::Saturation => [30.0, 80.0],
            Fault::Hysteresis => [3.0, 50.0],
            Fault::Crosstalk => [3.0, 50.0],
            Fault::Jitter => [2.0, 40.0],
            Fault::Onset | Fault::Lag => [2.0, 30.0],
            Fault::Shift => [1.0, 8.0],
            Fault::Rotation => [3.0, 30.0],
            Fault::Swap => [1.0, 5.0],
        }
    }

    fn spread(self) -> LevelScale {
        match self {
            Fault::Quantisation | Fault::Saturation | Fault::Rotation => LevelScale::Even,
            Fault::DeadLine | Fault::Shift | Fault::Swap => LevelScale::Whole,
            _ => LevelScale::Logarithmic,
        }
    }

    /// Returns the smallest and largest level with a meaning, in [`Fault::unit`].
    fn possible_levels(self) -> [f32; 2] {
        match self {
            Fault::Quantisation => [1.0, 24.0],
            Fault::Noise | Fault::Drift | Fault::Gain => [0.01, 1000.0],
            Fault::Hysteresis => [0.01, 99.0],
            Fault::DeadLine | Fault::Shift | Fault::Swap => [1.0, 1000.0],
            Fault::Rotation => [0.01, 180.0],
            _ => [0.01, 100.0],
        }
    }

    /// Checks whether it needs several channels or taxels: a single one that is dead or stuck says nothing of the label, and
    /// has no neighbour to be mixed or swapped with.
    fn needs_several(self) -> bool {
        use Fault::{Crosstalk, Dead, DeadLine, Stuck, Swap};
        matches!(self, Dead | Stuck | DeadLine | Crosstalk | Swap)
    }

    /// Returns whether training draws it where no kinds are named. A later kind is not, so that equal settings train as
    /// before.
    fn is_usual(self) -> bool {
        self != Fault::Lag
    }

    /// Returns its weight among the kinds: wrong wiring takes the most samples to learn.
    fn weight(self) -> f64 {
        if self == Fault::Swap { 1.5 } else { 1.0 }
    }
}

impl TrainingFaults {
    /// Checks the settings.
    ///
    /// # Errors
    /// [`Error::Parameter`]: the first setting outside its range.
    pub fn check(&self) -> Result<()> {
        let refuse = |name: String, value: String, expected: &str| {
            Err(Error::Parameter { name, value, expected: expected.into() })
        };
        for (name, value) in [("probability", self.probability), ("second", self.second)] {
            if !(0.0..=1.0).contains(&value) {
                return refuse(name.into(), value.to_string(), "must be in 0..=1");
            }
        }
        if !(1..=100).contains(&self.copies) {
            return refuse("copies".into(), self.copies.to_string(), "must be in 1..=100");
        }
        for (&fault, &[low, high]) in &self.levels {
            let [least, most] = fault.possible_levels();
            if !(least <= low && low <= high && high <= most) {
                let expected = format!("must be [smallest, largest] in {least}..={most} {}", fault.unit());
                return refuse(format!("levels.{fault}"), format!("[{low}, {high}]"), &expected);
            }
        }
        Ok(())
    }

    /// Checks whether no fault is ever drawn.
    pub fn is_clean(&self) -> bool {
        self.probability == 0.0 && self.second == 0.0
    }

    /// Plans the faults of samples of `layout` with axes `shape`.
    ///
    /// # Errors
    /// [`Error::Fault`] for a kind that is asked for and has no meaning, [`Error::Parameter`] where no kind is
    /// left or `shape` is none of `layout`, and those of [`TrainingFaults::check`].
    pub fn plan(&self, layout: Layout, shape: &[usize]) -> Result<FaultPlan> {
        self.check()?;
        for &fault in &self.kinds {
            if let Some(reason) = fault.refusal(layout) {
                let layout = layout.describe();
                return Err(Error::Fault { fault: fault.name(), layout, reason });
            }
        }
        if !layout.fits(shape) {
            let (value, expected) = (format!("{shape:?}"), format!("must be {}", layout.describe()));
            return Err(Error::Parameter { name: "shape".into(), value, expected });
        }
        let (rows, columns, _) = grid(layout, shape);
        let single = rows * columns == 1;
        let is_wanted = |fault: &Fault| {
            if self.kinds.is_empty() {
                fault.is_usual() && !(single && fault.needs_several())
            } else {
                self.kinds.contains(fault)
            }
        };
        let kinds: Vec<Fault> = Fault::ALL
            .into_iter()
            .filter(|fault| is_wanted(fault) && fault.applicable(layout) && !self.without.contains(fault))
            .collect();
        if kinds.is_empty() {
            let (name, value) = ("without".into(), format!("{:?}", self.without));
            let expected = "must leave a kind to train under; probability = 0 trains on clean samples".into();
            return Err(Error::Parameter { name, value, expected });
        }
        let levels = |fault: Fault| self.levels.get(&fault).copied().unwrap_or(fault.trained_levels());
        let kinds = kinds.into_iter().map(|fault| (fault, levels(fault))).collect();
        Ok(FaultPlan { probability: self.probability, second: self.second, kinds })
    }
}

/// [`TrainingFaults`] for samples of one layout.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultPlan {
    probability: f64,
    second: f64,
    /// Each kind with its smallest and largest level.
    kinds: Vec<(Fault, [f32; 2])>,
}

impl FaultPlan {
    /// Lists the kinds that are drawn, in the order of the table.
    pub fn kinds(&self) -> impl Iterator<Item = Fault> {
        self.kinds.iter().map(|(fault, _)| *fault)
    }

    /// Breaks one raw sample in place, or leaves it as it is: a function of `seed` and `purpose`, which names
    /// the sample and the occasion. Gives the number of faults; `sample` names it in messages.
    ///
    /// # Errors
    /// As [`Fault::apply`].
    pub fn apply(
        &self,
        mut x: ArrayViewMutD<f32>,
        sensor: &Sensor,
        seed: u64,
        purpose: &str,
        sample: usize,
    ) -> Result<usize> {
        if !sensor.layout.fits(x.shape()) {
            let reason = format!("shape {:?} is not {}", x.shape(), sensor.layout.describe());
            return Err(Error::Sample { sample, reason });
        }
        let mut rng = taxel_base::seed::rng(seed, purpose);
        let mut count = 0;
        for probability in [self.probability, self.second] {
            if rng.random::<f64>() >= probability {
                continue;
            }
            let Some((fault, level)) = self.draw(&mut rng, sensor, x.shape()) else { continue };
            let rng = taxel_base::seed::rng(seed, &format!("{purpose}/{count}"));
            fault.apply_level(x.view_mut(), sensor, level, rng, sample)?;
            count += 1;
        }
        Ok(count)
    }

    /// Draws a kind and its level.
    fn draw(
        &self,
        rng: &mut taxel_base::seed::Rng,
        sensor: &Sensor,
        shape: &[usize],
    ) -> Option<(Fault, f32)> {
        let whole: f64 = self.kinds.iter().map(|(fault, _)| fault.weight()).sum();
        let mut left = rng.random::<f64>() * whole;
        let within = |(fault, _): &&(Fault, [f32; 2])| {
            left -= fault.weight();
            left < 0.0
        };
        let &(fault, [low, high]) = self.kinds.iter().find(within).or(self.kinds.last())?;
        let (share, low, high) = (rng.random::<f64>(), f64::from(low), f64::from(high));
        let level = match fault.spread() {
            LevelScale::Even => low + share * (high - low),
            LevelScale::Logarithmic => (low.ln() + share * (high.ln() - low.ln())).exp(),
            LevelScale::Whole => (low + share * (high - low + 1.0)).floor().min(high),
        } as f32;
        // A sample that is to learn of a dead channel has one.
        let one = |(rows, columns, _): (usize, usize, usize)| 100.0 / (rows * columns).max(1) as f32;
        let level = match fault {
            Fault::Dead | Fault::Stuck => level.max(one(grid(sensor.layout, shape))),
            _ => level,
        };
        Some((fault, level))
    }
}
