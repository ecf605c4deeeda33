//! The quantile code: each channel of a series as ramps between the quantiles of its readings.
//!
//! # Reference
//!
//! Gorishniy, Rubachev and Babenko, "On embeddings for numerical features in tabular deep learning",
//! NeurIPS 2022, section 3.2 (piecewise linear encoding), carried over to series: besides the readings
//! themselves, their changes and their local level are encoded.
//!
//! # Departures
//!
//! The outer ramps end at 0 and 1 as well, so that no reading, however wrong, makes a large input. Views that
//! take few values get more edges among these. How many rows come out depends on the number of channels alone:
//! ramps that a view does not need are 0.

use ndarray::{Array3, ArrayView3, Axis};
use serde::{Deserialize, Serialize};

use crate::finite::{self, all_finite, values};
use crate::scale::{check_finite, shape_error};
use crate::{Error, Result};

/// Views of a channel: readings, their change, the mean of five, its change over five.
const VIEWS: usize = 4;
/// Readings of that mean.
const WINDOW: usize = 5;
/// Outermost quantiles of a view's values, and of its distinct values.
const ENDS: [f64; 2] = [0.005, 0.995];
const DISTINCT_ENDS: [f64; 2] = [0.02, 0.98];
/// Largest absolute value of a z-score.
const LARGEST_SCORE: f32 = 8.0;
/// Share of a channel's largest reading that sums of five readings are rounded by at most.
const ROUNDING: f32 = 1e-6;

/// `[N, C, T]` as ramps and z-scores `[N, rows, steps]`; what is fitted to training data is in it.
///
/// Rows: for each channel and each of its four views, ramps `min(max((v − a) / (b − a), 0), 1)` between
/// neighbouring edges a < b; then, for each channel and view, the z-score within ±8. The views are the readings,
/// their first difference, the mean of five (edges held), and the difference of that mean over five. Along
/// time, the mean of every ⌈T / `steps`⌉ values; the last one may have fewer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuantileCode {
    /// Ramps that all views of all channels share, before those among distinct values; each view gets 2 to 16.
    pub ramps: usize,
    /// Most steps in time that come out, at least 1.
    pub steps: usize,
    /// Four of each channel; none before [`QuantileCode::fit`].
    views: Vec<CodeView>,
}

/// The values that are fitted to one view of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CodeView {
    /// Mean of the training values.
    pub mean: f32,
    /// Positive; 1 where the view is constant.
    pub sd: f32,
    /// Ascending; fewer than two where the view is constant.
    pub edges: Vec<f32>,
}

impl Default for QuantileCode {
    fn default() -> Self {
        QuantileCode::new(768, 40)
    }
}

impl QuantileCode {
    /// Makes a code that is not fitted yet.
    pub fn new(ramps: usize, steps: usize) -> Self {
        QuantileCode { ramps, steps, views: vec![] }
    }

    /// Returns what is fitted to the four views of each channel, channel after channel: readings, change, level, drift. Empty
    /// before [`QuantileCode::fit`].
    pub fn views(&self) -> &[CodeView] {
        &self.views
    }

    /// Returns the ramps of each view between quantiles of all its values.
    fn ramps_of_view(&self, channels: usize) -> usize {
        (self.ramps / (VIEWS * channels.max(1))).clamp(2, 16)
    }

    /// Returns the rows of ramps of each view: half as many again as between the quantiles of all values.
    fn rows_of_view(&self, channels: usize) -> usize {
        let ramps = self.ramps_of_view(channels);
        ramps + ramps / 2
    }

    /// Returns the number of values of which one step in time is the mean.
    fn stride(&self, length: usize) -> usize {
        length.div_ceil(self.steps.max(1)).max(1)
    }

    /// Returns the rows and steps in time of encoded samples of `channels` × `length`.
    pub fn shape(&self, channels: usize, length: usize) -> [usize; 2] {
        [VIEWS * channels * (self.rows_of_view(channels) + 1), length.div_ceil(self.stride(length))]
    }

