//! Which numbers of a line are a time step, and which is its time.

use taxel_data::{Clock, ColumnName, Layout, SampleSpec};

use crate::channels::StreamChannels;
use crate::fault::Fault;
use crate::numbers::{LineNumbers, Names};
use crate::time_column::Time;

/// Makes time steps of lines.
///
/// A line is numbers separated by commas (or, where there are none, by semicolons, tabs or spaces), a JSON array, or a
/// JSON object. A first line without any number names the columns. Columns are found by the names of the model's channels
/// where it knows any, and a missing one is refused. Otherwise all are channels but time and indices
/// ([`ColumnName`](taxel_data::ColumnName)); of a recording with more channels than the model reads, its channels are taken.
#[derive(Debug, Clone)]
pub struct LineColumns {
    /// Values of a time step; 0 for as many as the first line has.
    each: usize,
    /// Where nobody knows them, the channels as the first line has them.
    any: Option<StreamChannels>,
    /// Channels kept of more, along the first axis of a sample, where that is not time.
    channels: Option<Vec<usize>>,
    /// Names of the model's channels.
    model_names: Vec<String>,
    time: Option<Time>,
    clock: Option<Clock>,
    names: Names,
    numbers: LineNumbers,
    taken: Option<Taken>,
}

/// Which numbers of a line are used.
#[derive(Debug, Clone, PartialEq)]
struct Taken {
    width: usize,
    time: Option<usize>,
    /// Which number each value is.
    values: Vec<usize>,
}

impl LineColumns {
    /// Prepares for time steps of this kind; `time` says where stamps are, `clock` their unit. By default a column called `time`,
    /// `timestamp` or `t` is it, with its unit at the end, `time_ms`, or in seconds.
    pub fn new(spec: &SampleSpec, time: Option<Time>, clock: Option<Clock>) -> Self {
        let (before, _, after) = spec.around_time();
        let of_table = || spec.table.as_ref().map_or(vec![], |table| table.columns.clone());
        let model_names = if spec.channel_names.is_empty() { of_table() } else { spec.channel_names.clone() };
        let channels = spec.channels.clone().filter(|kept| {
            matches!(spec.layout, Layout::Series | Layout::Fingers) && spec.shape.first() == Some(&kept.len())
        });
        LineColumns {
            each: before * after,
            any: None,
            channels,
            model_names,
            time,
            clock,
            names: Names::default(),
            numbers: LineNumbers::default(),
            taken: None,
        }
    }

    /// Prepares for time steps of channels that nobody knows: all columns of the first line but time and indices. Also returns
    /// where their names will be.
    pub fn any(time: Option<Time>, clock: Option<Clock>) -> (Self, StreamChannels) {
        let channels = StreamChannels::default();
        let columns = Self::new(&SampleSpec::new(Layout::Series, &[1, 1]), time, clock);
        (LineColumns { each: 0, any: Some(channels.clone()), ..columns }, channels)
    }

    /// Says what a line has to be, for messages.
    pub(crate) fn wanted(&self) -> String {
        if self.each == 0 { "a reading".into() } else { format!("a reading of {} numbers", self.each) }
    }

    /// Takes the names of channels that nobody knew, of a source without lines.
    #[cfg(feature = "mcap")]
    pub(crate) fn found(&self, names: &[String]) {
        if let Some(channels) = &self.any {
            channels.found(names.to_vec());
        }
    }

    /// Counts the values of a time step; 0 of channels that nobody knows.
    pub fn each(&self) -> usize {
        self.each
    }

