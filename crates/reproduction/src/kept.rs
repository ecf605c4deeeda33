//! Results of every run for each claim: `reference/claims.csv`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel::data::SourceKind;

use crate::claims::{CLAIMS, Claim, Verdict};
use crate::error::{Error, Result};

/// Result of one run for one claim; numbers as they are printed, empty where there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClaimRow {
    pub paper: String,
    pub place: String,
    pub claim: String,
    pub run: String,
    pub source: String,
    pub kind: String,
    pub outcome: String,
    pub effect: String,
    pub size: String,
    pub size_low: String,
    pub size_high: String,
}

/// Returns the kind in words: `simulated` or `real`.
pub(crate) fn kind(kind: SourceKind) -> &'static str {
    match kind {
        SourceKind::Simulated => "simulated",
        SourceKind::Real => "real",
    }
}

impl ClaimRow {
    pub fn of(claim: &Claim) -> Self {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let [low, high] = claim.interval.map_or([None, None], |ends| ends.map(Some));
        ClaimRow {
            paper: claim.paper.clone(),
            place: claim.place.clone(),
            claim: claim.says.clone(),
            run: claim.run.clone(),
            source: claim.source.to_string(),
            kind: kind(claim.source.kind).into(),
            outcome: claim.outcome.words().into(),
            effect: claim.effect.clone(),
            size: number(claim.size),
            size_low: number(low),
            size_high: number(high),
        }
    }

    /// Checks whether the claim could be tested on the run.
    pub fn is_tested(&self) -> bool {
        self.outcome != Verdict::CannotBeTested.words()
    }
}

/// Reads the kept rows.
pub(crate) fn read(path: &Path) -> Result<Vec<ClaimRow>> {
    let mut reader = csv::Reader::from_path(path).map_err(|e| Error::file(path, e))?;
    reader.deserialize().collect::<std::result::Result<_, _>>().map_err(|e| Error::file(path, e))
}

/// Returns the rows as a CSV file.
pub(crate) fn text(rows: &[ClaimRow], path: &Path) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|e| Error::file(path, e))?;
    let bytes = writer.into_inner().map_err(|e| Error::file(path, e))?;
    String::from_utf8(bytes).map_err(|e| Error::file(path, e))
}

/// Puts new rows in the place of those of the same runs, in the order of the claims and of the runs' names. Of a claim
/// that no run of a kind can test, one reason is kept: the shortest.
///
/// # Errors
/// A row about a claim that the program does not know.
pub(crate) fn merged(kept: Vec<ClaimRow>, new: Vec<ClaimRow>, path: &Path) -> Result<Vec<ClaimRow>> {
    let renewed: BTreeSet<String> = new.iter().map(|row| row.run.clone()).collect();
    let mut rows: Vec<ClaimRow> = kept.into_iter().filter(|row| !renewed.contains(&row.run)).collect();
    rows.extend(new);
    let place = |row: &ClaimRow| CLAIMS.iter().position(|claim| claim.says == row.claim);
    if let Some(unknown) = rows.iter().find(|row| place(row).is_none()) {
        let reason = format!("no claim of the program reads `{}`; delete its rows", unknown.claim);
        return Err(Error::file(path, reason));
    }
    rows.sort_by(|a, b| (place(a), &a.run).cmp(&(place(b), &b.run)));
    let mut tested = BTreeSet::new();
    let mut shortest: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (at, row) in rows.iter().enumerate() {
        let key = (row.claim.as_str(), row.kind.as_str());
        if row.is_tested() {
            tested.insert(key);
        }
        let best = shortest.entry(key).or_insert(at);
        if row.effect.chars().count() < rows[*best].effect.chars().count() {
            *best = at;
        }
    }
    let reasons: BTreeSet<usize> =
        shortest.iter().filter(|(key, _)| !tested.contains(*key)).map(|(_, at)| *at).collect();
    let keep = |(at, row): &(usize, &ClaimRow)| row.is_tested() || reasons.contains(at);
    Ok(rows.iter().enumerate().filter(keep).map(|(_, row)| row.clone()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(claim: usize, run: &str, outcome: Verdict, effect: &str) -> ClaimRow {
        let claim = &CLAIMS[claim];
        ClaimRow {
            paper: claim.paper.into(),
            place: claim.place.into(),
            claim: claim.says.into(),
            run: run.into(),
            source: "simulated: fingertip".into(),
            kind: "simulated".into(),
            outcome: outcome.words().into(),
            effect: effect.into(),
            size: String::new(),
            size_low: String::new(),
            size_high: String::new(),
        }
    }

    #[test]
    fn a_run_that_is_asked_again_replaces_its_rows() {
        let kept = vec![
            row(0, "b", Verdict::Holds, "old"),
            row(0, "c", Verdict::TooFewData, "stays"),
            row(1, "b", Verdict::CannotBeTested, "the run lacks a and b"),
            row(1, "c", Verdict::CannotBeTested, "the run lacks a"),
        ];
        let new = vec![
            row(0, "b", Verdict::DoesNotHold, "new"),
            row(1, "b", Verdict::CannotBeTested, "the run lacks a and b"),
        ];
        let rows = merged(kept, new, Path::new("claims.csv")).unwrap();
        let said: Vec<(&str, &str)> =
            rows.iter().map(|row| (row.run.as_str(), row.effect.as_str())).collect();
        assert_eq!(said, [("b", "new"), ("c", "stays"), ("c", "the run lacks a")]);
        let mut unknown = row(0, "b", Verdict::Holds, "");
        unknown.claim = "nobody says this".into();
        let error = merged(vec![unknown], vec![], Path::new("claims.csv")).unwrap_err().to_string();
        assert!(error.starts_with("claims.csv: ") && error.contains("`nobody says this`"), "{error}");
    }
}
