//! Decides what a column is, by its name and its cells: the one rule of all readers of columns.
//!
//! Time stamps, indices and columns without a name are never channels. Numbers that do not read as numbers (`1,5`, `12mV`)
//! are refused, since a channel would be missing without a word.

use crate::formats::table::column_name::{ColumnName, INDEX_WHY};
use crate::formats::table::number_form::{NumberForm, is_filled_in};
use crate::formats::table::options::Clock;
use crate::formats::table::time_text;
use std::collections::HashSet;

/// The kind of a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ColumnKind {
    Time(Clock),
    /// No channel: why.
    LeftOut(&'static str),
    Channel,
    Text,
    /// Numbers that do not read as numbers; the first of them.
    Disguised(Disguised),
}

/// A number that does not read as one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Disguised {
    pub line: u64,
    pub cell: String,
    pub form: NumberForm,
}

/// Fewest rows that show that a counter counts.
const COUNTED: usize = 3;
/// A counter leaps once in so many rows at most.
const LEAPS: usize = 5;
/// Fewest rows that show that numbers in another order are those of rows.
const NUMBERED: usize = 20;
/// Most rows that are looked at for that.
const MOST: usize = 1 << 20;
/// Letters of a cell that a message shows.
const SHOWN: usize = 40;
/// Why a column without a cell is no channel.
const EMPTY: &str = "empty";

/// Seconds since 1970 of the years 2001 and 2128.
const EPOCH: std::ops::Range<f64> = 1e9..5e9;

/// Watches the cells of one column.
#[derive(Debug)]
pub(crate) struct ColumnCells {
    name: ColumnName,
    numbers: usize,
    texts: usize,
    /// Cells that say that a value is missing.
    missing: usize,
    /// Texts that are dates or times of day.
    times: usize,
    disguised: usize,
    first_disguised: Option<Disguised>,
    first_number: f64,
    counter: Counter,
}

impl ColumnCells {
    /// Begins a column; `name` is none in a file without names.
    pub fn new(name: Option<&str>) -> Self {
        Self {
            name: name.map_or(ColumnName::Open, ColumnName::of),
            numbers: 0,
            texts: 0,
            missing: 0,
            times: 0,
            disguised: 0,
            first_disguised: None,
            first_number: 0.0,
            counter: Counter::default(),
        }
    }

    /// Takes the next cell, and the number that it is, if it is one.
    pub fn add(&mut self, line: u64, cell: &str, number: Option<f64>) {
        if let Some(number) = number {
            if self.numbers == 0 {
                self.first_number = number;
            }
            self.numbers += 1;
            if self.name == ColumnName::Counter {
                self.counter.add(number);
            }
            return;
        }
        if is_filled_in(cell) {
            self.missing += usize::from(!cell.is_empty());
            return;
        }
        self.texts += 1;
        self.times += usize::from(time_text::seconds(cell).is_some());
        if let Some(form) = NumberForm::of(cell) {
            self.disguised += 1;
            let cell = cell.chars().take(SHOWN).collect();
            self.first_disguised.get_or_insert(Disguised { line, cell, form });
        }
    }

    /// Checks whether further cells may change the kind.
    pub fn is_open(&self) -> bool {
        match self.name {
            ColumnName::LeftOut(_) => false,
            ColumnName::Time(_) => self.numbers + self.texts == 0,
            ColumnName::Counter => self.numbers == 0 || self.counter.is_open(),
            ColumnName::Open => self.numbers == 0,
        }
    }

    /// Returns the kind of the column.
    pub fn kind(self) -> ColumnKind {
        let is_written = self.numbers == 0 && self.times > 0 && self.times == self.texts;
        match self.name {
            ColumnName::LeftOut(why) => ColumnKind::LeftOut(why),
            ColumnName::Time(_) if is_written => ColumnKind::Time(Clock::Seconds),
            ColumnName::Time(clock) => ColumnKind::Time(clock.unwrap_or_else(|| epoch(self.first_number))),
            ColumnName::Counter if self.counter.is_index() => ColumnKind::LeftOut(INDEX_WHY),
            _ if self.numbers > 0 => ColumnKind::Channel,
            _ if self.texts + self.missing == 0 => ColumnKind::LeftOut(EMPTY),
            _ if is_written => ColumnKind::Time(Clock::Seconds),
            _ => match self.first_disguised {
                Some(first) if self.disguised == self.texts => ColumnKind::Disguised(first),
                _ => ColumnKind::Text,
            },
        }
    }
}

