//! The smallest network that suffices, with the evidence.

mod words;

use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::contest::{Contest, Effect};
use crate::error::{Error, Result};
use crate::judgement::{Judged, Judgement};
use crate::statistics::holm;
pub(crate) use words::shown;

/// What is to be small.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum By {
    /// Time from raw reading to answer of one sample on one thread.
    #[default]
    Latency,
    /// Bytes of parameters and statistics.
    Size,
    /// Multiply-accumulates per sample.
    Macs,
}

/// What a choice has to respect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wish {
    /// What is to be small.
    pub by: By,
    /// Level of significance over the whole table, (0, 1). Default 0.05.
    pub alpha: f64,
    /// The most accuracy that faults may cost on average, in percentage points; none: not asked for.
    pub max_loss: Option<f64>,
    /// An accuracy loss that would matter, in percentage points: a table that could not have seen a loss
    /// this large has too few data, and what seems to lose more is not chosen. Default 5.
    pub margin: f64,
}

/// One network beside the most accurate one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Name in the experiment.
    pub network: String,
    /// Mean accuracy in %.
    pub accuracy: f64,
    /// Its accuracy less that of the best, in percentage points; 0 for the best itself.
    pub difference: f64,
    /// 95 % interval of the difference, where the test gives one.
    pub interval: Option<[f64; 2]>,
    /// Two-sided p of the test against the best; none for the best itself.
    pub p: Option<f64>,
    /// The same, Holm-corrected over the table.
    pub p_holm: Option<f64>,
    /// Whether it is worse than the best beyond doubt (`p_holm < alpha` and less accurate).
    pub worse: bool,
    /// What is to be small: ms, bytes or multiply-accumulates; none where it was not measured.
    pub cost: Option<f64>,
    /// Mean accuracy that faults cost, in percentage points; none without a stress test.
    pub mean_loss: Option<f64>,
    /// Why it cannot be chosen; none for candidates.
    pub refused: Option<String>,
}

/// How two networks were compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Corrected resampled t-test over folds and repetitions (Nadeau & Bengio 2003).
    NadeauBengio,
    /// Exact test on the samples of one shared test part (McNemar 1947).
    McNemar,
}

/// The recommendation and all that speaks for and against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// What was asked for.
    pub wish: Wish,
    /// How networks were compared.
    pub test: Test,
    /// The most accurate one.
    pub best: String,
    /// The smallest one that suffices; none where none does.
    pub chosen: Option<String>,
    /// Whether the data can tell: no candidate may be worse than the best by [`Wish::margin`] unseen.
    pub enough_data: bool,
    /// In the order of the run.
    pub evidence: Vec<Evidence>,
    /// The recommendation in sentences: what is chosen, what it gives up, what it saves, what is not known.
    pub words: Vec<String>,
}

impl Default for Wish {
    fn default() -> Self {
        Wish { by: By::Latency, alpha: 0.05, max_loss: None, margin: 5.0 }
    }
}

impl Wish {
    /// Refuses what cannot be wished for, before anything is measured.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn check(&self) -> Result<()> {
        let refuse = |name, value: f64, reason: &str| {
            Err(Error::Setting { name, value: value.to_string(), reason: reason.into() })
        };
        if !(self.alpha > 0.0 && self.alpha < 1.0) {
            return refuse("--alpha", self.alpha, "must be in (0, 1); 0.05 is usual");
        }
        if !(self.margin > 0.0 && self.margin <= 100.0) {
            return refuse("--margin", self.margin, "must be in (0, 100] percentage points");
        }
        match self.max_loss {
            Some(loss) if !(0.0..=100.0).contains(&loss) => {
                refuse("--max-loss", loss, "must be in 0..=100 percentage points")
            }
            _ => Ok(()),
        }
    }
}

/// The baseline that reads nothing.
pub(crate) const MAJORITY: &str = "majority";

/// The smallest network of a run that suffices: of those that are not significantly worse than the most
/// accurate one the cheapest, with the evidence. Baselines take part; majority, which reads nothing, is
/// compared and never chosen, nor is anything that is no better than chance or seems to lose more than
/// [`Wish::margin`], significantly or not. Of a learning curve only the rows with the most training samples take part.
///
/// # Errors
/// A wish outside its range, a limit on losses without a stress test, damaged records.
///
/// ```no_run
/// use taxel_judge::{Case, Options, Wish, choose, judge};
///
/// let case = Case::open("runs/quickstart".as_ref())?;
/// let judgement = judge(&case, &Options::default())?;
/// let choice = choose(&case, &judgement, &Wish::default())?;
/// println!("{}", choice.words.join("\n"));
/// # Ok::<(), taxel_judge::Error>(())
/// ```
pub fn choose(case: &Case, judgement: &Judgement, wish: &Wish) -> Result<Choice> {
    decide(&Contest::of(case)?, judgement, &case.contestants(), wish)
}

