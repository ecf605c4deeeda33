//! Finds the lines of a text table that are no rows of it, as loggers write them: lines before the header, comments, messages such as
//! `OVERFLOW`, the header once more, a summary at the end.
//!
//! A line that could be a row stays, and is refused where it is read.

use crate::error::plural;
use std::collections::HashMap;

/// Lines by which the number of columns is found.
const LOOKED_AT: usize = 1000;
/// First letters of comments.
const MARKS: [char; 4] = ['#', '%', '!', ';'];
/// Most messages of a table: so many, or one in so many rows. In a file of more every second reading may be lost.
const MESSAGES: (usize, usize) = (3, 10);
/// Letters of a line that a message shows.
const SHOWN: usize = 40;
/// First or last words of lines that sum up the rows above.
const SUMMARY: [&str; 18] = [
    "mean",
    "average",
    "avg",
    "median",
    "std",
    "stdev",
    "std dev",
    "standard deviation",
    "sd",
    "rms",
    "min",
    "max",
    "minimum",
    "maximum",
    "sum",
    "total",
    "count",
    "summary",
];

/// A text table without its odd lines, which are blank so that messages count lines as the file does.
pub(crate) struct WithoutOddLines {
    pub text: String,
    /// Which lines were left out, for people.
    pub said: String,
}

/// The kind of a line that is no row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OddLine {
    BeforeTable,
    Comment,
    Header,
    Message,
    Summary,
}

impl OddLine {
    const ALL: [Self; 5] = [Self::BeforeTable, Self::Comment, Self::Header, Self::Message, Self::Summary];

    fn words(self) -> &'static str {
        match self {
            Self::BeforeTable => "before the table",
            Self::Comment => "a comment",
            Self::Header => "the header once more",
            Self::Message => "a message, where readings may be lost",
            Self::Summary => "a summary",
        }
    }
}

/// A line that is not blank, without its end; lines count from 1.
#[derive(Clone, Copy)]
struct Line<'t> {
    number: usize,
    text: &'t str,
}

fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let numbered = text.lines().enumerate().map(|(at, text)| Line { number: at + 1, text: text.trim() });
    numbered.filter(|line| !line.text.is_empty())
}

/// Returns a text table without the lines that are no rows; none where there are none, or where it is no plain table of several
/// columns. `said` is the separator that its first line states. In a table `of_readings` words alone are a message; in a list, such as that
/// of the files of a set, they are an entry that is cut.
pub(crate) fn without_odd_lines(text: &str, said: Option<u8>, of_readings: bool) -> Option<WithoutOddLines> {
    // A cell in quotes may hold the end of a line.
    if text.lines().any(|line| line.matches('"').count() % 2 == 1) {
        return None;
    }
    let columns = Columns::of(text, said)?;
    let begin = columns.begin(text)?;
    let mut odd: Vec<(usize, OddLine)> = lines(text)
        .take_while(|line| line.number < begin.number)
        .map(|line| (line.number, OddLine::BeforeTable))
        .collect();
    odd.extend(columns.between(text, begin, of_readings)?);
    let summary = columns.summary(text, begin, &odd).filter(|_| of_readings);
    odd.extend(summary.unwrap_or_default());
    odd.sort_by_key(|(number, _)| *number);
    (!odd.is_empty()).then(|| WithoutOddLines { text: blanked(text, &odd), said: in_words(text, &odd) })
}

/// The columns of a table by most of its lines.
struct Columns {
    separator: char,
    width: usize,
    /// Rows end with a separator.
    has_ends: bool,
}

impl Columns {
    /// Finds the separator by which most lines have equally many cells, and several.
    fn of(text: &str, said: Option<u8>) -> Option<Self> {
        let separators = said.map_or(vec!['\t', ';', ','], |said| vec![char::from(said)]);
        separators.into_iter().find_map(|separator| {
            let (mut widths, mut all) = (HashMap::<(usize, bool), usize>::new(), 0);
            for line in lines(text).take(LOOKED_AT) {
                *widths.entry((width(line.text, separator), line.text.ends_with(separator))).or_default() +=
                    1;
                all += 1;
            }
            let ((width, has_ends), count) = widths.into_iter().max_by_key(|(_, count)| *count)?;
            (width > 1 && 2 * count > all).then_some(Self { separator, width, has_ends })
        })
    }

