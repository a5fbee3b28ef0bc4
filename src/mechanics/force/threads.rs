//! Loops over chunks, on one thread or on a pool: the same chunks, the same bits.

use rayon::prelude::*;

/// The worker threads of one run.
#[derive(Debug)]
pub struct Threads {
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// A pool of `count` threads, or none at all for one.
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn new(count: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = if count > 1 { Some(rayon::ThreadPoolBuilder::new().num_threads(count).build()?) } else { None };
        Ok(Self { pool })
    }

    /// Calls `work(index, item)` for every item.
    pub fn for_each<T: Send>(&self, items: impl IndexedParallelIterator<Item = T> + Iterator<Item = T>, work: impl Fn(usize, T) + Sync + Send) {
        match &self.pool {
            Some(pool) => pool.install(|| IndexedParallelIterator::enumerate(items).for_each(|(i, item)| work(i, item))),
            None => Iterator::enumerate(items).for_each(|(i, item)| work(i, item)),
        }
    }
}
