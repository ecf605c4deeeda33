//! Lines of text as time steps.

use std::io::Read;
use std::time::Instant;

use crate::columns::LineColumns;
use crate::error::{Error, Result};
use crate::fault::Fault;
use crate::lines::{InputLine, Lines};
use crate::numbers::are_names;
use crate::pace::Pacer;
use crate::queue::{Closed, Feed, Skip, StreamCounters};

/// Bytes that a number of a line may take, and those that any line may.
const BYTES: (usize, usize) = (64, 1 << 16);

/// Where lines come from, and what is said about them.
pub(crate) struct Text<'s> {
    /// Name of the source in messages.
    pub label: String,
    pub columns: LineColumns,
    pub pacer: Pacer,
    /// Time steps per second of lines without time stamps; none where they are as old as their arrival says.
    pub rate: Option<f64>,
    /// The first line may be the end of one: that of a port which sends whether somebody listens or not.
    pub begins_inside: bool,
    /// Hears what is odd, once of each kind.
    pub say: &'s dyn Fn(&str),
}

impl Text<'_> {
    /// Reads all lines to the end.
    ///
    /// # Errors
    /// A source that breaks off; one in which nothing is a time step.
    pub fn feed(mut self, from: impl Read, feed: &mut Feed) -> Result<()> {
        let most = BYTES.1.max(BYTES.0 * self.columns.each());
        let mut lines = Lines::new(from, most);
        let (mut number, mut readings) = (0u64, 0u64);
        let mut values = Vec::with_capacity(self.columns.each());
        let mut first: Option<String> = None;
        loop {
            let line = lines.next().map_err(|e| self.broken(&e.to_string()))?;
            let Some(line) = line else { break };
            number += 1;
            feed.counters.line();
            // A number that is cut is a number too. Names of columns do no harm.
            if number == 1 && self.begins_inside && !line.has_names_alone() {
                continue;
            }
            if number > 1 && line.is_word("tare") {
                if let Err(Closed) = feed.tare() {
                    return Ok(());
                }
                continue;
            }
            let read = match line {
                InputLine::TooLong => Err((Some(Skip::TooLong), format!("it is longer than {most} bytes"))),
                InputLine::Whole(line) => match std::str::from_utf8(line) {
                    Ok(line) => self.columns.read(line, &mut values).map_err(Fault::parts),
                    Err(_) => Err((Some(Skip::Malformed), "it is no text (UTF-8)".into())),
                },
            };
            match read {
                Ok(None) => continue,
                Ok(Some(stamp)) => {
                    let stamp = stamp.or(self.rate.map(|rate| readings as f64 / rate));
                    self.wait(stamp)?;
                    let at = if self.pacer.drops() { Instant::now() } else { lines.arrived() };
                    if let Err(Closed) = feed.reading(&values, stamp, at) {
                        return Ok(());
                    }
                }
                Err((None, why)) => return Err(self.broken(&format!("line {number}: {why}"))),
                Err((Some(kind), why)) => {
                    let why = format!("line {number}: {why}");
                    self.skip(&feed.counters, kind, &why);
                    feed.skip();
                    first.get_or_insert(why);
                }
            }
            readings += 1;
        }
        match (feed.counters.now().readings, first) {
            (0, Some(why)) => {
                Err(self.broken(&format!("nothing in {number} lines is {}: {why}", self.columns.wanted())))
            }
            (0, None) => {
                let wanted = self.columns.wanted();
                Err(self.broken(&format!("nothing came; a line is {wanted}, as 0.5,1.5")))
            }
            _ => Ok(()),
        }
    }

    fn wait(&mut self, stamp: Option<f64>) -> Result<()> {
        match stamp {
            Some(stamp) => self.pacer.wait(stamp),
            None if self.pacer.needs_stamps() => {
                let why = "no rate is known, neither by time stamps nor by the model; say --rate HZ";
                return Err(self.broken(why));
            }
            None => {}
        }
        Ok(())
    }

    fn skip(&self, counters: &StreamCounters, kind: Skip, why: &str) {
        if counters.skip(kind) {
            (self.say)(&format!("{}: {why}; skipped. It is said once, the summary counts them", self.label));
        }
    }

    fn broken(&self, why: &str) -> Error {
        Error::Source { source_label: self.label.clone(), why: why.into() }
    }
}

impl Fault {
    /// Says how a line is counted that is skipped, and why; a fault of all lines is not counted.
    fn parts(self) -> (Option<Skip>, String) {
        match self {
            Fault::Malformed(why) => (Some(Skip::Malformed), why),
            Fault::Columns(why) => (Some(Skip::Columns), why),
            Fault::NotFinite(why) => (Some(Skip::NotFinite), why),
            Fault::Names(why) => (None, why),
        }
    }
}

impl InputLine<'_> {
    /// Checks whether it is this word alone.
    fn is_word(&self, word: &str) -> bool {
        matches!(self, InputLine::Whole(line) if line.trim_ascii().eq_ignore_ascii_case(word.as_bytes()))
    }

    /// Checks whether a line holds names of columns and no numbers.
    fn has_names_alone(&self) -> bool {
        match self {
            InputLine::TooLong => false,
            InputLine::Whole(line) => std::str::from_utf8(line).is_ok_and(|line| are_names(line.trim())),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use taxel_data::{Layout, SampleSpec};

    use super::*;
    use crate::pace::Pace;
    use crate::queue::{Next, queue};

    /// Reads the time steps of two channels in a text.
    fn readings(text: &str, begins_inside: bool) -> Vec<Vec<f32>> {
        let columns = LineColumns::new(&SampleSpec::new(Layout::Series, &[2, 4]), None, None);
        let label = "port".to_string();
        let pacer = Pacer::new(Pace::Fast);
        let lines = Text { label, columns, pacer, rate: None, begins_inside, say: &|_| {} };
        let (mut feed, stream) = queue(2, false);
        lines.feed(text.as_bytes(), &mut feed).unwrap();
        let mut all = vec![];
        while let Next::Reading(arrival) = stream.waiting() {
            all.push(arrival.values);
        }
        all
    }

    #[test]
    fn the_end_of_a_line_is_no_reading_of_a_port() {
        // Of "21.5,3".
        let text = "1.5,3\n22,4\n23,5\n";
        assert_eq!(readings(text, true), [[22.0, 4.0], [23.0, 5.0]]);
        assert_eq!(
            readings(text, false),
            [[1.5, 3.0], [22.0, 4.0], [23.0, 5.0]],
            "a file begins with a line"
        );
        for first in ["", "5]", "[1,2]", "{\"a\":1,\"b\":2}", ",3"] {
            assert_eq!(readings(&format!("{first}\n22,4\n"), true), [[22.0, 4.0]], "{first}");
        }
    }

    #[test]
    fn names_of_columns_are_heard_in_the_first_line_of_a_port() {
        assert_eq!(readings("a,t_ms,b\n22,10,4\n", true), [[22.0, 4.0]]);
    }
}