    /// Checks whether a line has as many cells as rows have; a separator may end all rows, or the header.
    fn fits(&self, line: &str) -> bool {
        let width = width(line, self.separator);
        width == self.width
            || self.has_ends && width + 1 == self.width
            || line.ends_with(self.separator) && width == self.width + 1
    }

    fn cells<'l>(&self, line: &'l str) -> impl Iterator<Item = &'l str> {
        line.split(self.separator).map(|cell| cell.trim().trim_matches('"').trim())
    }

    /// Checks whether a line holds names and no numbers.
    fn has_names(&self, line: &str) -> bool {
        let mut cells = self.cells(line);
        let is_name = |cell: &str| cell.starts_with(|c: char| c.is_alphabetic() || c == '_');
        self.cells(line).any(is_name) && !cells.any(|cell| cell.parse::<f64>().is_ok())
    }

    fn is_marked(&self, line: &str) -> bool {
        line.starts_with("//") || line.starts_with(|c: char| MARKS.contains(&c) && c != self.separator)
    }

    /// Finds the line with which the table begins; none where lines before it may belong to it.
    fn begin<'t>(&self, text: &'t str) -> Option<Line<'t>> {
        let fitting = || lines(text).filter(|line| self.fits(line.text));
        // A comment or a title may have as many commas as a row. `#time,force` above numbers is a header.
        let is_title = |line: &Line| self.cells(line.text).filter(|cell| !cell.is_empty()).count() == 1;
        let may_go = |line: &Line| self.is_marked(line.text) || is_title(line);
        let after = fitting().find(|line| !may_go(line)).filter(|line| self.has_names(line.text));
        let begin = after.or_else(|| fitting().next())?;
        // Without a header, words in another line may be the names of the columns.
        let may_name = |line: &Line| {
            !self.is_marked(line.text) || line.text.split_whitespace().count().abs_diff(self.width) < 2
        };
        let mut before = lines(text).take_while(|line| line.number < begin.number);
        let is_sure = self.has_names(begin.text) || !before.any(|line| may_name(&line));
        is_sure.then_some(begin)
    }

    /// Finds comments, messages and the header after the beginning; none of a table with too many messages.
    fn between(&self, text: &str, begin: Line, of_readings: bool) -> Option<Vec<(usize, OddLine)>> {
        let is_header = self.has_names(begin.text);
        let (mut odd, mut rows, mut marked, mut before) = (vec![], 0, vec![], None);
        for line in lines(text).skip_while(|line| line.number <= begin.number) {
            let fits = self.fits(line.text);
            if is_header && line.text == begin.text {
                odd.push((line.number, OddLine::Header));
            } else if self.is_marked(line.text) && !fits {
                odd.push((line.number, OddLine::Comment));
            } else if of_readings && self.is_message(line.text, fits, before) {
                odd.push((line.number, OddLine::Message));
            } else {
                rows += 1;
                if self.is_marked(line.text) && self.is_commented_out(line.text) {
                    marked.push((line.number, OddLine::Comment));
                }
                before = Some(line.text).filter(|_| fits).or(before);
            }
        }
        // `#1` may be the name of an object in each row.
        if 2 * marked.len() <= rows {
            odd.extend(marked);
        }
        let messages = odd.iter().filter(|(_, kind)| *kind == OddLine::Message).count();
        (messages <= MESSAGES.0.max(rows / MESSAGES.1)).then_some(odd)
    }

    /// Checks whether a line is one cell of words, in a column that holds numbers or in none.
    fn is_message(&self, line: &str, fits: bool, before: Option<&str>) -> bool {
        let separator = self.separator;
        let start = line.len() - line.trim_start_matches([separator, ' ']).len();
        let cell = line[start..].trim_end_matches([separator, ' ']);
        if cell.contains(separator) || cell.is_empty() || cell.parse::<f64>().is_ok() {
            return false;
        }
        let column = line[..start].matches(separator).count();
        let is_number =
            |row: &str| self.cells(row).nth(column).is_some_and(|cell| cell.parse::<f64>().is_ok());
        let is_word = cell.chars().any(char::is_alphabetic);
        let has_number = |row: &str| self.cells(row).any(|cell| cell.parse::<f64>().is_ok());
        if fits {
            is_word && before.is_some_and(is_number)
        } else {
            (is_word || cell.len() > 2) && before.is_none_or(has_number)
        }
    }

    /// Checks whether a row has a mark before a number.
    fn is_commented_out(&self, line: &str) -> bool {
        let first = self.cells(line).next().unwrap_or_default();
        first.trim_start_matches('/').trim_start_matches(MARKS).trim_start().parse::<f64>().is_ok()
    }

    /// Finds the lines at the end that sum up the rows: their word is in no row above.
    fn summary(&self, text: &str, begin: Line, known: &[(usize, OddLine)]) -> Option<Vec<(usize, OddLine)>> {
        let count = text.lines().count();
        let from_end = text.lines().rev().enumerate().map(|(at, text)| (count - at, text.trim()));
        let is_known = |number: usize| known.iter().any(|(other, _)| *other == number);
        let rows = from_end.filter(|(number, line)| !line.is_empty() && !is_known(*number));
        let rows = rows.take_while(|(number, _)| *number > begin.number);
        let first_row = lines(text).find(|line| line.number > begin.number && self.fits(line.text))?;
        let last = rows.map_while(|(number, line)| Some((number, self.sums_up(line, first_row.text)?)));
        let last: Vec<(usize, (usize, String))> = last.collect();
        let first = last.iter().map(|(number, _)| *number).min().unwrap_or(0);
        let is_above = |(column, word): &(usize, String)| {
            let above = lines(text).take_while(|line| line.number < first);
            let is_it = |line: Line| {
                self.cells(line.text).nth(*column).is_some_and(|cell| cell.eq_ignore_ascii_case(word))
            };
            above.into_iter().any(is_it)
        };
        let said = last.into_iter().filter(|(_, place)| !is_above(place));
        Some(said.map(|(number, _)| (number, OddLine::Summary)).collect())
    }

    /// Returns the cell by which a line sums up, and its column: a word such as `Mean`, or more words after it where `row` has a number.
    fn sums_up(&self, line: &str, row: &str) -> Option<(usize, String)> {
        let is_word =
            |cell: &str| SUMMARY.contains(&cell.trim_end_matches([':', '=']).trim().to_lowercase().as_str());
        let is_number =
            |column: usize| self.cells(row).nth(column).is_some_and(|cell| cell.parse::<f64>().is_ok());
        let begins = |cell: &str| cell.split([' ', ':', '=']).next().is_some_and(is_word);
        let found = self.cells(line).enumerate();
        let found =
            found.into_iter().find(|(column, cell)| is_word(cell) || begins(cell) && is_number(*column));
        found.map(|(column, cell)| (column, cell.to_string()))
    }
}

