//! Finds numbers that are written so that they do not read as numbers: `1,5`, `12mV`, `1'000`.

/// How a number is written in a cell that is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberForm {
    DecimalComma,
    Thousands,
    Unit,
    Currency,
    /// A sign stands before it or behind it: `~1.5`, `<0.5`, `1.5*`, `1.5±0.1`.
    Sign,
    List,
    Hexadecimal,
}

/// Most letters of a unit.
const UNIT: usize = 8;
/// Signs and names of currencies, as they stand before a number.
const CURRENCIES: [&str; 9] = ["$", "€", "£", "¥", "EUR", "USD", "GBP", "CHF", "JPY"];
/// Separators of thousands.
const THOUSANDS: [char; 6] = [',', '\'', '\u{2019}', ' ', '\u{a0}', '\u{202f}'];

impl NumberForm {
    /// Finds the form of a number in a cell; none where the cell is a number, or a text.
    pub fn of(cell: &str) -> Option<Self> {
        if cell.parse::<f64>().is_ok() {
            return None;
        }
        if is_decimal_comma(cell) {
            return Some(Self::DecimalComma);
        }
        let digits = cell.strip_prefix(['+', '-', '\u{2212}']).unwrap_or(cell);
        if is_thousands(digits) {
            return Some(Self::Thousands);
        }
        if let Some(digits) = digits.strip_prefix("0x").or(digits.strip_prefix("0X")) {
            let is_it = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
            return is_it.then_some(Self::Hexadecimal);
        }
        if is_list(cell) {
            return Some(Self::List);
        }
        if has_unit(digits) {
            return Some(Self::Unit);
        }
        if has_currency(digits) {
            return Some(Self::Currency);
        }
        has_sign(cell).then_some(Self::Sign)
    }

    /// Says what it is and how to write it, after the cell.
    pub fn hint(self) -> &'static str {
        match self {
            Self::DecimalComma => {
                "is a number with a decimal comma; write decimals with points, or all of them with commas and separate \
                 columns with semicolons"
            }
            Self::Thousands => "is a number with separators of thousands; write it without them",
            Self::Unit => "is a number with a unit; write the unit into the name of the column",
            Self::Currency => "is a number with a currency; write the number alone",
            Self::Sign => "is a number with a sign beside it; write the number alone",
            Self::List => "is a list of numbers; write a column for each",
            Self::Hexadecimal => "is a hexadecimal number; write it in decimals",
        }
    }
}

impl NumberForm {
    /// Ends the message about a cell of a recording that is no number.
    pub fn short_hint(self) -> &'static str {
        match self {
            Self::DecimalComma => {
                "; separate columns with semicolons where decimals have commas, or write points"
            }
            Self::Thousands => "; write it without separators of thousands",
            Self::Unit => "; write the unit into the name of the column",
            Self::Currency | Self::Sign => "; write the number alone",
            Self::List => "; separate columns with commas, decimals with points",
            Self::Hexadecimal => "; write it in decimals",
        }
    }
}

/// Checks for one comma between digits: `1,5`, `-,5`, `1,5e-3`.
pub(crate) fn is_decimal_comma(cell: &str) -> bool {
    let mut parts = cell.splitn(2, ',');
    let (whole, Some(rest)) = (parts.next().unwrap_or_default(), parts.next()) else { return false };
    let whole = whole.strip_prefix(['+', '-']).unwrap_or(whole);
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let is_fraction = rest.starts_with(|letter: char| letter.is_ascii_digit()) && !rest.contains([',', '.']);
    is_digits(whole) && is_fraction && cell.replacen(',', ".", 1).parse::<f64>().is_ok()
}

/// Checks for a point between digits.
pub(crate) fn is_decimal_point(cell: &str) -> bool {
    cell.contains('.') && cell.parse::<f64>().is_ok()
}

/// Checks for a cell that says that its value is missing.
pub(crate) fn is_missing(cell: &str) -> bool {
    let known = ["", "-", "--", "?", "na", "n/a", "#n/a", "null", "none", "nan"];
    known.contains(&cell.to_ascii_lowercase().as_str())
}

/// Words that loggers and meters write in place of a value out of their range.
const OVERLOAD: [&str; 14] = [
    "ol",
    "+ol",
    "-ol",
    "o.l",
    "o.l.",
    "ovl",
    "ovf",
    "ovld",
    "over",
    "overload",
    "overflow",
    "overrange",
    "over range",
    "out of range",
];

/// Checks for a cell that a logger fills in where it has no value: missing, or out of range.
pub(crate) fn is_filled_in(cell: &str) -> bool {
    is_missing(cell) || OVERLOAD.contains(&cell.to_ascii_lowercase().as_str())
}

/// Checks for groups of three digits: `1,234.5`, `1'234`, `1.234,5`.
fn is_thousands(digits: &str) -> bool {
    let is_grouped = |whole: &str, separator: char| {
        let mut groups = whole.split(separator);
        let is_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
        let is_first = groups.next().is_some_and(|group| (1..=3).contains(&group.len()) && is_digits(group));
        let mut rest = groups.peekable();
        is_first && rest.peek().is_some() && rest.all(|group| group.len() == 3 && is_digits(group))
    };
    let points = digits.split_once('.').map_or(digits, |(whole, _)| whole);
    let fraction = digits.split_once('.').map_or("", |(_, fraction)| fraction);
    let is_plain = fraction.bytes().all(|byte| byte.is_ascii_digit());
    let german = digits.split_once(',').is_some_and(|(whole, fraction)| {
        is_grouped(whole, '.') && fraction.bytes().all(|byte| byte.is_ascii_digit())
    });
    german
        || is_plain && THOUSANDS.into_iter().any(|separator| is_grouped(points, separator))
        || is_grouped(digits, '.')
}

