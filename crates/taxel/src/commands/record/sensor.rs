//! The source of a recording: its channels, its rate, and its time steps one after the other.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use taxel::data::ColumnName;
use taxel::stream::{Arrival, Next, ReadingStream, StreamChannels};

/// Time steps from which a rate is measured: at least, and at most of a file.
const STEPS: (usize, usize) = (32, 256);
/// Seconds for which a sensor is listened to: with time stamps of its own, and without.
const LISTENED: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(2));
/// Seconds in which a port hands over what waited for somebody to open it.
const SETTLED: f64 = 0.3;
/// Time after which a source that sends nothing is given up.
pub const SILENT: Duration = Duration::from_secs(10);
/// Steps of other lengths than the median, as a share of it, are gaps or jitter: the median is the step then.
const UNEVEN: f64 = 0.5;
/// Steps of a clock that is too coarse for the rate are at most so many times the median, and more than one in so many are long.
const COARSE: f64 = 2.5;
const FEW: usize = 10;
/// Share by which a rate that somebody says may differ from that of the time stamps.
const AGREES: f64 = 0.02;
/// Most times that the rate of time stamps may differ from that of the arrivals.
const CLOCK: f64 = 1.5;
/// The highest rate that arrivals can show, in Hz; a pipe may hand over a whole file at once.
const FASTEST: f64 = 20_000.0;
/// Time for which a time step is waited for; then signals and keys are looked for.
const QUIET: Duration = Duration::from_millis(20);

/// Facts that a source says before anything is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorFacts {
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Whether the source named them.
    pub is_named: bool,
    /// Time steps per second (Hz), measured or said.
    pub rate: f64,
    /// Time steps bear time stamps.
    pub is_stamped: bool,
    /// Columns that count the lines, and are no channels.
    pub left_out: Vec<String>,
}

/// How readings come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SourceKind {
    /// Whether anybody takes them or not.
    Port,
    /// When they are measured, or all at once; they wait to be taken.
    Pipe,
    /// All at once.
    File,
}

/// A source that is being read.
pub struct Sensor {
    stream: ReadingStream,
    label: String,
    /// Time steps that a file gave while its rate was measured.
    waiting: VecDeque<Arrival>,
    /// Which value each channel of the set is.
    order: Vec<usize>,
    kind: SourceKind,
    ended: Option<String>,
}

/// The next event of a sensor.
pub enum Heard {
    /// A time step; its values in the order of the set.
    Reading(Arrival, Vec<f32>),
    /// Nothing for a moment.
    Quiet,
    /// The source has ended; a reason where it broke off.
    End(Option<String>),
}

