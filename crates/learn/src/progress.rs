//! How far a run is.

use crate::run::records::FoldKey;

/// Hears how a run gets on. Work is counted in multiply-accumulates, so that a bar over networks of
/// different size moves evenly.
pub trait Progress {
    /// Reports that the run begins with `work` to do.
    fn start(&self, work: u64);
    /// Reports that fold `key` begins, number `number` (from 1) of `total`.
    fn fold(&self, key: &FoldKey, number: usize, total: usize);
    /// Reports that a piece of `work` is done.
    fn step(&self, work: u64);
    /// Reports that the run has ended, for good or bad.
    fn finish(&self);
    /// Reports something that a user should know at once.
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
