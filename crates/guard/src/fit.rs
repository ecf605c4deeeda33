//! A guard fitted on clean training samples.

use ndarray::{ArrayViewD, CowArray, IxDyn};
use taxel_base::Layout;

use crate::channels;
use crate::error::{Error, Result};
use crate::guard::{BrokenKind, Guard, Link, of_element};
use crate::limits::{MARGIN, SHARE, TOLERANCE};
use crate::places::ElementPlaces;
use crate::window::{kinds, residual};

/// The range of the sensor, as far as it is known beside the samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct KnownRange<'f> {
    /// The largest possible reading; otherwise the largest of the samples is taken for it.
    pub full_scale: Option<f32>,
    /// Readings without contact, one for all or one for each channel; otherwise 0, of channels over time the median of
    /// their first readings.
    pub rest: Option<&'f [f32]>,
}

impl Guard {
    /// Fits a guard to clean training samples `[N, ..]` of a layout, in three passes.
    ///
    /// # Errors
    /// No samples, another shape than the layout has, readings that are not finite, rest values in another number.
    pub fn fit(train: ArrayViewD<f32>, layout: Layout, facts: &KnownRange) -> Result<Self> {
        let (count, shape) = match train.shape() {
            [count, shape @ ..] if *count > 0 => (*count, shape.to_vec()),
            _ => (0, vec![]),
        };
        let refuse = || Error::Shape { layout: layout.describe(), shape: train.shape().to_vec() };
        let places = ElementPlaces::of(layout, &shape).filter(|_| count > 0).ok_or_else(refuse)?;
        let train: CowArray<f32, IxDyn> = train.as_standard_layout();
        #[expect(clippy::expect_used, reason = "the standard layout is one slice")]
        let values = train.as_slice().expect("standard layout");
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let (sample, reading) = (at / places.len(), at % places.len());
            return Err(Error::NonFinite { sample, reading, value: values[at] });
        }
        let rest = match facts.rest {
            Some(rest) if rest.len() == 1 || rest.len() == places.elements => rest.to_vec(),
            Some(rest) => return Err(Error::Rest { given: rest.len(), elements: places.elements }),
            None => resting(&places, layout, values),
        };
        let seen = ElementRanges::of(&places, values);
        let ends = |(low, high): (f32, f32), value: &f32| (low.min(*value), high.max(*value));
        let (low, most) = values.iter().fold((0.0, f32::NEG_INFINITY), ends);
        let high = facts.full_scale.map_or(most, |full| full.max(most));
        let has_area = places.has_area();
        let mut guard = Guard {
            layout,
            shape,
            samples: count,
            // A range of nothing but zeros has no width; any will do.
            range: [low, if high > low { high } else { low + low.abs().max(1.0) }],
            constant: (0..places.elements).filter(|&element| seen.is_constant(element)).collect(),
            mean: seen.mean.iter().map(|mean| *mean as f32).collect(),
            rest,
            quiet: if has_area { vec![0.0] } else { seen.quiet },
            links: if has_area { vec![] } else { channels::links(&places, values, &seen.mean) },
            ends: if has_area { vec![] } else { seen.ends },
            scale: vec![],
            bounds: Default::default(),
            shares: Default::default(),
        };
        let links = guard.table(&places);
        guard.scale = scale(&guard, &places, &links, values);
        (guard.bounds, guard.shares) = bounds(&guard, &places, &links, values);
        Ok(guard)
    }
}

/// The values of each element in training.
struct ElementRanges {
    mean: Vec<f64>,
    ends: Vec<[f32; 2]>,
    /// The smallest variation over a window.
    quiet: Vec<f32>,
}

impl ElementRanges {
    fn of(places: &ElementPlaces, values: &[f32]) -> Self {
        let mut mean = vec![0.0; places.elements];
        let mut ends = vec![[f32::INFINITY, f32::NEG_INFINITY]; places.elements];
        let mut quiet = vec![f32::INFINITY; places.elements];
        for sample in values.chunks_exact(places.len()) {
            for element in 0..places.elements {
                let mut range = [f32::INFINITY, f32::NEG_INFINITY];
                for time in 0..places.times {
                    let value = sample[places.at(element, time)];
                    mean[element] += f64::from(value);
                    range = [range[0].min(value), range[1].max(value)];
                }
                // Never infinite, however far apart.
                quiet[element] = quiet[element].min((range[1] - range[0]).min(f32::MAX));
                ends[element] = [ends[element][0].min(range[0]), ends[element][1].max(range[1])];
            }
        }
        let readings = (values.len() / places.elements) as f64;
        mean.iter_mut().for_each(|sum| *sum /= readings);
        Self { mean, ends, quiet }
    }

    fn is_constant(&self, element: usize) -> bool {
        self.ends[element][0] == self.ends[element][1]
    }
}

