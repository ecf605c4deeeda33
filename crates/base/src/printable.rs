//! Makes texts out of foreign files safe to print and to open.

use std::borrow::Cow;
use std::fmt::Write;

/// Characters that begin a formula in a spreadsheet.
const FORMULA: [char; 4] = ['=', '+', '-', '@'];

/// Escapes what could steer a terminal: control characters but for tabs and ends of lines, and marks that turn the
/// direction of writing. The escapes are those of JSON.
///
/// ```
/// assert_eq!(taxel_base::printable("soft\u{1b}[2J"), "soft\\u001b[2J");
/// assert_eq!(taxel_base::printable("weich\tÄpfel\n"), "weich\tÄpfel\n");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(steers) {
        return text.into();
    }
    let mut escaped = String::with_capacity(text.len() + 5);
    for c in text.chars() {
        if steers(c) {
            // Writing to a text never fails.
            let _ = write!(escaped, "\\u{:04x}", u32::from(c));
        } else {
            escaped.push(c);
        }
    }
    escaped.into()
}

/// Checks for a character that a terminal obeys, or that turns the direction of writing.
fn steers(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && !matches!(c, '\n' | '\t')
}

/// Puts an apostrophe before a text that a spreadsheet would run as a formula, as OWASP advises; numbers stay as they are.
///
/// ```
/// assert_eq!(taxel_base::spreadsheet_text("=HYPERLINK(A1)"), "'=HYPERLINK(A1)");
/// assert_eq!(taxel_base::spreadsheet_text("-1.5"), "-1.5");
/// ```
pub fn spreadsheet_text(text: &str) -> Cow<'_, str> {
    let begins = text.trim_start().starts_with(FORMULA) || text.starts_with(['\t', '\r']);
    // A lone sign is no formula.
    if begins && text.parse::<f64>().is_err() && text.trim().chars().count() > 1 {
        format!("'{text}").into()
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_is_left() {
        let foreign = "\u{1b}]0;title\u{7}\u{9b}31m\r\u{8}a\u{202e}b\u{7f}";
        assert_eq!(printable(foreign), "\\u001b]0;title\\u0007\\u009b31m\\u000d\\u0008a\\u202eb\\u007f");
        assert!(matches!(printable("é 東 \u{1f600} -> \\u001b"), Cow::Borrowed(_)));
    }

    #[test]
    fn formulas_become_texts_and_numbers_stay() {
        for formula in ["=1+1", "+cmd", "-2+3", "@SUM(A1)", " =1", "\t=1", "-ä"] {
            assert_eq!(spreadsheet_text(formula), format!("'{formula}"));
        }
        for text in ["-1.5", "+3", "-inf", "1e-3", "soft", "", "-", "a=b", "p(=x)"] {
            assert_eq!(spreadsheet_text(text), text);
        }
    }
}