/// Returns the unit of a time stamp whose name has none: that in which it lies in this century, else seconds.
pub(crate) fn epoch(stamp: f64) -> Clock {
    let others = [Clock::Milliseconds, Clock::Microseconds, Clock::Nanoseconds];
    let is_it = |clock: &Clock| EPOCH.contains(&(stamp / clock.per_second()));
    others.into_iter().find(is_it).unwrap_or(Clock::Seconds)
}

/// Checks whether the cells of a first line number the columns as pandas does, `0,1,2`: such a line is a header. Beside
/// names of other columns it counts from 0 or 1, alone from 0.
pub fn numbers_columns<'c>(cells: impl Iterator<Item = &'c str>) -> bool {
    let (mut count, mut others, mut nameless, mut first) = (0u32, 0, 0, 0);
    for cell in cells {
        match cell.parse::<u32>() {
            Ok(number) => {
                if count == 0 {
                    first = number;
                }
                if number != first + count {
                    return false;
                }
                count += 1;
            }
            Err(_) if cell.parse::<f64>().is_ok() => return false,
            Err(_) if cell.is_empty() => nameless += 1,
            Err(_) => others += 1,
        }
    }
    match first {
        0 => count > 1 || count == 1 && nameless == 1 && others == 0,
        1 => count > 1 && nameless + others > 0,
        _ => false,
    }
}

/// Watches whether numbers count up by one: from their beginning again, or with a few leaps where other recordings begin or
/// rows are lost; or whether they number rows that were mixed.
#[derive(Debug)]
struct Counter {
    first: f64,
    last: f64,
    count: usize,
    /// Number of steps by one.
    rises: usize,
    is_whole: bool,
    /// All other steps lead back to the first number.
    is_exact: bool,
    /// The first numbers, while they are whole and none is there twice.
    numbers: Option<HashSet<i64>>,
}

impl Default for Counter {
    fn default() -> Self {
        let numbers = Some(HashSet::new());
        Self { first: 0.0, last: 0.0, count: 0, rises: 0, is_whole: true, is_exact: true, numbers }
    }
}

impl Counter {
    fn add(&mut self, number: f64) {
        self.is_whole &= number.fract() == 0.0;
        if let Some(numbers) = self.numbers.as_mut().filter(|numbers| numbers.len() < MOST) {
            let is_new = self.is_whole && number.abs() < 1e15 && numbers.insert(number as i64);
            if !is_new {
                self.numbers = None;
            }
        }
        if self.count == 0 {
            self.first = number;
        } else if number - self.last == 1.0 {
            self.rises += 1;
        } else {
            self.is_exact &= self.rises > 0 && number == self.first;
        }
        self.last = number;
        self.count += 1;
    }

    /// Counts the steps that are not by one.
    fn leaps(&self) -> usize {
        self.count.saturating_sub(1 + self.rises)
    }

    /// Checks whether further numbers may make it an index.
    fn is_open(&self) -> bool {
        let may_be_mixed = self.numbers.as_ref().is_some_and(|numbers| numbers.len() < MOST);
        let may_count = self.is_exact || self.count < LEAPS || self.leaps() <= self.rises;
        self.is_whole && (may_be_mixed || may_count)
    }

    fn is_index(&self) -> bool {
        let is_mostly = LEAPS * self.leaps() <= self.count;
        self.is_whole && self.count >= COUNTED && (self.is_exact || is_mostly) || self.is_mixed()
    }

