//! How fast recordings are replayed.

use std::time::{Duration, Instant};

/// How fast recordings are replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pace {
    /// As fast as they are answered.
    #[default]
    Fast,
    /// Each time step when its time stamp, or the rate, says.
    Rate,
}

/// Seconds that a stamp may be ahead of the one before and still be waited for.
const LONGEST: f64 = 10.0;

/// Waits until a time step is due.
pub(crate) struct Pacer {
    pace: Pace,
    /// A moment and the stamp that was due at it.
    begin: Option<(Instant, f64)>,
    last: f64,
}

impl Pacer {
    pub fn new(pace: Pace) -> Self {
        Pacer { pace, begin: None, last: 0.0 }
    }

    /// Checks whether time steps have to bear time stamps.
    pub fn needs_stamps(&self) -> bool {
        self.pace == Pace::Rate
    }

    /// Checks whether the time steps come whether there is room for them or not.
    pub fn drops(&self) -> bool {
        self.pace == Pace::Rate
    }

    /// Waits until `stamp`, in seconds, is due. A clock that falls, or jumps ahead, is not waited for.
    pub fn wait(&mut self, stamp: f64) {
        if self.pace == Pace::Fast {
            return;
        }
        let now = Instant::now();
        let step = stamp - std::mem::replace(&mut self.last, stamp);
        let due = match self.begin {
            Some((begin, first)) if (0.0..LONGEST).contains(&step) => {
                begin + Duration::from_secs_f64((stamp - first).max(0.0))
            }
            _ => {
                self.begin = Some((now, stamp));
                now
            }
        };
        if due > now {
            std::thread::sleep(due - now);
        }
    }
}
