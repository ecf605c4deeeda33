//! Splitting work over threads so that the result does not depend on their number.
//!
//! Work is cut by its size alone; every piece writes its own memory. Sums are kept per piece and added
//! in the order of the pieces.

use rayon::prelude::*;

use crate::error::{Error, Result};

/// Threads that any machine may be asked for; more than there are cores bring nothing, and many more take all of
/// its time and memory to start.
const MOST: usize = 64;

/// One pool of worker threads; a pool of one runs everything in the calling thread.
#[derive(Debug)]
pub(crate) struct Threads {
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// Makes a pool of so many threads; of one where the work `is_small`.
    pub fn new(threads: usize, is_small: bool) -> Result<Self> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let most = cores.max(MOST);
        if threads > most {
            let reason = format!("this machine has {cores} cores, and {most} threads are the most");
            return Err(Error::Threads { threads, reason });
        }
        if threads <= 1 || is_small {
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