    /// Checks whether the numbers are those of rows in another order, or of the half of them.
    fn is_mixed(&self) -> bool {
        let Some(numbers) = self.numbers.as_ref().filter(|numbers| numbers.len() >= NUMBERED) else {
            return false;
        };
        let (least, most) = (numbers.iter().min(), numbers.iter().max());
        least.zip(most).is_some_and(|(least, most)| most - least <= 2 * numbers.len() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(name: &str, cells: &[&str]) -> ColumnKind {
        let mut column = ColumnCells::new(Some(name));
        for (line, cell) in cells.iter().enumerate() {
            column.add(line as u64 + 2, cell, cell.parse().ok());
        }
        column.kind()
    }

    #[test]
    fn a_column_is_what_its_name_and_cells_say() {
        assert_eq!(kind("force", &["", "1.5", "2"]), ColumnKind::Channel);
        assert_eq!(kind("force", &["", ""]), ColumnKind::LeftOut(EMPTY));
        assert_eq!(kind("force", &["", "?"]), ColumnKind::Text);
        assert!(
            matches!(kind("force", &["OL", "1.5 N"]), ColumnKind::Disguised(_)),
            "out of range is no text"
        );
        assert_eq!(kind("object", &["can", "2"]), ColumnKind::Channel, "its first cell is refused");
        assert_eq!(kind("object", &["can", "1,5"]), ColumnKind::Text);
        let Disguised { line, cell, form } = match kind("force", &["-", "1,5", "2,5"]) {
            ColumnKind::Disguised(first) => first,
            other => panic!("{other:?}"),
        };
        assert_eq!((line, cell.as_str(), form), (3, "1,5", NumberForm::DecimalComma));
        assert!(matches!(kind("force", &["1 N", "12mV"]), ColumnKind::Disguised(_)));
        assert_eq!(
            kind("when", &["2024-05-01 12:00:00", "2024-05-01 12:00:01"]),
            ColumnKind::Time(Clock::Seconds)
        );
        assert_eq!(kind("time_ms", &["2024-05-01T12:00:00Z"]), ColumnKind::Time(Clock::Seconds));
        assert_eq!(kind("t_us", &["10"]), ColumnKind::Time(Clock::Microseconds));
        assert_eq!(kind("time", &["0.5"]), ColumnKind::Time(Clock::Seconds));
        assert_eq!(kind("time", &["1709281200000"]), ColumnKind::Time(Clock::Milliseconds));
        assert_eq!(kind("time", &["1709281200000000000"]), ColumnKind::Time(Clock::Nanoseconds));
    }

    #[test]
    fn a_counter_is_an_index_where_it_counts() {
        for cells in [
            &["7", "8", "9"][..],
            &["0", "1", "2", "0", "1"],
            &["0", "1", "2", "3", "4", "9", "10", "11", "12", "13"],
            &["1", "2", "3", "4", "6", "7", "8"],
        ] {
            assert_eq!(kind("index", cells), ColumnKind::LeftOut(INDEX_WHY), "{cells:?}");
        }
        for cells in [
            &["5.1", "5.0", "5.2"][..],
            &["1", "2"],
            &["8", "10", "12"],
            &["1", "2", "4"],
            &["0", "1", "2", "0", "1", "2", "5"],
            &["3", "2", "1"],
            &["1", "1", "1"],
        ] {
            assert_eq!(kind("index", cells), ColumnKind::Channel, "a finger: {cells:?}");
        }
        assert_eq!(kind("force", &["1", "2", "3"]), ColumnKind::Channel, "by its numbers alone");
        // Rows that were mixed keep their numbers.
        let mixed = |step: usize| (0..20).map(|at| (7 * at % 20 * step).to_string()).collect::<Vec<_>>();
        let of = |cells: &[String]| kind("index", &cells.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(of(&mixed(1)), ColumnKind::LeftOut(INDEX_WHY));
        assert_eq!(of(&mixed(2)), ColumnKind::LeftOut(INDEX_WHY), "half of the rows");
        assert_eq!(of(&mixed(1)[..19]), ColumnKind::Channel, "few rows");
        assert_eq!(of(&mixed(3)), ColumnKind::Channel, "far apart");
        assert_eq!(of(&[mixed(1), vec!["3".into()]].concat()), ColumnKind::Channel, "one is there twice");
    }

    #[test]
    fn a_line_that_numbers_the_columns_is_a_header() {
        for (cells, is_header) in [
            (&["0", "1", "2"][..], true),
            (&["0", "1"], true),
            (&["", "0", "1"], true),
            (&["", "0"], true),
            (&["time", "0", "1"], true),
            (&["a", "0"], false),
            (&["a", "1"], false),
            (&["time", "1", "2"], true),
            (&["1", "2", "3"], false),
            (&["0"], false),
            (&["0", "0"], false),
            (&["0", "1.0"], false),
            (&["a", "b"], false),
        ] {
            assert_eq!(numbers_columns(cells.iter().copied()), is_header, "{cells:?}");
        }
    }
}
