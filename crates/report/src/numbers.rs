//! Numbers as people read them.

/// Returns three digits that count: 0.0123, 1.23, 123, 12,345.
pub fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    if value.abs() >= 9999.5 {
        let sign = if value < 0.0 { "-" } else { "" };
        return format!("{sign}{}", taxel_base::thousands(value.abs().round() as u64));
    }
    let places = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.places$}")
}

/// Returns a number with a prefix of the SI: 12.3 k, 1.23 M.
pub fn si(value: f64) -> String {
    let (scaled, prefix) = match value.abs() {
        v if v >= 1e9 => (value / 1e9, " G"),
        v if v >= 1e6 => (value / 1e6, " M"),
        v if v >= 1e3 => (value / 1e3, " k"),
        _ => (value, " "),
    };
    if scaled == scaled.trunc() && scaled.abs() < 1e3 {
        format!("{scaled:.0}{}", prefix.trim_end())
    } else {
        format!("{}{}", digits(scaled), prefix.trim_end())
    }
}

/// Returns a size in bytes: 12.3 kB.
pub fn bytes(value: f64) -> String {
    match si(value) {
        plain if plain.ends_with(['k', 'M', 'G']) => format!("{plain}B"),
        plain => format!("{plain} B"),
    }
}

/// Returns a tick of an axis without needless digits: 0.01, 1, 100.
pub fn tick(value: f64) -> String {
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// Returns a number with one decimal: `3.0`; `-0.0` is `0.0`.
pub fn tenth(value: f64) -> String {
    match format!("{value:.1}").as_str() {
        "-0.0" => "0.0".into(),
        text => text.into(),
    }
}

/// Puts intervals into words behind their numbers: ` (1.0 to 3.2)`.
pub fn between(show: fn(f64) -> String) -> impl Fn([f64; 2]) -> String + Copy {
    move |[low, high]| format!(" ({} to {})", show(low), show(high))
}

/// Puts intervals into words behind their numbers: ` [1.0, 3.2]`.
pub fn in_brackets(show: fn(f64) -> String) -> impl Fn([f64; 2]) -> String + Copy {
    move |[low, high]| format!(" [{}, {}]", show(low), show(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_unit_and_three_digits() {
        let all = [0.01234, 1.0, 123.4, 12345.0, 0.0].map(digits);
        assert_eq!(all, ["0.0123", "1.00", "123", "12,345", "0"]);
        assert_eq!(
            [0.0, 999.0, 1000.0, 13923.0, 19_535_232.0].map(si),
            ["0", "999", "1 k", "13.9 k", "19.5 M"]
        );
        assert_eq!([12.0, 55_692.0].map(bytes), ["12 B", "55.7 kB"]);
        assert_eq!([0.001, 5.0, 100.0].map(tick), ["0.001", "5", "100"]);
        assert_eq!(tenth(-0.04), "0.0");
    }
}