impl Sensor {
    /// Listens to a source until its channels and its rate are known. `said` is a rate that somebody knows better.
    ///
    /// # Errors
    /// A source that sends nothing, too little, or no rate; channels without names of their own.
    pub fn listen(
        stream: ReadingStream,
        channels: &StreamChannels,
        label: String,
        said: Option<f64>,
        kind: SourceKind,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<(Self, SensorFacts)>, String> {
        let mut sensor = Sensor { stream, label, waiting: VecDeque::new(), order: vec![], kind, ended: None };
        let (mut seen, begin) = (vec![], Instant::now());
        while !sensor.knows_enough(&seen, said) {
            if is_stopped() {
                return Ok(None);
            }
            match sensor.stream.next(QUIET) {
                Next::Reading(arrival) => seen.push(arrival),
                Next::End(Ok(())) => {
                    sensor.ended = Some(String::new());
                    break;
                }
                Next::End(Err(error)) => return Err(error.to_string()),
                Next::Quiet if begin.elapsed() > SILENT && seen.len() < 2 => {
                    return Err(format!(
                        "{}: no readings came in {} s; look at the cable, the baud rate (--baud) and whether the sensor sends",
                        sensor.label,
                        SILENT.as_secs()
                    ));
                }
                Next::Quiet | Next::Begin(_) | Next::Tare => {}
            }
        }
        if seen.len() < 2 {
            return Err(format!("{}: holds less than two readings", sensor.label));
        }
        let names = channels.names().unwrap_or_default().to_vec();
        let facts = sensor.facts(names, &seen, said)?;
        if kind != SourceKind::Port {
            sensor.waiting = seen.into();
        }
        Ok(Some((sensor, facts)))
    }

    fn knows_enough(&self, seen: &[Arrival], said: Option<f64>) -> bool {
        let (Some(first), Some(last)) = (seen.first(), seen.last()) else { return false };
        // Arrivals say a rate only after a while; stamps, and somebody, say it at once.
        let by_arrival = last.stamp.is_none() && said.is_none();
        if self.kind == SourceKind::File || self.kind == SourceKind::Pipe && !by_arrival {
            let is_enough = seen.len() >= STEPS.1 || said.is_some() && seen.len() >= STEPS.0;
            return is_enough || self.kind == SourceKind::Pipe && last.at - first.at >= LISTENED.1;
        }
        let wanted = if last.stamp.is_some() { LISTENED.0 } else { LISTENED.1 };
        seen.len() >= STEPS.0 && last.at - first.at >= wanted
    }

    fn facts(
        &mut self,
        names: Vec<String>,
        seen: &[Arrival],
        said: Option<f64>,
    ) -> Result<SensorFacts, String> {
        let (label, each) = (&self.label, seen[0].values.len());
        let is_stamped = seen.iter().all(|arrival| arrival.stamp.is_some());
        let looks_like_time = names
            .iter()
            .find(|name| matches!(ColumnName::of(name), ColumnName::Time(_)))
            .filter(|_| !is_stamped);
        if let Some(name) = looks_like_time {
            return Err(format!("{label}: the column {name:?} looks like time stamps; say --time {name}"));
        }
        let is_named = names.len() == each;
        let all: Vec<String> =
            if is_named { names } else { (0..each).map(|i| format!("channel-{i}")).collect() };
        let counts = |at: &usize| counts_up(seen.iter().map(|arrival| arrival.values[*at]));
        let is_counter = |at: &usize| {
            let name = ColumnName::of(&all[*at]);
            is_named && !matches!(name, ColumnName::Open) && counts(at)
        };
        let (left, kept): (Vec<usize>, Vec<usize>) = (0..each).partition(is_counter);
        self.order.clone_from(&kept);
        let channels: Vec<String> = kept.iter().map(|at| all[*at].clone()).collect();
        check_names(label, &channels)?;
        let rate = match said {
            Some(rate) if !is_stamped => rate,
            said => agreed(label, self.rate(seen, is_stamped)?, said)?,
        };
        let left_out = left.into_iter().map(|at| all[at].clone()).collect();
        Ok(SensorFacts { channels, is_named, rate, is_stamped, left_out })
    }

    /// Measures the rate: by the time stamps to six digits, by the arrivals to three.
    fn rate(&self, seen: &[Arrival], is_stamped: bool) -> Result<f64, String> {
        let label = &self.label;
        if !is_stamped && self.kind == SourceKind::File {
            return Err(format!(
                "{label}: no column holds time stamps, so the rate is not known; say --rate HZ"
            ));
        }
        let first = seen[0].at;
        let arrivals: Vec<f64> = seen.iter().map(|arrival| (arrival.at - first).as_secs_f64()).collect();
        // Buffers hand readings over in bunches, and at first what waited in them: only the whole says how fast they come.
        let settled = arrivals.partition_point(|time| *time < SETTLED).min(arrivals.len() - 2);
        let (settled, count) = (&arrivals[settled..], arrivals.len() - settled);
        let arriving = (settled[count - 1] - settled[0]) / (count - 1) as f64;
        let step = if is_stamped {
            let stamps: Vec<f64> = seen.iter().filter_map(|arrival| arrival.stamp).collect();
            let step = step(&stamps)
                .ok_or_else(|| format!("{label}: its time stamps do not rise; say --time COLUMN"))?;
            if self.kind == SourceKind::Port {
                check_clock(1.0 / step, 1.0 / arriving).map_err(|why| format!("{label}: {why}"))?;
            }
            step
        } else {
            arriving
        };
        let rate = 1.0 / step;
        if !is_stamped && (rate.is_nan() || rate > FASTEST) {
            return Err(format!(
                "{label}: readings come faster than any sensor sends them, so their arrival says no rate; say --rate HZ, or \
                 name the column of time stamps with --time"
            ));
        }
        let digits = if is_stamped { 5 } else { 2 };
        let scale = 10f64.powi(digits - rate.log10().floor() as i32);
        Ok((rate * scale).round() / scale)
    }

    /// Takes the channels in the order of `set`.
    ///
    /// # Errors
    /// Channels that the set has and the sensor has not, and the other way round.
    pub fn arrange(&mut self, facts: &SensorFacts, set: &[String]) -> Result<(), String> {
        let label = &self.label;
        if !facts.is_named && facts.channels.len() == set.len() {
            return Ok(());
        }
        let place = |name: &String| facts.channels.iter().position(|channel| channel == name);
        let missing: Vec<&str> =
            set.iter().filter(|name| place(name).is_none()).map(String::as_str).collect();
        let more: Vec<&str> =
            facts.channels.iter().filter(|name| !set.contains(name)).map(String::as_str).collect();
        if !missing.is_empty() || !more.is_empty() {
            let words = |names: &[&str]| if names.is_empty() { "none".into() } else { names.join(", ") };
            return Err(format!(
                "{label}: its channels are not those of the set: missing are {}, more are {}; record into another folder",
                words(&missing),
                words(&more)
            ));
        }
        self.order = set.iter().filter_map(place).map(|at| self.order[at]).collect();
        Ok(())
    }

    /// Returns what comes next.
    pub fn next(&mut self) -> Heard {
        let next = match self.waiting.pop_front() {
            Some(arrival) => Next::Reading(arrival),
            None => match &self.ended {
                Some(why) => return Heard::End(Some(why.clone()).filter(|why| !why.is_empty())),
                None => self.stream.next(QUIET),
            },
        };
        match next {
            Next::Reading(arrival) => {
                let values = self.order.iter().map(|at| arrival.values[*at]).collect();
                Heard::Reading(arrival, values)
            }
            Next::End(how) => {
                let why = how.err().map(|error| error.to_string()).unwrap_or_default();
                self.ended = Some(why.clone());
                Heard::End(Some(why).filter(|why| !why.is_empty()))
            }
            Next::Quiet | Next::Begin(_) | Next::Tare => Heard::Quiet,
        }
    }

    /// Returns what has come already, of a sensor whose readings do not wait.
    pub fn next_waiting(&mut self) -> Option<Heard> {
        if self.kind != SourceKind::Port {
            return None;
        }
        match self.stream.waiting() {
            Next::Reading(arrival) => {
                let values = self.order.iter().map(|at| arrival.values[*at]).collect();
                Some(Heard::Reading(arrival, values))
            }
            Next::Quiet => None,
            Next::Begin(_) | Next::Tare => Some(Heard::Quiet),
            Next::End(how) => {
                self.ended = Some(how.err().map(|error| error.to_string()).unwrap_or_default());
                None
            }
        }
    }

    /// Gives the memory of a time step back.
    pub fn give_back(&self, arrival: Arrival) {
        self.stream.give_back(arrival.values);
    }

    pub fn label(&self) -> &str {
        &self.label
    }
}

/// Returns the rate of time stamps (Hz); refuses another one that somebody `said`.
fn agreed(label: &str, stamped: f64, said: Option<f64>) -> Result<f64, String> {
    match said {
        Some(said) if (said / stamped - 1.0).abs() > AGREES => Err(format!(
            "--rate {said}: the time stamps of {label} say {stamped} Hz; leave --rate out, or say the unit of the stamps with --clock \
             ms, us or ns"
        )),
        _ => Ok(stamped),
    }
}

/// Refuses time stamps that say another rate (Hz) than the arrivals of a port: their unit is another one.
fn check_clock(stamped: f64, arriving: f64) -> Result<(), String> {
    let ratio = stamped / arriving;
    if (1.0 / CLOCK..=CLOCK).contains(&ratio) {
        return Ok(());
    }
    Err(format!(
        "its time stamps say {stamped:.4} Hz, and its readings come at {arriving:.4} Hz; say the unit of the stamps with --clock \
         ms, us or ns, or their column with --time"
    ))
}

/// Returns the step of rising stamps: the mean where they are even, or where a coarse clock rounds them to one or two ticks; else the
/// median, which gaps do not move. None where they do not rise.
fn step(times: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step != 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let median = *steps.get(steps.len() / 2)?;
    let (shortest, longest) = (*steps.first()?, *steps.last()?);
    let is_even = shortest > (1.0 - UNEVEN) * median && longest < (1.0 + UNEVEN) * median;
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let long = steps.iter().filter(|step| **step > (1.0 + UNEVEN) * median).count();
    // Readings that are lost are few, or recordings are not kept.
    let is_coarse = longest < COARSE * median && long * FEW > steps.len();
    Some(if is_even || is_coarse { mean } else { median }).filter(|step| *step > 0.0)
}

/// Checks for numbers that count up by one.
fn counts_up(values: impl Iterator<Item = f32>) -> bool {
    let values: Vec<f32> = values.collect();
    values.len() > 2 && values.windows(2).all(|pair| pair[1] == pair[0] + 1.0)
}

/// Refuses names that no file of recordings can keep.
fn check_names(label: &str, names: &[String]) -> Result<(), String> {
    if names.is_empty() {
        return Err(format!("{label}: no column is a channel"));
    }
    for (at, name) in names.iter().enumerate() {
        if name.trim().is_empty() || name.chars().any(char::is_control) {
            return Err(format!("{label}: channel {} has the name {name:?}; give it another one", at + 1));
        }
        if names[..at].contains(name) {
            return Err(format!("{label}: two channels are named {name:?}; rename one"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_the_mean_of_even_stamps_and_the_median_of_others() {
        // Milliseconds of a sensor at 300 Hz.
        let rounded: Vec<f64> = (0..100).map(|i| (f64::from(i) / 0.3).round() / 1e3).collect();
        assert!(step(&rounded).is_some_and(|step| (step * 300.0 - 1.0).abs() < 0.005));
        let gap: Vec<f64> =
            (0..100).filter(|i| !(40..60).contains(i)).map(|i| f64::from(i) / 100.0).collect();
        assert!(step(&gap).is_some_and(|step| (step - 0.01).abs() < 1e-9));
        let coarse: Vec<f64> = (0..256).map(|i| (f64::from(i) / 0.7).round() / 1e3).collect();
        assert!(step(&coarse).is_some_and(|step| (step * 700.0 - 1.0).abs() < 0.005), "ticks of 1 and 2 ms");
        let lost: Vec<f64> = (0..200).filter(|i| i % 20 != 7).map(|i| f64::from(i) / 100.0).collect();
        assert!(step(&lost).is_some_and(|step| (step - 0.01).abs() < 1e-9), "one in twenty is lost");
        assert_eq!(step(&[1.0, 1.0]), None);
        assert_eq!(step(&[3.0, 2.0, 1.0]), None);
    }

    #[test]
    fn stamps_say_the_rate_whatever_else_is_said() {
        assert_eq!(agreed("port", 99.8, None), Ok(99.8));
        assert_eq!(agreed("port", 99.8, Some(100.0)), Ok(99.8));
        assert!(agreed("port", 99.8, Some(50.0)).is_err_and(|why| why.contains("say 99.8 Hz")));
    }

    #[test]
    fn stamps_of_another_unit_are_refused() {
        assert!(check_clock(100.0, 97.0).is_ok() && check_clock(100.0, 120.0).is_ok());
        for (stamped, arriving) in [(0.1, 100.0), (100_000.0, 100.0), (100.0, 50.0)] {
            assert!(check_clock(stamped, arriving).is_err_and(|why| why.contains("--clock")), "{stamped}");
        }
    }

    #[test]
    fn counters_count_by_one() {
        assert!(counts_up([4.0, 5.0, 6.0].into_iter()));
        assert!(!counts_up([4.0, 5.0, 7.0].into_iter()));
        assert!(!counts_up([4.0, 5.0].into_iter()));
    }

    #[test]
    fn names_are_checked() {
        let names = |all: &[&str]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert!(check_names("port", &names(&["thumb", "index"])).is_ok());
        for wrong in [&["a", "a"][..], &["a", " "], &["a\u{1b}"], &[]] {
            assert!(check_names("port", &names(wrong)).is_err(), "{wrong:?}");
        }
    }
}
