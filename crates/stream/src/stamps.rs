//! Time stamps: gaps in them, and clocks that jump.

/// Steps whose median is the step of the stream.
const STEPS: usize = 16;
/// A step this many times as long as the others is a gap.
const GAP: f64 = 1.5;
/// A step forward of so many seconds, or windows, is a clock that was set and no gap.
const JUMP: f64 = 10.0;

/// Ranges in seconds of counters of microseconds and milliseconds in boards, of 32 bits and of 16.
const WRAPS: [f64; 3] = [4_294.967_296, 4_294_967.296, 65.536];
/// Steps over a wrap, in usual ones.
const OVER: std::ops::RangeInclusive<f64> = 0.5..=1.5;

/// The step from one time stamp to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// As long after the one before as the others.
    Steady,
    /// The same as the one before: by the rule of all readers the first is kept, and this time step is none.
    Repeated,
    /// A counter of 16 or 32 bits began anew at 0, a step after the one before.
    Wrapped,
    /// So many time steps are missing before it.
    Gap(u64),
    /// The clock was set by so many seconds; below 0 back.
    Jump(f64),
}

/// Watches the time stamps of a stream, in seconds.
#[derive(Debug, Clone)]
pub struct Stamps {
    /// Time steps of a window.
    ticks: usize,
    last: Option<f64>,
    steps: Vec<f64>,
    step: Option<f64>,
}

impl Stamps {
    /// Watches for windows of so many time steps.
    pub fn new(ticks: usize) -> Self {
        Stamps { ticks, last: None, steps: Vec::with_capacity(STEPS), step: None }
    }

    /// Forgets the last stamp: another recording begins.
    pub fn begin(&mut self) {
        self.last = None;
    }

    /// Returns the time steps per second, once enough of them are known: the median of the first 16 steps.
    pub fn rate(&self) -> Option<f64> {
        self.step.map(|step| 1.0 / step)
    }

    /// Takes a stamp. Before 16 steps are known only stamps that fall, or rise by 10 s or more, are a matter.
    pub fn push(&mut self, stamp: f64) -> Event {
        let Some(last) = self.last.replace(stamp) else { return Event::Steady };
        let step = stamp - last;
        let window = self.step.map_or(0.0, |step| step * self.ticks as f64);
        if step == 0.0 {
            return Event::Repeated;
        }
        let is_usual = |range: &f64| self.step.is_some_and(|usual| OVER.contains(&((step + range) / usual)));
        if step < 0.0 && WRAPS.iter().any(is_usual) {
            return Event::Wrapped;
        }
        if step < 0.0 || step >= JUMP * window.max(1.0) {
            return Event::Jump(step);
        }
        match self.step {
            None => {
                self.steps.push(step);
                if self.steps.len() == STEPS {
                    self.steps.sort_by(f64::total_cmp);
                    self.step = Some((self.steps[STEPS / 2 - 1] + self.steps[STEPS / 2]) / 2.0);
                }
                Event::Steady
            }
            Some(usual) if step > GAP * usual => Event::Gap((step / usual).round() as u64 - 1),
            Some(_) => Event::Steady,
        }
    }

    /// Checks whether windows begin anew after `event`: half a window or more is missing, or nobody knows how much.
    pub fn begins_anew(&self, event: Event) -> bool {
        let half = self.ticks as f64 / 2.0;
        match event {
            Event::Steady | Event::Repeated | Event::Wrapped => false,
            Event::Gap(missing) => missing as f64 >= half,
            Event::Jump(seconds) => self.step.is_none_or(|step| seconds.abs() >= half * step),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a stream at 100 Hz of which 20 time steps have come, the last at 0.19 s.
    fn steady() -> Stamps {
        let mut stamps = Stamps::new(10);
        (0..20).for_each(|t| assert_eq!(stamps.push(f64::from(t) / 100.0), Event::Steady));
        stamps
    }

    #[test]
    fn gaps_are_counted_in_readings() {
        let mut stamps = steady();
        assert!((stamps.rate().unwrap_or_default() - 100.0).abs() < 1e-6);
        assert_eq!(stamps.push(0.204), Event::Steady, "jitter");
        assert_eq!(stamps.push(0.234), Event::Gap(2));
        assert!(!stamps.begins_anew(Event::Gap(4)) && stamps.begins_anew(Event::Gap(5)));
        assert_eq!(stamps.push(0.234), Event::Repeated);
        assert_eq!(stamps.push(9.234), Event::Gap(899));
    }

    #[test]
    fn counters_that_wrap_go_on() {
        for range in WRAPS {
            let mut stamps = Stamps::new(10);
            (0..20).for_each(|t| assert_eq!(stamps.push(range - 0.2 + f64::from(t) / 100.0), Event::Steady));
            assert_eq!(stamps.push(0.0), Event::Wrapped, "{range}");
            assert!(!stamps.begins_anew(Event::Wrapped));
            assert_eq!(stamps.push(0.01), Event::Steady);
        }
        let mut stamps = steady();
        assert!(matches!(stamps.push(0.0), Event::Jump(_)), "a device that starts again");
    }

    #[test]
    fn clocks_that_are_set_are_no_gaps() {
        let mut stamps = steady();
        let Event::Jump(back) = stamps.push(0.18) else { unreachable!("it fell") };
        assert!((back + 0.01).abs() < 1e-9 && !stamps.begins_anew(Event::Jump(back)));
        assert_eq!(stamps.push(0.19), Event::Steady);
        assert!(stamps.begins_anew(Event::Jump(-0.05)));
        assert!(matches!(stamps.push(3600.0), Event::Jump(s) if s > 3599.0));
        assert_eq!(stamps.push(3600.01), Event::Steady);
        stamps.begin();
        assert_eq!(stamps.push(0.0), Event::Steady, "another recording");
        let mut early = Stamps::new(10);
        early.push(5.0);
        assert_eq!(early.push(1.0), Event::Jump(-4.0));
        assert!(early.begins_anew(Event::Jump(-0.001)), "nobody knows the step yet");
        assert_eq!(early.rate(), None);
    }
}
