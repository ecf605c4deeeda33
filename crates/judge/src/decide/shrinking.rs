//! Less and less of one thing beside the whole, and the knee.

use taxel_data::Dataset;
use taxel_learn::{FoldRecord, Protocol};

use super::comparison::{Comparison, Effect};
use super::statistics::holm;
use crate::error::Result;
use crate::values::{Contrast, Primary};

/// Compares each of `settings` with the `whole`: records of the same test parts, of all samples of `dataset`. One
/// without a test part in common with the whole has no contrast. The differences are tested as
/// [`choose`](super::choose) does ([`Comparison::tested`]), with Holm's correction over the settings.
///
/// # Errors
/// None that records of trainings cause.
pub fn contrasts(
    whole: &[FoldRecord],
    settings: &[Vec<FoldRecord>],
    dataset: &Dataset,
    protocol: &Protocol,
    seed: u64,
    alpha: f64,
) -> Result<Vec<Option<Contrast>>> {
    const WHOLE: &str = "whole";
    let primary = Primary::of(&dataset.task());
    let names: Vec<String> = (0..settings.len()).map(|at| at.to_string()).collect();
    let named = names.iter().cloned().zip(settings.iter().cloned());
    let networks = std::iter::once((WHOLE.to_string(), whole.to_vec())).chain(named).collect();
    let comparison = Comparison::of_records(networks, dataset, protocol, seed);
    let mut found: Vec<Option<(Effect, Effect)>> = vec![];
    for name in &names {
        let difference = comparison.difference(name, WHOLE, None)?;
        let whole = comparison.score(&[name, WHOLE])?;
        found.push(whole.zip(difference));
    }
    let p: Vec<f64> = found.iter().flatten().filter_map(|(_, difference)| difference.p).collect();
    let mut corrected = holm(&p).into_iter();
    let mut one = |(score, difference): (Effect, Effect)| {
        let p_holm = difference.p.and_then(|_| corrected.next());
        Contrast {
            score: score.size,
            score_interval: score.interval.map(|bounds| primary.clamped(bounds)),
            difference: difference.size,
            interval: difference.interval,
            p_holm,
            worse: p_holm.is_some_and(|p| p < alpha) && primary.loss(difference.size) > 0.0,
        }
    };
    Ok(found.into_iter().map(|pair| pair.map(&mut one)).collect())
}

/// Returns the primary metric as the mean over test parts, and its 95 % interval.
///
/// # Errors
/// None that records of trainings cause.
pub fn mean_score(
    records: &[FoldRecord],
    dataset: &Dataset,
    protocol: &Protocol,
    seed: u64,
) -> Result<Option<(f64, Option<[f64; 2]>)>> {
    let contrast = contrasts(records, &[records.to_vec()], dataset, protocol, seed, 0.05)?;
    Ok(contrast.into_iter().flatten().next().map(|contrast| (contrast.score, contrast.score_interval)))
}

/// Returns the smallest setting that suffices and that no larger one of the curve contradicts; settings come from the
/// largest to the smallest.
pub fn knee(contrasts: &[Option<Contrast>], margin: f64, primary: &Primary) -> Option<usize> {
    let enough =
        |contrast: &Option<Contrast>| contrast.is_some_and(|contrast| contrast.suffices(margin, primary));
    contrasts.iter().take_while(|contrast| enough(contrast)).count().checked_sub(1)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::synthetic::{Setting, player, synthetic};

    fn contrast(difference: f64, worse: bool) -> Option<Contrast> {
        Some(Contrast {
            score: 90.0 + difference,
            score_interval: None,
            difference,
            interval: None,
            p_holm: None,
            worse,
        })
    }

    #[test]
    fn a_knee_is_the_last_before_the_first_that_does_not_do() {
        let percent = Primary::default();
        let knee_of = |all: &[(f64, bool)]| {
            knee(&all.iter().map(|(by, worse)| contrast(*by, *worse)).collect::<Vec<_>>(), 2.0, &percent)
        };
        assert_eq!(knee_of(&[(0.0, false), (-2.0, false), (-2.1, false), (1.0, false)]), Some(1));
        assert_eq!(knee_of(&[(0.5, false), (-0.5, true), (0.0, false)]), Some(0));
        assert_eq!(knee_of(&[(-3.0, false), (0.0, false)]), None);
        assert_eq!(knee(&[contrast(0.0, false), None, contrast(0.0, false)], 2.0, &percent), Some(0));
        assert_eq!(knee(&[], 2.0, &percent), None);
    }

    #[test]
    fn settings_are_told_apart_as_networks_are() {
        let players = vec![
            player("whole", 1.0, &[5, 6, 4, 5, 5]),
            player("a", 1.0, &[5, 7, 4, 4, 5]),
            player("b", 1.0, &[25, 28, 22, 26, 24]),
        ];
        let (comparison, _) = synthetic(&Setting::default(), players);
        let records = |at: usize| comparison.networks[at].1.clone();
        let labels: Vec<u32> = (0..500).map(|row| row % 2).collect();
        let x = ndarray::ArrayD::from_shape_fn(vec![500, 1], |at| at[0] as f32);
        let dataset = Dataset::new("own", taxel_data::Layout::Features, x, &labels).unwrap();
        let contrasts = contrasts(
            &records(0),
            &[records(1), records(2), vec![]],
            &dataset,
            &Protocol::k_fold(5),
            0,
            0.05,
        )
        .unwrap();
        let (same, worse) = (contrasts[0].unwrap(), contrasts[1].unwrap());
        assert!(same.suffices(2.0, &Primary::default()) && same.difference.abs() < 1e-9, "{same:?}");
        assert!(worse.worse && (worse.difference + 20.0).abs() < 1e-9, "{worse:?}");
        let [low, high] = worse.interval.unwrap();
        assert!(low < -20.0 && high > -20.0 && high < -10.0);
        assert!((same.score - 95.0).abs() < 1e-9 && contrasts[2].is_none());
        assert_eq!(knee(&contrasts, 2.0, &Primary::default()), Some(0));
    }
}
