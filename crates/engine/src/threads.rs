//! Splitting work over threads so that the result does not depend on their number.
//!
//! Work is cut by its size alone; every piece writes its own memory. Sums are kept per piece and added
//! in the order of the pieces.

use rayon::prelude::*;

use crate::error::{Error, Result};

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
            Some(pool) if data.len() > len => pool.install(|| {
                data.par_chunks_mut(len).enumerate().for_each(|(i, chunk)| body(i, chunk));
            }),
            _ => data.chunks_mut(len).enumerate().for_each(|(i, chunk)| body(i, chunk)),
        }
    }

    /// Calls `body` for every pair of two equally long slices.
    pub fn each_pair<A: Send, B: Send>(
        &self,
        a: &mut [A],
        b: &mut [B],
        body: impl Fn(&mut A, &mut B) + Sync,
    ) {
        match &self.pool {
            Some(pool) if a.len() > 1 => {
                pool.install(|| a.par_iter_mut().zip(b).for_each(|(a, b)| body(a, b)));
            }
            _ => a.iter_mut().zip(b).for_each(|(a, b)| body(a, b)),
        }
    }
}
