//! The numbers of a line of CSV or JSON.

use serde_json::Value;
use taxel_data::{numbers_columns, seconds_of_date};

use crate::fault::Fault;

/// Letters of a line that a message shows.
const SHOWN: usize = 40;
/// Separators of fields, the first that is there; else blanks are.
const SEPARATORS: [char; 3] = [',', ';', '\t'];
/// Names that a message lists.
const SHOWN_NAMES: usize = 16;

/// Names of the columns, by a header or the first object.
#[derive(Debug, Clone, Default)]
pub(crate) struct Names {
    names: Vec<String>,
    /// Names of the numbers: under a key of several, each with its place.
    of_numbers: Vec<String>,
    /// Nothing was read since they were named; a line of units may follow.
    is_fresh: bool,
    /// They are those of a header, and not the words of a message.
    is_sure: bool,
}

/// The numbers of the last line.
#[derive(Debug, Clone, Default)]
pub(crate) struct LineNumbers {
    /// Every number, NaN where there is none and in place of the time stamp.
    pub values: Vec<f32>,
    /// Where the time stamp stands among them.
    pub time: Option<usize>,
    pub stamp: Option<f64>,
    /// The stamp was a date, and is in seconds.
    pub is_date: bool,
}

impl Names {
    /// Checks whether a line names the columns: the first that is no blank (`first`), without any number, or the same again.
    ///
    /// # Errors
    /// Other names than before: what follows are other channels.
    pub fn are_named(&mut self, line: &str, first: bool) -> Result<bool, Fault> {
        if line.starts_with(['[', '{']) {
            return Ok(false);
        }
        // A first time step of two numbers may be 0,1 too.
        let begins = || are_names(line) || fields(line).count() > 2 && numbers_columns(fields(line));
        if self.names.is_empty() {
            if first && begins() {
                self.name(line);
            }
            return Ok(!self.names.is_empty());
        }
        if fields(line).eq(self.names.iter().map(String::as_str)) {
            self.is_fresh = true;
            return Ok(true);
        }
        // Words of a program that starts, before the header.
        if first && is_header(line) && !self.is_sure {
            self.name(line);
            return Ok(true);
        }
        let shared = fields(line).filter(|field| self.names.iter().any(|name| name == field)).count();
        // Without separators, words may be a sentence: `thumb lost`.
        let (known, has_separator) = (self.names.len(), line.contains(SEPARATORS));
        let is_alike = if has_separator { 2 * shared >= known } else { known > 1 && shared >= known };
        let is_other =
            is_header(line) && (!self.is_fresh || shared > 0) || are_names(line) && shared > 0 && is_alike;
        if !is_other {
            return Ok(false);
        }
        Err(self.changed(fields(line)))
    }

    /// Refuses an object whose numbers lie under other keys than before. A message, such as `{"uptime": 5}`, has fewer.
    fn refuse_other_keys(&self, object: &serde_json::Map<String, Value>) -> Result<(), Fault> {
        if self.names.iter().all(|name| object.contains_key(name)) {
            return Ok(());
        }
        let found = object.iter().filter(|(_, value)| value.is_number() || count(value) > 0);
        let found: Vec<&String> = found.map(|(key, _)| key).collect();
        let known = found.iter().filter(|key| self.names.contains(key)).count();
        if known == found.len() || known == 0 && found.len() != self.names.len() {
            return Ok(());
        }
        Err(self.changed(found.into_iter().map(String::as_str)))
    }

