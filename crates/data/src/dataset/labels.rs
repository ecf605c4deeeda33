//! Labels with the names of their levels.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use unicode_normalization::UnicodeNormalization;

/// One attribute of the samples and the names of its levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attribute {
    /// `elasticity`; `class` where samples have one class each.
    pub name: String,
    /// Names by label.
    pub classes: Vec<String>,
}

/// Labels `[N, attributes]` with the names of their levels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    attributes: Vec<Attribute>,
    values: Vec<u32>,
}

impl Labels {
    /// Takes labels `[N, attributes]`, row-major; each below the number of its attribute's classes.
    pub fn new(attributes: Vec<Attribute>, values: Vec<u32>) -> Self {
        Self { attributes, values }
    }

    /// Takes one class per sample: a single attribute of the name `class`.
    pub fn of_classes(classes: &[String], values: &[u32]) -> Self {
        let attribute = Attribute { name: "class".into(), classes: classes.to_vec() };
        Self::new(vec![attribute], values.to_vec())
    }

    /// Takes labels `[N, attributes]`, row-major, of attributes without names: they become `attribute-0`,
    /// `attribute-1`, ...
    pub fn numbered(classes: Vec<Vec<String>>, values: Vec<u32>) -> Self {
        let attribute =
            |(i, classes): (usize, Vec<String>)| Attribute { name: format!("attribute-{i}"), classes };
        Self::new(classes.into_iter().enumerate().map(attribute).collect(), values)
    }

    /// Returns the attributes; one of the name `class` where samples have one class each.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }

    /// Returns the number of levels of each attribute.
    pub fn sizes(&self) -> Vec<usize> {
        self.attributes.iter().map(|attribute| attribute.classes.len()).collect()
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.values.len() / self.attributes.len().max(1)
    }

    /// Checks whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns the labels of `rows`, `[rows, attributes]`.
    pub fn of(&self, rows: &[usize]) -> Vec<u32> {
        let width = self.attributes.len();
        rows.iter().flat_map(|&row| &self.values[row * width..(row + 1) * width]).copied().collect()
    }

    /// Returns all labels `[N, attributes]`, row-major.
    pub fn values(&self) -> &[u32] {
        &self.values
    }

    /// Returns the same attributes with the labels of `rows` only.
    pub(crate) fn select(&self, rows: &[usize]) -> Self {
        Self::new(self.attributes.clone(), self.of(rows))
    }
}

/// Sorts the names that occur, each once, and returns them with the position of each sample's name: numbers by value
/// (2 before 10), then words by the alphabet.
pub(crate) fn by_name(names: Vec<String>) -> (Vec<String>, Vec<u32>) {
    let mut classes = names.clone();
    let number = |name: &str| name.parse::<f64>().unwrap_or(f64::INFINITY);
    classes.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
    classes.dedup();
    let position: HashMap<&str, u32> = classes.iter().map(String::as_str).zip(0..).collect();
    let labels = names.iter().map(|name| position[name.as_str()]).collect();
    (classes, labels)
}

/// Returns labels that are numbers as values, where at least one has a fraction: `0.53`. Whole numbers (`1`, `1.0`) are
/// classes.
///
/// This is the rule of scikit-learn's `type_of_target`, by which floats with fractions are continuous.
pub(crate) fn as_values(labels: &[String]) -> Option<Vec<f32>> {
    let mut has_fraction = false;
    let number = |label: &String| {
        let number: f64 = label.parse().ok()?;
        has_fraction |= number.is_finite() && number.fract() != 0.0;
        Some(number as f32)
    };
    let values: Vec<f32> = labels.iter().map(number).collect::<Option<_>>()?;
    has_fraction.then_some(values)
}

/// Returns the mark that a word is: 1 of samples to test on.
pub(crate) fn mark_of(text: &str) -> Option<i64> {
    match text.to_lowercase().as_str() {
        "train" | "training" | "false" => Some(0),
        "test" | "testing" | "true" => Some(1),
        _ => None,
    }
}

