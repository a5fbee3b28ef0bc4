//! Loops over chunks of work, on one thread or on a pool: the same chunks, the same bits.

use rayon::prelude::*;
use std::sync::Arc;

/// The worker threads of one run.
#[derive(Clone, Debug)]
pub struct Threads {
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Threads {
    /// No pool: the thread that asks.
    pub const ONE: Self = Self { pool: None };

    /// A pool of `count` threads, or none at all for one.
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn new(count: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let build = || rayon::ThreadPoolBuilder::new().num_threads(count).build().map(Arc::new);
        Ok(Self { pool: (count > 1).then(build).transpose()? })
    }

    /// Does `work` on one of the threads, which then takes its part in every loop: a loop that is begun elsewhere wakes them
    /// all, and waits.
    pub fn inside<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Does two pieces of work side by side.
    pub fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match &self.pool {
            Some(pool) => pool.join(a, b),
            None => (a(), b()),
        }
    }

    /// Does `work` on every item.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Send + Sync) {
        match &self.pool {
            Some(pool) => pool.install(|| items.par_iter_mut().for_each(work)),
            None => items.iter_mut().for_each(work),
        }
    }

    /// Does `work` on every run of `length` items of two arrays of the same length: `work(number, run of a, run of b)`.
    pub fn for_each_run<T: Send, U: Send>(
        &self,
        length: usize,
        (a, b): (&mut [T], &mut [U]),
        work: impl Fn(usize, &mut [T], &mut [U]) + Send + Sync,
    ) {
        if let Some(pool) = &self.pool {
            let runs = a.par_chunks_mut(length).zip(b.par_chunks_mut(length)).enumerate();
            pool.install(|| runs.with_min_len(8).for_each(|(i, (a, b))| work(i, a, b)));
        } else {
            let runs = a.chunks_mut(length).zip(b.chunks_mut(length)).enumerate();
            runs.for_each(|(i, (a, b))| work(i, a, b));
        }
    }
}