    /// Says that what follows has other names.
    fn changed<'n>(&self, found: impl Iterator<Item = &'n str>) -> Fault {
        let (expected, found) = (listed(self.names.iter().map(String::as_str)), listed(found));
        Fault::Names(format!(
            "the names of the columns change: expected {expected}, as before, and found {found}; end the stream there and begin \
             another one, or send one header throughout"
        ))
    }

    /// Takes the fields of a line as names.
    fn name(&mut self, line: &str) {
        self.names = fields(line).map(str::to_string).collect();
        self.of_numbers = self.names.clone();
        (self.is_fresh, self.is_sure) = (true, is_header(line));
    }

    /// Notes that a line of numbers was read.
    pub fn used(&mut self) {
        self.is_fresh = false;
    }

    /// Returns the names of the numbers; none of lines without names.
    pub fn of_numbers(&self) -> &[String] {
        &self.of_numbers
    }

    /// Returns the number of this name, which has to be the only one.
    pub fn position(&self, name: &str) -> Result<usize, Fault> {
        let mut at = (0..self.of_numbers.len()).filter(|at| self.of_numbers[*at] == name);
        match (at.next(), at.next()) {
            (Some(one), None) => Ok(one),
            (None, _) => Err(Fault::Names(format!(
                "there is no channel {name:?}, which the model reads; {}",
                self.held()
            ))),
            (Some(_), Some(_)) => Err(Fault::Names(format!("two columns are named {name:?}; rename one"))),
        }
    }

    /// Lists the names for a message.
    pub fn held(&self) -> String {
        if self.of_numbers.is_empty() {
            return "columns have no names".into();
        }
        format!("there are {}", listed(self.of_numbers.iter().map(String::as_str)))
    }

    /// Takes the names of an object whose keys hold numbers.
    fn take(
        &mut self,
        object: &serde_json::Map<String, Value>,
        is_time: &impl Fn(usize, Option<&str>) -> bool,
    ) {
        let mut at = 0;
        for (name, value) in object {
            let is_date =
                value.as_str().is_some_and(|text| seconds_of_date(text).is_some()) && is_time(at, Some(name));
            let count = if value.is_number() || is_date { 1 } else { count(value) };
            if value.is_array() || count == 1 {
                self.names.push(name.clone());
                at += count;
            }
            match value {
                Value::Array(_) => self.of_numbers.extend((0..count).map(|i| format!("{name}[{i}]"))),
                _ => self.of_numbers.extend((count == 1).then(|| name.clone())),
            }
        }
    }

    /// Returns the name of the column of time stamps.
    pub fn of_time(&self, at: Option<usize>) -> Option<&str> {
        self.get(at?)
    }

    fn get(&self, at: usize) -> Option<&str> {
        self.of_numbers.get(at).map(String::as_str)
    }
}

/// Checks whether a line can only be a header: different names of one word between separators, perhaps each with its unit, and no
/// number. `OL,OL` is none.
pub(crate) fn is_header(line: &str) -> bool {
    let word = |field: &str| {
        let name = field.trim_end_matches([']', ')']).split(['[', '(']).next().unwrap_or_default().trim();
        name.starts_with(|c: char| c.is_alphabetic() || c == '_') && !name.contains(char::is_whitespace)
    };
    let all: Vec<&str> = fields(line).filter(|field| !field.is_empty()).collect();
    let is_new = |(at, field): (usize, &&str)| !all[..at].contains(field);
    line.contains(SEPARATORS)
        && are_names(line)
        && all.len() > 1
        && all.iter().all(|field| word(field))
        && all.iter().enumerate().all(is_new)
}

/// Lists the first names for a message.
pub(crate) fn listed<'n>(names: impl Iterator<Item = &'n str>) -> String {
    let all: Vec<&str> = names.collect();
    match all.len().saturating_sub(SHOWN_NAMES) {
        0 => all.join(", "),
        more => format!("{} and {more} more", all[..SHOWN_NAMES].join(", ")),
    }
}

/// Checks whether the fields of a line are names and no numbers; an index has none.
pub(crate) fn are_names(line: &str) -> bool {
    let is_text = fields(line).all(|field| field.parse::<f64>().is_err());
    is_text
        && !line.starts_with(['[', '{'])
        && fields(line).any(|field| field.starts_with(char::is_alphabetic))
}

