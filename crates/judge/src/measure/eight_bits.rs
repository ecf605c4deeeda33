//! Which answers eight bits change, sample by sample.

use taxel_learn::FoldRecord;

use crate::case::Case;
use crate::values::Changed;

/// One value for each row in eight bits, over the test parts of the first repetition.
pub(super) fn changed(case: &Case) -> Vec<Changed> {
    let rows = case.results.networks.iter().filter_map(|own| Some((own, own.quantized.as_ref()?)));
    let all = rows.map(|(own, floats)| {
        let mut changed = Changed {
            network: own.network.clone(),
            floats: floats.clone(),
            samples: 0,
            differ: 0,
            only: [0; 2],
        };
        for bytes in case.first_repetition(&own.network) {
            let twin = case.first_repetition(floats);
            let same = |other: &&FoldRecord| other.key.fold == bytes.key.fold && other.index == bytes.index;
            if let Some(floats) = twin.into_iter().find(same) {
                count(floats, bytes, &mut changed);
            }
        }
        changed
    });
    all.filter(|own| own.samples > 0).collect()
}

fn count(floats: &FoldRecord, bytes: &FoldRecord, changed: &mut Changed) {
    let attributes = floats.outcome.labels().0.len() / floats.index.len().max(1);
    let answers = floats
        .outcome
        .labels()
        .1
        .chunks(attributes.max(1))
        .zip(bytes.outcome.labels().1.chunks(attributes.max(1)));
    for ((before, after), truth) in answers.zip(floats.outcome.labels().0.chunks(attributes.max(1))) {
        changed.samples += 1;
        changed.differ += u64::from(before != after);
        changed.only[0] += u64::from(before == truth && after != truth);
        changed.only[1] += u64::from(before != truth && after == truth);
    }
}