/// Estimates the values without contact: of channels over time the median of their first values, since recordings begin
/// before contact; 0 elsewhere.
fn resting(places: &ElementPlaces, layout: Layout, values: &[f32]) -> Vec<f32> {
    if !matches!(layout, Layout::Series | Layout::Fingers) {
        return vec![0.0];
    }
    let median = |element: usize| {
        let mut first: Vec<f32> =
            values.chunks_exact(places.len()).map(|sample| sample[places.at(element, 0)]).collect();
        first.sort_by(f32::total_cmp);
        first[first.len() / 2]
    };
    (0..places.elements).map(median).collect()
}

/// Hands the residual of every element in every sample to `take`; elements that never vary are left out.
fn each(
    guard: &Guard,
    places: &ElementPlaces,
    links: &[Vec<Link>],
    values: &[f32],
    mut take: impl FnMut(usize, &[f32], f64),
    mut next: impl FnMut(),
) {
    let is_broken = vec![false; places.elements];
    let mut is_constant = is_broken.clone();
    guard.constant.iter().for_each(|element| is_constant[*element] = true);
    for sample in values.chunks_exact(places.len()) {
        for element in (0..places.elements).filter(|element| !is_constant[*element]) {
            if let Some(residual) = residual(guard, places, &links[element], element, sample, &is_broken) {
                take(element, sample, residual);
            }
        }
        next();
    }
}

/// Returns the root mean square of the residual, of each channel or of all taxels together.
fn scale(guard: &Guard, places: &ElementPlaces, links: &[Vec<Link>], values: &[f32]) -> Vec<f32> {
    let groups = if places.has_area() { 1 } else { places.elements };
    let (mut squares, mut counts) = (vec![0.0; groups], vec![0usize; groups]);
    let take = |element: usize, _: &[f32], residual: f64| {
        let at = element.min(groups - 1);
        squares[at] += residual * residual;
        counts[at] += 1;
    };
    each(guard, places, links, values, take, || {});
    let least = 1e-6 * (f64::from(guard.range[1]) - f64::from(guard.range[0]));
    let least = least.max(f64::from(f32::MIN_POSITIVE));
    let root = |(square, count): (&f64, &usize)| {
        (square / (*count).max(1) as f64).sqrt().clamp(least, f64::from(f32::MAX)) as f32
    };
    squares.iter().zip(&counts).map(root).collect()
}

type KindTables = [Vec<f32>; BrokenKind::ALL.len()];

/// Returns the bounds of the residuals for each kind, and the share of windows of each kind.
fn bounds(
    guard: &Guard,
    places: &ElementPlaces,
    links: &[Vec<Link>],
    values: &[f32],
) -> (KindTables, KindTables) {
    const KINDS: usize = BrokenKind::ALL.len();
    const FAR: usize = KINDS - 1;
    let groups = if places.has_area() { 1 } else { places.elements };
    let (mut most, mut counts) = (vec![[0.0f64; KINDS]; groups], vec![[0usize; KINDS]; groups]);
    // The largest of each sample; none where no element is of the kind.
    let mut worst: [Vec<f64>; KINDS] = Default::default();
    let of_sample = std::cell::Cell::new([None::<f64>; KINDS]);
    let take = |element: usize, sample: &[f32], residual: f64| {
        let residual = residual / f64::from(of_element(&guard.scale, element));
        let mut worst = of_sample.get();
        for (kind, _) in kinds(guard, places, element, sample).iter().enumerate().filter(|(_, is_of)| **is_of)
        {
            let group = element.min(groups - 1);
            most[group][kind] = most[group][kind].max(residual);
            counts[group][kind] += 1;
            worst[kind] = Some(worst[kind].map_or(residual, |worst| worst.max(residual)));
        }
        of_sample.set(worst);
    };
    let next = || {
        worst.iter_mut().zip(of_sample.take()).for_each(|(all, residual)| all.extend(residual));
    };
    each(guard, places, links, values, take, next);
    let shared = worst.map(|mut all| {
        all.sort_by(f64::total_cmp);
        let at = (SHARE * all.len() as f64).ceil() as usize;
        all.get(at.min(all.len().saturating_sub(1))).copied().unwrap_or(0.0)
    });
    let floor = TOLERANCE * (f64::from(guard.range[1]) - f64::from(guard.range[0]));
    let bound = |group: usize, kind: usize| {
        let usual = match (places.has_area(), kind) {
            (true, _) => shared[kind],
            (false, FAR) => shared[kind].max(most[group][kind]),
            (false, _) => most[group][kind],
        };
        (MARGIN * usual).max(floor / f64::from(guard.scale[group]))
    };
    let of = |kind: usize, group: usize| match counts[group][kind] {
        0 => 0.0,
        _ => bound(group, kind).min(bound(group, FAR)) as f32,
    };
    let windows = (values.len() / places.len()) * (places.elements - guard.constant.len());
    let windows = if places.has_area() { windows } else { values.len() / places.len() };
    let share = |kind: usize, group: usize| (counts[group][kind] as f64 / windows.max(1) as f64) as f32;
    let table = |value: &dyn Fn(usize, usize) -> f32| {
        std::array::from_fn(|kind| (0..groups).map(|group| value(kind, group)).collect())
    };
    (table(&of), table(&share))
}
