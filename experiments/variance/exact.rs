//! Enumeration of all masks of a small graph: exact means, and the exact variance of each order of interaction.

use rayon::prelude::*;

use crate::model::{Model, Work};

/// Graphs with more uncertain vessels than this are not enumerated.
const MOST_VESSELS: usize = 20;

pub struct Exact {
    pub mean: Vec<f64>,
    pub variance: Vec<f64>,
    /// Per vessel the variance of order 1, 2, ... as shares of the whole.
    pub orders: Vec<Vec<f64>>,
}

impl Exact {
    /// `None` of a graph that is too large.
    pub fn of(model: &Model) -> Option<Self> {
        let m = model.vessels();
        if !(6..=MOST_VESSELS).contains(&m) {
            return None;
        }
        let blocks: Vec<Vec<f64>> = (0..1_u64 << (m - 6))
            .into_par_iter()
            .map_init(Work::default, |work, block| {
                let outcome = |vessel: usize, sample: u64| (block << 6 | sample) >> vessel & 1;
                work.masks.clear();
                work.masks.extend((0..m).map(|e| (0..64).fold(0, |mask, i| mask | outcome(e, i) << i)));
                let mut contributions = vec![0.0; 64 * m];
                model.solve(work, |sample, vessel, y| contributions[vessel * 64 + sample] = y);
                contributions
            })
            .collect();
        let spectra = (0..m).into_par_iter().map(|e| {
            let values = blocks.iter().flat_map(|block| &block[e * 64..(e + 1) * 64]).copied().collect();
            spectrum(values, &model.keep)
        });
        let spectra: Vec<(f64, Vec<f64>)> = spectra.collect();
        let variance: Vec<f64> = spectra.iter().map(|(_, by_order)| by_order.iter().sum()).collect();
        Some(Self {
            mean: spectra.iter().map(|(mean, _)| *mean).collect(),
            orders: spectra.iter().zip(&variance).map(|((_, by), v)| by.iter().map(|x| x / v).collect()).collect(),
            variance,
        })
    }
}

/// The mean of a function of independent bits, and its variance by order: the expansion in the products of
/// (x - p) / sqrt(p (1 - p)).
fn spectrum(mut values: Vec<f64>, keep: &[f64]) -> (f64, Vec<f64>) {
    for (bit, p) in keep.iter().enumerate() {
        for pair in values.chunks_mut(2 << bit) {
            let (closed, open) = pair.split_at_mut(1 << bit);
            for (f0, f1) in closed.iter_mut().zip(open) {
                (*f0, *f1) = ((1.0 - p) * *f0 + p * *f1, (p * (1.0 - p)).sqrt() * (*f1 - *f0));
            }
        }
    }
    let mut by_order = vec![0.0; keep.len()];
    for (subset, coefficient) in values.iter().enumerate().skip(1) {
        by_order[subset.count_ones() as usize - 1] += coefficient * coefficient;
    }
    (values[0], by_order)
}
