//! The faults: names, severities, layouts of samples for which they have a meaning.

use crate::{Error, Result};
use ndarray::ArrayViewMutD;
use serde::{Deserialize, Serialize};
use taxel_base::seed::Rng;

use crate::sensor::Sensor;
use crate::work::FaultySample;
use crate::{Layout, elements, place, signal, time};

/// One way in which a sensor, its wiring or its mounting fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// Electronic noise.
    Noise,
    /// Fewer bits in the converter.
    Quantisation,
    /// A slow ramp of the offset: temperature, creep.
    Drift,
    /// Another gain after re-mounting.
    Gain,
    /// Taxels or channels stuck at rest.
    Dead,
    /// Taxels or channels stuck at full scale.
    Stuck,
    /// Whole rows and columns, or fingers, at rest.
    DeadLine,
    /// Full scale reached early.
    Saturation,
    /// Loading and unloading differ.
    Hysteresis,
    /// Readings bleed into their neighbours.
    Crosstalk,
    /// Frames dropped on the way.
    Jitter,
    /// Contact detected late or early.
    Onset,
    /// One channel, finger or row of taxels arrives late.
    Lag,
    /// The object lies elsewhere on the array.
    Shift,
    /// The object lies turned on the array.
    Rotation,
    /// Channels or lines wired the wrong way round.
    Swap,
}

