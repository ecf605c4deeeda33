//! What a guard has learned, as it stands in a model's card.

use serde::{Deserialize, Serialize};
use taxel_base::Layout;

use crate::limits::NEIGHBOURS;
use crate::places::Places;

/// How an element is known to be broken.
///
/// For each the residual, the root mean square of what an element reads less what its neighbours say over the window,
/// must be larger than in any training window of the same kind, by [`MARGIN`](crate::limits::MARGIN). What never happened in training
/// needs no neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Full scale for the whole window.
    Full,
    /// Rest for the whole window.
    Rest,
    /// One value, though it varied in training.
    Still,
    /// Anything, far from what its neighbours say.
    Far,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Full, Self::Rest, Self::Still, Self::Far];

    /// In words, after the name of an element.
    pub fn words(self) -> &'static str {
        match self {
            Self::Full => "at full scale",
            Self::Rest => "at rest",
            Self::Still => "still",
            Self::Far => "far from its neighbours",
        }
    }
}

/// What one channel says of another: offset + slope · its reading.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Which channel says it.
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
    /// Elements that never varied: a network has learned nothing from them, and nothing is said of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) constant: Vec<usize>,
    /// Mean reading.
    pub(crate) mean: Vec<f32>,
    /// Reading without contact.
    pub(crate) rest: Vec<f32>,
    /// Of channels the smallest variation over a window, highest less lowest.
    pub(crate) quiet: Vec<f32>,
    /// Of channels lowest and highest readings; what neighbours say ends there. None of arrays.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) ends: Vec<[f32; 2]>,
    /// Of channels those that speak of each; the neighbours of taxels are those around them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) links: Vec<Vec<Link>>,
    /// Root mean square of the residual.
    pub(crate) scale: Vec<f32>,
    /// Bounds of the residual, in units of `scale`; 0 where the kind never occurred. In the order of [`Kind::ALL`].
    pub(crate) bounds: [Vec<f32>; 4],
    /// Share of training windows of each kind: of several the rarest is looked at first.
    pub(crate) shares: [Vec<f32>; 4],
}

/// The value of an element in a list of one for each or one for all.
pub(crate) fn own<T: Copy>(list: &[T], element: usize) -> T {
    list[if list.len() == 1 { 0 } else { element }]
}

impl Guard {
    /// What the axes of a sample are.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Shape of a sample.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Number of channels or taxels.
    pub fn elements(&self) -> usize {
        self.places().map_or(0, |places| places.elements)
    }

    /// What an element is called: `channel 3`, `taxel (4, 17)`.
    pub fn name(&self, element: usize) -> String {
        let name = |places: Places| places.name(self.layout, &self.shape, element);
        self.places().map_or_else(String::new, name)
    }

    /// The guard in words, for a card.
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

    pub(crate) fn places(&self) -> Option<Places> {
        Places::of(self.layout, &self.shape)
    }

    /// Whether this is the guard of readings of that layout and shape, and whole.
    ///
    /// # Errors
    /// What is wrong with it.
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
        let own = if places.has_area() { 0 } else { elements };
        let ends = |[low, high]: &[f32; 2]| low.is_finite() && high.is_finite() && low <= high;
        let link = |link: &Link| link.from < elements && link.offset.is_finite() && link.slope.is_finite();
        let links = |all: &Vec<Link>| all.len() <= NEIGHBOURS && all.iter().all(link);
        let is_sound = is_list(&self.mean, true)
            && lists.into_iter().chain(tables).all(|list| is_list(list, false))
            && self.scale.iter().all(|scale| *scale > 0.0)
            && self.range.iter().all(|end| end.is_finite())
            && self.constant.iter().all(|element| *element < elements)
            && (self.ends.len(), self.links.len()) == (own, own)
            && self.ends.iter().all(ends)
            && self.links.iter().all(links);
        match is_sound {
            true => Ok(()),
            false => Err("the numbers of the guard do not fit together".into()),
        }
    }

    /// What is said of each element, those that never varied left out.
    pub(crate) fn table(&self, places: &Places) -> Vec<Vec<Link>> {
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
