//! Less of a raw sample: fewer channels, rows or columns, a shorter window, fewer readings per second, larger
//! taxels, fewer bits in the converter.
//!
//! # Reference
//!
//! None; the definitions are ours, and `scripts/fixtures/reduction.py` writes them down in NumPy.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use taxel_base::Layout;

use crate::{Error, Result};

/// The part of a raw sample that a model reads, as a smaller sensor would have recorded it. Default all of it.
///
/// Channels, rows and columns are kept first, then the window and every so many-th reading, then taxels are
/// pooled, and last the converter rounds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Reduction {
    /// Positions that are kept along the first axis, in this order: channels of a series, fingers, or numbers of a
    /// row of features. Default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<usize>>,
    /// Rows of an array that are kept, in this order. Default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<Vec<usize>>,
    /// Columns of an array that are kept, in this order. Default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<usize>>,
    /// Readings that are kept from the start of a recording, 1 or more. Default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
    /// Every so many-th reading is kept, from the first on, as a sensor that is read less often gives them: nothing
    /// is averaged. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<usize>,
    /// Side of the squares of taxels that become one, the mean of what is there. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pool: Option<usize>,
    /// The converter. Default the one that recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub converter: Option<Converter>,
}

/// An analog-digital converter: 2^`bits` even levels from `low` to `high`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Converter {
    /// 1 to 24.
    pub bits: u32,
    /// The lowest level, in the unit of the readings.
    pub low: f32,
    /// The highest level, in the unit of the readings.
    pub high: f32,
}

/// A [`Reduction`] for samples of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct ReductionPlan {
    shape: Vec<usize>,
    /// Values of a whole sample.
    readings: usize,
    /// Positions in the whole sample, for one value of the reduced sample after the other.
    sources: Vec<usize>,
    /// The range of `sources` whose mean a value of the reduced sample is.
    ranges: Vec<Range<usize>>,
    converter: Option<Converter>,
}

/// The meaning of an axis of a sample.
#[derive(Clone, Copy, PartialEq)]
enum AxisKind {
    Channels,
    Time,
    Rows,
    Columns,
    Other,
}

/// Returns the meaning of each axis of a layout.
fn kinds(layout: Layout) -> &'static [AxisKind] {
    match layout {
        Layout::Features => &[AxisKind::Channels],
        Layout::Series => &[AxisKind::Channels, AxisKind::Time],
        Layout::Image => &[AxisKind::Rows, AxisKind::Columns],
        Layout::Colour => &[AxisKind::Other, AxisKind::Rows, AxisKind::Columns],
        Layout::Sequence => &[AxisKind::Time, AxisKind::Rows, AxisKind::Columns],
        Layout::Fingers => &[AxisKind::Channels, AxisKind::Other, AxisKind::Time],
    }
}

impl Converter {
    /// Rounds a value to the nearest level.
    pub fn convert(&self, reading: f32) -> f32 {
        let (low, high) = (f64::from(self.low), f64::from(self.high));
        let most = f64::from(self.bits).exp2() - 1.0;
        let step = (high - low) / most;
        (low + ((f64::from(reading) - low) / step).round().clamp(0.0, most) * step) as f32
    }

    fn check(&self) -> Result<()> {
        let refuse = |key, value, reason: &str| Err(Error::reduction(key, value, reason));
        if !(1..=24).contains(&self.bits) {
            return refuse("converter.bits", self.bits.to_string(), "must be in 1..=24");
        }
        if !(self.low.is_finite() && self.high.is_finite() && self.low < self.high) {
            return refuse("converter.low", self.low.to_string(), "must be below high, both finite");
        }
        Ok(())
    }
}

impl Reduction {
    /// Checks whether everything is left.
    pub fn is_whole(&self) -> bool {
        *self == Reduction::default()
    }

    /// Returns the same, and what `other` leaves where it says something.
    pub fn and(self, other: Reduction) -> Self {
        Reduction {
            channels: other.channels.or(self.channels),
            rows: other.rows.or(self.rows),
            columns: other.columns.or(self.columns),
            window: other.window.or(self.window),
            every: other.every.or(self.every),
            pool: other.pool.or(self.pool),
            converter: other.converter.or(self.converter),
        }
    }

    /// Checks what can be checked without a sample.
    ///
    /// # Errors
    /// [`Error::Reduction`] for a value that is wrong for any sample.
    pub fn check(&self) -> Result<()> {
        let refuse = |key, value: String, reason: &str| Err(Error::reduction(key, value, reason));
        for (key, kept) in [("channels", &self.channels), ("rows", &self.rows), ("columns", &self.columns)] {
            let Some(kept) = kept else { continue };
            if kept.is_empty() {
                return refuse(key, "[]".into(), "must keep at least one");
            }
            if let Some(twice) = (1..kept.len()).find(|&i| kept[..i].contains(&kept[i])) {
                return refuse(key, format!("{kept:?}"), &format!("names {} twice", kept[twice]));
            }
        }
        for (key, value) in [("window", self.window), ("every", self.every), ("pool", self.pool)] {
            if value == Some(0) {
                return refuse(key, "0".into(), "must be 1 or more");
            }
        }
        self.converter.as_ref().map_or(Ok(()), Converter::check)
    }

