//! Warns of pauses between time stamps, and of recordings of clearly different rates in one set.

use crate::error::plural;
use crate::formats::stamps::Plain;

/// A step that is so many times as long as the median step of its recording is a pause ...
const PAUSE: f64 = 5.0;
/// ... if it is also so many times as long as nine in ten of its steps: a sensor that sends unevenly does not pause.
const LONGER: f64 = 2.5;
/// Fewest steps that show a rate.
const STEPS: usize = 3;
/// Share by which the rates of one sensor may differ.
const ALIKE: f64 = 0.1;
/// Recordings that a message names.
const NAMED: usize = 3;

/// The steps of one recording.
struct Pace {
    /// Mean step in seconds, pauses left out.
    step: f64,
    /// The longest pause: seconds since the first stamp, and its length.
    longest: Option<(f64, f64)>,
    pauses: usize,
}

impl Pace {
    /// Measures rising stamps in seconds; none of too few.
    fn of(times: &[f64]) -> Option<Self> {
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.len() < STEPS {
            return None;
        }
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let (median, most) = (sorted[sorted.len() / 2], sorted[(sorted.len() - 1) * 9 / 10]);
        let is_pause = |step: f64| step > PAUSE * median && step > LONGER * most;
        let paused = || steps.iter().enumerate().filter(|(_, step)| is_pause(**step));
        let longest =
            paused().max_by(|a, b| a.1.total_cmp(b.1)).map(|(at, step)| (times[at] - times[0], *step));
        let usual: Vec<f64> = steps.iter().copied().filter(|step| !is_pause(*step)).collect();
        let step = usual.iter().sum::<f64>() / usual.len() as f64;
        Some(Self { step, longest, pauses: paused().count() })
    }
}

/// Returns the doubts about the time stamps of the recordings of a set, in seconds; `at` is the place of the set, `name` that of a
/// recording.
pub(crate) fn doubts(at: &str, stamps: &[&[f64]], name: impl Fn(usize) -> String) -> Vec<String> {
    let paces: Vec<(usize, Pace)> =
        stamps.iter().enumerate().filter_map(|(row, times)| Some((row, Pace::of(times)?))).collect();
    let said = [pauses(&paces, &name), rates(&paces, &name)];
    said.into_iter().flatten().map(|words| format!("{at}: {words}")).collect()
}