/// Gives groups numbers by their names, or says which names cannot be told apart.
pub(crate) fn group_numbers(names: Vec<String>) -> Result<Vec<i64>, String> {
    let (groups, numbers) = by_name(names);
    refuse_unclear("group", &groups)?;
    Ok(numbers.into_iter().map(i64::from).collect())
}

/// Refuses names of classes or groups that cannot be told apart by eye, are empty or hold control characters; `kind` says
/// of what they are the names. Blanks, characters without a shape, the normal form of Unicode and the spelling of a
/// number make no other name.
pub(crate) fn refuse_unclear(kind: &str, names: &[String]) -> Result<(), String> {
    let mut seen: HashMap<String, &String> = HashMap::new();
    for name in names {
        if name.chars().any(char::is_control) {
            return Err(format!("the {kind} name {name:?} holds a control character; rename it"));
        }
        let plain = plain_form(name);
        if plain.is_empty() {
            return Err(format!("the {kind} name {name:?} is blank; give it a name"));
        }
        if let Some(first) = seen.insert(plain, name) {
            return Err(format!(
                "the {kind} names {first:?} and {name:?} differ only in blanks, invisible characters, the form of their \
                 letters (NFC and NFD) or the spelling of a number; write both alike"
            ));
        }
    }
    Ok(())
}

/// Returns the form of a name that its look-alikes share.
fn plain_form(name: &str) -> String {
    let has_no_shape = |c: &char| matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}');
    let shown: String = name.nfc().filter(|c| !has_no_shape(c)).collect();
    let plain = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    match plain.parse::<f64>() {
        Ok(number) if number.is_finite() => number.to_string(),
        _ => plain,
    }
}

/// Returns the first two names that differ only in capital letters.
pub(crate) fn differ_in_case(names: &[String]) -> Option<(&str, &str)> {
    let mut seen: HashMap<String, &str> = HashMap::new();
    names.iter().find_map(|name| Some((seen.insert(name.to_lowercase(), name)?, name.as_str())))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn names_that_look_alike_are_refused_with_both_spellings() {
        for (a, b, shown) in [
            ("soft", "soft ", r#""soft" and "soft ""#),
            ("a b", "a\u{a0}b", r#""a b" and "a\u{a0}b""#),
            ("caf\u{e9}", "cafe\u{301}", r#""café" and "cafe\u{301}""#),
            ("soft", "\u{feff}soft", r#""soft" and "\u{feff}soft""#),
            ("1", "1.0", r#""1" and "1.0""#),
            ("2", "1e10", ""),
            ("Soft", "soft", ""),
            ("10\u{b2}", "102", ""),
        ] {
            let names = [a.to_string(), "stiff".into(), b.into()];
            match refuse_unclear("class", &names) {
                Ok(()) => assert_eq!(shown, "", "{a:?} {b:?}"),
                Err(why) => assert!(!shown.is_empty() && why.contains(shown), "{why}"),
            }
        }
        let refused = |name: &str| refuse_unclear("class", &[name.to_string()]).unwrap_err();
        assert!(refused("a\u{1b}[2J").contains(r#""a\u{1b}[2J" holds a control character"#));
        assert!(refused(" \u{200b}").contains("is blank"));
        assert_eq!(differ_in_case(&["a".into(), "Soft".into(), "soft".into()]), Some(("Soft", "soft")));
    }

    #[test]
    fn numbers_with_fractions_are_values() {
        let read = |labels: &[&str]| as_values(&labels.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(read(&["0.5", "1"]), Some(vec![0.5, 1.0]));
        assert!(read(&["0.5", "nan"]).unwrap()[1].is_nan());
        for classes in [&["1.0", "2.0"][..], &["1", "2"], &["0.5", "a"], &["nan", "inf"], &[]] {
            assert_eq!(read(classes), None);
        }
    }
}