/// Counts the cells of a line; separators in quotes are none.
fn width(line: &str, separator: char) -> usize {
    let outside = line.split('"').step_by(2);
    1 + outside.map(|part| part.matches(separator).count()).sum::<usize>()
}

fn blanked(text: &str, odd: &[(usize, OddLine)]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut next = odd.iter().map(|(number, _)| *number).peekable();
    for (at, line) in text.split_inclusive('\n').enumerate() {
        if next.next_if_eq(&(at + 1)).is_some() {
            out.push_str(&line[line.trim_end_matches(['\r', '\n']).len()..]);
        } else {
            out.push_str(line);
        }
    }
    out
}

/// Says which lines are left out, of each kind the first.
fn in_words(text: &str, odd: &[(usize, OddLine)]) -> String {
    let of_kind = |kind: OddLine| {
        let numbers: Vec<usize> =
            odd.iter().filter(|(_, other)| *other == kind).map(|(number, _)| *number).collect();
        let first = *numbers.first()?;
        let line: String = text.lines().nth(first - 1)?.trim().chars().take(SHOWN).collect();
        let more = if numbers.len() > 1 { format!(" and {} more", numbers.len() - 1) } else { String::new() };
        Some(format!("line {first} {line:?}{more} ({})", kind.words()))
    };
    let each = OddLine::ALL.into_iter().filter_map(of_kind).collect::<Vec<_>>().join(", ");
    let (is, they) = if odd.len() == 1 {
        ("is no row and is", "it is one")
    } else {
        ("are no rows and are", "one of them is")
    };
    format!("{} {is} left out: {each}; correct the file if {they}", plural(odd.len(), "line"))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Returns the lines that stay, and what is said of the others.
    fn kept(text: &str) -> (Vec<String>, String) {
        let (left, said) = match without_odd_lines(text, None, true) {
            Some(without) => (without.text, without.said),
            None => (text.to_string(), String::new()),
        };
        assert_eq!(left.lines().count(), text.lines().count(), "messages count lines");
        (lines(&left).map(|line| line.text.to_string()).collect(), said)
    }

    const TABLE: [&str; 5] = ["force,label", "1.5,cup", "2.5,can", "3.5,cup", "4.5,can"];

    /// Puts a line before line `at` of a table.
    fn with(at: usize, line: &str) -> String {
        let mut all = TABLE.to_vec();
        all.insert(at, line);
        all.join("\n") + "\n"
    }

    #[test]
    fn lines_that_are_no_rows_are_left_out_and_said() {
        for (at, line, words) in [
            (0, "Logger v2", "before the table"),
            (0, "# made by a logger, on Monday, by me", "before the table"),
            (0, "# made by, me", "before the table"),
            (2, "% calibrated", "a comment"),
            (2, "! gain, offset, unit", "a comment"),
            (2, "// gain", "a comment"),
            (2, "#2.5,can", "a comment"),
            (3, "force,label", "the header once more"),
            (3, "OVERFLOW", "a message"),
            (3, "OVERFLOW,", "a message"),
            (3, "-----", "a message"),
            (5, "Mean,3.0", "a summary"),
            (5, "3.0,mean", "a summary"),
            (5, "Total:,12.0,", "a summary"),
            (5, "Mean of all,can", "a summary"),
            (0, "My grasps,", "before the table"),
        ] {
            let (left, said) = kept(&with(at, line));
            assert_eq!(left, TABLE, "{line}");
            assert!(said.contains(&format!("line {} {line:?} ({words}", at + 1)), "{line}: {said}");
        }
        let (left, said) = kept(
            "A logger\r\nNo. 7\r\n\r\ntime;force\r\n0;1,5\r\n1;2,5\r\nOL\r\n2;3,5\r\nEND\r\n3;4,5\r\n4;1\r\n",
        );
        assert_eq!(left.len(), 6, "{left:?}");
        assert!(
            said.starts_with("4 lines are no rows") && said.contains("line 1 \"A logger\" and 1 more"),
            "{said}"
        );
    }

    #[test]
    fn what_may_be_a_row_stays() {
        for (at, line) in [(3, "5"), (3, "5,6,7"), (3, ",cup"), (3, "cup,5,6"), (0, "a,b,c"), (3, "mean,cup")]
        {
            let text = with(at, line);
            let stays = kept(&text).0.iter().any(|left| left == line);
            let is_header = at == 0;
            assert!(stays || is_header, "{line}");
        }
        for text in [
            // Names of columns without one for the names of rows.
            "a,b\n1,2,3\n2,3,4\n3,4,5\n",
            "time force x\n1,2,3\n2,3,4\n3,4,5\n",
            "# time force x\n1,2,3\n2,3,4\n3,4,5\n",
            "#time,force\n1,2\n2,3\n",
            "object,force\n#1,2\n#2,3\n#3,4\n",
            "label,force\ncup,1\nmax,2\ncan,2\nmax,3\n",
            "1\n2\nOVERFLOW\n3\n",
            "a,\"b\nc\"\n1,2\nOVERFLOW\n",
        ] {
            assert_eq!(kept(text).0, lines(text).map(|line| line.text).collect::<Vec<_>>(), "{text:?}");
        }
        let many = "a,b\n".to_string() + &"1,2\nOVERFLOW\n".repeat(8);
        assert!(kept(&many).1.is_empty(), "half of its readings may be lost");
    }

    #[test]
    fn a_list_keeps_entries_that_are_cut() {
        let list = "# by me\nfile,label,group\n1.csv,soft,1\n2.csv\n3.csv,hard,2\nmax,hard,2\n";
        let without = without_odd_lines(list, None, false).unwrap();
        assert_eq!(without.text, list.replace("# by me", ""));
    }

    #[test]
    fn a_comment_before_numbers_goes_where_it_is_no_header() {
        let (left, said) = kept("# logger of the lab, 2024\n1,2,3\n2,3,4\n3,4,5\n");
        assert_eq!((left.len(), said.contains("before the table")), (3, true), "{said}");
    }
}
