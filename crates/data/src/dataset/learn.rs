//! What of the labels is learned: the class, several attributes, or some of the classes.

use crate::dataset::dataset::Dataset;
use crate::dataset::labels::{Attribute, Labels};
use crate::{Error, Result};
use std::collections::HashMap;

impl Dataset {
    /// Learns every column of labels under these names, in the order of the columns; without names, the
    /// class alone. `y` then numbers the combinations of levels that occur, in ascending order, and
    /// `classes` are `attribute:level`.
    ///
    /// # Errors
    ///
    /// [`Error::LearnAttributes`] for one label per sample, and for another number of names than columns.
    pub fn learn_attributes(&mut self, names: &[String]) -> Result<()> {
        if names.is_empty() {
            return Ok(());
        }
        let refuse = |reason: String| Err(Error::LearnAttributes { reason });
        let Some(columns) = &self.columns else {
            return refuse(format!("{} has one label per sample; leave the key out", self.source));
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
        self.classes = attributes
            .iter()
            .flat_map(|a| a.classes.iter().map(move |class| format!("{}:{class}", a.name)))
            .collect();
        // Splits spread the combinations of levels evenly.
        let values = columns.values().to_vec();
        let mut combinations: Vec<&[u32]> = values.chunks_exact(width).collect();
        combinations.sort_unstable();
        combinations.dedup();
        let number: HashMap<&[u32], u32> = combinations.into_iter().zip(0..).collect();
        self.y = values.chunks_exact(width).map(|levels| number[levels]).collect();
        self.labels = Labels::new(attributes, values);
        self.columns = Some(self.labels.clone());
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
        if self.labels.attributes().len() > 1 {
            return refuse("..".into(), "works with one class per sample; leave data.attributes out".into());
        }
        let mut new = vec![None; self.classes.len()];
        for (label, name) in names.iter().enumerate() {
            match self.classes.iter().position(|class| class == name) {
                Some(old) if new[old].is_none() => new[old] = Some(label as u32),
                Some(_) => return refuse(format!("{name:?}"), "is there twice".into()),
                None => {
                    let hint = taxel_base::names::hint(name, self.classes.iter().map(String::as_str));
                    return refuse(format!("{name:?}"), format!("no class has this name; {hint}"));
                }
            }
        }
        if names.len() < 2 {
            return refuse(format!("{names:?}"), "needs two classes at least".into());
        }
        let kept: Vec<usize> = (0..self.len()).filter(|&row| new[self.y[row] as usize].is_some()).collect();
        *self = self.rows(&kept);
        self.y = self.y.iter().filter_map(|&label| new[label as usize]).collect();
        self.classes = names.to_vec();
        self.labels = Labels::of_classes(&self.classes, &self.y);
        Ok(())
    }
}