    /// Lists for each position of the reduced sample the positions of the whole one, along an axis of `length`.
    fn along(&self, kind: AxisKind, length: usize) -> Result<Vec<Vec<usize>>> {
        let kept = |key: &'static str, kept: &Option<Vec<usize>>| -> Result<Vec<usize>> {
            let Some(kept) = kept else { return Ok((0..length).collect()) };
            match kept.iter().find(|position| **position >= length) {
                None => Ok(kept.clone()),
                Some(_) => {
                    let reason =
                        format!("must be below {length}, as a sample has so many; they are counted from 0");
                    Err(Error::reduction(key, format!("{kept:?}"), reason))
                }
            }
        };
        let each = |positions: Vec<usize>| positions.into_iter().map(|position| vec![position]).collect();
        let pooled =
            |positions: Vec<usize>| positions.chunks(self.pool.unwrap_or(1)).map(<[usize]>::to_vec).collect();
        Ok(match kind {
            AxisKind::Channels => each(kept("channels", &self.channels)?),
            AxisKind::Rows => pooled(kept("rows", &self.rows)?),
            AxisKind::Columns => pooled(kept("columns", &self.columns)?),
            AxisKind::Other => each((0..length).collect()),
            AxisKind::Time => {
                let window = self.window.unwrap_or(length);
                if window > length {
                    let reason = format!("must be {length} or less, as a recording has so many readings");
                    return Err(Error::reduction("window", window.to_string(), reason));
                }
                each((0..window).step_by(self.every.unwrap_or(1)).collect())
            }
        })
    }

    /// Plans the reduction of samples of `shape`.
    ///
    /// # Errors
    /// [`Error::Reduction`] for a value out of range, or one without a meaning for such samples.
    pub fn plan(&self, layout: Layout, shape: &[usize]) -> Result<ReductionPlan> {
        self.check()?;
        let kinds = kinds(layout);
        if !layout.fits(shape) {
            let expected = format!("{} ({})", layout.describe(), layout.axes());
            return Err(Error::Shape { what: "a raw sample", expected, got: shape.to_vec() });
        }
        let wanted = [
            ("channels", self.channels.is_some(), AxisKind::Channels),
            ("rows", self.rows.is_some(), AxisKind::Rows),
            ("columns", self.columns.is_some(), AxisKind::Columns),
            ("window", self.window.is_some(), AxisKind::Time),
            ("every", self.every.is_some(), AxisKind::Time),
            ("pool", self.pool.is_some(), AxisKind::Rows),
        ];
        if let Some((key, ..)) = wanted.into_iter().find(|(_, set, kind)| *set && !kinds.contains(kind)) {
            let reason = format!("has no meaning for {}; leave it out", layout.describe());
            return Err(Error::reduction(key, "..".into(), reason));
        }
        let axes = kinds.iter().zip(shape).map(|(kind, length)| self.along(*kind, *length));
        let axes = axes.collect::<Result<Vec<_>>>()?;
        let (mut sources, mut ranges) = (vec![], vec![]);
        let out: Vec<usize> = axes.iter().map(Vec::len).collect();
        for value in 0..out.iter().product::<usize>() {
            // Position along each axis, last one fastest.
            let (mut rest, mut from) = (value, vec![0]);
            let mut groups = vec![];
            for (axis, length) in axes.iter().zip(&out).rev() {
                groups.push(&axis[rest % length]);
                rest /= length;
            }
            for (group, length) in groups.iter().rev().zip(shape) {
                from = from.iter().flat_map(|at| group.iter().map(move |next| at * length + next)).collect();
            }
            ranges.push(sources.len()..sources.len() + from.len());
            sources.extend(from);
        }
        let readings = shape.iter().product();
        Ok(ReductionPlan { shape: out, readings, sources, ranges, converter: self.converter })
    }

    /// Describes the reduced sample: `channels 0, 3; the first 25 readings; one reading of 2; 4 bits from 0 to 5`.
    pub fn words(&self) -> String {
        let mut parts = vec![];
        let list = |kept: &[usize]| kept.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        for (name, kept) in [("channels", &self.channels), ("rows", &self.rows), ("columns", &self.columns)] {
            parts.extend(kept.as_ref().map(|kept| format!("{name} {}", list(kept))));
        }
        parts.extend(self.window.map(|window| format!("the first {window} readings")));
        parts.extend(self.every.filter(|every| *every > 1).map(|every| format!("one reading of {every}")));
        parts.extend(self.pool.filter(|pool| *pool > 1).map(|pool| format!("{pool} × {pool} taxels as one")));
        let bits = |Converter { bits, low, high }: Converter| {
            format!("{bits} bit{} from {low} to {high}", if bits == 1 { "" } else { "s" })
        };
        parts.extend(self.converter.map(bits));
        if parts.is_empty() { "everything".into() } else { parts.join("; ") }
    }
}

impl ReductionPlan {
    /// Returns the shape of a reduced sample.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Puts the reduced `sample`, row-major, into `left`.
    ///
    /// # Errors
    /// [`Error::Shape`] for slices of other lengths.
    pub fn apply(&self, sample: &[f32], left: &mut [f32]) -> Result<()> {
        for (what, expected, got) in [
            ("a raw sample", self.readings, sample.len()),
            ("a reduced sample", self.ranges.len(), left.len()),
        ] {
            if expected != got {
                return Err(Error::Shape { what, expected: format!("{expected} values"), got: vec![got] });
            }
        }
        for (to, range) in left.iter_mut().zip(&self.ranges) {
            let value = match &self.sources[range.clone()] {
                [one] => sample[*one],
                many => {
                    (many.iter().map(|at| f64::from(sample[*at])).sum::<f64>() / many.len() as f64) as f32
                }
            };
            *to = self.converter.map_or(value, |converter| converter.convert(value));
        }
        Ok(())
    }
}
