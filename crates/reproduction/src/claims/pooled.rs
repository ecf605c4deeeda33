//! One verdict of a claim over all its runs.

use taxel::data::SourceKind;
use taxel::judge::Result;
use taxel::judge::statistics::{false_discovery, random_effects};

use super::claim::Claim;
use super::contrast::{Contrast, weakest};
use super::verdict::Verdict;

/// A claim over all runs on one kind of data.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pooled<'c> {
    /// Every run on such data, those that cannot test the claim too.
    pub runs: Vec<&'c Claim>,
    /// The runs that the verdict rests on.
    pub counted: usize,
    /// The comparison that decides; none where no run can test the claim.
    pub weakest: Option<Contrast>,
    /// Bound above which it supports the claim.
    pub least: f64,
    /// Comparisons of which it is the weakest.
    pub contrasts: usize,
    /// Benjamini and Hochberg's q over all claims on such data.
    pub q: Option<f64>,
}

impl<'c> Pooled<'c> {
    /// Pools the results of one claim on one kind of data: those of fresh worlds alone where there are some, since all other
    /// simulated runs share a world; a contrast over several runs by random effects.
    ///
    /// # Errors
    /// None that results of runs cause.
    pub fn of(runs: Vec<&'c Claim>) -> Result<Self> {
        let tested = || runs.iter().copied().filter(|claim| claim.outcome() != Verdict::CannotBeTested);
        let any_fresh = tested().any(|claim| claim.fresh);
        let counted: Vec<&Claim> = tested().filter(|claim| claim.fresh || !any_fresh).collect();
        let least = counted.first().map_or(0.0, |claim| claim.least);
        let contrasts = match counted.as_slice() {
            [] => vec![],
            [one] => one.contrasts.clone(),
            several => pooled(several)?,
        };
        let weakest = weakest(least, &contrasts).cloned();
        Ok(Pooled { counted: counted.len(), weakest, least, contrasts: contrasts.len(), q: None, runs })
    }

    /// Returns the verdict.
    pub fn outcome(&self) -> Verdict {
        self.weakest.as_ref().map_or(Verdict::CannotBeTested, |contrast| contrast.verdict(self.least))
    }

    /// Returns the kind of data.
    pub fn kind(&self) -> Option<SourceKind> {
        self.runs.first().map(|claim| claim.source.kind)
    }
}

/// Sets the q-values of all claims on one kind of data.
pub(crate) fn with_q(claims: &mut [Pooled]) {
    let p = |claim: &Pooled| claim.weakest.as_ref().and_then(|contrast| contrast.p);
    let (rows, values): (Vec<usize>, Vec<f64>) =
        claims.iter().enumerate().filter_map(|(at, claim)| Some((at, p(claim)?))).unzip();
    for (at, q) in rows.into_iter().zip(false_discovery(&values)) {
        claims[at].q = Some(q);
    }
}

/// Pools each contrast that several runs have; of one that a single run has, that run's.
fn pooled(runs: &[&Claim]) -> Result<Vec<Contrast>> {
    let mut names: Vec<&str> = vec![];
    for contrast in runs.iter().flat_map(|run| &run.contrasts) {
        if !names.contains(&contrast.effect.as_str()) {
            names.push(&contrast.effect);
        }
    }
    let found = names.iter().map(|name| {
        let same = runs.iter().flat_map(|run| &run.contrasts).filter(|contrast| contrast.effect == *name);
        over_runs(&same.collect::<Vec<_>>(), names.len())
    });
    found.collect()
}

/// Pools one contrast over runs. Without standard errors of all, the run that comes nearest to refuting the claim stands for
/// them.
fn over_runs(same: &[&Contrast], count: usize) -> Result<Contrast> {
    let effects: Option<Vec<(f64, f64)>> =
        same.iter().map(|contrast| Some((contrast.size, contrast.error?))).collect();
    let (Some(effects), true) = (effects, same.len() > 1) else {
        let all: Vec<Contrast> = same.iter().map(|contrast| (*contrast).clone()).collect();
        return Ok(weakest(0.0, &all).unwrap_or(same[0]).clone());
    };
    let whole = random_effects(&effects, 0.95)?;
    let refuting = random_effects(&effects, 1.0 - 0.05 / count.max(1) as f64)?;
    Ok(Contrast {
        effect: same[0].effect.clone(),
        size: whole.mean,
        interval: Some(whole.interval),
        refuting: Some(refuting.interval),
        error: None,
        p: Some(whole.p),
        margin: same[0].margin,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use taxel::Source;

    fn contrast(size: f64, error: f64) -> Contrast {
        let interval = Some([size - 2.0 * error, size + 2.0 * error]);
        Contrast {
            effect: "accuracy: a less b, points".into(),
            size,
            interval,
            refuting: interval,
            error: Some(error),
            p: Some(0.01),
            margin: Some(1.0),
        }
    }

    fn claim(run: &str, fresh: bool, contrasts: Vec<Contrast>) -> Claim {
        Claim {
            paper: "000".into(),
            place: "Table 2".into(),
            says: "a beats b".into(),
            run: run.into(),
            source: Source::simulated("fingertip"),
            fresh,
            least: 0.0,
            contrasts,
            lacks: None,
        }
    }

    #[test]
    fn one_verdict_is_made_of_all_runs() {
        let verdict = |claims: &[Claim]| Pooled::of(claims.iter().collect()).unwrap().outcome();
        let runs = |sizes: &[f64]| -> Vec<Claim> {
            sizes.iter().map(|size| claim("run", false, vec![contrast(*size, 0.5)])).collect()
        };
        assert_eq!(verdict(&runs(&[3.0])), Verdict::Holds);
        assert_eq!(verdict(&runs(&[3.0, 4.0, 3.5])), Verdict::Holds);
        // Runs that contradict each other say nothing about the next one, however sure each is.
        assert_eq!(verdict(&runs(&[3.0, -4.0, 3.5])), Verdict::TooFewData);
        assert_eq!(verdict(&runs(&[-3.0, -4.0, -3.5])), Verdict::DoesNotHold);
        assert_eq!(verdict(&[]), Verdict::CannotBeTested);
        // Two runs can hardly tell what a third would be.
        assert_eq!(verdict(&runs(&[3.0, 4.0])), Verdict::TooFewData);
    }

    #[test]
    fn runs_that_share_a_world_do_not_count_beside_fresh_ones() {
        let claims = [
            claim("seed-0", false, vec![contrast(-5.0, 0.5)]),
            claim("fresh", true, vec![contrast(0.1, 0.2)]),
            claim("unable", true, vec![]),
        ];
        let pooled = Pooled::of(claims.iter().collect()).unwrap();
        assert_eq!((pooled.outcome(), pooled.counted, pooled.runs.len()), (Verdict::NoDifference, 1, 3));
    }

    #[test]
    fn q_values_are_those_of_the_claims_that_are_tested() {
        let (a, b) = (claim("a", true, vec![contrast(1.0, 0.1)]), claim("b", true, vec![]));
        let mut all = vec![Pooled::of(vec![&a]).unwrap(), Pooled::of(vec![&b]).unwrap()];
        with_q(&mut all);
        assert_eq!((all[0].q, all[1].q), (Some(0.01), None));
    }
}
