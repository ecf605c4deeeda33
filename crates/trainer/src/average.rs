//! Rows that average what other rows predict.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use taxel_learn::{Candidate, Check, file_name, require};

/// One of `[[averages]]`: the mean of what other rows predict, each counting alike, as a row and a model of its own. Its members are
/// trained again as their own rows are.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AverageRow {
    /// Name in tables and files.
    pub label: String,
    /// Labels of networks and names of baselines whose predictions are averaged, at least two.
    pub of: Vec<String>,
}

impl AverageRow {
    /// Checks the name and the members; `labels` are those of networks and baselines.
    ///
    /// # Errors
    /// A name that names no files or that another row has, fewer than two members, one that is no row or is there twice.
    pub(crate) fn check(&self, labels: &BTreeSet<&str>) -> Check {
        file_name("label", &self.label)?;
        let said = format!("{:?}", self.label);
        let fresh = !labels.contains(self.label.as_str());
        require(fresh, "label", said, "two rows of the table would go by this name; give this one another")?;
        require(self.of.len() > 1, "of", format!("{:?}", self.of), "an average needs two rows or more")?;
        known("of", &self.of, labels)?;
        let distinct = self.of.iter().collect::<BTreeSet<_>>().len() == self.of.len();
        require(distinct, "of", format!("{:?}", self.of), "name each row once: all count alike")
    }

    /// Returns the candidate of it, or the first member that is not among `candidates`.
    pub(crate) fn candidate(&self, candidates: &[Candidate]) -> Result<Candidate, &str> {
        let find = |name| candidates.iter().find(|candidate| candidate.name == name).cloned().ok_or(name);
        let members: Vec<Candidate> =
            self.of.iter().map(String::as_str).map(find).collect::<Result<_, _>>()?;
        Ok(Candidate::average(self.label.clone(), &members))
    }
}

/// Checks that every name is one of the experiment's.
pub(crate) fn known(key: &str, names: &[String], labels: &BTreeSet<&str>) -> Check {
    for (i, name) in names.iter().enumerate() {
        let hint = taxel_base::names::hint(name, labels.iter().copied());
        let reason = format!("is no network or baseline of this experiment; {hint}");
        require(labels.contains(name.as_str()), &format!("{key}.{i}"), format!("{name:?}"), reason)?;
    }
    Ok(())
}
