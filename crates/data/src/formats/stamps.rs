//! The rule for time stamps, of all readers alike.
//!
//! Of time steps with one stamp the first is kept; the others are dropped and counted. Up to a tenth of a recording may
//! repeat a stamp, and one time step always may. A counter that wraps goes on. Time that goes back is refused.

use crate::error::plural;
use std::fmt::{self, Display, Formatter};

/// A recording may drop one in so many time steps for their stamps.
const REPEATED: usize = 10;
/// Most times the longest step so far that the step over a wrap may take.
const LONGER: f64 = 4.0;
/// A step over a wrap takes less than one in so many of the range of the counter.
const SHARE: f64 = 64.0;
/// Smallest and largest step over a wrap of 16 bits, in the longest so far, of a steady clock: so short a counter may be another recording.
const ALIKE: std::ops::RangeInclusive<f64> = 0.75..=1.25;

/// Ranges of counters of microseconds or milliseconds in boards, in their unit and in the larger ones.
const WRAPS: [(f64, u32); 4] = [(U32, 32), (U32 / 1e3, 32), (U32 / 1e6, 32), (65536.0, 16)];
const U32: f64 = 4294967296.0;

/// Counts of the stamps of some recordings that were mended, for the card.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Mended {
    /// Time steps, those that were dropped included.
    pub steps: usize,
    /// Time steps that were dropped.
    pub repeated: usize,
    /// Times that a counter wrapped.
    pub wraps: usize,
}

impl Mended {
    /// Adds what was done about another recording.
    pub fn add(&mut self, other: Self) {
        self.steps += other.steps;
        self.repeated += other.repeated;
        self.wraps += other.wraps;
    }

    /// Says that too many time steps of a recording repeat a stamp.
    pub fn checked(self) -> Result<Self, String> {
        let Self { steps, repeated, .. } = self;
        if repeated == 0 || steps - repeated > 1 && (repeated == 1 || repeated * REPEATED <= steps) {
            return Ok(self);
        }
        Err(format!("{repeated} of the {steps} time steps"))
    }

    /// Says what was done; nothing where nothing was.
    pub fn said(&self) -> Vec<String> {
        let Self { steps, repeated, wraps } = *self;
        let (repeats, is) = if repeated == 1 { ("repeats", "is") } else { ("repeat", "are") };
        let dropped = format!(
            "{repeated} of {} {repeats} the stamp before it and {is} dropped",
            plural(steps, "time step")
        );
        let wrapped = format!("the counter of time wraps {} and is unwrapped", times(wraps));
        [(repeated, dropped), (wraps, wrapped)]
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(_, said)| said)
            .collect()
    }
}

fn times(count: usize) -> String {
    if count == 1 { "once".into() } else { format!("{count} times") }
}

/// The stamp of a time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stamp {
    /// Later than that before, in the units of the clock; of a counter that has wrapped as if it had not.
    Later(f64),
    /// That of the time step before: drop this one.
    Repeated,
}

/// Watches the stamps of one recording, in the units of its clock.
#[derive(Debug, Clone, Default)]
pub(crate) struct StampRule {
    first: Option<f64>,
    /// As it was written.
    last: f64,
    /// Added to stamps after a counter has wrapped.
    offset: f64,
    /// Shortest and longest step so far.
    steps: Option<(f64, f64)>,
    mended: Mended,
}

impl StampRule {
    /// Takes the next stamp, or says why there is none like it: the words follow the name of the recording.
    pub fn push(&mut self, stamp: f64) -> Result<Stamp, String> {
        let Some(first) = self.first else {
            (self.first, self.last, self.mended.steps) = (Some(stamp), stamp, 1);
            return Ok(Stamp::Later(stamp));
        };
        let step = stamp - self.last;
        if step == 0.0 {
            self.mended.steps += 1;
            self.mended.repeated += 1;
            return Ok(Stamp::Repeated);
        }
        let step = if step > 0.0 { step } else { self.unwrapped(first, stamp)? };
        self.mended.steps += 1;
        let (shortest, longest) = self.steps.unwrap_or((step, step));
        self.steps = Some((shortest.min(step), longest.max(step)));
        self.last = stamp;
        Ok(Stamp::Later(stamp + self.offset))
    }

