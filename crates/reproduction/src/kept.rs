//! Results of every run for each claim: `reference/claims.csv`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel::Source;
use taxel::data::SourceKind;

use crate::claims::{CLAIMS, Claim, Contrast, Verdict};
use crate::error::{Error, Result};

/// One contrast of a claim on a run, or what the run lacks; numbers are empty where there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    paper: String,
    place: String,
    claim: String,
    run: String,
    source: Source,
    fresh: bool,
    least: f64,
    /// The contrast; of a run that lacks something, what that is.
    effect: String,
    size: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
    refuting_low: Option<f64>,
    refuting_high: Option<f64>,
    error: Option<f64>,
    p: Option<f64>,
    margin: Option<f64>,
}

/// Returns the kind in words: `simulated` or `real`.
pub(crate) fn kind(kind: SourceKind) -> &'static str {
    match kind {
        SourceKind::Simulated => "simulated",
        SourceKind::Real => "real",
    }
}

impl Row {
    /// Returns the rows of a claim on a run: one for each contrast, or one for what the run lacks.
    fn of(claim: &Claim) -> Vec<Row> {
        let lacking = Row {
            paper: claim.paper.clone(),
            place: claim.place.clone(),
            claim: claim.says.clone(),
            run: claim.run.clone(),
            source: claim.source.clone(),
            fresh: claim.fresh,
            least: claim.least,
            effect: claim.lacks.clone().unwrap_or_default(),
            size: None,
            low: None,
            high: None,
            refuting_low: None,
            refuting_high: None,
            error: None,
            p: None,
            margin: None,
        };
        if claim.contrasts.is_empty() {
            return vec![lacking];
        }
        let ends = |interval: Option<[f64; 2]>| interval.map_or([None, None], |ends| ends.map(Some));
        let row = |contrast: &Contrast| {
            let ([low, high], [refuting_low, refuting_high]) =
                (ends(contrast.interval), ends(contrast.refuting));
            Row {
                effect: contrast.effect.clone(),
                size: Some(contrast.size),
                low,
                high,
                refuting_low,
                refuting_high,
                error: contrast.error,
                p: contrast.p,
                margin: contrast.margin,
                ..lacking.clone()
            }
        };
        claim.contrasts.iter().map(row).collect()
    }

    /// Returns the contrast; none of a row that says what a run lacks.
    fn contrast(&self) -> Option<Contrast> {
        let ends = |low: Option<f64>, high: Option<f64>| Some([low?, high?]);
        Some(Contrast {
            effect: self.effect.clone(),
            size: self.size?,
            interval: ends(self.low, self.high),
            refuting: ends(self.refuting_low, self.refuting_high),
            error: self.error,
            p: self.p,
            margin: self.margin,
        })
    }

    /// Returns the claim of this row, without contrasts.
    fn claim(&self) -> Claim {
        Claim {
            paper: self.paper.clone(),
            place: self.place.clone(),
            says: self.claim.clone(),
            run: self.run.clone(),
            source: self.source.clone(),
            fresh: self.fresh,
            least: self.least,
            contrasts: vec![],
            lacks: self.size.is_none().then(|| self.effect.clone()),
        }
    }
}

/// Reads the kept results.
pub(crate) fn read(path: &Path) -> Result<Vec<Claim>> {
    let mut reader = csv::Reader::from_path(path).map_err(|e| Error::file(path, e))?;
    let rows = reader.deserialize().collect::<std::result::Result<Vec<Row>, _>>();
    let mut claims: Vec<Claim> = vec![];
    for row in rows.map_err(|e| Error::file(path, e))? {
        let is_next = |claim: &&mut Claim| (&claim.says, &claim.run) == (&row.claim, &row.run);
        match claims.last_mut().filter(is_next) {
            Some(claim) => claim.contrasts.extend(row.contrast()),
            None => claims.push(Claim { contrasts: row.contrast().into_iter().collect(), ..row.claim() }),
        }
    }
    Ok(claims)
}

/// Returns the results as a CSV file.
pub(crate) fn text(claims: &[Claim], path: &Path) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    claims
        .iter()
        .flat_map(Row::of)
        .try_for_each(|row| writer.serialize(row))
        .map_err(|e| Error::file(path, e))?;
    let bytes = writer.into_inner().map_err(|e| Error::file(path, e))?;
    String::from_utf8(bytes).map_err(|e| Error::file(path, e))
}

