//! The judge of contact: whether the sensor touches something.
//!
//! # Reference
//!
//! Zhang et al. 2022, section 3.1: contact is where a value is more than 1.1 or less than 0.9 times what it was, as
//! [`NumaTac::touches`] has it. There the judge compares neighbouring values at 2200 Hz; a stream may be slower, and a
//! press too slow for that, so that a value is compared with the level at rest here, and contact ends where all values
//! are back within half of the thresholds (hysteresis), which the paper does not say.

use taxel_data::{Layout, SampleSpec};
use taxel_encodings::NumaTac;

/// Time steps whose mean is the level at rest where it is not known.
const REST: u32 = 20;
/// Time steps in which the level at rest follows a drift.
pub(crate) const FOLLOWED: f64 = 1000.0;
/// The least level that thresholds are taken of, as a share of full scale: a tenth of a rest of 0 is nothing.
const FLOOR: f32 = 0.05;

/// Judges by each time step whether the sensor touches something.
#[derive(Debug, Clone)]
pub struct Contact {
    on: NumaTac,
    off: NumaTac,
    /// Level at rest of each value of a time step; the mean of those seen so far until [`REST`] are.
    rest: Vec<f64>,
    seen: u32,
    /// Level at rest at the beginning, where it is known.
    known_rest: Option<Vec<f64>>,
    floor: f64,
    /// Which values are judged.
    judged: Vec<bool>,
    touching: bool,
}

impl Contact {
    /// Makes a judge of time steps of this kind. `thresholds` are those of an encoding that has a contact judge; of its fingers the
    /// first feature (DC) is not judged. `full_scale` is the largest possible value.
    pub fn new(spec: &SampleSpec, thresholds: Option<NumaTac>, full_scale: Option<f32>) -> Self {
        let (before, _, after) = spec.around_time();
        let each = before * after;
        let on = thresholds.unwrap_or_default();
        let off = NumaTac { above: (1.0 + on.above) / 2.0, below: (1.0 + on.below) / 2.0, ..on };
        let features = match (spec.layout, spec.shape.as_slice()) {
            (Layout::Fingers, [_, features, _]) if thresholds.is_some() => *features,
            _ => 0,
        };
        let known_rest = spec.rest.as_ref().and_then(|rest| match rest.as_slice() {
            [one] => Some(vec![f64::from(*one); each]),
            several if several.len() == each => Some(several.iter().map(|v| f64::from(*v)).collect()),
            _ => None,
        });
        let floor = full_scale.map_or(0.0, |full| f64::from(FLOOR * full));
        let judged = (0..each).map(|at| features < 2 || at % features > 0).collect();
        let mut contact =
            Contact { on, off, rest: vec![0.0; each], seen: 0, known_rest, floor, judged, touching: false };
        contact.begin();
        contact
    }

    /// Forgets everything: another recording begins.
    pub fn begin(&mut self) {
        (self.touching, self.seen) = (false, 0);
        self.rest.fill(0.0);
        if let Some(known_rest) = &self.known_rest {
            self.rest.copy_from_slice(known_rest);
            self.seen = REST;
        }
    }

    /// Forgets that something is touched: time steps are missing.
    pub fn let_go(&mut self) {
        self.touching = false;
    }

    /// Checks whether something is touched.
    pub fn is_touching(&self) -> bool {
        self.touching
    }

    /// Checks whether any value has a level at rest that thresholds can be taken of; known from the first time steps on.
    pub fn can_judge(&self) -> bool {
        let level = |(rest, judged): (&f64, &bool)| *judged && rest.max(self.floor) > 0.0;
        self.seen < REST || self.rest.iter().zip(&self.judged).any(level)
    }

    /// Takes a time step; returns whether contact begins with it. While the level at rest is not known, none does.
    pub fn push(&mut self, reading: &[f32]) -> bool {
        if self.seen < REST {
            self.seen += 1;
            let share = 1.0 / f64::from(self.seen);
            self.follow(reading, share);
            return false;
        }
        let judge = if self.touching { self.off } else { self.on };
        let values = self.rest.iter().zip(&self.judged).zip(reading);
        let touches = values.filter(|((_, judged), _)| **judged).any(|((rest, _), value)| {
            // At the least level, a value is as far above it as it is above its own rest.
            let level = rest.max(self.floor);
            judge.touches(level as f32, (level + f64::from(*value) - rest) as f32)
        });
        let begins = touches && !self.touching;
        self.touching = touches;
        if !touches {
            self.follow(reading, 1.0 / FOLLOWED);
        }
        begins
    }