fn pauses(paces: &[(usize, Pace)], name: &impl Fn(usize) -> String) -> Option<String> {
    let paused: Vec<(usize, &Pace, (f64, f64))> =
        paces.iter().filter_map(|(row, pace)| Some((*row, pace, pace.longest?))).collect();
    let one = |(row, pace, (start, length)): &(usize, &Pace, (f64, f64))| {
        let several =
            if pace.pauses > 1 { format!(", the longest of {} pauses", pace.pauses) } else { String::new() };
        let usual = Plain(1e3 * pace.step);
        format!(
            "{} for {:.3} s at {:.3} s{several} (its usual step is {usual:.3} ms)",
            name(*row),
            Plain(*length),
            Plain(*start)
        )
    };
    let listed = paused.iter().take(NAMED).map(one).collect::<Vec<_>>().join("; ");
    let more = paused.len().saturating_sub(NAMED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    (!paused.is_empty()).then(|| {
        let (count, pauses) = (paused.len(), if paused.len() == 1 { "pauses" } else { "pause" });
        format!(
            "{} {pauses}: {listed}{more}. Readings there are drawn as a straight line; cut recordings at their pauses, or leave \
             them out",
            plural(count, "recording")
        )
    })
}

fn rates(paces: &[(usize, Pace)], name: &impl Fn(usize) -> String) -> Option<String> {
    let mut steps: Vec<f64> = paces.iter().map(|(_, pace)| pace.step).collect();
    steps.sort_by(f64::total_cmp);
    let usual = *steps.get(steps.len() / 2)?;
    let is_other = |pace: &Pace| !(1.0 / (1.0 + ALIKE)..=1.0 + ALIKE).contains(&(pace.step / usual));
    let others: Vec<&(usize, Pace)> = paces.iter().filter(|(_, pace)| is_other(pace)).collect();
    let (alike, _) = paces.iter().find(|(_, pace)| !is_other(pace))?;
    let of = |step: f64| format!("{:.1} Hz", Plain(1.0 / step));
    let one = |(row, pace): &&(usize, Pace)| format!("{} with {}", name(*row), of(pace.step));
    let listed = others.iter().take(NAMED).map(one).collect::<Vec<_>>().join(", ");
    let more = others.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!others.is_empty()).then(|| {
        format!(
            "recordings have different rates: {} of {} about {}, such as {}, others not: {listed}{more}. All are brought to one \
             rate, and how smooth that makes them may tell the classes apart; record at one rate, or leave the others out",
            paces.len() - others.len(),
            paces.len(),
            of(usual),
            name(*alike)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(count: u32, rate: f64) -> Vec<f64> {
        (0..count).map(|i| 7.0 + f64::from(i) / rate).collect()
    }

    fn said(recordings: &[Vec<f64>]) -> Vec<String> {
        let stamps: Vec<&[f64]> = recordings.iter().map(Vec::as_slice).collect();
        doubts("set", &stamps, |row| format!("r{row}"))
    }

    /// Stamps of which those from number `at` on come later.
    fn paused(mut times: Vec<f64>, at: usize, by: f64) -> Vec<f64> {
        times[at..].iter_mut().for_each(|time| *time += by);
        times
    }

    #[test]
    fn a_pause_is_named_with_its_place_and_length() {
        let pause = paused(even(50, 100.0), 20, 0.5);
        let words = said(&[even(50, 100.0), pause.clone()]).join("\n");
        assert!(
            words
                .contains("set: 1 recording pauses: r1 for 0.510 s at 0.190 s (its usual step is 10.000 ms)"),
            "{words}"
        );
        assert_eq!(said(&[paused(even(50, 100.0), 20, 0.03)]).len(), 0, "three readings that were lost");
        assert_eq!(said(&[paused(even(50, 100.0), 20, 0.05)]).len(), 1);
        let all: Vec<Vec<f64>> = vec![paused(pause, 40, 0.2); 5];
        let words = said(&all).join("\n");
        assert!(words.contains("5 recordings pause") && words.contains("the longest of 2 pauses"), "{words}");
        assert!(words.contains("; and 2 more. Readings"), "{words}");
    }

    #[test]
    fn uneven_steps_are_no_pauses() {
        // Bursts of eight readings.
        let bursts: Vec<f64> = (0..80).map(|i| f64::from(i / 8) + f64::from(i % 8) * 0.001).collect();
        assert_eq!(said(&[bursts]).len(), 0);
        assert_eq!(said(&[vec![0.0, 0.01, 9.0], vec![1.0], vec![]]).len(), 0, "too few steps");
    }

    #[test]
    fn recordings_of_other_rates_are_named() {
        let words = said(&[even(50, 100.0), even(50, 50.0), even(50, 99.0), even(50, 101.0)]).join("\n");
        assert!(words.contains("3 of 4 about") && words.contains("r1 with 50.0 Hz"), "{words}");
        assert!(words.contains("such as r0"), "{words}");
        assert_eq!(said(&[even(50, 100.0), even(50, 96.0), even(9, 104.0)]).len(), 0, "clocks differ");
        let one = said(&[even(50, 100.0), paused(even(50, 100.0), 9, 5.0)]);
        assert_eq!(one.len(), 1, "a pause is no other rate: {one:?}");
        // Milliseconds of 300 Hz.
        let rounded: Vec<Vec<f64>> =
            (0..4).map(|k| (k..k + 9).map(|i| (f64::from(i) / 0.3).round() / 1e3).collect()).collect();
        assert_eq!(said(&rounded).len(), 0);
    }
}
