//! Writes the card as text of at most 80 columns and one screen.

use crate::check::card::{Card, GroupSummary};
use crate::check::card_channels;
use crate::check::quantities::QuantitySummary;
use crate::error::plural;
use std::fmt::{self, Display, Formatter, Write};

const WIDTH: usize = 80;
const KEY: usize = 12;
/// Most letters of a list of names, about three lines.
const LIST: usize = 3 * (WIDTH - KEY);
/// Most problems that are printed.
const PROBLEMS: usize = 6;

impl Display for Card {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut out = String::new();
        self.write(&mut out)?;
        f.write_str(out.trim_end())
    }
}

impl Card {
    fn write(&self, out: &mut String) -> fmt::Result {
        let shape: Vec<String> = self.shape.iter().map(ToString::to_string).collect();
        entry(out, "data", &self.name)?;
        let shape = shape.join("×");
        entry(out, "shape", &format!("{shape} ({}, stored as {})", self.axes(), self.dtype))?;
        entries(out, "read as", &self.read_as)?;
        self.write_lengths(out)?;
        entry(out, "digest", self.digest.get(..16).unwrap_or(&self.digest))?;
        if !self.classes.is_empty() {
            let share = self.majority_share * 100.0;
            let classes: Vec<String> =
                self.classes.iter().map(|class| format!("{} {}", class.name, class.samples)).collect();
            let count = self.classes.len();
            let head = format!("{count}; always answering the largest scores {share:.1} %");
            entry(out, "classes", &head)?;
            entry(out, "", &first_of(&classes))?;
        }
        if let Some(labels) = &self.labels {
            entry(out, if self.classes.is_empty() { "targets" } else { "" }, labels)?;
        }
        for lines in self.quantities.iter().map(QuantitySummary::lines) {
            entries(out, "", &lines)?;
        }
        let groups = self.groups.as_ref().map_or("none".into(), |groups| {
            let [samples, classes] = [groups.samples, groups.classes].map(span);
            let GroupSummary { groups, name, .. } = groups;
            let classes =
                if self.quantities.is_empty() { format!(", {classes} classes each") } else { String::new() };
            format!("{groups} of {name}: {samples} samples each{classes}")
        });
        entry(out, "groups", &groups)?;
        if !self.other_arrays.is_empty() {
            let names = first_of(&self.other_arrays);
            entry(out, "also holds", &format!("{names} (group = \"...\" makes groups of one)"))?;
        }
        if !self.ignored.is_empty() {
            entry(out, "ignored", &first_of(&self.ignored))?;
        }
        self.write_values(out)?;
        if let Some(shortcut) = self.shortcut.as_ref().filter(|shortcut| !shortcut.is_suspicious()) {
            entry(out, "statistics", &shortcut.to_string())?;
        }
        if !self.dropped.is_empty() {
            entry(out, "dropped", &format!("{} rows", self.dropped.len()))?;
        }
        if self.without_target > 0 {
            entry(out, "no target", &format!("{} left out", plural(self.without_target, "sample")))?;
        }
        let list = |texts: &[String]| texts.iter().map(|text| format!("- {text}")).collect::<Vec<_>>();
        entries(out, "mind", &list(&self.warnings))?;
        let mut problems = list(&self.problems);
        if problems.len() > PROBLEMS {
            let more = problems.split_off(PROBLEMS).len();
            problems.push(format!("and {more} more, listed in JSON"));
        }
        entries(out, "WRONG", &problems)
    }

    fn write_lengths(&self, out: &mut String) -> fmt::Result {
        let Some(lengths) = &self.lengths else { return Ok(()) };
        entry(out, "lengths", &lengths.to_string())?;
        // Not wrapped, to be copied into a config.
        match lengths.rule {
            Some(rule) => writeln!(out, "{:KEY$}{}", "rule", rule.key())?,
            None => writeln!(out, "{:KEY$}{} (below: the set under it)", "proposed", lengths.proposed.key())?,
        }
        if let Some(left_out) = lengths.left_out() {
            entry(out, "left out", &left_out)?;
        }
        Ok(())
    }

    fn write_values(&self, out: &mut String) -> fmt::Result {
        let Some([min, max]) = self.range else {
            return entry(out, "values", "none is finite");
        };
        let [at_min, at_max] = self.saturation.map(|share| share * 100.0);
        let finite = match (self.nan, self.infinite) {
            (0, 0) => String::new(),
            (nan, infinite) => format!("; {nan} NaN, {infinite} infinite"),
        };
        let text = format!("{min}..{max}; {at_min:.1} % at lowest, {at_max:.1} % at highest");
        entry(out, "values", &format!("{text}{finite}"))?;
        for (i, line) in card_channels::lines(&self.channels).iter().enumerate() {
            writeln!(out, "{:<KEY$}{line}", if i == 0 { "channels" } else { "" })?;
        }
        Ok(())
    }
}

/// Joins the first names of a long list.
fn first_of(names: &[String]) -> String {
    let mut letters = 0;
    let fits = |name: &&String| {
        letters += name.chars().count() + 2;
        letters <= LIST
    };
    // The first is always shown.
    let shown = names.iter().take_while(fits).count().max(1).min(names.len());
    let more = names.len() - shown;
    let text = names[..shown].join(", ");
    if more == 0 { text } else { format!("{text} and {more} more, listed in JSON") }
}

fn span([low, high]: [usize; 2]) -> String {
    if low == high { low.to_string() } else { format!("{low}..{high}") }
}

/// Writes a key and its texts below one another.
fn entries(out: &mut String, key: &str, texts: &[String]) -> fmt::Result {
    let keys = std::iter::once(key).chain(std::iter::repeat(""));
    keys.zip(texts).try_for_each(|(key, text)| entry(out, key, text))
}

/// Writes a key and its text, wrapped at spaces under the first line.
fn entry(out: &mut String, key: &str, text: &str) -> fmt::Result {
    write!(out, "{key:<KEY$}")?;
    let mut column = KEY;
    for (i, word) in text.split(' ').enumerate() {
        let width = word.chars().count();
        if i > 0 && column + 1 + width > WIDTH {
            write!(out, "\n{:KEY$}", "")?;
            column = KEY;
        } else if i > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += width;
    }
    out.push('\n');
    Ok(())
}
