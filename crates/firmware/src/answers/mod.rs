//! The answers of a library: classes with probabilities, of one attribute or of several, or values with intervals, as C.

use taxel_base::exponential::{LN, MOST};

use crate::literals::{comment, double, float, text};

mod attributes;
mod gate;
mod readings;

pub use attributes::{Attribute, Shares};
pub use gate::Gate;
pub use readings::ReadingsGate;

/// The answers of a library.
#[derive(Debug, Clone, PartialEq)]
pub enum Answers {
    /// One class, by the softmax of the outputs.
    Classes {
        /// Names of the classes.
        names: Vec<String>,
        /// The temperature that divides the logits, of a calibrated model.
        temperature: Option<f64>,
        /// Tells samples unlike those of the training, of a model that has a gate.
        gate: Option<Gate>,
    },
    /// One class of each attribute, whose outputs follow each other.
    Attributes {
        /// Names, and names of the classes.
        attributes: Vec<Attribute>,
        /// How outputs become probabilities.
        shares: Shares,
        /// The temperature that divides the logits of probabilities, of a calibrated model.
        temperature: Option<f64>,
    },
    /// Values: the first outputs, in the unit of the targets.
    Values {
        /// Names and units.
        quantities: Vec<Quantity>,
        /// The outputs behind the values, which tell their errors.
        spread: Spread,
        /// Half the width of the 90 % interval of each value, of a model that has intervals: in its unit, or in spreads.
        half: Option<Vec<f64>>,
    },
}

/// A value's name and unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quantity {
    /// `force`.
    pub name: String,
    /// `N`, where it is known.
    pub unit: Option<String>,
}

/// The outputs behind the values, which tell how far these are off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spread {
    /// There are none: all samples are off alike.
    Alike,
    /// The logarithm of a variance for each value.
    LogVariance,
    /// A lower quantile of each value, then an upper one of each.
    Quantiles,
}

/// The least distance that a network may say.
const LEAST_SPREAD: f32 = 1e-12;

impl Answers {
    /// Makes classes without a temperature.
    pub fn classes(names: Vec<String>) -> Self {
        Answers::Classes { names, temperature: None, gate: None }
    }

    /// Returns the number of classes, those of all attributes, or of values.
    pub fn count(&self) -> usize {
        match self {
            Answers::Classes { names, .. } => names.len(),
            Answers::Attributes { attributes, .. } => attributes.iter().map(|one| one.classes.len()).sum(),
            Answers::Values { quantities, .. } => quantities.len(),
        }
    }

    /// Returns the outputs that the network has to have.
    pub fn outputs(&self) -> usize {
        let each = match self {
            Answers::Classes { .. }
            | Answers::Attributes { .. }
            | Answers::Values { spread: Spread::Alike, .. } => 1,
            Answers::Values { spread: Spread::LogVariance, .. } => 2,
            Answers::Values { spread: Spread::Quantiles, .. } => 3,
        };
        each * self.count()
    }

    /// Checks whether values have intervals.
    pub(crate) fn has_intervals(&self) -> bool {
        matches!(self, Answers::Values { half: Some(_), .. })
    }

