//! Several attributes, one class of each, as C.

use taxel_base::exponential::MOST;

use super::{functions, quoted};
use crate::literals::{comment, float};

/// An attribute and its classes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attribute {
    /// `hardness`.
    pub name: String,
    /// Names of its classes, in the order of the outputs.
    pub classes: Vec<String>,
}

/// How the outputs of an attribute become probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shares {
    /// A sigmoid of each output.
    Sigmoid,
    /// Of ordered classes: the softmax of the sums up to each output, without the first one.
    Ordered,
    /// The outputs themselves, cut at 0 and 1.
    Cut,
}

impl Shares {
    /// Returns the name of the function.
    fn function(self) -> &'static str {
        match self {
            Shares::Sigmoid => "of_each",
            Shares::Ordered => "of_ordered",
            Shares::Cut => "of_cut",
        }
    }

    /// Writes the functions that it calls; those that a temperature needs as well, where there is one.
    pub(super) fn helpers(self, has_temperature: bool) -> String {
        let softmax = include_str!("../c/softmax.c");
        let (text, needed) = match (self, has_temperature) {
            (Shares::Ordered, _) => (include_str!("../c/attributes/ordered.c"), softmax),
            (Shares::Sigmoid, true) => (include_str!("../c/attributes/sigmoid.c"), functions(softmax, 2)),
            (Shares::Sigmoid, false) => (include_str!("../c/attributes/sigmoid.c"), functions(softmax, 1)),
            (Shares::Cut, true) => (include_str!("../c/attributes/cut.c"), functions(softmax, 2)),
            (Shares::Cut, false) => (include_str!("../c/attributes/cut.c"), ""),
        };
        format!("{needed}{}", text.replace("@most@", &float(MOST)))
    }

    /// Writes the statements that make probabilities of a row of all attributes.
    pub(super) fn text(self, has_temperature: bool) -> String {
        let temper = if has_temperature { "        temper(row + at, count);\n" } else { "" };
        include_str!("../c/attributes/each.c")
            .replace("@function@", self.function())
            .replace("@temper@", temper)
    }
}

/// Writes the part of the header before that of classes: numbers and names.
pub(super) fn header(attributes: &[Attribute]) -> String {
    let one = |(at, one): (usize, &Attribute)| {
        format!("#define TAXEL_@NAME@_CLASSES_{at} {}u /* {} */\n", one.classes.len(), comment(&one.name))
    };
    include_str!("../c/attributes/header.h")
        .replace("@attributes@", &attributes.len().to_string())
        .replace("@sizes@\n", &attributes.iter().enumerate().map(one).collect::<String>())
}

/// Writes names and numbers of classes.
pub(super) fn tables(attributes: &[Attribute]) -> String {
    let names = quoted(attributes.iter().map(|one| &one.name));
    let sizes: Vec<String> = attributes.iter().map(|one| format!("{}u", one.classes.len())).collect();
    include_str!("../c/attributes/tables.c").replace("@names@", &names).replace("@sizes@", &sizes.join(", "))
}