/// A row of the table: name, description, the five severities and their unit.
type FaultRow = (&'static str, &'static str, [f32; 5], &'static str);

impl Fault {
    /// Every fault, in the order of the table.
    pub const ALL: [Self; 16] = [
        Self::Noise,
        Self::Quantisation,
        Self::Drift,
        Self::Gain,
        Self::Dead,
        Self::Stuck,
        Self::DeadLine,
        Self::Saturation,
        Self::Hysteresis,
        Self::Crosstalk,
        Self::Jitter,
        Self::Onset,
        Self::Lag,
        Self::Shift,
        Self::Rotation,
        Self::Swap,
    ];

    fn row(self) -> FaultRow {
        match self {
            Self::Noise => ("noise", "electronic noise", [1., 2., 5., 10., 20.], "% of full scale, SD"),
            Self::Quantisation => ("quantisation", "fewer ADC bits", [8., 6., 5., 4., 3.], "bits"),
            Self::Drift => ("drift", "offset ramp", [2., 5., 10., 20., 40.], "% of full scale by the end"),
            Self::Gain => ("gain", "gain changed by re-mounting", [5., 10., 20., 40., 60.], "% up or down"),
            Self::Dead => ("dead", "stuck at rest", [2., 5., 10., 25., 50.], "% of taxels or channels"),
            Self::Stuck => {
                ("stuck", "stuck at full scale", [1., 2., 5., 10., 25.], "% of taxels or channels")
            }
            Self::DeadLine => ("dead-line", "whole lines at rest", [1., 2., 3., 4., 6.], "lines or fingers"),
            Self::Saturation => {
                ("saturation", "full scale reached early", [80., 60., 50., 40., 30.], "% of full scale")
            }
            Self::Hysteresis => {
                ("hysteresis", "loading and unloading differ", [5., 10., 20., 30., 50.], "% of the peak")
            }
            Self::Crosstalk => {
                ("crosstalk", "neighbours bleed", [5., 10., 20., 30., 50.], "% from neighbours")
            }
            Self::Jitter => ("jitter", "frames dropped", [2., 5., 10., 20., 40.], "% of frames"),
            Self::Onset => {
                ("onset", "contact detected late or early", [2., 5., 10., 20., 30.], "% of the window")
            }
            Self::Lag => ("lag", "one channel arrives late", [2., 5., 10., 20., 30.], "% of the window"),
            Self::Shift => ("shift", "object placed elsewhere", [1., 2., 4., 6., 8.], "taxels"),
            Self::Rotation => ("rotation", "object turned", [5., 10., 15., 20., 30.], "degrees"),
            Self::Swap => ("swap", "wired the wrong way round", [1., 2., 3., 4., 5.], "swaps"),
        }
    }

    /// Returns the name in settings and reports.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Describes the fault in a few words.
    pub fn describe(self) -> &'static str {
        self.row().1
    }

    /// Returns the severities 1 to 5 in [`Fault::unit`].
    pub fn severities(self) -> [f32; 5] {
        self.row().2
    }

    /// Returns the unit of the severities.
    pub fn unit(self) -> &'static str {
        self.row().3
    }

    /// Returns the value of one severity in [`Fault::unit`].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a severity outside 1..=5.
    pub fn level(self, severity: u8) -> Result<f32> {
        let at = usize::from(severity).checked_sub(1);
        at.and_then(|at| self.severities().get(at).copied()).ok_or(Error::Parameter {
            name: "severity".into(),
            value: severity.to_string(),
            expected: "must be in 1..=5".into(),
        })
    }

    /// Says why the fault has no meaning for samples of this layout; none if it has one.
    pub fn refusal(self, layout: Layout) -> Option<&'static str> {
        match self {
            Self::Hysteresis | Self::Jitter | Self::Onset | Self::Lag if !layout.has_time() => {
                Some("it acts over time, and a single image has none")
            }
            Self::Shift | Self::Rotation if !layout.has_area() => {
                Some("it moves the object over an array, and channels have no place")
            }
            _ => None,
        }
    }

    /// Checks whether the fault has a meaning for samples of this layout.
    pub fn applicable(self, layout: Layout) -> bool {
        self.refusal(layout).is_none()
    }

    /// Breaks one sample in place; `sample` is its index in the data set. A row of features `[F]` is
    /// broken as a series `[1, F]`.
    ///
    /// Everything random comes from seed, fault and sample. Readings end within `sensor`'s range.
    ///
    /// # Errors
    ///
    /// [`Error::Fault`] where the fault has no meaning, [`Error::Parameter`] for an impossible
    /// severity or sensor, [`Error::Sample`] for a wrong shape or a reading that is not finite.
    /// `x` is unchanged then.
    pub fn apply(
        self,
        x: ArrayViewMutD<f32>,
        sensor: &Sensor,
        severity: u8,
        seed: u64,
        sample: usize,
    ) -> Result<()> {
        let level = self.level(severity)?;
        let rng = taxel_base::seed::rng(seed, &format!("fault/{self}/{sample}"));
        self.apply_level(x, sensor, level, rng, sample)
    }

    /// Breaks one sample as [`Fault::apply`], at any level of its unit.
    ///
    /// # Errors
    /// As [`Fault::apply`].
    pub(crate) fn apply_level(
        self,
        mut x: ArrayViewMutD<f32>,
        sensor: &Sensor,
        level: f32,
        rng: Rng,
        sample: usize,
    ) -> Result<()> {
        if let Some(reason) = self.refusal(sensor.layout) {
            let layout = sensor.layout.describe();
            return Err(Error::Fault { fault: self.name(), layout, reason });
        }
        let mut work = FaultySample::new(x.view(), sensor, rng, sample)?;
        let share = f64::from(level) / 100.0;
        match self {
            Self::Noise => signal::noise(&mut work, share),
            Self::Quantisation => signal::quantisation(&mut work, level),
            Self::Drift => signal::drift(&mut work, share),
            Self::Gain => signal::gain(&mut work, share),
            Self::Saturation => signal::saturation(&mut work, share),
            Self::Dead => elements::dead(&mut work, share),
            Self::Stuck => elements::stuck(&mut work, share),
            Self::DeadLine => elements::dead_line(&mut work, level as usize),
            Self::Crosstalk => elements::crosstalk(&mut work, share),
            Self::Swap => elements::swap(&mut work, level as usize),
            Self::Hysteresis => time::hysteresis(&mut work, share),
            Self::Jitter => time::jitter(&mut work, share),
            Self::Onset => time::onset(&mut work, share),
            Self::Lag => time::lag(&mut work, share),
            Self::Shift => place::shift(&mut work, level as isize),
            Self::Rotation => place::rotation(&mut work, f64::from(level)),
        }
        work.write(&mut x);
        Ok(())
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Fault {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|fault| fault.name() == name).ok_or_else(|| {
            let hint = taxel_base::names::hint(name, Self::ALL.map(Self::name));
            Error::UnknownFault { name: name.into(), hint }
        })
    }
}