    /// Fits edges, means and standard deviations to the training samples `[N, C, T]`. Give it training samples only: with test
    /// samples in it, a score on them is no longer a score on unseen data.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for no readings, [`Error::NonFinite`] for a bad one.
    pub fn fit(&self, train: ArrayView3<f32>) -> Result<Self> {
        check_finite(&train.into_dyn())?;
        if train.is_empty() {
            return Err(shape_error(&train.into_dyn(), "training data", "at least one reading".into()));
        }
        let (samples, channels, length) = train.dim();
        let ramps = self.ramps_of_view(channels);
        let mut views = Vec::with_capacity(VIEWS * channels);
        let (mut series, mut seen) = (vec![0.0; length], [(); VIEWS].map(|()| vec![0.0; length]));
        for channel in train.axis_iter(Axis(1)) {
            let mut values = [(); VIEWS].map(|()| Vec::with_capacity(samples * length));
            for sample in channel.outer_iter() {
                series.iter_mut().zip(sample).for_each(|(to, from)| *to = *from);
                look(&series, &mut seen);
                values.iter_mut().zip(&seen).for_each(|(all, one)| all.extend_from_slice(one));
            }
            let rounding = ROUNDING * channel.iter().fold(0.0f32, |most, v| most.max(v.abs()));
            views.extend(values.into_iter().map(|values| CodeView::fit(values, ramps, rounding)));
        }
        Ok(QuantileCode { views, ..*self })
    }

    /// Encodes samples `[N, C, T]` as `[N, rows, steps]`; see [`QuantileCode::shape`].
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for other channels than fitted or no readings, [`Error::Parameter`] for fitted values
    /// that no fit gives, [`Error::NonFinite`] for a bad reading.
    pub fn encode_batch(&self, x: ArrayView3<f32>) -> Result<Array3<f32>> {
        let (samples, channels, length) = x.dim();
        self.check([samples, channels, length])?;
        // The place of a bad reading is looked for only where there is one.
        if !all_finite(&values(&x)) {
            check_finite(&x.into_dyn())?;
        }
        let [rows, steps] = self.shape(channels, length);
        let mut code = vec![0.0; samples * rows * steps];
        let mut work = Scratch::new(length, self.stride(length));
        let each = (channels * length).max(1);
        for (sample, code) in values(&x).chunks_exact(each).zip(code.chunks_exact_mut((rows * steps).max(1)))
        {
            self.encode(sample, code, &mut work);
        }
        #[expect(clippy::expect_used, reason = "made with that many values")]
        Ok(Array3::from_shape_vec((samples, rows, steps), code).expect("as many values"))
    }

    /// Plans the code of samples of `channels` × `length`, ready to be made again and again.
    ///
    /// # Errors
    ///
    /// Those of [`QuantileCode::encode_batch`].
    pub fn plan(&self, channels: usize, length: usize) -> Result<CodePlan> {
        self.check([1, channels, length])?;
        Ok(CodePlan { work: Scratch::new(length, self.stride(length)), code: self.clone(), channels, length })
    }

    fn check(&self, shape: [usize; 3]) -> Result<()> {
        let [_, channels, length] = shape;
        if self.views.len() != VIEWS * channels || channels * length == 0 {
            let expected = format!("[N, {}, T], the channels that were fitted", self.views.len() / VIEWS);
            return Err(Error::Shape { what: "readings", expected, got: shape.to_vec() });
        }
        let rows = self.rows_of_view(channels);
        self.views.iter().enumerate().try_for_each(|(number, view)| view.check(number, rows))
    }

