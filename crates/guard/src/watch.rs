//! A guard at work: broken elements of one sample after another, found and replaced.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::guard::{Guard, Kind, Link, own};
use crate::limits::MOST;
use crate::places::Places;
use crate::ranking::Ranking;
use crate::window::{kinds, residual, said};

/// An element that was replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Found {
    /// Which one; [`Guard::name`] says what it is called.
    pub element: usize,
    /// How it is known to be broken.
    pub kind: Kind,
}

/// A guard with the memory that it needs: each thread has its own. Nothing is allocated while it works.
#[derive(Debug, Clone)]
pub struct Watch {
    known: Known,
    most: usize,
    // Of the sample.
    ranking: Ranking<Suspicion>,
    is_broken: Vec<bool>,
    found: Vec<Found>,
}

/// What does not change from sample to sample.
#[derive(Debug, Clone)]
struct Known {
    guard: Arc<Guard>,
    places: Places,
    /// What is said of each element, and of whom each speaks.
    links: Vec<Vec<Link>>,
    hears: Vec<Vec<usize>>,
    is_constant: Vec<bool>,
}

/// Why an element is taken for broken.
#[derive(Debug, Clone, Copy)]
struct Suspicion {
    /// Of training windows that are of its kind: the rarer, the surer.
    share: f32,
    /// Residual by its bound, above 1.
    excess: f64,
    kind: Kind,
}

impl Suspicion {
    /// Whether it is the surer of two.
    fn is_before(&self, other: &Self) -> bool {
        (self.share, -self.excess) < (other.share, -other.excess)
    }
}

impl Watch {
    /// A guard ready to work.
    ///
    /// # Panics
    /// For a guard that [`Guard::check`] refuses.
    pub fn new(guard: Arc<Guard>) -> Self {
        #[expect(clippy::expect_used, reason = "a guard that was fitted or checked has a shape")]
        let places = guard.places().expect("a guard of a shape");
        let links = guard.table(&places);
        let elements = places.elements;
        let (mut hears, mut is_constant) = (vec![vec![]; elements], vec![false; elements]);
        guard.constant.iter().for_each(|element| is_constant[*element] = true);
        for (element, links) in links.iter().enumerate() {
            links.iter().for_each(|link| hears[link.from].push(element));
        }
        let most = ((elements as f64 * MOST) as usize).max(1);
        Self {
            known: Known { guard, places, links, hears, is_constant },
            most,
            ranking: Ranking::new(elements),
            is_broken: vec![false; elements],
            found: Vec::with_capacity(most),
        }
    }

    /// The guard.
    pub fn guard(&self) -> &Guard {
        &self.known.guard
    }

    /// What was found in the last sample.
    pub fn found(&self) -> &[Found] {
        &self.found
    }

    /// Replaces what broken elements of one row-major sample read by what their neighbours say, or, where all of those
    /// are broken, by their mean in training; says which, the surest first. A sample of another length, or with a
    /// reading that is not finite, stays as it is.
    pub fn mend(&mut self, sample: &mut [f32]) -> &[Found] {
        let Self { known, most, ranking, is_broken, found } = self;
        found.clear();
        if sample.len() != known.places.len() || sample.iter().any(|value| !value.is_finite()) {
            return found;
        }
        is_broken.fill(false);
        ranking.fill(Suspicion::is_before, |element| known.suspicion(element, sample, is_broken));
        while let Some((element, Suspicion { kind, .. })) = ranking.first().filter(|_| found.len() < *most) {
            found.push(Found { element, kind });
            is_broken[element] = true;
            ranking.set(element, None, Suspicion::is_before);
            for &other in known.hears[element].iter().filter(|other| !is_broken[**other]) {
                ranking.set(other, known.suspicion(other, sample, is_broken), Suspicion::is_before);
            }
        }
        let Known { guard, places, links, .. } = known;
        for Found { element, .. } in &*found {
            for time in 0..places.times {
                let said = said(guard, places, &links[*element], (*element, time), sample, is_broken);
                sample[places.at(*element, time)] = said.unwrap_or(guard.mean[*element]);
            }
        }
        found
    }
}

impl Known {
    /// Why an element is broken, if it is: of several reasons the rarest.
    fn suspicion(&self, element: usize, sample: &[f32], is_broken: &[bool]) -> Option<Suspicion> {
        if self.is_constant[element] {
            return None;
        }
        let Self { guard, places, links, .. } = self;
        // Fewer neighbours know less.
        let (all, sound) =
            (&links[element], links[element].iter().filter(|link| !is_broken[link.from]).count());
        let allowed = all.len().max(1) as f64 / sound.max(1) as f64;
        let residual = residual(guard, places, all, element, sample, is_broken)
            .map(|residual| residual / f64::from(own(&guard.scale, element)) / allowed);
        let is_of = kinds(guard, places, element, sample);
        let mut surest: Option<Suspicion> = None;
        for (at, kind) in Kind::ALL.into_iter().enumerate().filter(|(at, _)| is_of[*at]) {
            let bound = f64::from(own(&guard.bounds[at], element));
            let excess = match residual {
                _ if bound == 0.0 => f64::INFINITY,
                Some(residual) => residual / bound,
                None => continue,
            };
            let own = Suspicion { share: own(&guard.shares[at], element), excess, kind };
            if excess > 1.0 && surest.is_none_or(|surest| own.is_before(&surest)) {
                surest = Some(own);
            }
        }
        surest
    }
}
