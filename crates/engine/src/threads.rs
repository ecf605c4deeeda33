//! Splitting work over threads so that the result does not depend on their number.
//!
//! Work is cut into parts by its size alone; every part writes its own slice. Sums are kept per part
//! and added in the order of the parts.

use rayon::prelude::*;

use crate::error::{Error, Result};

/// The most parts a batch is cut into.
const PARTS: usize = 16;

/// One pool of worker threads; a pool of one runs everything in the calling thread.
#[derive(Debug)]
pub(crate) struct Threads {
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    pub fn new(threads: usize) -> Result<Self> {
        if threads <= 1 {
            return Ok(Threads { pool: None });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| Error::Threads { threads, reason: e.to_string() })?;
        Ok(Threads { pool: Some(pool) })
    }

    /// Calls `body(i, chunk)` for every chunk of `len` values.
    pub fn each<T: Send>(&self, data: &mut [T], len: usize, body: impl Fn(usize, &mut [T]) + Sync) {
        match &self.pool {
            None => data.chunks_mut(len).enumerate().for_each(|(i, chunk)| body(i, chunk)),
            Some(pool) => pool.install(|| {
                data.par_chunks_mut(len).enumerate().for_each(|(i, chunk)| body(i, chunk));
            }),
        }
    }

    /// As [`Threads::each`] over two slices cut alike.
    pub fn each2<A: Send, B: Send>(
        &self,
        (a, a_len): (&mut [A], usize),
        (b, b_len): (&mut [B], usize),
        body: impl Fn(usize, &mut [A], &mut [B]) + Sync,
    ) {
        match &self.pool {
            None => {
                let pairs = a.chunks_mut(a_len).zip(b.chunks_mut(b_len));
                pairs.enumerate().for_each(|(i, (a, b))| body(i, a, b));
            }
            Some(pool) => pool.install(|| {
                let pairs = a.par_chunks_mut(a_len).zip(b.par_chunks_mut(b_len));
                pairs.enumerate().for_each(|(i, (a, b))| body(i, a, b));
            }),
        }
    }
}

/// `count` items cut into at most `most` (and never more than 16) ranges of equal length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parts {
    pub count: usize,
    pub each: usize,
}

impl Parts {
    pub fn of(items: usize, most: usize) -> Self {
        let each = items.div_ceil(most.clamp(1, PARTS)).max(1);
        Parts { count: items.div_ceil(each), each }
    }

    pub fn range(&self, part: usize, items: usize) -> std::ops::Range<usize> {
        part * self.each..((part + 1) * self.each).min(items)
    }
}

/// `out = Σ parts` in their order; `parts` holds `count` slices of `out.len()`.
pub(crate) fn add_parts(parts: &[f32], out: &mut [f32]) {
    out.fill(0.0);
    for part in parts.chunks_exact(out.len()) {
        for (sum, value) in out.iter_mut().zip(part) {
            *sum += value;
        }
    }
}

/// As [`add_parts`] for the double sums of statistics.
pub(crate) fn add_parts_f64(parts: &[f64], width: usize) -> Vec<f64> {
    let mut out = vec![0.0; width];
    for part in parts.chunks_exact(width) {
        for (sum, value) in out.iter_mut().zip(part) {
            *sum += value;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_every_item_once() {
        for items in 1..200 {
            for most in [1, 3, 16, 99] {
                let parts = Parts::of(items, most);
                assert!(parts.count <= most.min(PARTS));
                let covered: Vec<usize> = (0..parts.count).flat_map(|p| parts.range(p, items)).collect();
                assert_eq!(covered, (0..items).collect::<Vec<_>>());
            }
        }
    }
}