/// The same from records and a judgement alone.
pub(crate) fn decide(
    contest: &Contest,
    judgement: &Judgement,
    contestants: &[&str],
    wish: &Wish,
) -> Result<Choice> {
    wish.check()?;
    if wish.max_loss.is_some() && judgement.stress.is_none() {
        let (name, value) = ("--max-loss", wish.max_loss.unwrap_or_default().to_string());
        let reason = "needs a stress test, and there is none in the judgement; judge the run with one";
        return Err(Error::Setting { name, value, reason: reason.into() });
    }
    let rows: Vec<&Judged> =
        judgement.networks.iter().filter(|n| contestants.contains(&n.results.network.as_str())).collect();
    let Some(best) = rows.iter().copied().filter(|row| row.results.mean.is_some()).max_by(|a, b| {
        let cost = |row: &Judged| cost(row, wish.by).unwrap_or(f64::INFINITY);
        accuracy(a).total_cmp(&accuracy(b)).then(cost(b).total_cmp(&cost(a)))
    }) else {
        let (folder, reason) = (judgement.results.name.clone(), "has no finished fold".into());
        return Err(Error::Run { folder, reason });
    };
    let name = |row: &Judged| row.results.network.clone();
    let mut evidence = vec![];
    for row in &rows {
        let effect = match std::ptr::eq(*row, best) {
            true => Some(Effect { size: 0.0, interval: None, p: None }),
            false => contest.difference(&name(row), &name(best), None)?,
        };
        let stressed = judgement.stress.iter().flat_map(|s| &s.networks);
        let mean_loss = stressed.clone().find(|n| n.network == name(row)).map(|n| n.mean_loss);
        evidence.push(Evidence {
            network: name(row),
            accuracy: accuracy(row),
            difference: effect.map_or(accuracy(row) - accuracy(best), |e| e.size),
            interval: effect.and_then(|e| e.interval),
            p: effect.and_then(|e| e.p),
            p_holm: None,
            worse: false,
            cost: cost(row, wish.by),
            mean_loss,
            refused: match effect {
                None => Some(format!("has no finished fold in common with {}", name(best))),
                Some(_) => refusal(row, judgement.chance, mean_loss, wish),
            },
        });
    }
    correct(&mut evidence, wish.alpha);
    for own in evidence.iter_mut().filter(|own| own.refused.is_none() && !own.worse) {
        let lost = -own.difference;
        own.refused =
            (lost > wish.margin).then(|| format!("seems to lose {lost:.1} points, but the data cannot tell"));
    }
    let best = name(best);
    let chosen = cheapest(&evidence).map(|own| own.network.clone());
    let enough_data = evidence.iter().all(|own| own.network == best || !unseen(own, wish.margin));
    let mut choice = Choice {
        wish: wish.clone(),
        test: contest.test(),
        best,
        chosen,
        enough_data,
        evidence,
        words: vec![],
    };
    choice.words = words::words(&choice, judgement, &rows);
    Ok(choice)
}

fn accuracy(row: &Judged) -> f64 {
    row.results.mean.map_or(0.0, |mean| mean.accuracy)
}

/// What is to be small.
fn cost(row: &Judged, by: By) -> Option<f64> {
    match by {
        By::Latency => row.speed.map(|speed| speed.whole_p50_ms),
        By::Size => Some(row.results.costs.bytes as f64),
        By::Macs => Some(row.results.costs.macs as f64),
    }
}

/// Why a network cannot be chosen, however accurate it is.
fn refusal(row: &Judged, chance: f64, mean_loss: Option<f64>, wish: &Wish) -> Option<String> {
    if row.results.zoo == MAJORITY {
        return Some("reads nothing: is here to be beaten".into());
    }
    // To rounding: accuracies are means over folds.
    if accuracy(row) <= chance + 1e-9 {
        return Some("is no better than always naming the commonest class".into());
    }
    if cost(row, wish.by).is_none() {
        return Some("was not timed: its speed is not known".into());
    }
    match (wish.max_loss, mean_loss) {
        (Some(most), Some(loss)) if loss > most => {
            Some(format!("loses {loss:.1} points to faults on average, more than {most}"))
        }
        (Some(_), None) => Some("was not tested under faults".into()),
        _ => None,
    }
}

/// Holm over all comparisons with the best; what is worse beyond doubt.
fn correct(evidence: &mut [Evidence], alpha: f64) {
    let p: Vec<f64> = evidence.iter().filter_map(|own| own.p).collect();
    let tested = evidence.iter_mut().filter(|own| own.p.is_some());
    for (own, corrected) in tested.zip(holm(&p)) {
        own.p_holm = Some(corrected);
        own.worse = corrected < alpha && own.difference < 0.0;
    }
}

/// The cheapest that is neither refused nor worse; of equals the more accurate.
fn cheapest(evidence: &[Evidence]) -> Option<&Evidence> {
    let candidates = evidence.iter().filter(|own| own.refused.is_none() && !own.worse);
    candidates.min_by(|a, b| {
        let cost = |own: &Evidence| own.cost.unwrap_or(f64::INFINITY);
        cost(a).total_cmp(&cost(b)).then(b.accuracy.total_cmp(&a.accuracy))
    })
}

/// Whether a loss larger than `margin` could have stayed unseen, or is seen and not sure. Majority counts:
/// data that cannot tell it from the best tell nothing.
fn unseen(own: &Evidence, margin: f64) -> bool {
    let counts = own.refused.is_none() || own.network == MAJORITY || own.difference < -margin;
    counts && !own.worse && own.interval.is_none_or(|[low, _]| low < -margin)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