impl LineNumbers {
    /// Reads a line; `is_time` knows the time stamp by its place and name.
    pub fn read(
        &mut self,
        line: &str,
        names: &mut Names,
        is_time: impl Fn(usize, Option<&str>) -> bool,
    ) -> Result<(), Fault> {
        self.values.clear();
        (self.time, self.stamp, self.is_date) = (None, None, false);
        if !line.starts_with(['[', '{']) {
            for (at, field) in fields(line).enumerate() {
                if is_time(at, names.get(at)) {
                    let number = field.parse().ok();
                    self.is_date = number.is_none();
                    self.stamp(
                        number.or_else(|| seconds_of_date(field)).ok_or_else(|| no_number(at, field))?,
                    );
                } else {
                    self.values.push(field.parse().unwrap_or(f32::NAN));
                }
            }
            return Ok(());
        }
        let json = |e: serde_json::Error| Fault::Malformed(format!("it is no JSON: {e}"));
        match serde_json::from_str::<Value>(line).map_err(json)? {
            Value::Object(object) => {
                if names.names.is_empty() {
                    names.take(&object, &is_time);
                }
                names.refuse_other_keys(&object)?;
                for name in &names.names {
                    let value =
                        object.get(name).ok_or_else(|| Fault::Malformed(format!("it has no {name:?}")))?;
                    let date = value.as_str().and_then(seconds_of_date);
                    match (is_time(self.values.len(), Some(name)), value.as_f64().or(date)) {
                        (true, Some(stamp)) => {
                            self.is_date = date.is_some();
                            self.stamp(stamp);
                        }
                        // A text is a fault only where it is one of the values of the time step.
                        _ if value.is_string() || value.is_boolean() => self.values.push(f32::NAN),
                        _ => self.flatten(value, name)?,
                    }
                }
                Ok(())
            }
            array => {
                self.flatten(&array, "the array")?;
                let time = (0..self.values.len()).find(|at| is_time(*at, None));
                // A number within an array is as good as its 53 bits, too.
                if let (Some(at), Value::Array(all)) = (time, &array) {
                    (self.time, self.stamp) = (Some(at), all.get(at).and_then(Value::as_f64));
                }
                Ok(())
            }
        }
    }

    fn stamp(&mut self, stamp: f64) {
        (self.time, self.stamp) = (Some(self.values.len()), Some(stamp));
        self.values.push(f32::NAN);
    }

    fn flatten(&mut self, value: &Value, name: &str) -> Result<(), Fault> {
        match value {
            Value::Number(number) => self.values.push(number.as_f64().map_or(f32::NAN, |v| v as f32)),
            Value::Null => self.values.push(f32::NAN),
            Value::Array(all) => all.iter().try_for_each(|inner| self.flatten(inner, name))?,
            other => {
                let text: String = other.to_string().chars().take(SHOWN).collect();
                return Err(Fault::Malformed(format!("{text} in {name} is no number")));
            }
        }
        Ok(())
    }

    /// Finds the first field of a line of CSV that is no number.
    pub fn no_number(&self, line: &str) -> Option<Fault> {
        let mut fields = fields(line).enumerate().filter(|_| !line.starts_with(['[', '{']));
        fields.find(|(_, field)| field.parse::<f32>().is_err()).map(|(at, field)| no_number(at, field))
    }

    /// Describes number `at` of a line, which is not finite.
    pub fn fault(&self, line: &str, at: usize) -> Fault {
        if line.starts_with(['[', '{']) {
            return Fault::NotFinite(format!("number {} of it is no finite number", at + 1));
        }
        match fields(line).nth(at) {
            Some(field) if field.parse::<f32>().is_ok() => {
                Fault::NotFinite(format!("column {}: {field} is not finite", at + 1))
            }
            field => no_number(at, field.unwrap_or_default()),
        }
    }
}

/// Counts the numbers of a list; 0 of all else.
fn count(value: &Value) -> usize {
    match value {
        Value::Array(all) => all.iter().map(|inner| if inner.is_array() { count(inner) } else { 1 }).sum(),
        _ => 0,
    }
}

fn no_number(at: usize, field: &str) -> Fault {
    let text: String = field.chars().take(SHOWN).collect();
    Fault::Malformed(format!("column {}: {text:?} is no number", at + 1))
}

/// Splits a line into fields, by commas where there are any, else by semicolons, tabs or blanks.
pub(crate) fn fields(line: &str) -> impl Iterator<Item = &str> {
    let separator = SEPARATORS.into_iter().find(|separator| line.contains(*separator));
    let split = separator.map(|separator| line.split(separator).map(str::trim));
    let blanks = separator.is_none().then(|| line.split_whitespace());
    split.into_iter().flatten().chain(blanks.into_iter().flatten())
}
