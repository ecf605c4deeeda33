//! Reads one line of JSON Lines: the numbers and the texts of an object, or the numbers of an array.

use crate::formats::json_numbers::JsonNumbers;
use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Most numbers of a line of a file that is not damaged.
const MAX_NUMBERS: usize = 1 << 16;

/// The numbers of one line, column after column.
#[derive(Default)]
pub(crate) struct TimeStep {
    /// Keys that hold numbers, and how many; an array is one column without a name.
    pub names: Vec<(String, usize)>,
    pub numbers: Vec<f64>,
    /// Keys that hold a text.
    pub texts: Vec<(String, String)>,
}

impl TimeStep {
    /// Brings the columns into the order of `wanted`, or says which key is missing or too many.
    pub fn arrange(&mut self, wanted: &[(String, usize)]) -> Result<(), String> {
        if self.names == wanted {
            return Ok(());
        }
        let mut starts = vec![];
        let mut start = 0;
        for (_, count) in &self.names {
            starts.push(start);
            start += count;
        }
        let mut numbers = Vec::with_capacity(self.numbers.len());
        for (name, count) in wanted {
            let Some(at) = self.names.iter().position(|(held, _)| held == name) else {
                return Err(format!(
                    "has no number under {name:?}, as the first line has; write the same keys in each"
                ));
            };
            let held = self.names[at].1;
            if held != *count {
                return Err(format!(
                    "holds {held} numbers under {name:?}, and the first line {count}; write as many in each"
                ));
            }
            numbers.extend(&self.numbers[starts[at]..starts[at] + count]);
        }
        if let Some((name, _)) =
            self.names.iter().find(|(name, _)| !wanted.iter().any(|(held, _)| held == name))
        {
            return Err(format!(
                "has numbers under {name:?}, and the first line has none; write the same keys in each"
            ));
        }
        (self.numbers, self.names) = (numbers, wanted.to_vec());
        Ok(())
    }

    /// Returns the text under a key.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.texts.iter().find(|(held, _)| held == name).map(|(_, text)| text.as_str())
    }

    /// Returns the one number under a key.
    pub fn number(&self, name: &str) -> Option<f64> {
        let at = self.names.iter().position(|(held, count)| held == name && *count == 1)?;
        let start: usize = self.names[..at].iter().map(|(_, count)| count).sum();
        self.numbers.get(start).copied()
    }

    fn reader(&mut self) -> JsonNumbers<'_> {
        JsonNumbers { out: &mut self.numbers, most: MAX_NUMBERS }
    }
}

impl<'de> Deserialize<'de> for TimeStep {
    fn deserialize<D: Deserializer<'de>>(reader: D) -> Result<Self, D::Error> {
        reader.deserialize_any(LineVisitor)
    }
}

struct LineVisitor;

impl<'de> Visitor<'de> for LineVisitor {
    type Value = TimeStep;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object of numbers or an array of numbers")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TimeStep, A::Error> {
        let mut line = TimeStep::default();
        while let Some(name) = map.next_key::<String>()? {
            let is_twice = line.names.iter().any(|(held, _)| *held == name)
                || line.texts.iter().any(|(held, _)| *held == name);
            if is_twice {
                return Err(A::Error::custom(format!("two keys are named {name:?}")));
            }
            let before = line.numbers.len();
            let text = map.next_value_seed(CellReader(line.reader()))?;
            let count = line.numbers.len() - before;
            if let Some(text) = text {
                line.texts.push((name, text));
            } else if count > 0 {
                line.names.push((name, count));
            }
        }
        Ok(line)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<TimeStep, A::Error> {
        let mut line = TimeStep::default();
        while list.next_element_seed(line.reader())?.is_some() {}
        line.names = vec![(String::new(), line.numbers.len())];
        Ok(line)
    }
}

/// Reads the numbers of a value, or returns its text.
struct CellReader<'a>(JsonNumbers<'a>);

impl<'de> DeserializeSeed<'de> for CellReader<'_> {
    type Value = Option<String>;

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<Self::Value, D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for CellReader<'_> {
    type Value = Option<String>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.expecting(f)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        self.0.visit_bool(value).map(|()| None)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        self.0.visit_i64(value).map(|()| None)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        self.0.visit_u64(value).map(|()| None)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        self.0.visit_f64(value).map(|()| None)
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        self.0.visit_unit().map(|()| None)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        Ok(Some(text.into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        self.0.visit_seq(list).map(|()| None)
    }
}