    /// Moves the level at rest of each value towards this one. A level of 0 has been learned as what no threshold can be
    /// taken of, and stays: a press would become its rest.
    fn follow(&mut self, reading: &[f32], share: f64) {
        let learned = self.seen >= REST && share < 1.0 / f64::from(REST);
        for (rest, value) in self.rest.iter_mut().zip(reading) {
            if !learned || rest.max(self.floor) > 0.0 {
                *rest += share * (f64::from(*value) - *rest);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(channels: usize) -> SampleSpec {
        SampleSpec::new(Layout::Series, &[channels, 10])
    }

    /// Returns where contact begins, and whether each time step is one of contact.
    fn judged(contact: &mut Contact, readings: &[f32]) -> (Vec<usize>, Vec<bool>) {
        let mut begins = vec![];
        let mut touching = vec![];
        for (at, value) in readings.iter().enumerate() {
            begins.extend(contact.push(&[*value]).then_some(at));
            touching.push(contact.is_touching());
        }
        (begins, touching)
    }

    #[test]
    fn contact_begins_at_the_papers_thresholds_and_ends_at_half_of_them() {
        let mut contact = Contact::new(&series(1), None, None);
        assert!(judged(&mut contact, &[100.0; 20]).0.is_empty());
        // 1.1 and 0.9 themselves are none; once begun it holds above 1.05 and below 0.95.
        let (begins, touching) =
            judged(&mut contact, &[109.0, 111.0, 107.0, 106.0, 104.0, 107.0, 100.0, 89.0, 94.0, 96.0]);
        assert_eq!(begins, [1, 7]);
        assert_eq!(touching, [false, true, true, true, false, false, false, true, true, false]);
    }

    #[test]
    fn rest_is_followed_slowly_and_not_during_contact() {
        let mut contact = Contact::new(&series(1), None, None);
        let drift: Vec<f32> = (0..20_000).map(|t| 100.0 * (1.0 + t as f32 / 20_000.0)).collect();
        assert!(judged(&mut contact, &drift).0.is_empty(), "twice the level, but slowly");
        assert_eq!(judged(&mut contact, &[300.0; 5000]), (vec![0], vec![true; 5000]));
    }

    #[test]
    fn a_rest_of_zero_needs_a_full_scale() {
        let mut blind = Contact::new(&series(1), None, None);
        assert!(blind.can_judge());
        assert!(judged(&mut blind, &[0.0; 30]).0.is_empty());
        assert!(judged(&mut blind, &[500.0; 3]).0.is_empty() && !blind.can_judge());
        let mut contact = Contact::new(&series(1), None, Some(1000.0));
        assert!(judged(&mut contact, &[0.0; 30]).0.is_empty());
        // A tenth of 5 % of full scale.
        assert_eq!(judged(&mut contact, &[4.9, 5.1]).0, [1]);
        let mut known_rest = Contact::new(&SampleSpec { rest: Some(vec![100.0]), ..series(1) }, None, None);
        assert_eq!(judged(&mut known_rest, &[111.0]).0, [0], "nothing is to be learned");
        known_rest.begin();
        assert_eq!(judged(&mut known_rest, &[89.0]).0, [0]);
    }

    #[test]
    fn of_fingers_with_thresholds_of_their_own_dc_is_not_judged() {
        let spec = SampleSpec::new(Layout::Fingers, &[2, 2, 10]);
        let thresholds = NumaTac { above: 1.5, ..NumaTac::default() };
        let mut contact = Contact::new(&spec, Some(thresholds), None);
        (0..20).for_each(|_| assert!(!contact.push(&[100.0; 4])));
        assert!(!contact.push(&[200.0, 140.0, 200.0, 100.0]));
        assert!(contact.push(&[100.0, 100.0, 100.0, 160.0]));
        let mut plain = Contact::new(&spec, None, None);
        (0..20).for_each(|_| assert!(!plain.push(&[100.0; 4])));
        assert!(plain.push(&[200.0, 100.0, 100.0, 100.0]));
    }
}