    /// Reads a line into `values`; returns its time stamp in seconds, none where the line is blank, or names columns.
    pub(crate) fn read(&mut self, line: &str, values: &mut Vec<f32>) -> Result<Option<Option<f64>>, Fault> {
        let line = line.trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}');
        values.clear();
        if line.is_empty() || self.names.are_named(line, self.taken.is_none()) {
            return Ok(None);
        }
        let is_time = |at: usize, name: Option<&str>| match (&self.time, name) {
            (Some(Time::At(column)), _) => at == *column,
            (Some(Time::Named(column)), Some(name)) => column.eq_ignore_ascii_case(name),
            (None, Some(name)) => {
                Clock::of_column(name).is_some() && !self.model_names.iter().any(|known| known == name)
            }
            (Some(Time::Named(_)) | None, None) => false,
        };
        self.numbers.read(line, &mut self.names, is_time)?;
        let (width, time) = (self.numbers.values.len(), self.numbers.time);
        if self.taken.as_ref().is_none_or(|taken| taken.width != width || taken.time != time) {
            let taken = self.take(width, time);
            // A field that is no number explains a wrong count best.
            let taken = taken.map_err(|fault| match fault {
                Fault::Names(_) => fault,
                fault => self.numbers.no_number(line).unwrap_or(fault),
            })?;
            self.taken = Some(taken);
        }
        let taken = self.taken.iter().flat_map(|taken| &taken.values);
        for &at in taken {
            let value = self.numbers.values[at];
            if !value.is_finite() {
                return Err(self.numbers.fault(line, at));
            }
            values.push(value);
        }
        let stamp = self.numbers.stamp.map(|stamp| stamp / self.clock().per_second());
        match stamp {
            Some(stamp) if !stamp.is_finite() => Err(Fault::NotFinite(format!("its time stamp is {stamp}"))),
            stamp => Ok(Some(stamp)),
        }
    }

    fn clock(&self) -> Clock {
        if self.numbers.is_date {
            return Clock::Seconds;
        }
        let named = || self.names.of_time(self.numbers.time).and_then(Clock::of_column);
        self.clock.or_else(named).unwrap_or(Clock::Seconds)
    }

    /// Finds which of `width` numbers are the values of a time step.
    fn take(&self, width: usize, time: Option<usize>) -> Result<Taken, Fault> {
        self.refuse_no_time(width, time)?;
        let knows_names = self.model_names.len() == self.each && self.each > 0;
        // A first line that has other columns was no header.
        let named: Option<Vec<usize>> = if knows_names && self.names.of_numbers().len() == width {
            let places = self.model_names.iter().map(|name| self.names.position(name));
            Some(places.collect::<Result<_, _>>()?)
        } else {
            None
        };
        let is_index = |at: &usize| {
            let name = self.names.of_numbers().get(*at).map(|name| ColumnName::of(name));
            matches!(name, Some(ColumnName::LeftOut(_)))
        };
        let others: Vec<usize> = (0..width).filter(|at| Some(*at) != time && !is_index(at)).collect();
        let fits = if self.any.is_some() { !others.is_empty() } else { others.len() == self.each };
        let values = named.or_else(|| fits.then(|| others.clone())).or_else(|| {
            let channels = self.channels.as_ref().filter(|channels| !channels.is_empty())?;
            let inner = self.each / channels.len();
            let of =
                |channel: &usize| (channel * inner..(channel + 1) * inner).map(|at| others.get(at).copied());
            channels.iter().flat_map(of).collect()
        });
        let refuse = || {
            if self.any.is_some() {
                return Fault::Columns("it has no number beside the time stamp".into());
            }
            let stamp = match (time, others.len() == self.each + 1) {
                (Some(_), _) => " beside the time stamp",
                (None, true) => "; if the first is a time stamp, say --time 1",
                (None, false) => "",
            };
            Fault::Columns(format!(
                "it has {} numbers, a reading of the model has {}{stamp}",
                others.len(),
                self.each
            ))
        };
        let values = values.ok_or_else(refuse)?;
        match &self.taken {
            Some(before) if before.width != width => {
                Err(Fault::Columns(format!("it has {width} columns, lines before had {}", before.width)))
            }
            _ => {
                if let Some(any) = &self.any {
                    let names = self.names.of_numbers();
                    let named = values.iter().filter(|_| names.len() == width);
                    any.found(named.map(|at| names[*at].clone()).collect());
                }
                Ok(Taken { width, time, values })
            }
        }
    }

    /// Refuses lines without the column of time stamps that was named.
    fn refuse_no_time(&self, width: usize, time: Option<usize>) -> Result<(), Fault> {
        match &self.time {
            Some(Time::Named(name)) if time.is_none() => {
                let held = self.names.held();
                Err(Fault::Names(format!(
                    "there is no column of time stamps {name:?}, which --time names; {held}"
                )))
            }
            Some(Time::At(at)) if *at >= width => {
                Err(Fault::Columns(format!("it has {width} columns, and --time names column {}", at + 1)))
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use taxel_data::TableOptions;

    use super::*;

    fn series(channels: usize) -> SampleSpec {
        SampleSpec::new(Layout::Series, &[channels, 10])
    }

    fn plain(spec: &SampleSpec) -> LineColumns {
        LineColumns::new(spec, None, None)
    }

    type Read = Option<(Vec<f32>, Option<f64>)>;

    fn read(columns: &mut LineColumns, line: &str) -> Result<Read, Fault> {
        let mut values = vec![];
        Ok(columns.read(line, &mut values)?.map(|stamp| (values, stamp)))
    }

    fn good(columns: &mut LineColumns, line: &str) -> (Vec<f32>, Option<f64>) {
        read(columns, line)
            .unwrap_or_else(|e| panic!("{line:?}: {e:?}"))
            .unwrap_or_else(|| panic!("{line:?}"))
    }

    #[test]
    fn numbers_are_read_however_they_are_parted() {
        for line in
            ["1,2.5", " 1 , 2.5\r", "1;2.5", "1\t2.5", "1  2.5", "[1, 2.5]", "[[1],[2.5]]", "\u{feff}1,25e-1"]
        {
            assert_eq!(good(&mut plain(&series(2)), line), (vec![1.0, 2.5], None), "{line:?}");
        }
        assert_eq!(read(&mut plain(&series(2)), "  \r").unwrap(), None);
    }

    #[test]
    fn time_is_a_column_by_number_name_or_header() {
        let stamped = |time: &str, clock| LineColumns::new(&series(2), Some(time.parse().unwrap()), clock);
        let want = (vec![1.0, 2.0], Some(0.5));
        assert_eq!(good(&mut stamped("1", None), "0.5,1,2"), want);
        assert_eq!(good(&mut stamped("3", Some(Clock::Milliseconds)), "1,2,500"), want);
        let mut header = plain(&series(2));
        assert_eq!(read(&mut header, "a,time_ms,b").unwrap(), None);
        assert_eq!(good(&mut header, "1,500,2"), want);
        assert_eq!(read(&mut header, "a,time_ms,b").unwrap(), None, "a device that starts again");
        let mut named = stamped("stamp", None);
        read(&mut named, "stamp;a;b").unwrap();
        assert_eq!(good(&mut named, "0.5;1;2"), want);
        for line in
            [r#"{"t":0.5,"a":1,"b":2}"#, r#"{"a":1,"b":2,"time":0.5,"ok":true}"#, r#"{"t":0.5,"x":[1,2]}"#]
        {
            assert_eq!(good(&mut plain(&series(2)), line), want, "{line}");
        }
        assert!("0".parse::<Time>().is_err());
        for (time, line) in [("nosuch", "1,2"), ("nosuch", r#"{"t":0.5,"a":1,"b":2}"#), ("4", "1,2")] {
            let refused = read(&mut stamped(time, None), line).unwrap_err();
            let (Fault::Columns(why) | Fault::Names(why)) = &refused else { panic!("{refused:?}") };
            assert!(why.contains("--time"), "{why}");
        }
        // Nanoseconds since 1970 keep their microseconds.
        let mut long = stamped("1", Some(Clock::Nanoseconds));
        let (_, stamp) = good(&mut long, "1795363200123456789,1,2");
        assert!((stamp.unwrap() - 1_795_363_200.123_456_7).abs() < 1e-6);
    }

    #[test]
    fn channels_are_found_by_name_and_taken_of_more() {
        let table = TableOptions { columns: vec!["thumb".into(), "index".into()], ..TableOptions::default() };
        let mut by_name = plain(&SampleSpec { table: Some(table), ..series(2) });
        read(&mut by_name, "index,id,thumb").unwrap();
        assert_eq!(good(&mut by_name, "1,left,2").0, [2.0, 1.0]);
        assert_eq!(good(&mut by_name, r#"{"thumb":3,"id":"x","index":4}"#).0, [3.0, 4.0]);
        let mut objects = plain(&series(2));
        assert_eq!(good(&mut objects, r#"{"a":1,"b":2}"#).0, [1.0, 2.0]);
        assert_eq!(good(&mut objects, r#"{"b":2,"a":1}"#).0, [1.0, 2.0], "the first object says the order");
        let mut some = plain(&SampleSpec { channels: Some(vec![2, 0]), ..series(2) });
        assert_eq!(good(&mut some, "5,6,7,8").0, [7.0, 5.0]);
        let fingers = SampleSpec::new(Layout::Fingers, &[1, 2, 10]);
        let mut second = plain(&SampleSpec { channels: Some(vec![1]), ..fingers });
        assert_eq!(good(&mut second, "1,2,3,4").0, [3.0, 4.0]);
    }

    #[test]
    fn channels_that_nobody_knows_are_those_of_the_first_line() {
        for (header, line, names) in [
            ("thumb,time_ms,id,index", "1,500,7,2", &["thumb", "index"][..]),
            ("", r#"{"t":0.5,"a":1,"b":2}"#, &["a", "b"]),
            ("a banner of three and more", "1,2", &[]),
        ] {
            let (mut columns, channels) = LineColumns::any(None, None);
            assert_eq!(read(&mut columns, header).unwrap(), None, "{header}");
            assert_eq!(channels.names(), None);
            assert_eq!(good(&mut columns, line).0, [1.0, 2.0], "{header}");
            assert_eq!(channels.names().unwrap(), names, "{header}");
            assert!(matches!(read(&mut columns, "1,2,3,4,5"), Err(Fault::Columns(_))), "{header}");
        }
        let (mut stamps, _) = LineColumns::any(Some(Time::At(0)), None);
        assert!(matches!(read(&mut stamps, "0.5"), Err(Fault::Columns(_))));
    }

    #[test]
    fn names_of_the_model_are_found_or_refused() {
        let names = ["thumb", "index"].map(String::from).to_vec();
        let known = || plain(&SampleSpec { channel_names: names.clone(), ..series(2) });
        for header in ["index,id,thumb", ",index,ring,thumb", "time_ms,index,thumb"] {
            let mut columns = known();
            assert_eq!(read(&mut columns, header).unwrap(), None, "{header}");
            let line = header
                .replace("thumb", "1")
                .replace("index", "2")
                .replace(|c: char| c.is_alphabetic() || c == '_', "");
            let line = line
                .split(',')
                .map(|cell| if cell.is_empty() { "9" } else { cell })
                .collect::<Vec<_>>()
                .join(",");
            assert_eq!(good(&mut columns, &line).0, [1.0, 2.0], "{header}: {line}");
        }
        assert_eq!(good(&mut known(), r#"{"x":[7,8],"index":2,"thumb":1}"#).0, [1.0, 2.0]);
        assert_eq!(good(&mut known(), "1,2").0, [1.0, 2.0], "lines without names");
        let lists = SampleSpec { channel_names: vec!["x[1]".into(), "a".into()], ..series(2) };
        assert_eq!(good(&mut plain(&lists), r#"{"a":3,"x":[7,8]}"#).0, [8.0, 3.0]);
        for (header, line, part) in [
            ("thumb,ring", "1,2", "no channel \"index\", which the model reads; there are thumb, ring"),
            ("thumb,index,thumb", "1,2,3", "two columns are named \"thumb\""),
        ] {
            let mut columns = known();
            read(&mut columns, header).unwrap();
            assert!(
                matches!(read(&mut columns, line), Err(Fault::Names(why)) if why.contains(part)),
                "{header}"
            );
        }
    }

    #[test]
    fn indices_are_no_channels_and_dates_are_stamps() {
        for header in ["Unnamed: 0,a,t,b", ",a,t,b", "frame_index,a,t,b"] {
            let mut columns = plain(&series(2));
            read(&mut columns, header).unwrap();
            assert_eq!(good(&mut columns, "7,1,0.5,2"), (vec![1.0, 2.0], Some(0.5)), "{header}");
            assert_eq!(good(&mut columns, "7,1,1970-01-01T00:00:02.5Z,2"), (vec![1.0, 2.0], Some(2.5)));
        }
        let object = r#"{"time_ms":"1970-01-01 00:00:02.5","a":1,"b":2}"#;
        assert_eq!(good(&mut plain(&series(2)), object), (vec![1.0, 2.0], Some(2.5)));
        let mut numbered = plain(&series(3));
        assert_eq!(read(&mut numbered, "0,1,2").unwrap(), None);
        assert_eq!(good(&mut numbered, "5,6,7").0, [5.0, 6.0, 7.0]);
    }

    #[test]
    fn a_column_of_time_that_is_not_there_is_refused() {
        let named = || LineColumns::new(&series(2), Some(Time::Named("nosuch".into())), None);
        for lines in [&["t,a,b", "0,1,2"][..], &["1,2"], &[r#"{"t":0,"a":1,"b":2}"#]] {
            let mut columns = named();
            let last = lines.iter().map(|line| read(&mut columns, line)).last().unwrap();
            assert!(matches!(last, Err(Fault::Names(why)) if why.contains("nosuch")), "{lines:?}");
        }
        let mut far = LineColumns::new(&series(2), Some(Time::At(8)), None);
        assert!(
            matches!(read(&mut far, "1,2"), Err(Fault::Columns(why)) if why.contains("--time names column 9"))
        );
    }

    #[test]
    fn what_is_no_reading_says_why() {
        let refused = |lines: &[&str]| {
            let mut columns = plain(&series(2));
            let mut last = Ok(None);
            lines.iter().for_each(|line| last = read(&mut columns, line));
            last.unwrap_err()
        };
        let malformed = |part: &str, lines: &[&str]| match refused(lines) {
            Fault::Malformed(why) => assert!(why.contains(part), "{why}"),
            other => panic!("{lines:?}: {other:?}"),
        };
        malformed("column 2: \"x\" is no number", &["1,2", "1,x"]);
        malformed("column 1: \"\" is no number", &["1,2", ",2"]);
        malformed("\"b\" is no number", &["a,b", "1,b"]);
        malformed("JSON", &["[1,2"]);
        malformed("\"b\"", &[r#"{"a":1,"b":2}"#, r#"{"a":1}"#]);
        malformed("column 2", &["1,2", "1,2;3"]);
        let columns = |part: &str, lines: &[&str]| match refused(lines) {
            Fault::Columns(why) => assert!(why.contains(part), "{why}"),
            other => panic!("{lines:?}: {other:?}"),
        };
        columns(
            "it has 3 numbers, a reading of the model has 2; if the first is a time stamp, say --time 1",
            &["1,2,3"],
        );
        columns("1 numbers", &["1,2", "5"]);
        assert!(matches!(refused(&["1,2", "1,NaN"]), Fault::NotFinite(why) if why.contains("column 2")));
        assert!(matches!(refused(&["t,a,b", "inf,1,2"]), Fault::NotFinite(_)));
    }
}
