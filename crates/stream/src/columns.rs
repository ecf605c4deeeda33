//! Which numbers of a line are a time step, and which is its time.

use taxel_data::{Clock, ColumnName, Layout, SampleSpec};

use crate::channels::StreamChannels;
use crate::fault::Fault;
use crate::numbers::{LineNumbers, Names, fields, is_header, listed};
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
        if line.is_empty()
            || self.is_late_header(line)?
            || self.names.are_named(line, self.taken.is_none())?
        {
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
        self.names.used();
        let stamp = self.numbers.stamp.map(|stamp| stamp / self.clock().per_second());
        match stamp {
            Some(stamp) if !stamp.is_finite() => Err(Fault::NotFinite(format!("its time stamp is {stamp}"))),
            stamp => Ok(Some(stamp)),
        }
    }

    /// Checks for a first header after lines of numbers, which were read by their places.
    ///
    /// # Errors
    /// A header that names them otherwise than the model does.
    fn is_late_header(&self, line: &str) -> Result<bool, Fault> {
        let knows_names = self.model_names.len() == self.each && self.each > 0;
        let Some(taken) = self.taken.as_ref().filter(|_| knows_names && self.names.of_numbers().is_empty())
        else {
            return Ok(false);
        };
        if !is_header(line) {
            return Ok(false);
        }
        let is_there =
            |(name, at): (&String, &usize)| fields(line).nth(*at).is_some_and(|field| field == name);
        if self.model_names.iter().zip(&taken.values).all(is_there) {
            return Ok(true);
        }
        Err(Fault::Names(format!(
            "it names the columns {}, and the lines before it were read by their places as {}; begin the stream with this line",
            listed(fields(line)),
            listed(self.model_names.iter().map(String::as_str))
        )))
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
