//! The same work on every item, on all threads, with the results in the order of the items.

use rayon::prelude::*;

/// What `work` makes of each item, in their order whatever the threads.
pub fn in_order<'t, T: Sync, R: Send>(items: &'t [T], work: impl Fn(usize, &'t T) -> R + Sync) -> Vec<R> {
    items.par_iter().enumerate().map(|(number, item)| work(number, item)).collect()
}