    /// Says in words what is predicted.
    pub(crate) fn words(&self) -> String {
        match self {
            Answers::Classes { names, .. } => format!("one of {} classes", names.len()),
            Answers::Attributes { attributes, .. } => {
                let one = |one: &Attribute| format!("{} as one of {} classes", one.name, one.classes.len());
                attributes.iter().map(one).collect::<Vec<_>>().join(", ")
            }
            Answers::Values { quantities, .. } => {
                let one = |Quantity { name, unit }: &Quantity| match unit {
                    Some(unit) => format!("{name} in {unit}"),
                    None => name.clone(),
                };
                quantities.iter().map(one).collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// Returns the bytes of names and tables.
    pub(crate) fn table_bytes(&self) -> usize {
        let names = |name: &String| name.len() + 1 + size_of::<u32>();
        match self {
            Answers::Classes { names: all, temperature, gate } => {
                let exponential = size_of_val(&taxel_base::exponential::EXP);
                let temper = temperature.map_or(0, |_| size_of_val(&LN));
                let gate = gate.as_ref().map_or(0, Gate::table_bytes);
                all.iter().map(names).sum::<usize>() + exponential + temper + gate
            }
            Answers::Attributes { attributes, shares, temperature } => {
                let one =
                    |one: &Attribute| names(&one.name) + 2 + one.classes.iter().map(names).sum::<usize>();
                let exponential = if *shares == Shares::Cut && temperature.is_none() {
                    0
                } else {
                    size_of_val(&taxel_base::exponential::EXP)
                };
                let temper = temperature.map_or(0, |_| size_of_val(&LN));
                attributes.iter().map(one).sum::<usize>() + exponential + temper
            }
            Answers::Values { quantities, half, .. } => {
                let one = |quantity: &Quantity| {
                    names(&quantity.name) + quantity.unit.as_ref().map_or(names(&String::new()), names)
                };
                let half = half.as_ref().map_or(0, |half| 8 * half.len());
                quantities.iter().map(one).sum::<usize>() + half
            }
        }
    }

    /// Returns about the bytes of the code: softmax, temperature, intervals.
    pub(crate) fn code_bytes(&self) -> usize {
        match self {
            Answers::Classes { temperature, gate, .. } => {
                400 + temperature.map_or(0, |_| 500) + gate.as_ref().map_or(0, |_| 1200)
            }
            Answers::Attributes { temperature, .. } => 450 + temperature.map_or(0, |_| 500),
            Answers::Values { half: None, .. } => 100,
            // Doubles are software on most cores.
            Answers::Values { spread: Spread::LogVariance, .. } => 1500,
            Answers::Values { .. } => 1200,
        }
    }

    /// Writes the part of the header: macros and functions.
    pub(crate) fn header(&self) -> String {
        match self {
            Answers::Classes { gate: Some(_), .. } => {
                format!("{}{}", include_str!("../c/answers/classes.h"), include_str!("../c/answers/gate.h"))
            }
            Answers::Classes { gate: None, .. } => include_str!("../c/answers/classes.h").into(),
            Answers::Attributes { attributes, .. } => {
                attributes::header(attributes) + include_str!("../c/answers/classes.h")
            }
            Answers::Values { .. } if self.has_intervals() => {
                format!(
                    "{}{}",
                    include_str!("../c/answers/values.h"),
                    include_str!("../c/answers/intervals.h")
                )
            }
            Answers::Values { .. } => include_str!("../c/answers/values.h").into(),
        }
    }

    /// Writes the logarithm.
    pub(crate) fn logarithm() -> String {
        constants(&first_function(include_str!("../c/temper.c")).replace("LN_COEFFICIENTS", &list(&LN)))
    }

    /// Writes the functions that other parts of the library do not need: softmax, temperature.
    pub(crate) fn helpers(&self) -> String {
        match self {
            Answers::Classes { temperature, .. } => exponential(*temperature),
            Answers::Attributes { shares, temperature, .. } => {
                let temper = temperature.map_or(String::new(), temper);
                constants(&(shares.helpers(temperature.is_some()) + &temper))
            }
            Answers::Values { spread: Spread::LogVariance, half: Some(_), .. } => {
                constants(first_function(include_str!("../c/softmax.c")))
            }
            Answers::Values { .. } => String::new(),
        }
    }

    /// Writes names and the functions that answer.
    pub(crate) fn source(&self) -> String {
        match self {
            Answers::Classes { names, temperature, gate } => {
                let temper = temperature.map_or("", |_| "    temper(row, TAXEL_@NAME@_CLASSES);\n");
                let plain = include_str!("../c/answers/classes.c")
                    .replace("@classes@", &quoted(names.iter()))
                    .replace("@shares@", &format!("    softmax(row, TAXEL_@NAME@_CLASSES);\n{temper}"));
                plain + &gate.as_ref().map_or(String::new(), Gate::text)
            }
            Answers::Attributes { attributes, shares, temperature } => {
                let classes = attributes.iter().flat_map(|one| &one.classes);
                attributes::tables(attributes)
                    + &include_str!("../c/answers/classes.c")
                        .replace("@classes@", &quoted(classes))
                        .replace("@shares@", &shares.text(temperature.is_some()))
            }
            Answers::Values { quantities, spread, half } => {
                let units = quantities.iter().map(|quantity| quantity.unit.as_deref().unwrap_or_default());
                let plain = include_str!("../c/answers/values.c")
                    .replace("@quantities@", &quoted(quantities.iter().map(|quantity| &quantity.name)))
                    .replace("@units@", &quoted(units));
                half.as_ref().map_or(plain.clone(), |half| plain + &intervals(*spread, half))
            }
        }
    }

    /// Writes the part of the test that predicts samples, and measures their readings where there is a gate of them.
    pub(crate) fn check(&self, has_readings: bool) -> String {
        let readings = if has_readings { include_str!("../c/answers/check_readings.c") } else { "" };
        self.check_answers().replace("        @readings@\n", readings)
    }

    fn check_answers(&self) -> String {
        match self {
            Answers::Classes { gate, .. } => {
                let gate = gate.as_ref().map_or("", |_| include_str!("../c/answers/check_gate.c"));
                include_str!("../c/answers/check_classes.c").replace("        @gate@\n", gate)
            }
            Answers::Attributes { .. } => {
                include_str!("../c/answers/check_classes.c").replace("        @gate@\n", "")
            }
            Answers::Values { .. } if self.has_intervals() => include_str!("../c/answers/check_values.c")
                .replace("@intervals@", include_str!("../c/answers/check_intervals.c").trim_end()),
            Answers::Values { .. } => {
                include_str!("../c/answers/check_values.c").replace("    @intervals@\n", "")
            }
        }
    }

    /// Writes the last lines of the example, which print an answer.
    pub(crate) fn example(&self) -> &'static str {
        match self {
            Answers::Classes { .. } => include_str!("../folder/print_classes.ino"),
            Answers::Attributes { .. } => include_str!("../folder/print_attributes.ino"),
            Answers::Values { .. } => include_str!("../folder/print_values.ino"),
        }
    }

    /// Writes how the library is called, for the README.
    pub(crate) fn use_of(&self) -> String {
        match self {
            Answers::Classes { gate: Some(_), .. } => {
                format!(
                    "{}{}",
                    include_str!("../folder/use_classes.md"),
                    include_str!("../folder/use_gate.md")
                )
            }
            Answers::Classes { gate: None, .. } => include_str!("../folder/use_classes.md").into(),
            Answers::Attributes { .. } => {
                format!(
                    "{}{}",
                    include_str!("../folder/use_classes.md"),
                    include_str!("../folder/use_attributes.md")
                )
            }
            Answers::Values { .. } if self.has_intervals() => {
                format!(
                    "{}{}",
                    include_str!("../folder/use_values.md"),
                    include_str!("../folder/use_intervals.md")
                )
            }
            Answers::Values { .. } => include_str!("../folder/use_values.md").into(),
        }
    }

    /// Writes the row of the README's table.
    pub(crate) fn row(&self) -> String {
        match self {
            Answers::Classes { names, .. } => {
                format!("| classes | {}: {} |", names.len(), cell(&names.join(", ")))
            }
            Answers::Attributes { attributes, .. } => {
                let one = |one: &Attribute| format!("{} ({})", one.name, one.classes.join(", "));
                let all = attributes.iter().map(one).collect::<Vec<_>>().join("; ");
                format!("| attributes | {}: {} |", attributes.len(), cell(&all))
            }
            Answers::Values { half, .. } => {
                let intervals = half.as_ref().map_or("", |_| ", each with its 90 % interval");
                format!("| values | {}: {}{intervals} |", self.count(), cell(&self.words()))
            }
        }
    }
}

/// Makes a text fit a cell of a table.
fn cell(text: &str) -> String {
    comment(text).replace('|', "\\|")
}

/// Writes texts in quotes, one a line.
fn quoted<T: AsRef<str>>(texts: impl Iterator<Item = T>) -> String {
    texts.map(|one| format!("    {},\n", text(one.as_ref()))).collect()
}

fn intervals(spread: Spread, half: &[f64]) -> String {
    let around = match spread {
        Spread::Alike => include_str!("../c/answers/alike.c"),
        Spread::LogVariance => include_str!("../c/answers/log_variance.c"),
        Spread::Quantiles => include_str!("../c/answers/quantiles.c"),
    };
    let half: Vec<String> = half.iter().map(|half| double(*half)).collect();
    include_str!("../c/answers/intervals.c")
        .replace("@around@", around)
        .replace("@half@", &half.join(", "))
        .replace("@least@", &float(LEAST_SPREAD))
        .replace("@most@", &float(MOST))
}

/// Returns the functions of a text up to the end of the first one.
fn first_function(text: &str) -> &str {
    functions(text, 1)
}

/// Returns the first `count` functions of a text.
fn functions(text: &str, count: usize) -> &str {
    text.match_indices("\n}\n").nth(count - 1).map_or(text, |(end, _)| &text[..end + 3])
}

/// Writes softmax and temperature with their constants.
fn exponential(temperature: Option<f64>) -> String {
    constants(&(include_str!("../c/softmax.c").to_string() + &temperature.map_or(String::new(), temper)))
}

/// Writes what divides the logits of probabilities by a temperature.
fn temper(temperature: f64) -> String {
    let inverse = float((1.0 / temperature) as f32);
    include_str!("../c/temper.c")
        .replace("LN_COEFFICIENTS", &list(&LN))
        .replace("INVERSE_TEMPERATURE", &inverse)
}

fn list(values: &[f32]) -> String {
    values.iter().map(|value| float(*value)).collect::<Vec<_>>().join(", ")
}

/// Fills in the numbers of the exponential.
fn constants(text: &str) -> String {
    use taxel_base::exponential::{EXP, LEAST, LN_2};
    text.replace("EXP_COEFFICIENTS", &list(&EXP))
        .replace("LN_2_HIGH", &float(LN_2[0]))
        .replace("LN_2_LOW", &float(LN_2[1]))
        .replace("LOG2_E", &float(std::f32::consts::LOG2_E))
        .replace("EXP_LEAST", &float(LEAST))
}