    /// Returns the step to a stamp that falls, where it is a counter that wraps.
    fn unwrapped(&mut self, first: f64, stamp: f64) -> Result<f64, String> {
        let (from, to) = (Plain(self.last), Plain(stamp));
        for (range, bits) in WRAPS {
            let step = stamp + range - self.last;
            if stamp < 0.0 || self.last >= range {
                continue;
            }
            let is_likely = match self.steps {
                Some((shortest, longest)) if bits == 16 => {
                    longest <= shortest * 2.0 && ALIKE.contains(&(step / longest))
                }
                Some((_, longest)) => step <= longest * LONGER && step * SHARE <= range,
                None => bits == 32 && step * SHARE <= range,
            };
            if is_likely {
                self.offset += range;
                self.mended.wraps += 1;
                return Ok(step);
            }
            // Close below its range it is a counter of many bits, whatever was lost there.
            if bits == 32 && self.last > 0.999 * range {
                return Err(format!(
                    "goes from {from} to {to}: a counter of 32 bits has wrapped there, in a gap; cut the recording in two at \
                     this place, or write its time with 64 bits"
                ));
            }
        }
        if stamp <= first {
            return Err(format!(
                "begins again: its time goes from {from} to {to}; give each of the two recordings a name of its own"
            ));
        }
        Err(format!(
            "has a time that goes back, from {from} to {to}; keep rows in the order in which they were recorded, and where \
             the clock was set begin another recording"
        ))
    }

    /// Returns what was done, or says that too many stamps repeat.
    pub fn finish(&self) -> Result<Mended, String> {
        self.mended.checked()
    }
}

/// Ends the words of [`Mended::checked`], after the name of a recording.
pub(crate) const TOO_MANY: &str =
    "repeat the stamp before them, more than one in ten: the clock is too coarse";

/// A number in a message: never hundreds of digits.
pub(crate) struct Plain(pub f64);

impl Display for Plain {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        match f.precision() {
            _ if size != 0.0 && !(1e-6..1e15).contains(&size) => write!(f, "{:.3e}", self.0),
            Some(digits) => write!(f, "{:.digits$}", self.0),
            None => write!(f, "{}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(stamps: &[f64]) -> Result<(Vec<f64>, Mended), String> {
        let mut rule = StampRule::default();
        let mut kept = vec![];
        for stamp in stamps {
            if let Stamp::Later(stamp) = rule.push(*stamp)? {
                kept.push(stamp);
            }
        }
        Ok((kept, rule.finish()?))
    }

    #[test]
    fn counters_go_on_where_they_wrap() {
        let (kept, mended) = read(&[U32 - 2000.0, U32 - 1000.0, 0.0, 1000.0]).unwrap();
        assert_eq!(kept, [U32 - 2000.0, U32 - 1000.0, U32, U32 + 1000.0]);
        assert_eq!((mended.wraps, mended.repeated), (1, 0));
        assert_eq!(read(&[U32 - 500.0, 500.0]).unwrap().1.wraps, 1, "before any step is known");
        let twice: Vec<f64> = (0..14).map(|i| f64::from(i * 10_000 % 65_536)).collect();
        let (kept, mended) = read(&twice).unwrap();
        assert_eq!((kept[13], mended.wraps), (130_000.0, 1));
        assert_eq!(
            Mended { wraps: 2, ..mended }.said(),
            ["the counter of time wraps 2 times and is unwrapped"]
        );
    }

    #[test]
    fn a_recording_that_begins_again_is_no_counter_that_wraps() {
        for (stamps, why) in [
            (vec![0.0, 10.0, 65_500.0, 0.0], "begins again"),
            (vec![0.0, 1000.0, 2000.0, 0.0], "begins again"),
            (vec![5.0, 6.0, 7.0, 6.5], "goes back, from 7 to 6.5"),
            (vec![1.0, U32 - 2.0, 9e8], "a counter of 32 bits has wrapped"),
            (vec![1e300, 0.0], "from 1.000e300 to 0"),
        ] {
            let message = read(&stamps).unwrap_err();
            assert!(message.contains(why) && !message.contains("sort"), "{message}");
        }
    }

    #[test]
    fn a_tenth_of_the_stamps_may_repeat() {
        let (kept, mended) = read(&[0.0, 1.0, 1.0, 2.0]).unwrap();
        assert_eq!((kept, mended.repeated), (vec![0.0, 1.0, 2.0], 1));
        assert_eq!(mended.said(), ["1 of 4 time steps repeats the stamp before it and is dropped"]);
        let two: Vec<f64> = [&[0.0, 0.0, 1.0, 1.0][..], &(2..18).map(f64::from).collect::<Vec<_>>()].concat();
        assert_eq!(read(&two).unwrap().1.repeated, 2);
        assert_eq!(read(&two[..19]).unwrap_err(), "2 of the 19 time steps");
        assert_eq!(read(&[3.0, 3.0]).unwrap_err(), "1 of the 2 time steps");
    }

    #[test]
    fn numbers_of_messages_are_short() {
        let text = |value| format!("{}", Plain(value));
        assert_eq!(
            [text(0.25), text(1e300), text(-1e-9), text(0.0)],
            ["0.25", "1.000e300", "-1.000e-9", "0"]
        );
        assert_eq!(format!("{:.1}", Plain(2.25)), "2.2");
    }
}
