//! How far a run is.

use indicatif::{ProgressBar, ProgressStyle};

use crate::run::records::FoldKey;

/// Hears how a run gets on. Work is counted in multiply-accumulates, so that a bar over networks of
/// different size moves evenly.
pub trait Progress {
    /// The run begins with `work` to do.
    fn start(&self, work: u64);
    /// Fold `key` begins, number `number` (from 1) of `total`.
    fn fold(&self, key: &FoldKey, number: usize, total: usize);
    /// A piece of work is done.
    fn step(&self, work: u64);
    /// The run has ended, for good or bad.
    fn finish(&self);
    /// Something that a user should know at once.
    fn say(&self, _line: &str) {}
}

/// Says nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _work: u64) {}
    fn fold(&self, _key: &FoldKey, _number: usize, _total: usize) {}
    fn step(&self, _work: u64) {}
    fn finish(&self) {}
}

/// A bar with the remaining time on standard error; hidden where that is no terminal.
#[derive(Debug)]
pub struct IndicatifProgress {
    bar: ProgressBar,
}

impl Default for IndicatifProgress {
    fn default() -> Self {
        let bar = ProgressBar::new(0);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3}% {eta:>4} left  {msg}") {
            bar.set_style(style);
        }
        IndicatifProgress { bar }
    }
}

impl Progress for IndicatifProgress {
    fn start(&self, work: u64) {
        self.bar.set_length(work);
        self.bar.reset();
    }

    fn fold(&self, key: &FoldKey, number: usize, total: usize) {
        self.bar.set_message(format!("{} fold {} ({number} of {total})", key.network, key.fold));
    }

    fn step(&self, work: u64) {
        self.bar.inc(work);
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn say(&self, line: &str) {
        self.bar.suspend(|| eprintln!("{line}"));
    }
}
