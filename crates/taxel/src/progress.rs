//! The progress bar of the command line and the Python package.

use std::io::Write;

use indicatif::{ProgressBar, ProgressStyle};
use taxel_learn::{FoldKey, Progress};

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
        self.bar.suspend(|| {
            // Nobody reads it any more; the work goes on.
            let _ = writeln!(std::io::stderr(), "{}", taxel_base::printable(line));
        });
    }
}
