//! Networks in eight bits beside the same in floats.

use super::statistics::mcnemar;
use crate::values::{EightBits, Judgement};

/// Returns every row in eight bits whose row in floats was measured too, in the order of the run.
pub fn eight_bits(judgement: &Judgement) -> Vec<EightBits> {
    let lost = |name: &str| judgement.stress.as_ref()?.mean_loss(name);
    let both = |a: Option<f64>, b: Option<f64>| Some([a?, b?]);
    let rows = judgement.changed.iter().filter_map(|changed| {
        let (floats, bytes) = (judgement.network(&changed.floats)?, judgement.network(&changed.network)?);
        let time = |row: &crate::values::Judged| row.speed.map(|speed| speed.whole.p50_ms);
        Some(EightBits {
            network: changed.floats.clone(),
            scores: [floats.score()?, bytes.score()?],
            p: mcnemar(changed.only[0], changed.only[1]),
            loss: both(lost(&changed.floats), lost(&changed.network)),
            latency: both(time(floats), time(bytes)),
            bytes: [floats.results.costs.bytes, bytes.results.costs.bytes],
            changed: changed.clone(),
        })
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::synthetic::{Setting, player, synthetic};
    use crate::values::Changed;

    #[test]
    fn a_row_is_beside_its_own() {
        let players = vec![player("net", 2.0, &[5; 5]), player("net.int8", 1.0, &[6; 5])];
        let (_, mut judgement) = synthetic(&Setting::default(), players);
        assert!(eight_bits(&judgement).is_empty());
        judgement.changed = vec![Changed {
            network: "net.int8".into(),
            floats: "net".into(),
            samples: 200,
            differ: 12,
            only: [9, 1],
        }];
        let rows = eight_bits(&judgement);
        assert_eq!((rows.len(), rows[0].latency), (1, Some([2.0, 1.0])));
        // Two-sided: 2 · (1 + 10) / 2^10.
        assert!((rows[0].p - 22.0 / 1024.0).abs() < 1e-12, "{}", rows[0].p);
    }
}
