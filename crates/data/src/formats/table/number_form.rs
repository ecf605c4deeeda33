//! Finds numbers that are written so that they do not read as numbers: `1,5`, `12mV`, `1'000`.

/// How a number is written in a cell that is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberForm {
    DecimalComma,
    Thousands,
    Unit,
    List,
    Hexadecimal,
}

/// Most letters of a unit.
const UNIT: usize = 8;
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
        has_unit(digits).then_some(Self::Unit)
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
    let is_number = |letter: &char| letter.is_ascii_digit() || matches!(letter, '.' | ',');
    let end = digits.chars().take_while(is_number).map(char::len_utf8).sum::<usize>();
    let (number, unit) = digits.split_at(end);
    let is_number = number.parse::<f64>().is_ok() || is_decimal_comma(number) || is_thousands(number);
    let unit = unit.trim_start();
    let is_unit = |letter: char| letter.is_alphabetic() || "%°/²³·*^Ωµ$€".contains(letter);
    let begins = unit.starts_with(|letter: char| letter.is_alphabetic() || "%°Ωµ$€".contains(letter));
    let letters = unit.trim_end_matches(['2', '3']);
    is_number
        && begins
        && unit.chars().count() <= UNIT
        && letters.chars().all(is_unit)
        && !["st", "nd", "rd", "th"].contains(&unit)
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
        ] {
            assert_eq!(NumberForm::of(cell), None, "{cell}");
        }
    }
}
