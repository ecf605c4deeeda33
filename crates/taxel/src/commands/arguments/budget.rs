//! `--budget`, and the experiment of recordings that it limits.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Args;
use taxel::experiment::{self, Start};
use taxel::{ReadOptions, Registry};

use crate::terminal::messages::{detail, note};

/// The `--budget` of commands that choose an experiment.
#[derive(Args)]
pub struct Budget {
    /// Time that the experiment of recordings may take on this machine: 90s, 10m, 2h. Epochs, networks and training under
    /// faults are left out until it fits [default: 10m].
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    budget: Option<Duration>,
}

/// Time of an experiment where nobody says another.
const USUAL: Duration = Duration::from_secs(600);

impl Budget {
    /// Refuses a budget beside a config, which says itself what is run.
    pub fn refuse(&self, config: &Path) -> Result<(), String> {
        match self.budget {
            None => Ok(()),
            Some(_) => Err(format!(
                "--budget limits what is chosen for recordings, and {} says itself what is run; leave it out, shorten the run with \
                 --quick or --set train.epochs=N (--plan says what it takes), or name the recordings in place of the config",
                config.display()
            )),
        }
    }

    /// Says that a run which goes on keeps its choice.
    pub fn note_unused(&self, begun: &Path) {
        if self.budget.is_some() {
            note(format!(
                "--budget: not used, {} says what is run; --resume goes on with it",
                begun.display()
            ));
        }
    }

    /// Chooses the experiment of the recordings at `path`, of a config with the values `set`, and says what it is. Each method is tried for a
    /// moment on a few of them.
    ///
    /// # Errors
    /// Recordings that cannot be read or learned from.
    pub fn start(
        &self,
        path: &Path,
        options: &ReadOptions,
        set: &[String],
        threads: usize,
        cancel: &AtomicBool,
    ) -> experiment::Result<Start> {
        let registry = Registry::built_in();
        let dataset = Start::read(path, options, set, &registry)?;
        dataset.refuse_one_class()?;
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
        let whole = Start::new(&dataset, &absolute, options);
        let estimates = whole.measured(&dataset, &registry, cancel)?;
        for estimate in &estimates {
            let (begin, epoch) = (1e3 * estimate.begin, 1e3 * estimate.epoch);
            detail(format!("{}: {begin:.3} ms for a sample, and {epoch:.3} ms in an epoch", estimate.name));
        }
        let budget = self.budget.unwrap_or(USUAL);
        let start = whole.within(budget, &estimates, threads);
        note(start.summary());
        if start.exceeds(budget) {
            note("--budget: no choice of methods fits it; this one takes the least");
        }
        Ok(start)
    }
}