    /// Writes the code of one sample, channel after channel, into `code`, which is zeros.
    #[allow(clippy::manual_clamp, reason = "`clamp` would pass on the NaN that two infinities leave")]
    fn encode(&self, sample: &[f32], code: &mut [f32], work: &mut Scratch) {
        let length = work.series.len();
        let (rows, steps) = (self.rows_of_view(sample.len() / length), work.steps);
        let (ramps, scores) = code.split_at_mut(self.views.len() * rows * steps);
        let rows = ramps.chunks_exact_mut(rows * steps).zip(scores.chunks_exact_mut(steps));
        let mut views = self.views.iter().zip(rows);
        for channel in sample.chunks_exact(length) {
            work.look(channel);
            for (number, (view, (ramps, score))) in (0..VIEWS).zip(&mut views) {
                work.take_apart(number);
                for (pair, row) in view.edges.windows(2).zip(ramps.chunks_exact_mut(steps)) {
                    let (low, factor) = (pair[0], 1.0 / (pair[1] - pair[0]));
                    work.mean(row, |v| ((v - low) * factor).max(0.0).min(1.0));
                }
                let (mean, factor) = (view.mean, 1.0 / view.sd);
                work.mean(score, |v| ((v - mean) * factor).max(-LARGEST_SCORE).min(LARGEST_SCORE));
            }
        }
    }
}

impl CodeView {
    /// Fits the edges of `ramps` ramps, and more where values repeat; values nearer than `rounding` are one.
    fn fit(mut values: Vec<f32>, ramps: usize, rounding: f32) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let squares = values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>();
        let sd = (squares / n).sqrt() as f32;
        values.sort_unstable_by(f32::total_cmp);
        let levels = |[first, last]: [f64; 2]| {
            (0..=ramps).map(move |i| first + (last - first) * i as f64 / ramps as f64)
        };
        let mut edges: Vec<f32> = levels(ENDS).map(|level| quantile(&values, level)).collect();
        keep_apart(&mut edges, rounding);
        if edges.len() <= ramps {
            keep_apart(&mut values, rounding);
            edges.extend(levels(DISTINCT_ENDS).step_by(2).map(|level| quantile(&values, level)));
            edges.sort_unstable_by(f32::total_cmp);
            keep_apart(&mut edges, rounding);
        }
        CodeView { mean: mean as f32, sd: if sd <= rounding { 1.0 } else { sd }, edges }
    }

    /// Refuses what [`CodeView::fit`] does not give.
    fn check(&self, number: usize, rows: usize) -> Result<()> {
        let refuse = |what: &str, value: f32, expected| {
            let name = format!("{what} of view {} of channel {}", number % VIEWS, number / VIEWS);
            Err(Error::Parameter { name, value, expected })
        };
        if !self.mean.is_finite() {
            return refuse("mean", self.mean, "finite");
        }
        if !(self.sd > 0.0 && self.sd.is_finite()) {
            return refuse("sd", self.sd, "positive and finite");
        }
        if self.edges.len() > rows + 1 {
            return refuse("number of edges", self.edges.len() as f32, "at most one more than its rows");
        }
        let apart = |pair: &[f32]| pair[0] < pair[1] && (1.0 / (pair[1] - pair[0])).is_finite();
        match self.edges.windows(2).find(|pair| !apart(pair)) {
            Some(pair) => refuse("edge", pair[1], "ascending and finite"),
            None => Ok(()),
        }
    }
}

/// A [`QuantileCode`] of samples of one shape: nothing is planned or allocated for another one.
#[derive(Debug, Clone)]
pub struct CodePlan {
    code: QuantileCode,
    channels: usize,
    length: usize,
    work: Scratch,
}

impl CodePlan {
    /// Encodes one sample, channel after channel, into `code` `[rows, steps]`, bit for bit as
    /// [`QuantileCode::encode_batch`] does.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for other lengths, [`Error::NonFinite`] for a bad reading.
    pub fn encode(&mut self, sample: &[f32], code: &mut [f32]) -> Result<()> {
        let CodePlan { channels, length, .. } = *self;
        let [rows, steps] = self.code.shape(channels, length);
        if sample.len() != channels * length || code.len() != rows * steps {
            let expected = format!("{channels} x {length} readings, and room for {rows} x {steps}");
            return Err(Error::Shape { what: "readings", expected, got: vec![sample.len(), code.len()] });
        }
        finite::check_finite(sample, |at| format!("reading {} of channel {}", at % length, at / length))?;
        code.fill(0.0);
        self.code.encode(sample, code, &mut self.work);
        Ok(())
    }
}

