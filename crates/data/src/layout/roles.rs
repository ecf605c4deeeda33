//! Finds the arrays of a file that are samples, labels, groups and marks.

use crate::options::ReadOptions;

/// Names that stand for `x` where there is no such array.
const SAMPLES: [&str; 2] = ["X", "data"];
/// Names that stand for `y`.
const LABELS: [&str; 2] = ["Y", "labels"];

/// Arrays by their role.
#[derive(Debug, PartialEq)]
pub(crate) struct Roles {
    pub x: SampleArrays,
    /// By target one array, or that of the training and that of the test samples.
    pub y: Option<Vec<Vec<String>>>,
    pub group: Option<Vec<String>>,
}

/// The arrays that hold the samples.
#[derive(Debug, PartialEq)]
pub(crate) enum SampleArrays {
    /// `[N, ...]`.
    One(String),
    /// Training samples and test samples.
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
    /// Returns the name of the arrays of samples in messages.
    pub fn x_name(&self) -> String {
        match &self.x {
            SampleArrays::One(x) => x.clone(),
            SampleArrays::Split(both) => both.join(" with "),
            SampleArrays::Each(_) => "the other arrays".into(),
        }
    }

    /// Returns the names of the arrays of targets in messages.
    pub fn y_name(&self) -> Option<String> {
        let each =
            |arrays: &Vec<Vec<String>>| arrays.iter().map(|halves| halves.join(" with ")).collect::<Vec<_>>();
        self.y.as_ref().map(|arrays| each(arrays).join(", "))
    }

    /// Looks among the arrays `held`, in the order in which they were saved; `labels_of` counts the labels of an array.
    pub fn of(
        held: &[String],
        options: &ReadOptions,
        needs_labels: bool,
        labels_of: impl FnOnce(&str) -> Option<u64>,
    ) -> Result<Self, Unclear> {
        let others = |is_named: bool, others| if is_named { &[][..] } else { others };
        let x = Role { held, name: options.x(), others: others(options.names_x(), &SAMPLES), option: "x" };
        let y = |split| targets(held, options, split);
        match x.find() {
            Ok(found) => {
                let split = found.len() == 2;
                let labels = match y(split) {
                    Ok(found) => Some(found),
                    Err(unclear) if needs_labels || !unclear.several.is_empty() => return Err(unclear),
                    Err(_) => None,
                };
                let group = group(held, options, split)?;
                let x = match <[String; 2]>::try_from(found) {
                    Ok(both) => SampleArrays::Split(both),
                    Err(mut one) => SampleArrays::One(one.remove(0)),
                };
                Ok(Self { x, y: labels, group })
            }
            Err(unclear) => {
                // Labels and as many other arrays: each is a recording.
                let Ok(labels) = y(false) else { return Err(unclear) };
                let group = group(held, options, false)?;
                let is_other = |name: &&String| {
                    !labels.iter().flatten().any(|label| label == *name)
                        && group.as_ref().is_none_or(|group| !group.contains(name))
                        && options.test.as_ref() != Some(*name)
                };
                let each: Vec<String> = held.iter().filter(is_other).cloned().collect();
                let count = labels_of(&labels[0][0]);
                if !unclear.several.is_empty() || each.len() < 2 || count != Some(each.len() as u64) {
                    return Err(unclear);
                }
                Ok(Self { x: SampleArrays::Each(each), y: Some(labels), group })
            }
        }
    }
}

/// Finds the arrays of targets: those that are named, or `y` or what stands for it.
fn targets(held: &[String], options: &ReadOptions, split: bool) -> Result<Vec<Vec<String>>, Unclear> {
    if options.names_y() {
        let option = options.y_option();
        let one = |name: &String| Role { held, name, others: &[], option }.find_in(split);
        return options.y_names().iter().map(one).collect();
    }
    Role { held, name: "y", others: &LABELS, option: "y" }.find_in(split).map(|one| vec![one])
}

/// Finds the array of groups: the one that is named, or `group` where there is one.
fn group(held: &[String], options: &ReadOptions, split: bool) -> Result<Option<Vec<String>>, Unclear> {
    let name = options.group.as_deref().unwrap_or("group");
    match (Role { held, name, others: &[], option: "group" }).find_in(split) {
        Err(unclear) if options.group.is_some() => Err(unclear),
        other => Ok(other.ok()),
    }
}

/// A role, and the names that its array may have.
struct Role<'r> {
    held: &'r [String],
    name: &'r str,
    /// Names that stand for `name` where there is no such array.
    others: &'r [&'r str],
    option: &'static str,
}

impl Role<'_> {
    /// Finds one array, or its two halves where there is no such one.
    fn find(&self) -> Result<Vec<String>, Unclear> {
        match (self.find_in(false), self.find_in(true)) {
            (Ok(whole), Ok(halves)) if whole[0] != self.name => {
                let (array, several) = (self.name.into(), [whole, halves].concat());
                Err(Unclear { array, option: self.option, several })
            }
            (Ok(whole), _) => Ok(whole),
            (Err(unclear), _) if !unclear.several.is_empty() => Err(unclear),
            (Err(unclear), halves) => {
                halves.map_err(|halves| if halves.several.is_empty() { unclear } else { halves })
            }
        }
    }

    /// Finds one array, or where it is `split` both halves, `name_train` and `name_test`.
    fn find_in(&self, split: bool) -> Result<Vec<String>, Unclear> {
        let names = |name: &str| {
            let halves = || ["train", "test"].map(|part| format!("{name}_{part}")).to_vec();
            if split { halves() } else { vec![name.to_string()] }
        };
        let is_there = |names: &Vec<String>| names.iter().all(|name| self.held.contains(name));
        let wanted = names(self.name);
        if is_there(&wanted) {
            return Ok(wanted);
        }
        let others = self.others.iter().map(|other| names(other));
        let mut found: Vec<Vec<String>> = others.filter(is_there).collect();
        match (found.pop(), found.as_slice()) {
            (Some(one), []) => Ok(one),
            (one, _) => {
                let several = found.into_iter().chain(one).flatten().collect();
                Err(Unclear { array: wanted[0].clone(), option: self.option, several })
            }
        }
    }
}
