//! Values between bytes and floats, through a scale and shift per channel and a rectifier.

use crate::fold::Fold;
use crate::frozen::place::ImagePlace;
use crate::frozen::rows::columns;
use crate::lengths::{at_least, exactly, reach};
use crate::rows::{load, vectors};
use crate::simd::{Simd, at_level};
use crate::view::Rectifier;

use super::ByteScale;
use super::output::{ByteOutput, Ending, Target};

/// Memory that values come from.
#[derive(Clone, Copy)]
pub enum SourceValues<'a> {
    /// Bytes.
    Bytes(&'a [u8]),
    /// Floats.
    Floats(&'a [f32]),
}

impl SourceValues<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            SourceValues::Bytes(x) => x.len(),
            SourceValues::Floats(x) => x.len(),
        }
    }
}

/// `y = rectifier(scale · x + shift)` between two places.
pub struct Map {
    from: ImagePlace,
    to: ImagePlace,
    /// Whether bytes come in.
    reads_bytes: bool,
    output: ByteOutput,
    ending: Ending,
    /// Of every channel, zeros and steps of both sides included.
    factors: Vec<f32>,
    shifts: Vec<f32>,
    /// Bytes that stay as they are.
    is_copy: bool,
}

impl Map {
    /// Makes the map from values written in `input` (floats: none) to `output`; `affine` is scale and shift per
    /// channel.
    pub fn new(
        (from, input): (ImagePlace, Option<ByteScale>),
        (to, output): (ImagePlace, ByteOutput),
        affine: Option<(&[f32], &[f32])>,
        rectifier: Rectifier,
    ) -> Self {
        let channels = from.channels;
        assert!(from.size == to.size && channels == to.channels, "{from:?} and {to:?} are of two shapes");
        let is_copy = affine.is_none()
            && rectifier == Rectifier::None
            && input.is_some_and(|input| output == ByteOutput::Bytes(input));
        let (factors, shifts) = Map::coefficients(channels, input, output, affine);
        let ending = output.ending(rectifier);
        Map { from, to, reads_bytes: input.is_some(), output, ending, factors, shifts, is_copy }
    }

    /// Returns factors and shifts of the `channels`, steps and zeros of both sides included: a stored number is an
    /// [`Ending`] of `factor · x + shift`.
    pub fn coefficients(
        channels: usize,
        input: Option<ByteScale>,
        output: ByteOutput,
        affine: Option<(&[f32], &[f32])>,
    ) -> (Vec<f32>, Vec<f32>) {
        let (step, zero) = input.map_or((1.0, 0.0), |s| (f64::from(s.step), f64::from(s.zero)));
        if let Some((scale, shift)) = affine {
            exactly("scales", scale.len(), channels);
            exactly("shifts", shift.len(), channels);
        }
        let one = |c: usize| {
            let (scale, shift) = affine.map_or((1.0, 0.0), |(s, t)| (f64::from(s[c]), f64::from(t[c])));
            let factor = (scale * step * output.steps()) as f32;
            (factor, ((shift - scale * step * zero) * output.steps()) as f32)
        };
        (0..channels).map(one).unzip()
    }

    /// Computes all values.
    pub fn run(&self, x: SourceValues, mut y: Target) {
        at_least("values to be moved", x.len(), self.from.end());
        at_least("room for values", y.len(), self.to.end());
        assert!(y.fits(self.output), "memory for {:?} is needed", self.output);
        assert!(
            matches!(x, SourceValues::Bytes(_)) == self.reads_bytes,
            "values of the other kind are needed"
        );
        let channels = self.from.channels;
        if let (true, SourceValues::Bytes(x), Target::Bytes(y)) = (self.is_copy, x, &mut y) {
            return columns(&self.from, &self.to, |[a, b], [from, to], count| {
                // Few bytes are copied faster than a copy is called.
                for column in 0..count {
                    let pairs = y[b + column * to..][..channels].iter_mut().zip(&x[a + column * from..]);
                    pairs.for_each(|(y, x)| *y = *x);
                }
            });
        }
        let scales = PerChannel { factors: &self.factors, shifts: &self.shifts };
        let fold = Fold::new(channels).map(|f| (f, f.repeat(&self.factors), f.repeat(&self.shifts)));
        columns(&self.from, &self.to, |starts, pitches, count| {
            let mut folded = 0;
            if let (Some((fold, factors, shifts)), true) = (&fold, pitches == [channels; 2]) {
                let (several, wide) = (PerChannel { factors, shifts }, fold.channels());
                let whole = fold.whole(count * channels);
                run(&several, &self.ending, starts, [wide; 2], whole / wide, x, &mut y);
                folded = whole / channels;
            }
            let starts = starts.map(|start| start + folded * channels);
            run(&scales, &self.ending, starts, pitches, count - folded, x, &mut y);
        });
    }
}

