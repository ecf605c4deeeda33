//! A guard at work: broken elements of one sample after another, found and replaced.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::guard::{BrokenKind, Guard, Link, of_element};
use crate::limits::MOST;
use crate::places::ElementPlaces;
use crate::ranking::Ranking;
use crate::window::{kinds, predicted, residual};

/// An element that was replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReplacedElement {
    /// Its number; [`Guard::name`] names it.
    pub element: usize,
    /// The sign by which it is known to be broken.
    pub kind: BrokenKind,
}

/// A guard with the memory that it needs: each thread has its own. Nothing is allocated while it works.
#[derive(Debug, Clone)]
pub struct Watch {
    known: Known,
    most: usize,
    // Of the sample.
    ranking: Ranking<Suspicion>,
    is_broken: Vec<bool>,
    found: Vec<ReplacedElement>,
}

/// The guard and its tables, which do not change from sample to sample.
#[derive(Debug, Clone)]
struct Known {
    guard: Arc<Guard>,
    places: ElementPlaces,
    /// The predictions of each element, and the elements that each predicts.
    links: Vec<Vec<Link>>,
    predicts: Vec<Vec<usize>>,
    is_constant: Vec<bool>,
}

/// The reason why an element is taken for broken.
#[derive(Debug, Clone, Copy)]
struct Suspicion {
    /// Of training windows that are of its kind: the rarer, the surer.
    share: f32,
    /// Residual by its bound, above 1.
    excess: f64,
    kind: BrokenKind,
}

impl Suspicion {
    /// Checks whether it is the surer of two.
    fn is_before(&self, other: &Self) -> bool {
        (self.share, -self.excess) < (other.share, -other.excess)
    }
}

impl Watch {
    /// Makes a guard ready to work.
    ///
    /// # Panics
    /// For a guard that [`Guard::check`] refuses.
    pub fn new(guard: Arc<Guard>) -> Self {
        #[expect(clippy::expect_used, reason = "a guard that was fitted or checked has a shape")]
        let places = guard.places().expect("a guard of a shape");
        let links = guard.table(&places);
        let elements = places.elements;
        let (mut predicts, mut is_constant) = (vec![vec![]; elements], vec![false; elements]);
        guard.constant.iter().for_each(|element| is_constant[*element] = true);
        for (element, links) in links.iter().enumerate() {
            links.iter().for_each(|link| predicts[link.from].push(element));
        }
        let most = ((elements as f64 * MOST) as usize).max(1);
        Self {
            known: Known { guard, places, links, predicts, is_constant },
            most,
            ranking: Ranking::new(elements),
            is_broken: vec![false; elements],
            found: Vec::with_capacity(most),
        }
    }

    /// Returns the guard.
    pub fn guard(&self) -> &Guard {
        &self.known.guard
    }

    /// Returns the elements that were replaced in the last sample.
    pub fn found(&self) -> &[ReplacedElement] {
        &self.found
    }

    /// Replaces the values of broken elements of one row-major sample by the predictions of their neighbours, or, where all of
    /// those are broken, by their mean in training. Returns the elements, the surest first. A sample of another length, or
    /// with a value that is not finite, stays as it is.
    pub fn mend(&mut self, sample: &mut [f32]) -> &[ReplacedElement] {
        let Self { known, most, ranking, is_broken, found } = self;
        found.clear();
        if sample.len() != known.places.len() || sample.iter().any(|value| !value.is_finite()) {
            return found;
        }
        is_broken.fill(false);
        ranking.fill(Suspicion::is_before, |element| known.suspicion(element, sample, is_broken));
        while let Some((element, Suspicion { kind, .. })) = ranking.first().filter(|_| found.len() < *most) {
            found.push(ReplacedElement { element, kind });
            is_broken[element] = true;
            ranking.set(element, None, Suspicion::is_before);
            for &other in known.predicts[element].iter().filter(|other| !is_broken[**other]) {
                ranking.set(other, known.suspicion(other, sample, is_broken), Suspicion::is_before);
            }
        }
        let Known { guard, places, links, .. } = known;
        for ReplacedElement { element, .. } in &*found {
            for time in 0..places.times {
                let value = predicted(guard, places, &links[*element], (*element, time), sample, is_broken);
                sample[places.at(*element, time)] = value.unwrap_or(guard.mean[*element]);
            }
        }
        found
    }
}

impl Known {
    /// Says why an element is broken, if it is: of several reasons the rarest.
    fn suspicion(&self, element: usize, sample: &[f32], is_broken: &[bool]) -> Option<Suspicion> {
        if self.is_constant[element] {
            return None;
        }
        let Self { guard, places, links, .. } = self;
        // With fewer neighbours the residual may be larger.
        let (all, sound) =
            (&links[element], links[element].iter().filter(|link| !is_broken[link.from]).count());
        let allowed = all.len().max(1) as f64 / sound.max(1) as f64;
        let residual = residual(guard, places, all, element, sample, is_broken)
            .map(|residual| residual / f64::from(of_element(&guard.scale, element)) / allowed);
        let is_of = kinds(guard, places, element, sample);
        let mut surest: Option<Suspicion> = None;
        for (at, kind) in BrokenKind::ALL.into_iter().enumerate().filter(|(at, _)| is_of[*at]) {
            let bound = f64::from(of_element(&guard.bounds[at], element));
            let excess = match residual {
                _ if bound == 0.0 => f64::INFINITY,
                Some(residual) => residual / bound,
                None => continue,
            };
            let suspicion = Suspicion { share: of_element(&guard.shares[at], element), excess, kind };
            if excess > 1.0 && surest.is_none_or(|surest| suspicion.is_before(&surest)) {
                surest = Some(suspicion);
            }
        }
        surest
    }
}
