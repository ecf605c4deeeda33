//! Chooses the labels to learn: the class, several attributes, or some of the classes.

use crate::dataset::dataset::Dataset;
use crate::dataset::labels::{Attribute, Labels};
use crate::dataset::targets::Targets;
use crate::{Error, Result};

impl Dataset {
    /// Learns every column of labels under these names, in the order of the columns; without names, the
    /// class alone. One name makes ordered levels of the classes of a set with one label per sample.
    ///
    /// # Errors
    ///
    /// [`Error::LearnAttributes`] for values, and for another number of names than columns.
    pub fn learn_attributes(&mut self, names: &[String]) -> Result<()> {
        if names.is_empty() {
            return Ok(());
        }
        let refuse = |reason: String| Err(Error::LearnAttributes { reason });
        let columns = match (self.targets.columns(), self.targets.labels()) {
            (Some(columns), _) => columns,
            (None, Some(labels)) if names.len() == 1 => labels,
            (None, Some(_)) => {
                return refuse(format!(
                    "{} has one label per sample; one name makes levels of it",
                    self.source
                ));
            }
            (None, None) => return refuse(format!("{} has values; leave the key out", self.source)),
        };
        let width = columns.attributes().len();
        if width != names.len() {
            return refuse(format!("{} has {width} columns of labels; name each of them", self.source));
        }
        let attributes: Vec<Attribute> = columns
            .attributes()
            .iter()
            .zip(names)
            .map(|(attribute, name)| Attribute { name: name.clone(), classes: attribute.classes.clone() })
            .collect();
        self.targets = Targets::Levels(Labels::new(attributes, columns.values().to_vec()));
        Ok(())
    }

    /// Keeps the samples of these classes only; their labels are numbered in this order. Samples stay in
    /// their order, and the digest stays that of the set as read.
    ///
    /// # Errors
    ///
    /// [`Error::KeepClasses`] for a name that no class has or that is there twice, for fewer than two, and
    /// where several attributes are learned.
    pub fn keep_classes(&mut self, names: &[String]) -> Result<()> {
        let refuse = |value: String, reason: String| Err(Error::KeepClasses { value, reason });
        let Targets::Classes { labels, columns, .. } = &self.targets else {
            return refuse("..".into(), "works with one class per sample; leave data.attributes out".into());
        };
        let (classes, labels) = (&labels.attributes()[0].classes, labels.values());
        let mut new = vec![None; classes.len()];
        for (label, name) in names.iter().enumerate() {
            match classes.iter().position(|class| class == name) {
                Some(old) if new[old].is_none() => new[old] = Some(label as u32),
                Some(_) => return refuse(format!("{name:?}"), "is there twice".into()),
                None => {
                    let hint = taxel_base::names::hint(name, classes.iter().map(String::as_str));
                    return refuse(format!("{name:?}"), format!("no class has this name; {hint}"));
                }
            }
        }
        if names.len() < 2 {
            return refuse(format!("{names:?}"), "needs two classes at least".into());
        }
        let kept: Vec<usize> = (0..self.len()).filter(|&row| new[labels[row] as usize].is_some()).collect();
        let renumbered: Vec<u32> = labels.iter().filter_map(|&label| new[label as usize]).collect();
        let columns = columns.as_ref().map(|columns| columns.select(&kept));
        *self = self.rows(&kept);
        let steps = self.targets.steps().cloned();
        self.targets = Targets::Classes { labels: Labels::of_classes(names, &renumbered), columns, steps };
        Ok(())
    }
}