/// A factor and an offset per channel.
struct PerChannel<'a> {
    factors: &'a [f32],
    shifts: &'a [f32],
}

at_level! {
    fn run(
        scales: &PerChannel, ending: &Ending, starts: [usize; 2], pitches: [usize; 2], count: usize, x: SourceValues,
        y: &mut Target,
    ) = run_at
}

/// Computes `count` columns by the channels' factors and shifts, with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd>(
    scales: &PerChannel,
    ending: &Ending,
    [from, to]: [usize; 2],
    pitches: [usize; 2],
    count: usize,
    x: SourceValues,
    y: &mut Target,
) {
    let channels = scales.factors.len();
    at_least("values to be moved", x.len(), from.saturating_add(reach(count, pitches[0], channels)));
    at_least("room for values", y.len(), to.saturating_add(reach(count, pitches[1], channels)));
    exactly("shifts", scales.shifts.len(), channels);
    for column in 0..count {
        let (from, to) = (from + column * pitches[0], to + column * pitches[1]);
        vectors!(S, channels, c, n, {
            // SAFETY: both slices are asserted to hold the channels of the last of `count` columns; factors and shifts
            // are one per channel.
            unsafe {
                let value = load_at::<S>(x, from + c, n);
                let value = S::mul(value, load::<S>(scales.factors, c, n));
                let value = S::add(value, load::<S>(scales.shifts, c, n));
                store_at::<S>(y, to + c, n, value, ending);
            }
        });
    }
}

/// Loads lanes `at..at + n` of `x`, bytes as numbers; the other lanes are zero.
///
/// # Safety
/// The CPU has the features of `S`, and `x` holds `at + n` values.
#[inline(always)]
pub(super) unsafe fn load_at<S: Simd>(x: SourceValues, at: usize, n: usize) -> S::V {
    // SAFETY: the caller's contract.
    unsafe {
        match x {
            SourceValues::Bytes(x) => S::load_bytes(x.as_ptr().add(at), n),
            SourceValues::Floats(x) => load::<S>(x, at, n),
        }
    }
}

/// Stores `value` with the output's zero, cut off.
///
/// # Safety
/// The CPU has the features of `S`, and `y` holds `at + n` values.
#[inline(always)]
pub(super) unsafe fn store_at<S: Simd>(y: &mut Target, at: usize, n: usize, value: S::V, ending: &Ending) {
    // SAFETY: the caller's contract.
    unsafe {
        let value = S::add(value, S::splat(ending.zero));
        let value = S::clamp(value, S::splat(ending.low), S::splat(ending.high));
        match y {
            Target::Bytes(y) => S::store_bytes(y.as_mut_ptr().add(at), value, n),
            Target::Floats(y) => crate::rows::store::<S>(y, at, n, value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "no memory holds")]
    fn columns_that_lie_too_far_apart_are_refused() {
        let scales = PerChannel { factors: &[1.0], shifts: &[0.0] };
        let ending = ByteOutput::Floats.ending(Rectifier::None);
        let pitches = [usize::MAX / 2 + 1, 1];
        run(
            &scales,
            &ending,
            [0, 0],
            pitches,
            3,
            SourceValues::Bytes(&[1]),
            &mut Target::Floats(&mut [0.0; 3]),
        );
    }
}