/// Memory for encoding, used again for the next sample.
#[derive(Debug, Clone)]
struct Scratch {
    stride: usize,
    steps: usize,
    series: Vec<f32>,
    views: [Vec<f32>; VIEWS],
    /// Every `stride`-th value of a view, from the first, the second, .. on: `stride` runs of `steps` values, the
    /// later ones perhaps one short.
    phases: Vec<f32>,
    /// The factors of the sums of the phases.
    shares: Vec<f32>,
}

impl Scratch {
    fn new(length: usize, stride: usize) -> Self {
        let steps = length.div_ceil(stride);
        let share = |step: usize| 1.0 / stride.min(length - step * stride) as f32;
        Scratch {
            stride,
            steps,
            series: vec![0.0; length],
            views: [(); VIEWS].map(|()| vec![0.0; length]),
            phases: vec![0.0; stride * steps],
            shares: (0..steps).map(share).collect(),
        }
    }

    /// Looks at a channel.
    fn look(&mut self, channel: &[f32]) {
        self.series.copy_from_slice(channel);
        look(&self.series, &mut self.views);
    }

    /// Takes view `number` apart, for [`Scratch::mean`].
    fn take_apart(&mut self, number: usize) {
        for (phase, run) in self.phases.chunks_exact_mut(self.steps).enumerate() {
            let values = self.views[number][phase.min(self.series.len())..].iter().step_by(self.stride);
            run.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
        }
    }

    /// Adds the mean over every `stride` values of `f(v)` to `row`, which is zeros.
    #[inline(always)]
    fn mean(&self, row: &mut [f32], f: impl Fn(f32) -> f32) {
        for (phase, run) in self.phases.chunks_exact(self.steps).enumerate() {
            let count = self.series.len().saturating_sub(phase).div_ceil(self.stride);
            row.iter_mut().zip(&run[..count]).for_each(|(sum, &v)| *sum += f(v));
        }
        row.iter_mut().zip(&self.shares).for_each(|(sum, share)| *sum *= share);
    }
}

/// Computes the four views of a channel, each as long as `series`.
fn look(series: &[f32], [readings, change, level, drift]: &mut [Vec<f32>; VIEWS]) {
    readings.copy_from_slice(series);
    if let Some(first) = change.first_mut() {
        *first = 0.0;
    }
    for (to, pair) in change.iter_mut().skip(1).zip(series.windows(2)) {
        *to = pair[1] - pair[0];
    }
    let mean = |five: [f32; WINDOW]| (five[0] + five[1] + five[2] + five[3] + five[4]) * 0.2;
    let (half, last) = (WINDOW / 2, series.len() - 1);
    for (t, to) in level.iter_mut().enumerate().take(half) {
        *to = mean([0, 1, 2, 3, 4].map(|i| series[(t + i).saturating_sub(half).min(last)]));
    }
    for (to, five) in level.iter_mut().skip(half).zip(series.windows(WINDOW)) {
        *to = mean([five[0], five[1], five[2], five[3], five[4]]);
    }
    for (t, to) in level.iter_mut().enumerate().skip((series.len().max(half) - half).max(half)) {
        *to = mean([0, 1, 2, 3, 4].map(|i| series[(t + i).saturating_sub(half).min(last)]));
    }
    drift.iter_mut().take(WINDOW).for_each(|to| *to = 0.0);
    let before = level.iter().zip(level.iter().skip(WINDOW));
    drift.iter_mut().skip(WINDOW).zip(before).for_each(|(to, (before, now))| *to = now - before);
}

/// Returns the quantile at `level` of ascending values, straight between neighbours.
fn quantile(ascending: &[f32], level: f64) -> f32 {
    let place = level * (ascending.len() - 1) as f64;
    let (low, high) = (ascending[place.floor() as usize], ascending[place.ceil() as usize]);
    (f64::from(low) + (f64::from(high) - f64::from(low)) * place.fract()) as f32
}

/// Keeps of ascending values those that are more than `rounding` above the last one kept.
fn keep_apart(ascending: &mut Vec<f32>, rounding: f32) {
    ascending.dedup_by(|next, kept| *next - *kept <= rounding.max(f32::MIN_POSITIVE));
}
