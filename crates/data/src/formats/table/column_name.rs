//! Decides what a column may be by its name alone.

use crate::formats::table::options::Clock;

/// The kind of a column as far as its name says it, in every reader alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnName {
    /// Time stamps, with their unit where the name ends in one: `time_ms`, `timestamp`, `header.stamp`.
    Time(Option<Clock>),
    /// Never a channel: why.
    LeftOut(&'static str),
    /// A counter of rows where its numbers count up: `index`, `nr`, `frame`. A finger may be called `index` too.
    Counter,
    /// Anything.
    Open,
}

/// Words that are time stamps, whatever stands before them.
const STAMP: [&str; 4] = ["timestamp", "timestamps", "stamp", "datetime"];
/// Words that are time stamps alone, or after one of [`WHOSE`].
const TIME: [&str; 3] = ["time", "date", "ts"];
/// Words before `time` that keep it a time stamp. The time of a contact or of a rise is a feature.
const WHOSE: [&str; 24] = [
    "abs", "absolute", "capture", "date", "device", "elapsed", "epoch", "gps", "host", "local", "log",
    "received", "recv", "rel", "relative", "ros", "rosbag", "sample", "sensor", "sys", "system", "unix",
    "utc", "wall",
];
/// Units that are no names of sensors and are time stamps alone.
const UNITS: [&str; 9] =
    ["millis", "milliseconds", "micros", "microseconds", "nanos", "nanoseconds", "seconds", "secs", "ms"];

/// Whole names of row numbers and keys, words joined by `_`.
const INDEX: [&str; 18] = [
    "id",
    "uuid",
    "guid",
    "rownames",
    "row_names",
    "row_number",
    "rownumber",
    "row_num",
    "row_index",
    "row_id",
    "line_number",
    "frame_index",
    "frame_idx",
    "frame_number",
    "sample_index",
    "sample_idx",
    "sample_id",
    "level_0",
];
/// Last words of names of counters.
const COUNTER: [&str; 26] = [
    "counter", "frame", "frames", "i", "id", "idx", "index", "k", "line", "n", "no", "nr", "num", "number",
    "packet", "reading", "record", "row", "rows", "sample", "samples", "seq", "step", "steps", "tick",
    "ticks",
];

/// Why an index is no channel.
pub(crate) const INDEX_WHY: &str = "an index";
/// Why a column without a name is no channel.
const NAMELESS: &str = "no name, as an index has";
/// Why time in another unit is no channel.
const SLOW: &str = "time in minutes, hours or days";

impl ColumnName {
    /// Returns what a name says.
    pub fn of(name: &str) -> Self {
        let name = name.trim();
        let lower = name.to_lowercase();
        if name.is_empty() {
            return Self::LeftOut(NAMELESS);
        }
        // pandas and readr name columns without a name.
        let is_pandas = lower.starts_with("unnamed:") || lower.starts_with("__index_level_");
        let is_readr =
            lower.strip_prefix("...").is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()));
        if is_pandas || is_readr || lower == "#" {
            return Self::LeftOut(INDEX_WHY);
        }
        let words = words(name);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        if let Some(clock) = time(&words) {
            return clock;
        }
        if INDEX.contains(&words.join("_").as_str()) {
            return Self::LeftOut(INDEX_WHY);
        }
        match words.last() {
            Some(last) if COUNTER.contains(last) => Self::Counter,
            _ => Self::Open,
        }
    }
}

impl Clock {
    /// Returns the unit at the end of the name of a column of time stamps (`time_ms`), or seconds without one; none for a
    /// name of anything else.
    pub fn of_column(name: &str) -> Option<Self> {
        match ColumnName::of(name) {
            ColumnName::Time(clock) => Some(clock.unwrap_or(Self::Seconds)),
            _ => None,
        }
    }
}

