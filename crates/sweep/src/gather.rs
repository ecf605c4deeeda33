//! Folds that were trials of their own, put together to the run that they are parts of.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use taxel_learn::{RunFolder, RunOptions, Silent, gather};
use taxel_trainer::Runner;
use taxel_zoo::Registry;

use crate::error::Result;
use crate::folder::SweepFolder;
use crate::json;
use crate::lease::{Lease, Taken};
use crate::record::TrialResult;
use crate::samples::Loader;
use crate::trial::{Trial, TrialFold};
use crate::work::{publish, resolved};

/// Puts the finished folds of one run together, unless that is done or somebody else is at it. The run folder is
/// that of a run which was never divided, byte for byte. Its result; none where somebody else is at it.
///
/// # Errors
/// A fold whose files are damaged, samples that are not there any more, a folder that cannot be written.
pub(crate) fn put_together(
    folder: &SweepFolder,
    folds: &[(String, TrialFold)],
    any: &Trial,
    (registry, loader): (&Registry, &mut Loader),
    stale: Duration,
) -> Result<Option<TrialResult>> {
    let run = any.run();
    if let Some(result) = TrialResult::read(folder, run)? {
        return Ok(Some(result));
    }
    let Taken::Mine(lease) = Lease::take(folder, run, stale)? else { return Ok(None) };
    let out = folder.run(&any.name, run);
    if !out.is_dir() {
        let work = lease.work()?;
        // What a killed process has begun is begun anew: nothing is trained here.
        if work.is_dir() {
            std::fs::remove_dir_all(&work).map_err(|e| crate::Error::io(&work, "removed", e))?;
        }
        let pieces = folds
            .iter()
            .map(|(identity, piece)| {
                Ok((RunFolder::open(&folder.piece(&any.name, identity))?, piece.key.clone()))
            })
            .collect::<Result<Vec<_>>>()?;
        gather(&work, &pieces)?;
        let experiment = resolved(any, registry)?;
        let dataset = loader.of(&experiment)?;
        let runner = Runner { experiment: &experiment, registry, dataset: &dataset };
        // No fold is to be trained: all are there.
        let options = RunOptions { resume: true, only: Some(vec![]), ..RunOptions::default() };
        runner.run(Some(&work), &options, &Silent, &AtomicBool::new(false))?;
        publish(&work, &out)?;
    }
    let results = RunFolder::open(&out)?.results()?;
    let result = TrialResult::of(run, &any.data, &results);
    json::write(&folder.result(run), &result)?;
    lease.finish()?;
    Ok(Some(result))
}