/// Puts new results in the place of those of the same runs, in the order of the claims and of the runs' names. Of a claim
/// that no run of a kind can test, one reason is kept: the shortest. A run is asked about papers alone of which it tests some
/// claim: that it lacks the networks of the others says nothing.
///
/// # Errors
/// A result about a claim that the program does not know.
pub(crate) fn merged(kept: Vec<Claim>, new: &[Claim], path: &Path) -> Result<Vec<Claim>> {
    let renewed: BTreeSet<&str> = new.iter().map(|claim| claim.run.as_str()).collect();
    let mut all: Vec<Claim> =
        kept.into_iter().filter(|claim| !renewed.contains(claim.run.as_str())).collect();
    let is_tested = |claim: &Claim| claim.outcome() != Verdict::CannotBeTested;
    let papers: BTreeSet<(&str, &str)> =
        new.iter().filter(|claim| is_tested(claim)).map(|claim| (&*claim.run, &*claim.paper)).collect();
    all.extend(new.iter().filter(|claim| papers.contains(&(&*claim.run, &*claim.paper))).cloned());
    let place = |claim: &Claim| CLAIMS.iter().position(|known| known.says == claim.says);
    if let Some(unknown) = all.iter().find(|claim| place(claim).is_none()) {
        let reason = format!("no claim of the program reads `{}`; delete its rows", unknown.says);
        return Err(Error::file(path, reason));
    }
    // Where a claim is printed is the program's to say, however long its results are kept.
    for claim in &mut all {
        if let Some(at) = place(claim) {
            claim.place = CLAIMS[at].place.into();
        }
    }
    all.sort_by(|a, b| (place(a), &a.run).cmp(&(place(b), &b.run)));
    let mut tested = BTreeSet::new();
    let mut shortest: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (at, claim) in all.iter().enumerate() {
        let key = (claim.says.as_str(), kind(claim.source.kind));
        if is_tested(claim) {
            tested.insert(key);
        }
        let best = shortest.entry(key).or_insert(at);
        if claim.effect().chars().count() < all[*best].effect().chars().count() {
            *best = at;
        }
    }
    let reasons: BTreeSet<usize> =
        shortest.iter().filter(|(key, _)| !tested.contains(*key)).map(|(_, at)| *at).collect();
    let keep = |(at, claim): &(usize, &Claim)| is_tested(claim) || reasons.contains(at);
    Ok(all.iter().enumerate().filter(keep).map(|(_, claim)| claim.clone()).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn claim(at: usize, run: &str, sizes: &[f64], lacks: Option<&str>) -> Claim {
        let known = &CLAIMS[at];
        let contrast = |size: &f64| Contrast {
            effect: format!("{size} points"),
            size: *size,
            interval: Some([size - 0.1, size + 0.1]),
            refuting: Some([size - 0.2, size + 0.2]),
            error: Some(0.05),
            p: None,
            margin: Some(1.0),
        };
        Claim {
            paper: known.paper.into(),
            place: known.place.into(),
            says: known.says.into(),
            run: run.into(),
            source: Source::simulated("fingertip"),
            fresh: true,
            least: 0.0,
            contrasts: sizes.iter().map(contrast).collect(),
            lacks: lacks.map(String::from),
        }
    }

    #[test]
    fn a_run_that_is_asked_again_replaces_its_rows() {
        let kept = vec![
            claim(0, "b", &[1.0], None),
            claim(0, "c", &[2.0, 3.0], None),
            claim(1, "b", &[], Some("a and b")),
            claim(1, "c", &[], Some("a")),
        ];
        let elsewhere = CLAIMS.iter().position(|known| known.paper == "001").unwrap();
        let mut new = vec![claim(0, "b", &[-4.0], None), claim(1, "b", &[], Some("a and b"))];
        new.push(claim(elsewhere, "b", &[], Some("a")));
        new[0].place = "somewhere else".into();
        let all = merged(kept, &new, Path::new("claims.csv")).unwrap();
        let said: Vec<(&str, String)> =
            all.iter().map(|claim| (claim.run.as_str(), claim.effect())).collect();
        let second = "2 points; nearest of 2".to_string();
        assert_eq!(said, [("b", "-4 points".into()), ("c", second), ("c", "the run lacks a".into())]);
        assert!(all.iter().all(|kept| CLAIMS.iter().any(|known| known.place == kept.place)), "{all:?}");
        let unknown = Claim { says: "nobody says this".into(), ..claim(0, "b", &[1.0], None) };
        let error = merged(vec![unknown], &[], Path::new("claims.csv")).unwrap_err().to_string();
        assert!(error.starts_with("claims.csv: ") && error.contains("`nobody says this`"), "{error}");
        // The file gives back what was written.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("claims.csv");
        std::fs::write(&path, text(&all, &path).unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), all);
    }
}