/// Splits a name at all that is neither letter nor digit, and before capitals: `timeMs`, `header.stamp`, `Time [s]`.
fn words(name: &str) -> Vec<String> {
    let (mut words, mut word, mut before) = (vec![], String::new(), ' ');
    for letter in name.chars() {
        let begins = before.is_lowercase() && letter.is_uppercase();
        if begins || !letter.is_alphanumeric() {
            words.push(std::mem::take(&mut word));
        }
        if letter.is_alphanumeric() {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.push(word);
    words.retain(|word| !word.is_empty());
    words
}

/// Finds a name of time stamps; none for another name.
fn time(words: &[&str]) -> Option<ColumnName> {
    if let [unit] = words
        && UNITS.contains(unit)
    {
        return Some(ColumnName::Time(unit_of(unit)));
    }
    let (last, before) = words.split_last()?;
    let is_slow =
        matches!(*last, "min" | "mins" | "minute" | "minutes" | "h" | "hr" | "hour" | "hours" | "d" | "days");
    if is_time(before) {
        if is_slow {
            return Some(ColumnName::LeftOut(SLOW));
        }
        if let Some(clock) = unit_of(last) {
            return Some(ColumnName::Time(Some(clock)));
        }
    }
    if is_time(words) {
        return Some(ColumnName::Time(None));
    }
    // `timems`, but not `times`.
    let joined = ["timestamp", "time"].into_iter().find_map(|time| last.strip_prefix(time));
    let clock = joined.filter(|unit| unit.len() > 1).and_then(unit_of);
    clock.filter(|_| before.is_empty()).map(|clock| ColumnName::Time(Some(clock)))
}

fn is_time(words: &[&str]) -> bool {
    let Some((last, before)) = words.split_last() else { return false };
    let is_whose = || before.iter().all(|word| WHOSE.contains(word));
    STAMP.contains(last)
        || TIME.contains(last) && is_whose()
        || before.is_empty() && matches!(*last, "t" | "epoch")
}

/// Finds the unit of time that a word is.
fn unit_of(word: &str) -> Option<Clock> {
    Some(match word {
        "s" | "sec" | "secs" | "second" | "seconds" => Clock::Seconds,
        "ms" | "msec" | "msecs" | "milli" | "millis" | "millisecond" | "milliseconds" => Clock::Milliseconds,
        "us" | "µs" | "μs" | "usec" | "usecs" | "micro" | "micros" | "microsecond" | "microseconds" => {
            Clock::Microseconds
        }
        "ns" | "nsec" | "nsecs" | "nano" | "nanos" | "nanosec" | "nanosecond" | "nanoseconds" => {
            Clock::Nanoseconds
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_time_stamps_end_in_their_unit() {
        use Clock::{Microseconds as Us, Milliseconds as Ms, Nanoseconds as Ns, Seconds as S};
        for (name, clock) in [
            ("time", None),
            ("T", None),
            ("Timestamp", None),
            ("time stamp", None),
            ("epoch", None),
            ("%time", None),
            ("datetime", None),
            ("header.stamp", None),
            ("left_timestamp", None),
            ("t_us", Some(Us)),
            ("t (µs)", Some(Us)),
            ("timestamp_ns", Some(Ns)),
            ("Time_ms", Some(Ms)),
            ("timeMs", Some(Ms)),
            ("timems", Some(Ms)),
            ("time, s", Some(S)),
            ("Elapsed Time [sec]", Some(S)),
            ("unix_time_ms", Some(Ms)),
            ("millis", Some(Ms)),
        ] {
            assert_eq!(ColumnName::of(name), ColumnName::Time(clock), "{name}");
        }
        assert_eq!(ColumnName::of("time_min"), ColumnName::LeftOut(SLOW));
    }

    #[test]
    fn indices_are_left_out_and_counters_are_looked_at() {
        for name in [
            "",
            " ",
            "Unnamed: 0",
            "Unnamed: 0.1",
            "__index_level_0__",
            "...1",
            "id",
            "frame_index",
            "RowNames",
        ] {
            assert!(matches!(ColumnName::of(name), ColumnName::LeftOut(_)), "{name}");
        }
        for name in
            ["index", "Index", "nr", "row", "frame", "sampleIndex", "packet_no", "left_index", "Lfd. Nr."]
        {
            let is_left_out = name == "sampleIndex";
            assert_eq!(ColumnName::of(name) == ColumnName::Counter, !is_left_out, "{name}");
        }
    }

    #[test]
    fn other_names_are_open() {
        for name in [
            "time_of_day",
            "t_1",
            "times",
            "contact_time",
            "rise_time_ms",
            "temperature",
            "force",
            "0",
            "thumb",
            "date_1",
            "s",
        ] {
            assert_eq!(ColumnName::of(name), ColumnName::Open, "{name}");
        }
    }
}
