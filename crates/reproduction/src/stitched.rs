//! The stitched network of Rouhafzay et al. 2021 beside its parents: `reference/stitched.csv`.
//!
//! No run trains it, since it is made of two trained networks. `scripts/stitch_experiment.py` makes it, and writes what it
//! answers to the test samples of each parent.

use serde::Deserialize;
use taxel::Source;
use taxel::learn::metrics::{MeanEstimate, Terms, t_quantile};

use crate::claims::{CLAIMS, Claim, Contrast, STITCHED};
use crate::error::{Error, Result};
use crate::pages::Pages;

const FILE: &str = "reference/stitched.csv";

/// Test samples of one parent.
#[derive(Debug, Deserialize)]
struct Stream {
    run: String,
    samples: usize,
    /// Samples that the stitched network alone gets right.
    gained: usize,
    /// Samples that the parent alone gets right.
    lost: usize,
}

/// Tests whether the stitched network loses less than a point against its parents, over the test samples of both; none
/// without the file.
///
/// # Errors
/// A file that is damaged.
pub(crate) fn stitched(pages: &Pages) -> Result<Option<Claim>> {
    let path = pages.file(FILE);
    if !path.exists() {
        return Ok(None);
    }
    let mut reader = csv::Reader::from_path(&path).map_err(|e| Error::file(&path, e))?;
    let streams = reader.deserialize().collect::<std::result::Result<Vec<Stream>, _>>();
    let streams = streams.map_err(|e| Error::file(&path, e))?;
    if let Some(stream) = streams.iter().find(|stream| stream.gained + stream.lost > stream.samples) {
        return Err(Error::file(&path, format!("more answers differ than {} samples", stream.samples)));
    }
    let known = CLAIMS.iter().find(|claim| claim.says == STITCHED);
    Ok(streams.first().zip(known).map(|(first, known)| Claim {
        paper: known.paper.into(),
        place: known.place.into(),
        says: known.says.into(),
        run: first.run.clone(),
        source: Source::simulated("imprint"),
        fresh: false,
        least: -1.0,
        contrasts: contrast(&streams).into_iter().collect(),
        lacks: None,
    }))
}

/// Compares the answers of the stitched network with those of its parents; none of fewer than two samples.
fn contrast(streams: &[Stream]) -> Option<Contrast> {
    let sum = |of: fn(&Stream) -> usize| streams.iter().map(of).sum::<usize>();
    let (samples, gained, lost) = (sum(|s| s.samples), sum(|s| s.gained), sum(|s| s.lost));
    let difference = |at: usize| match at {
        at if at < gained => 1.0,
        at if at < gained + lost => -1.0,
        _ => 0.0,
    };
    let differences: Vec<f64> = (0..samples).map(difference).collect();
    let numbers: Vec<u32> = (0..samples as u32).collect();
    let found = MeanEstimate::of(&differences, &numbers, None, Terms::Differences)?;
    let interval = found.interval(0.95).map(|ends| ends.map(|end| 100.0 * end));
    let half = interval.map(|[low, high]| (high - low) / 2.0);
    Some(Contrast {
        effect: format!("accuracy: stitched less its parents, {samples} samples of both streams, points"),
        size: 100.0 * found.mean,
        interval,
        refuting: interval,
        error: half.map(|half| half / t_quantile(found.freedom, 0.975)),
        p: None,
        margin: None,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::claims::Verdict;

    #[test]
    fn a_stitched_network_is_counted_on_both_streams() {
        let folder = tempfile::tempdir().unwrap();
        let pages = Pages::at(folder.path()).unwrap();
        assert_eq!(stitched(&pages).unwrap(), None);
        std::fs::create_dir(folder.path().join("reference")).unwrap();
        let write = |rows: &str| {
            let text = format!("run,stream,samples,gained,lost\n{rows}");
            std::fs::write(folder.path().join(FILE), text).unwrap();
        };
        let verdict = |rows: &str| {
            write(rows);
            stitched(&pages).unwrap().unwrap().outcome()
        };
        assert_eq!(verdict("r,visual,210,0,0\nr,tactile,210,0,0\n"), Verdict::Holds);
        assert_eq!(verdict("r,visual,210,0,0\n"), Verdict::Holds);
        assert_eq!(verdict("r,visual,210,0,3\nr,tactile,210,1,4\n"), Verdict::TooFewData);
        assert_eq!(verdict("r,visual,210,0,30\nr,tactile,210,1,40\n"), Verdict::DoesNotHold);
        write("r,visual,2,3,0\n");
        let error = stitched(&pages).unwrap_err().to_string();
        assert!(error.contains("stitched.csv: more answers differ than 2 samples"), "{error}");
    }
}
