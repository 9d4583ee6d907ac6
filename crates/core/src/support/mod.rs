//! Tools for every other module: boosted trees, random streams, vector instructions, statistics, comparisons of groups, geometry, lengths along lines, elimination orders, suggestions,
//! lists by number, text that may be shown, endings of names, limits of the system.

pub mod arc_lengths;
pub mod boosted_trees;
pub mod calibration;
pub mod comparison;
pub mod elimination;
pub mod endings;
pub mod gamma;
pub mod geometry;
pub mod kappa;
pub mod limits;
pub mod model_provenance;
pub mod normal_equations;
pub mod numbered;
pub mod printable;
pub mod random;
pub mod simd;
pub mod statistics;
pub mod suggestions;
pub mod ties;
pub mod toml_text;

pub use geometry::{
    Point, area_of, bounds, box_diagonal, centroid, cross, distance, dot, lerp, norm, norm_squared, onto, radius_of, smooth,
    straightest, sub, unit, weighted_centroid,
};
pub use numbered::{counted, grouped, list_of, marked, placed};
pub use statistics::{Distribution, median, otsu, quantile, quantile_of_sorted, sigmoid, weighted_quantiles};

use rayon::prelude::*;

/// Some items in rising order, each once.
pub fn distinct<T: Ord>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut items: Vec<T> = items.into_iter().collect();
    items.sort_unstable();
    items.dedup();
    items
}

/// The result of `work` for each item, in their order at any number of threads.
pub fn in_order<'t, T: Sync, R: Send>(items: &'t [T], work: impl Fn(usize, &'t T) -> R + Sync) -> Vec<R> {
    items.par_iter().enumerate().map(|(number, item)| work(number, item)).collect()
}

/// Works on chunks of so many items at their place, in parallel; the last may have fewer.
pub fn in_chunks<T: Send>(items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync + Send) {
    items.par_chunks_mut(size).enumerate().for_each(|(number, chunk)| work(number, chunk));
}
