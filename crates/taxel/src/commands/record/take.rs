//! One recording: time steps at rest, then those of the touch, brought to equal steps.

use std::time::{Duration, Instant};

use taxel::data::interpolate;
use taxel::stream::Arrival;

/// Largest distance of a time stamp from equal steps, as a share of a step, that is left as it is. Readers of recordings take 0.2
/// from the earliest to the latest.
const JITTER: f64 = 0.1;
/// A step this many times as long as the others is a gap.
const GAP: f64 = 1.5;
/// Share of the time steps that may be missing where time stamps say where.
const MISSING: f64 = 0.05;
/// Share of the time steps that may repeat a stamp.
const REPEATED: f64 = 0.1;
/// Share by which the time that a recording took may differ from its length, where no time stamps say more, and seconds that
/// buffers may hold readings back.
const LATE: (f64, f64) = (0.1, 0.15);

/// The time steps that every recording of a set has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// Time steps, those at rest included.
    pub rows: usize,
    /// The first of them that are at rest.
    pub rest: usize,
    /// Time steps per second (Hz).
    pub rate: f64,
    /// Time steps bear time stamps; otherwise they are counted.
    pub is_stamped: bool,
    /// Time steps arrive when they are measured, so that their arrival shows whether all have come.
    pub is_live: bool,
}

/// A recording, complete.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// Seconds since its first time step.
    pub times: Vec<f64>,
    /// Time step after time step.
    pub values: Vec<f32>,
    /// Time steps that were missing, and were filled between their neighbours.
    pub missing: usize,
    /// Time stamps were uneven: values are interpolated at equal steps.
    pub is_evened: bool,
}

/// How a recording goes on.
#[derive(Debug, PartialEq)]
pub enum Progress {
    /// More time steps are to come.
    Going,
    /// The last time step at rest has come.
    Rested,
    /// It is complete.
    Done(Taken),
    /// It will not be complete: why.
    Broken(String),
}

/// A recording under way.
pub struct Take {
    schedule: Schedule,
    times: Vec<f64>,
    values: Vec<f32>,
    repeated: usize,
    began: Option<Instant>,
    last: Option<Instant>,
}

impl Take {
    pub fn new(schedule: Schedule) -> Self {
        Take { schedule, times: vec![], values: vec![], repeated: 0, began: None, last: None }
    }

    /// Counts the time steps that have come.
    pub fn rows(&self) -> usize {
        self.times.len()
    }

    /// Takes a time step of `values` in the order of the set.
    pub fn push(&mut self, arrival: &Arrival, values: &[f32]) -> Progress {
        if arrival.lost > 0 && self.began.is_some() {
            return Progress::Broken(format!(
                "{} readings were lost, this computer was too slow",
                arrival.lost
            ));
        }
        // Where time is counted, nobody would see that one is missing.
        if arrival.skipped > 0 && self.began.is_some() && !self.schedule.is_stamped {
            return Progress::Broken(format!("{} lines were no readings", arrival.skipped));
        }
        self.began.get_or_insert(arrival.at);
        self.last = Some(arrival.at);
        let before = self.times.len();
        if self.schedule.is_stamped {
            match (arrival.stamp, self.times.last()) {
                (None, _) => return Progress::Broken("a reading has no time stamp".into()),
                (Some(stamp), Some(last)) if stamp == *last => {
                    self.repeated += 1;
                    let too_many = self.repeated as f64 > REPEATED * self.schedule.rows as f64;
                    let why =
                        "more than one reading in ten repeats the time stamp before it: write finer stamps";
                    return if too_many { Progress::Broken(why.into()) } else { Progress::Going };
                }
                (Some(stamp), Some(last)) if stamp < *last => {
                    return Progress::Broken(format!(
                        "the clock of the sensor went back by {:.3} s",
                        last - stamp
                    ));
                }
                (Some(stamp), _) => self.times.push(stamp),
            }
        } else {
            self.times.push(before as f64 / self.schedule.rate);
        }
        self.values.extend_from_slice(values);
        if self.is_complete() {
            return self.finish();
        }
        if before + 1 == self.schedule.rest { Progress::Rested } else { Progress::Going }
    }

    /// Returns the seconds since the last time step came.
    pub fn silence(&self) -> Option<Duration> {
        self.last.map(|last| last.elapsed())
    }

    fn is_complete(&self) -> bool {
        let Schedule { rows, rate, is_stamped, .. } = self.schedule;
        let span = self.times.last().zip(self.times.first()).map_or(0.0, |(last, first)| last - first);
        if is_stamped { span * rate >= (rows - 1) as f64 - JITTER } else { self.times.len() >= rows }
    }

    fn finish(&mut self) -> Progress {
        let Schedule { rows, rate, is_stamped, is_live, .. } = self.schedule;
        if !is_stamped {
            let took = self.began.zip(self.last).map_or(0.0, |(began, last)| (last - began).as_secs_f64());
            let wanted = (rows - 1) as f64 / rate;
            if is_live && (took - wanted).abs() > (LATE.0 * wanted).max(LATE.1) {
                let found = (rows - 1) as f64 / took;
                return Progress::Broken(format!(
                    "its readings came at {found:.3} Hz, and those of the set at {rate} Hz"
                ));
            }
            let (times, values) = (std::mem::take(&mut self.times), std::mem::take(&mut self.values));
            return Progress::Done(Taken { times, values, missing: 0, is_evened: false });
        }
        let steps = self.times.windows(2).map(|pair| (pair[1] - pair[0]) * rate);
        let missing: usize = steps.filter(|step| *step > GAP).map(|step| step.round() as usize - 1).sum();
        if missing as f64 > MISSING * rows as f64 {
            return Progress::Broken(format!("{missing} of {rows} readings are missing"));
        }
        let first = self.times[0];
        self.times.iter_mut().for_each(|time| *time = (1e9 * (*time - first)).round() / 1e9);
        let is_even = self.times.len() == rows
            && self.times.iter().enumerate().all(|(i, time)| (time * rate - i as f64).abs() <= JITTER);
        Progress::Done(if is_even {
            let (times, values) = (std::mem::take(&mut self.times), std::mem::take(&mut self.values));
            Taken { times, values, missing, is_evened: false }
        } else {
            self.evened(missing)
        })
    }

