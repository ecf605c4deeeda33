//! Values of metrics by name.

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::metrics::mean_sd;

/// Values of metrics by name, in the order of the task's table and in the metrics' units.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scores(Vec<(String, f64)>);

impl Scores {
    /// Takes names and values.
    pub fn new<N: Into<String>>(each: impl IntoIterator<Item = (N, f64)>) -> Self {
        Scores(each.into_iter().map(|(name, value)| (name.into(), value)).collect())
    }

    /// Returns the value of the metric `name`.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Returns the value of the primary metric, which stands first.
    pub fn primary(&self) -> Option<f64> {
        self.0.first().map(|(_, value)| *value)
    }

    /// Sets the value of the metric `name`.
    pub fn set(&mut self, name: &str, value: f64) {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.0.push((name.into(), value)),
        }
    }

    /// Returns names and values.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, value)| (name.as_str(), *value))
    }

    /// Checks whether all of its metrics have the same values in `other`.
    pub fn is_part_of(&self, other: &Scores) -> bool {
        self.iter().all(|(name, value)| other.get(name) == Some(value))
    }

    /// Returns mean and sample standard deviation (divided by n - 1) of each metric that all of `each` have; no
    /// deviation of fewer than two, nothing of none.
    pub fn mean_sd(each: &[&Scores]) -> (Option<Scores>, Option<Scores>) {
        let Some(first) = each.first() else { return (None, None) };
        let (mut means, mut sds) = (Scores::default(), Scores::default());
        for (name, _) in first.iter() {
            let Some(values) = each.iter().map(|scores| scores.get(name)).collect::<Option<Vec<f64>>>()
            else {
                continue;
            };
            let (mean, sd) = mean_sd(&values);
            means.set(name, mean);
            if let Some(sd) = sd {
                sds.set(name, sd);
            }
        }
        (Some(means), (each.len() > 1).then_some(sds))
    }
}

impl Serialize for Scores {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Scores {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(InOrder)
    }
}

/// Reads a map in the order in which it is written.
struct InOrder;

impl<'de> Visitor<'de> for InOrder {
    type Value = Scores;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("numbers by the names of metrics")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Scores, A::Error> {
        let mut scores = vec![];
        while let Some(entry) = map.next_entry::<String, f64>()? {
            scores.push(entry);
        }
        Ok(Scores(scores))
    }
}