/// Checks for numbers in brackets, or separated by semicolons or blanks.
fn is_list(cell: &str) -> bool {
    let inside = cell.strip_prefix(['[', '(', '{']).and_then(|cell| cell.strip_suffix([']', ')', '}']));
    let text = inside.unwrap_or(cell);
    let mut numbers = text.split([',', ';', ' ']).filter(|part| !part.is_empty()).peekable();
    numbers.peek().is_some() && numbers.all(|part| part.parse::<f64>().is_ok())
}

/// Checks for a number and its unit: `1.5 N`, `12mV`, `50%`, `9.8 m/s²`. Ordinals (`2nd`) have none.
fn has_unit(digits: &str) -> bool {
    let (number, unit) = digits.split_at(end_of_number(digits));
    let unit = unit.trim_start();
    let is_unit = |letter: char| letter.is_alphabetic() || "%°/²³·*^Ωµ$€".contains(letter);
    let begins = unit.starts_with(|letter: char| letter.is_alphabetic() || "%°Ωµ$€".contains(letter));
    let letters = unit.trim_end_matches(['2', '3']);
    is_written_number(number)
        && begins
        && unit.chars().count() <= UNIT
        && letters.chars().all(is_unit)
        && !["st", "nd", "rd", "th"].contains(&unit)
}

/// Returns where the number ends that a text begins with, its exponent included; 0 of none.
fn end_of_number(text: &str) -> usize {
    let is_part = |letter: &char| letter.is_ascii_digit() || matches!(letter, '.' | ',');
    let end = text.chars().take_while(is_part).count();
    let Some(power) = text[end..].strip_prefix(['e', 'E']).filter(|_| end > 0) else { return end };
    let unsigned = power.strip_prefix(['+', '-']).unwrap_or(power);
    match unsigned.bytes().take_while(u8::is_ascii_digit).count() {
        0 => end,
        digits => end + 1 + (power.len() - unsigned.len()) + digits,
    }
}

fn is_written_number(text: &str) -> bool {
    text.parse::<f64>().is_ok() || is_decimal_comma(text) || is_thousands(text)
}

/// Checks for a currency before a number: `$1.50`, `€ 3`, `EUR 1,50`.
fn has_currency(digits: &str) -> bool {
    let rest = CURRENCIES.into_iter().find_map(|currency| digits.strip_prefix(currency));
    rest.is_some_and(|rest| is_written_number(rest.trim_start()))
}

/// Checks for signs beside a number: `~1.5`, `<0.5`, `\u{2212}1.5`, `1.5*`, `1.5±0.1`.
fn has_sign(cell: &str) -> bool {
    let is_number = |text: &str| is_written_number(text) || has_unit(text);
    if let Some((value, error)) = cell.split_once('±').or_else(|| cell.split_once("+/-")) {
        return (value.trim().is_empty() || is_number(value.trim())) && is_number(error.trim());
    }
    let inside = cell.trim_start_matches(['~', '≈', '<', '>', '≤', '≥', '=', '\'', '\u{2212}']).trim_start();
    let inside = inside.trim_end_matches(['*', '?', '!', '†']).trim_end();
    inside.len() < cell.len() && is_number(inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_disguise_are_known_by_their_form() {
        for (form, cells) in [
            (NumberForm::DecimalComma, &["1,5", "-0,25", ",5", "1,500", "2,5e-3"][..]),
            (NumberForm::Thousands, &["1,234.5", "1,234,567", "1'234", "1 234", "1.234,5", "1.234.567"]),
            (
                NumberForm::Unit,
                &["1.5 N", "12mV", "50%", "1,5 N", "-3.2°C", "9.81 m/s²", "9.81 m/s^2", "5 Nm", "3.3V"],
            ),
            (NumberForm::Unit, &["1.5e-3 N", "2E5Pa", "12 %"]),
            (NumberForm::Currency, &["$1.50", "€ 3", "-$1,234.50", "EUR 1,50"]),
            (
                NumberForm::Sign,
                &["~1.5", "<0.5", "≥ 3", "1.5*", "1.5±0.1", "1.5 +/- 0.1", "\u{2212}1.5", "'1.5", "~3 N"],
            ),
            (NumberForm::List, &["[1, 2.5]", "(1 2 3)", "1 2", "1;2", "1,2,3"]),
            (NumberForm::Hexadecimal, &["0x1F", "-0x10"]),
        ] {
            for cell in cells {
                assert_eq!(NumberForm::of(cell), Some(form), "{cell}");
            }
        }
    }

    #[test]
    fn numbers_and_texts_are_none_in_disguise() {
        for (cell, is_it) in
            [("OL", true), ("-", true), ("", true), ("Overflow", true), ("NaN", true), ("on", false)]
        {
            assert_eq!(is_filled_in(cell), is_it, "{cell}");
        }
        for cell in [
            "1.5",
            "-2e-3",
            "nan",
            "inf",
            "",
            "soft",
            "2nd",
            "cup_03",
            "2024-05-01",
            "12:00:00",
            "2024-05-01T12:00:00Z",
            "192.168.0.1",
            "v1.2",
            "3/4",
            "[...]",
            "day1",
            "1-2",
            "10 kilograms",
            "=A1",
            "US 5",
            "a±b",
            "?",
            "<cup>",
        ] {
            assert_eq!(NumberForm::of(cell), None, "{cell}");
        }
    }
}
