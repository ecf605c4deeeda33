//! Reads time stamps that are written as dates and times of day.

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};

/// Forms of a date with a time, after a `T` has become a blank.
const FORMS: [&str; 4] =
    ["%Y-%m-%d %H:%M:%S%.f", "%Y/%m/%d %H:%M:%S%.f", "%Y-%m-%d %H:%M", "%d.%m.%Y %H:%M:%S%.f"];
/// Longest text that is a time stamp.
const LONGEST: usize = 40;

/// Returns the seconds of a date with a time since 1970, or of a time since midnight: `2024-05-01T12:00:00.123Z`,
/// `2024-05-01 12:00:00+02:00`, `12:00:00.5`.
pub fn seconds(text: &str) -> Option<f64> {
    if text.len() > LONGEST
        || !text.starts_with(|letter: char| letter.is_ascii_digit())
        || !text.contains(':')
    {
        return None;
    }
    // Python's logging writes a comma before milliseconds.
    let text =
        text.trim_end_matches(['Z', 'z']).trim_end_matches(" UTC").replace(['T', 't'], " ").replace(',', ".");
    if let Ok(time) = NaiveTime::parse_from_str(&text, "%H:%M:%S%.f") {
        return Some(f64::from(time.num_seconds_from_midnight()) + f64::from(time.nanosecond()) * 1e-9);
    }
    let plain = FORMS.into_iter().find_map(|form| NaiveDateTime::parse_from_str(&text, form).ok());
    let since = match plain {
        Some(plain) => plain.and_utc(),
        None => DateTime::parse_from_str(&text, "%Y-%m-%d %H:%M:%S%.f%#z").ok()?.to_utc(),
    };
    Some(since.timestamp() as f64 + f64::from(since.timestamp_subsec_nanos()) * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_times_are_seconds() {
        for (text, want) in [
            ("1970-01-01T00:00:10Z", 10.0),
            ("1970-01-01 00:00:10.25", 10.25),
            ("1970-01-01 00:00:10,25", 10.25),
            ("1970-01-01T02:00:10+02:00", 10.0),
            ("1970-01-01 02:00:10+02", 10.0),
            ("2024-05-01T12:00:00.123Z", 1_714_564_800.123),
            ("2024/05/01 12:00:00", 1_714_564_800.0),
            ("01.05.2024 12:00:00", 1_714_564_800.0),
            ("2024-05-01 12:00", 1_714_564_800.0),
            ("00:01:00.5", 60.5),
        ] {
            let got = seconds(text).unwrap();
            assert!((got - want).abs() < 1e-6, "{text}: {got}");
        }
    }

    #[test]
    fn other_texts_are_none() {
        for text in
            ["", "soft", "1.5", "2024-05-01", "12:00", "25:00:00", "2024-13-01 12:00:00", "a:b", "1:2"]
        {
            assert_eq!(seconds(text), None, "{text}");
        }
    }
}
