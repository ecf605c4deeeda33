//! A fitted guard, as it stands in a model's card.

use serde::{Deserialize, Serialize};
use taxel_base::Layout;

use crate::limits::NEIGHBOURS;
use crate::places::ElementPlaces;

/// The sign by which an element is known to be broken.
///
/// For each, the residual must be larger than in any training window of the same kind, by
/// [`MARGIN`](crate::limits::MARGIN). The residual is the root mean square over the window of an element's values less the
/// predictions of its neighbours. A kind that never occurred in training needs no neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrokenKind {
    /// Full scale for the whole window.
    Full,
    /// Rest for the whole window.
    Rest,
    /// One value, though it varied in training.
    Still,
    /// Any values that are far from the predictions of its neighbours.
    Far,
}

impl BrokenKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Full, Self::Rest, Self::Still, Self::Far];

    /// Describes the kind, after the name of an element.
    pub fn words(self) -> &'static str {
        match self {
            Self::Full => "at full scale",
            Self::Rest => "at rest",
            Self::Still => "still",
            Self::Far => "far from its neighbours",
        }
    }
}

/// The prediction of one channel by another: offset + slope · its value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// The channel that predicts.
    pub from: usize,
    /// In the unit of the readings.
    pub offset: f32,
    /// Least squares over all training readings.
    pub slope: f32,
}

/// A guard, fitted on clean training samples.
///
/// Lists hold one value for each element, or a single one for all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Guard {
    pub(crate) layout: Layout,
    /// Of a sample.
    pub(crate) shape: Vec<usize>,
    /// Training samples.
    pub(crate) samples: usize,
    /// The sensor's range: from 0 or the lowest reading to full scale or the highest.
    pub(crate) range: [f32; 2],
    /// Elements that never varied: a network has learned nothing from them, and they are not checked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) constant: Vec<usize>,
    /// Mean reading.
    pub(crate) mean: Vec<f32>,
    /// Reading without contact.
    pub(crate) rest: Vec<f32>,
    /// Of channels the smallest variation over a window, highest less lowest.
    pub(crate) quiet: Vec<f32>,
    /// Lowest and highest value of each channel, which bound its predictions; empty for arrays.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) ends: Vec<[f32; 2]>,
    /// The channels that predict each channel; empty for arrays, where the taxels around predict.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) links: Vec<Vec<Link>>,
    /// Root mean square of the residual.
    pub(crate) scale: Vec<f32>,
    /// Bounds of the residual, in units of `scale`; 0 where the kind never occurred. In the order of [`BrokenKind::ALL`].
    pub(crate) bounds: [Vec<f32>; 4],
    /// Share of training windows of each kind: of several the rarest is looked at first.
    pub(crate) shares: [Vec<f32>; 4],
}

/// Returns the value of an element in a list of one for each or one for all.
pub(crate) fn of_element<T: Copy>(list: &[T], element: usize) -> T {
    list[if list.len() == 1 { 0 } else { element }]
}

impl Guard {
    /// Returns the axes of a sample.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Returns the shape of a sample.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Returns the number of channels or taxels.
    pub fn elements(&self) -> usize {
        self.places().map_or(0, |places| places.elements)
    }

    /// Returns the name of an element: `channel 3`, `taxel (4, 17)`.
    pub fn name(&self, element: usize) -> String {
        let name = |places: ElementPlaces| places.name(self.layout, &self.shape, element);
        self.places().map_or_else(String::new, name)
    }

    /// Describes the guard for a card.
    pub fn words(&self) -> String {
        let what = match self.layout {
            Layout::Features => "features",
            Layout::Series | Layout::Fingers => "channels",
            Layout::Image | Layout::Colour | Layout::Sequence => "taxels",
        };
        let [low, high] = self.range;
        let constant = match self.constant.len() {
            0 => String::new(),
            count => format!(", {count} of which never varied"),
        };
        format!(
            "on: {} {what}{constant}; readings {low} to {high}, fitted on {} samples",
            self.elements(),
            self.samples
        )
    }

    pub(crate) fn places(&self) -> Option<ElementPlaces> {
        ElementPlaces::of(self.layout, &self.shape)
    }

    /// Checks whether this is a whole guard of samples of that layout and shape.
    ///
    /// # Errors
    /// The problem.
    pub fn check(&self, layout: Layout, shape: &[usize]) -> Result<(), String> {
        let places = self.places().filter(|_| (self.layout, self.shape.as_slice()) == (layout, shape));
        let Some(places) = places else {
            return Err(format!("the guard is of {} samples of shape {:?}", self.layout, self.shape));
        };
        let elements = places.elements;
        let is_list = |list: &[f32], all: bool| {
            (list.len() == elements || list.len() == 1 && !all) && list.iter().all(|value| value.is_finite())
        };
        let lists = [&self.rest, &self.quiet, &self.scale];
        let tables = self.bounds.iter().chain(&self.shares);
        let channels = if places.has_area() { 0 } else { elements };
        let ends = |[low, high]: &[f32; 2]| low.is_finite() && high.is_finite() && low <= high;
        let link = |link: &Link| link.from < elements && link.offset.is_finite() && link.slope.is_finite();
        let links = |all: &Vec<Link>| all.len() <= NEIGHBOURS && all.iter().all(link);
        let is_sound = is_list(&self.mean, true)
            && lists.into_iter().chain(tables).all(|list| is_list(list, false))
            && self.scale.iter().all(|scale| *scale > 0.0)
            && self.range.iter().all(|end| end.is_finite())
            && self.constant.iter().all(|element| *element < elements)
            && (self.ends.len(), self.links.len()) == (channels, channels)
            && self.ends.iter().all(ends)
            && self.links.iter().all(links);
        if is_sound { Ok(()) } else { Err("the numbers of the guard do not fit together".into()) }
    }

    /// Lists the predictions of each element, without those by elements that never varied.
    pub(crate) fn table(&self, places: &ElementPlaces) -> Vec<Vec<Link>> {
        let mut is_constant = vec![false; places.elements];
        self.constant.iter().for_each(|element| is_constant[*element] = true);
        if !places.has_area() {
            return self.links.clone();
        }
        let around = |element: usize| {
            let near = places.around(element).filter(|from| !is_constant[*from]);
            near.map(|from| Link { from, offset: 0.0, slope: 1.0 }).collect()
        };
        (0..places.elements).map(around).collect()
    }
}
