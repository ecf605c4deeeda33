//! Events that were found, over the time steps of recordings.

use taxel_data::TargetSteps;

use crate::metrics::quantile;

/// Events of recordings that were found or missed, and alarms where there was none.
///
/// An event is a run of time steps that are events, and a false alarm a run of steps that are called an event and are
/// none. Runs end with the recording.
///
/// ```
/// use taxel_data::TargetSteps;
/// use taxel_learn::metrics::Detections;
///
/// let steps = TargetSteps { recordings: vec![0; 6], steps: (4..10).collect(), hop: 1, rate: Some(10.0) };
/// let is_event = [false, false, true, true, true, false];
/// let is_called = [true, false, false, true, true, false];
/// let found = Detections::of(&is_event, &is_called, &steps);
/// assert_eq!((found.delay(), found.missed(), found.false_alarms()), (Some(1.0), 0, 1));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Detections {
    /// Of each event that was found, steps from its start, ascending.
    delays: Vec<u32>,
    missed: usize,
    false_alarms: usize,
    steps: u64,
}

impl Detections {
    /// Compares samples that are events with those that are called one, recording after recording in the order of their steps.
    pub fn of(is_event: &[bool], is_called: &[bool], at: &TargetSteps) -> Self {
        let mut order: Vec<usize> = (0..is_event.len()).collect();
        order.sort_by_key(|row| (at.recordings[*row], at.steps[*row]));
        let steps = order.len() as u64 * u64::from(at.hop);
        let mut found = Detections { delays: vec![], missed: 0, false_alarms: 0, steps };
        for recording in order.chunk_by(|a, b| at.recordings[*a] == at.recordings[*b]) {
            for run in recording.chunk_by(|a, b| is_event[*a] == is_event[*b]) {
                if !is_event[run[0]] {
                    let alarms = run.chunk_by(|a, b| is_called[*a] == is_called[*b]);
                    found.false_alarms += alarms.filter(|alarm| is_called[alarm[0]]).count();
                } else if let Some(row) = run.iter().find(|row| is_called[**row]) {
                    found.delays.push(at.steps[*row] - at.steps[run[0]]);
                } else {
                    found.missed += 1;
                }
            }
        }
        found.delays.sort_unstable();
        found
    }

    /// Returns the median over the events that were found of the steps from the start of an event to the first one that is
    /// called so. None where none was found.
    pub fn delay(&self) -> Option<f64> {
        let delays: Vec<f64> = self.delays.iter().copied().map(f64::from).collect();
        (!delays.is_empty()).then(|| quantile(&delays, 0.5))
    }

    /// Returns the share of events of which no step is called so. None without events.
    pub fn missed_share(&self) -> Option<f64> {
        let events = self.missed + self.delays.len();
        (events > 0).then(|| self.missed as f64 / events as f64)
    }

    /// Counts the events of which no step is called so.
    pub fn missed(&self) -> usize {
        self.missed
    }

    /// Counts the false alarms.
    pub fn false_alarms(&self) -> usize {
        self.false_alarms
    }

    /// Counts the time steps that the samples stand for.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}
