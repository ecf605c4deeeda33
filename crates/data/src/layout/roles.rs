//! Which arrays of a file are samples, labels, groups and marks.

use crate::options::ReadOptions;

/// Names that stand for `x` where there is no such array.
const SAMPLES: [&str; 2] = ["X", "data"];
/// Names that stand for `y`.
const LABELS: [&str; 2] = ["Y", "labels"];

/// Arrays by what they are for.
#[derive(Debug, PartialEq)]
pub(crate) struct Roles {
    pub x: Samples,
    /// One array, or that of the training and that of the test samples.
    pub y: Option<Vec<String>>,
    pub group: Option<Vec<String>>,
}

/// Where samples are.
#[derive(Debug, PartialEq)]
pub(crate) enum Samples {
    /// `[N, ...]`.
    One(String),
    /// Those to train on and those to test on.
    Split([String; 2]),
    /// One array per recording, in the order in which they were saved.
    Each(Vec<String>),
}

/// A role that no array, or more than one, could have.
#[derive(Debug, PartialEq)]
pub(crate) struct Unclear {
    /// The array that was sought.
    pub array: String,
    /// The option that names it.
    pub option: &'static str,
    /// Arrays that could be it.
    pub several: Vec<String>,
}

impl Roles {
    /// Looks among the arrays `held`, in the order in which they were saved; `labels_of` counts the labels of an array.
    pub fn of(
        held: &[String],
        options: &ReadOptions,
        needs_labels: bool,
        labels_of: impl FnOnce(&str) -> Option<u64>,
    ) -> Result<Self, Unclear> {
        let x = find(held, options.x(), !options.names_x(), &SAMPLES, "x");
        let y = |split| find_in(held, options.y(), !options.names_y(), &LABELS, "y", split);
        match x {
            Ok(found) => {
                let split = found.len() == 2;
                let labels = match y(split) {
                    Ok(found) => Some(found),
                    Err(unclear) if needs_labels || !unclear.several.is_empty() => return Err(unclear),
                    Err(_) => None,
                };
                let group = group(held, options, split)?;
                let x = match <[String; 2]>::try_from(found) {
                    Ok(both) => Samples::Split(both),
                    Err(mut one) => Samples::One(one.remove(0)),
                };
                Ok(Self { x, y: labels, group })
            }
            Err(unclear) => {
                // Labels and as many other arrays: each is a recording.
                let Ok(labels) = y(false) else { return Err(unclear) };
                let group = group(held, options, false)?;
                let is_other = |name: &&String| {
                    !labels.contains(name)
                        && group.as_ref().is_none_or(|own| !own.contains(name))
                        && options.test.as_ref() != Some(*name)
                };
                let each: Vec<String> = held.iter().filter(is_other).cloned().collect();
                let count = labels_of(&labels[0]);
                if !unclear.several.is_empty() || each.len() < 2 || count != Some(each.len() as u64) {
                    return Err(unclear);
                }
                Ok(Self { x: Samples::Each(each), y: Some(labels), group })
            }
        }
    }
}

/// The array of groups: the one that is named, or `group` where there is one.
fn group(held: &[String], options: &ReadOptions, split: bool) -> Result<Option<Vec<String>>, Unclear> {
    let name = options.group.as_deref().unwrap_or("group");
    match find_in(held, name, false, &[], "group", split) {
        Err(unclear) if options.group.is_some() => Err(unclear),
        other => Ok(other.ok()),
    }
}

/// One array, or two halves where there is no such one.
fn find(
    held: &[String],
    name: &str,
    is_default: bool,
    others: &[&str],
    option: &'static str,
) -> Result<Vec<String>, Unclear> {
    let whole = find_in(held, name, is_default, others, option, false);
    let halves = find_in(held, name, is_default, others, option, true);
    match (whole, halves) {
        (Ok(whole), Ok(halves)) if whole[0] != name => {
            Err(Unclear { array: name.into(), option, several: [whole, halves].concat() })
        }
        (Ok(whole), _) => Ok(whole),
        (Err(unclear), _) if !unclear.several.is_empty() => Err(unclear),
        (Err(unclear), halves) => {
            halves.map_err(|halves| if halves.several.is_empty() { unclear } else { halves })
        }
    }
}

/// The array `name`, or the one of `others` that is there; of a `split` both halves, `name_train` and `name_test`.
fn find_in(
    held: &[String],
    name: &str,
    is_default: bool,
    others: &[&str],
    option: &'static str,
    split: bool,
) -> Result<Vec<String>, Unclear> {
    let names = |name: &str| match split {
        false => vec![name.to_string()],
        true => ["train", "test"].iter().map(|part| format!("{name}_{part}")).collect(),
    };
    let is_there = |names: &Vec<String>| names.iter().all(|name| held.contains(name));
    let own = names(name);
    if is_there(&own) {
        return Ok(own);
    }
    let others: &[&str] = if is_default { others } else { &[] };
    let mut found: Vec<Vec<String>> = others.iter().map(|other| names(other)).filter(is_there).collect();
    match (found.pop(), found.as_slice()) {
        (Some(one), []) => Ok(one),
        (one, _) => Err(Unclear {
            array: own[0].clone(),
            option,
            several: found.into_iter().chain(one).flatten().collect(),
        }),
    }
}
