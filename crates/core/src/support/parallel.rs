//! Does the same work on every item, on all threads, with the results in the order of the items.

use rayon::prelude::*;

/// The result of `work` for each item, in their order at any number of threads.
pub fn in_order<'t, T: Sync, R: Send>(items: &'t [T], work: impl Fn(usize, &'t T) -> R + Sync) -> Vec<R> {
    items.par_iter().enumerate().map(|(number, item)| work(number, item)).collect()
}

/// Works on chunks of so many items at their place, in parallel; the last may have fewer.
pub fn in_chunks<T: Send>(items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync + Send) {
    items.par_chunks_mut(size).enumerate().for_each(|(number, chunk)| work(number, chunk));
}
