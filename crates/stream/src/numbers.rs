//! The numbers of a line of CSV or JSON.

use serde_json::Value;

use crate::fault::Fault;

/// Letters of a line that a message shows.
const SHOWN: usize = 40;

/// Names of the columns, by a header or the first object.
#[derive(Debug, Clone, Default)]
pub(crate) struct Names {
    names: Vec<String>,
}

/// The numbers of the last line.
#[derive(Debug, Clone, Default)]
pub(crate) struct LineNumbers {
    /// Every number, NaN where there is none and in place of the time stamp.
    pub values: Vec<f32>,
    /// Where the time stamp stands among them.
    pub time: Option<usize>,
    pub stamp: Option<f64>,
}

impl Names {
    /// Checks whether a line names the columns: the first that is no blank (`first`), without any number, or the same again.
    pub fn are_named(&mut self, line: &str, first: bool) -> bool {
        if line.starts_with(['[', '{']) {
            return false;
        }
        if !self.names.is_empty() {
            return fields(line).eq(self.names.iter().map(String::as_str));
        }
        let named = first && are_names(line);
        if named {
            self.names = fields(line).map(str::to_string).collect();
        }
        named
    }

    /// Returns the column of this name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Returns the name of the column of time stamps.
    pub fn of_time(&self, at: Option<usize>) -> Option<&str> {
        self.get(at?)
    }

    fn get(&self, at: usize) -> Option<&str> {
        self.names.get(at).map(String::as_str)
    }
}

/// Checks whether every field of a line is a name and no number.
pub(crate) fn are_names(line: &str) -> bool {
    !line.starts_with(['[', '{'])
        && fields(line).all(|field| field.parse::<f64>().is_err() && !field.is_empty())
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
        (self.time, self.stamp) = (None, None);
        if !line.starts_with(['[', '{']) {
            for (at, field) in fields(line).enumerate() {
                if is_time(at, names.get(at)) {
                    self.stamp(field.parse().map_err(|_| no_number(at, field))?);
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
                    let numbers = object.iter().filter(|(_, value)| value.is_number() || value.is_array());
                    names.names = numbers.map(|(name, _)| name.clone()).collect();
                }
                for name in &names.names {
                    let value =
                        object.get(name).ok_or_else(|| Fault::Malformed(format!("it has no {name:?}")))?;
                    match (is_time(self.values.len(), Some(name)), value.as_f64()) {
                        (true, Some(stamp)) => self.stamp(stamp),
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

fn no_number(at: usize, field: &str) -> Fault {
    let text: String = field.chars().take(SHOWN).collect();
    Fault::Malformed(format!("column {}: {text:?} is no number", at + 1))
}

/// Splits a line into fields, by commas where there are any, else by semicolons, tabs or blanks.
fn fields(line: &str) -> impl Iterator<Item = &str> {
    let separator = [',', ';', '\t'].into_iter().find(|separator| line.contains(*separator));
    let split = separator.map(|separator| line.split(separator).map(str::trim));
    let blanks = separator.is_none().then(|| line.split_whitespace());
    split.into_iter().flatten().chain(blanks.into_iter().flatten())
}