    /// Interpolates at equal steps from the first time step on.
    fn evened(&self, missing: usize) -> Taken {
        let Schedule { rows, rate, .. } = self.schedule;
        let channels = self.values.len() / self.times.len();
        let times: Vec<f64> = (0..rows).map(|i| i as f64 / rate).collect();
        let mut values = Vec::with_capacity(rows * channels);
        interpolate(&self.times, &self.values, channels, times.iter().copied(), &mut values);
        Taken { times, values, missing, is_evened: true }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;

    const STAMPED: Schedule = Schedule { rows: 20, rest: 5, rate: 100.0, is_stamped: true, is_live: true };

    /// Takes time steps of these stamps, whose value is the time in steps; they come when they are due.
    fn take(schedule: Schedule, stamps: impl Iterator<Item = f64>) -> (Vec<Progress>, usize) {
        let (mut take, begin) = (Take::new(schedule), Instant::now());
        let mut came = vec![];
        for stamp in stamps {
            let at = begin + Duration::from_secs_f64(stamp.max(0.0));
            let arrival = Arrival { values: vec![], stamp: Some(stamp), at, lost: 0, skipped: 0 };
            let value = [(stamp * 100.0) as f32, 7.0];
            match take.push(&arrival, &value) {
                Progress::Going => {}
                end @ (Progress::Done(_) | Progress::Broken(_)) => {
                    came.push(end);
                    break;
                }
                rested => came.push(rested),
            }
        }
        (came, take.rows())
    }

    fn done(schedule: Schedule, stamps: impl Iterator<Item = f64>) -> Taken {
        match take(schedule, stamps).0.pop() {
            Some(Progress::Done(taken)) => taken,
            other => panic!("{other:?}"),
        }
    }

    fn broken(schedule: Schedule, stamps: impl Iterator<Item = f64>) -> String {
        match take(schedule, stamps).0.pop() {
            Some(Progress::Broken(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    fn even() -> impl Iterator<Item = f64> {
        (0..1000).map(|i| f64::from(i) / 100.0)
    }

    #[test]
    fn a_recording_has_its_rows_and_says_when_the_rest_is_over() {
        let (came, _) = take(STAMPED, even());
        assert_eq!(came.len(), 2);
        assert_eq!(came[0], Progress::Rested);
        let taken = done(STAMPED, even());
        assert_eq!((taken.times.len(), taken.values.len(), taken.is_evened), (20, 40, false));
        assert_eq!((taken.times[7], taken.values[14]), (0.07, 7.0));
        let counted = Schedule { is_stamped: false, ..STAMPED };
        assert_eq!(done(counted, even()).times, taken.times);
    }

    #[test]
    fn uneven_stamps_become_equal_steps_of_the_same_number() {
        for (wobble, lost) in [(0.4, None), (0.0, Some(9)), (0.3, Some(18)), (0.45, Some(0))] {
            let stamp = |i: u32| (f64::from(i) + wobble * f64::from(i % 3) / 2.0) / 100.0;
            let taken = done(STAMPED, (0..60).filter(|i| Some(*i) != lost).map(stamp));
            assert!(taken.is_evened || wobble == 0.0 && lost.is_none());
            assert_eq!((taken.times.len(), taken.values.len()), (20, 40), "{wobble} {lost:?}");
            let first = taken.values[0];
            for (i, pair) in taken.values.chunks_exact(2).enumerate() {
                // A line stays a line.
                assert!((pair[0] - first - i as f32).abs() < 0.11 && pair[1] == 7.0, "{wobble} {lost:?} {i}");
            }
        }
    }

    #[test]
    fn what_is_not_whole_is_refused() {
        assert!(broken(STAMPED, even().filter(|t| !(0.05..0.08).contains(t))).contains("3 of 20"));
        assert!(broken(STAMPED, [0.0, 0.01, 0.005].into_iter()).contains("went back"));
        assert!(broken(STAMPED, [0.0; 9].into_iter()).contains("finer stamps"));
        let counted = Schedule { is_stamped: false, rows: 100, ..STAMPED };
        assert!(broken(counted, even().map(|t| 2.0 * t)).contains("came at 50"), "half of them were lost");
        assert_eq!(done(Schedule { is_live: false, ..counted }, even().map(|t| 2.0 * t)).times.len(), 100);
        let mut take = Take::new(counted);
        let arrival = |lost| Arrival { values: vec![], stamp: None, at: Instant::now(), lost, skipped: 0 };
        assert_eq!(take.push(&arrival(3), &[1.0]), Progress::Going, "lost before it began");
        assert!(
            matches!(take.push(&arrival(2), &[1.0]), Progress::Broken(why) if why.contains("2 readings"))
        );
        let skipped = Arrival { skipped: 1, ..arrival(0) };
        assert!(matches!(take.push(&skipped, &[1.0]), Progress::Broken(why) if why.contains("no readings")));
    }
}
