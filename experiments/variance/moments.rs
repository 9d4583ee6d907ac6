//! Moments of a long plain run, the limits that follow from them, and control variates with their coefficients.
//!
//! Y is a vessel's contribution in one sample, X the bits of its mask. X are independent, so the first-order index of
//! vessel e and bit i is their squared correlation, and a regression on many bits is as many regressions on one.

use rayon::prelude::*;
use willis::internals::perturbation::Occlusion;

use crate::masks::{Masks, Scheme};
use crate::model::{Model, Work};

/// Sums over the samples of a run.
#[derive(Clone)]
pub struct Moments {
    pub samples: f64,
    /// Σ Y, Σ Y² and the samples with Y > 0.
    pub sum: Vec<f64>,
    pub square: Vec<f64>,
    pub count: Vec<f64>,
    /// Σ X.
    open: Vec<f64>,
    /// Σ Y_e X_i, a row for each e.
    cross: Vec<f64>,
    /// Σ X_e X_i, a row for each e.
    pairs: Vec<f64>,
}

/// Parts of a run that are summed side by side and added in order.
const PARTS: u64 = 16;

impl Moments {
    fn zero(m: usize) -> Self {
        let row = vec![0.0; m];
        let square = vec![0.0; m * m];
        Self {
            samples: 0.0,
            sum: row.clone(),
            square: row.clone(),
            count: row.clone(),
            open: row,
            cross: square.clone(),
            pairs: square,
        }
    }

    /// Of `blocks` plain blocks.
    pub fn of(model: &Model, seed: u64, blocks: u64) -> Self {
        let part = |part: u64| {
            let (mut moments, mut work) = (Self::zero(model.vessels()), Work::default());
            let mut masks = Masks::new(Scheme::Plain, &model.keep, seed);
            for block in blocks * part / PARTS..blocks * (part + 1) / PARTS {
                masks.draw(block, &mut work.masks);
                moments.add_block(model, &mut work);
            }
            moments
        };
        let parts: Vec<Self> = (0..PARTS).into_par_iter().map(part).collect();
        parts.iter().fold(Self::zero(model.vessels()), Self::plus)
    }

    /// Adds the block in `work.masks`.
    pub fn add_block(&mut self, model: &Model, work: &mut Work) {
        let m = model.vessels();
        let masks = work.masks.clone();
        let open: Vec<f64> = (0..64).flat_map(|sample| masks.iter().map(move |mask| (mask >> sample & 1) as f64)).collect();
        model.solve(work, |sample, vessel, y| {
            self.sum[vessel] += y;
            self.square[vessel] += y * y;
            self.count[vessel] += 1.0;
            let row = &mut self.cross[vessel * m..(vessel + 1) * m];
            row.iter_mut().zip(&open[sample * m..]).for_each(|(sum, x)| *sum += y * x);
        });
        for (e, mask) in masks.iter().enumerate() {
            self.open[e] += f64::from(mask.count_ones());
            let row = &mut self.pairs[e * m..(e + 1) * m];
            row.iter_mut().zip(&masks).for_each(|(sum, other)| *sum += f64::from((mask & other).count_ones()));
        }
        self.samples += 64.0;
    }

    fn plus(mut self, other: &Self) -> Self {
        let add = |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        self.samples += other.samples;
        add(&mut self.sum, &other.sum);
        add(&mut self.square, &other.square);
        add(&mut self.count, &other.count);
        add(&mut self.open, &other.open);
        add(&mut self.cross, &other.cross);
        add(&mut self.pairs, &other.pairs);
        self
    }

    /// The variance of one contribution.
    pub fn variance(&self, e: usize) -> f64 {
        let mean = self.sum[e] / self.samples;
        self.square[e] / self.samples - mean * mean
    }

    /// Coefficient of bit i for vessel e, and the share of the variance that it explains.
    fn linear(&self, model: &Model, e: usize, i: usize) -> (f64, f64) {
        let spread = model.keep[i] * (1.0 - model.keep[i]);
        let covariance =
            self.cross[e * self.sum.len() + i] / self.samples - self.sum[e] / self.samples * self.open[i] / self.samples;
        if spread > 0.0 { (covariance / spread, covariance * covariance / (spread * self.variance(e))) } else { (0.0, 0.0) }
    }

    /// The same among the samples with e open, i ≠ e.
    fn linear_if_open(&self, model: &Model, e: usize, i: usize) -> (f64, f64) {
        let (at, n) = (e * self.sum.len() + i, self.open[e]);
        let spread = model.keep[i] * (1.0 - model.keep[i]);
        let mean = self.sum[e] / n;
        let covariance = self.cross[at] / n - mean * self.pairs[at] / n;
        let variance = self.square[e] / n - mean * mean;
        if spread > 0.0 && i != e { (covariance / spread, covariance * covariance / (spread * variance)) } else { (0.0, 0.0) }
    }

    /// The shares of a vessel's variance that functions of its mask explain.
    pub fn shares(&self, model: &Model, e: usize) -> Shares {
        let p = model.keep[e];
        let all = || (0..model.vessels()).filter(|i| *i != e);
        let own = self.linear(model, e, e).1;
        let mean = self.sum[e] / self.open[e];
        let if_open = self.square[e] / self.open[e] - mean * mean;
        // Each estimated index is too large by one over the samples that it comes from.
        let (noise, noise_if_open) = (1.0 / self.samples, 1.0 / self.open[e]);
        Shares {
            own,
            neighbours: own + model.neighbours[e].iter().map(|i| self.linear(model, e, *i).1 - noise).sum::<f64>(),
            all: own + all().map(|i| self.linear(model, e, i).1 - noise).sum::<f64>(),
            open_neighbours: own
                + (1.0 - own)
                    * model.neighbours[e].iter().map(|i| self.linear_if_open(model, e, *i).1 - noise_if_open).sum::<f64>(),
            open_all: own + (1.0 - own) * all().map(|i| self.linear_if_open(model, e, i).1 - noise_if_open).sum::<f64>(),
            forced: 1.0 - p * p * if_open / self.variance(e),
        }
    }
}

/// Shares of a vessel's variance that a scheme can remove at the best, at equal numbers of samples.
pub struct Shares {
    /// A function of the vessel's own bit.
    pub own: f64,
    /// A linear function of its bit and its neighbours'.
    pub neighbours: f64,
    /// A linear function of all bits: the sum of the first-order indices.
    pub all: f64,
    /// A function of its own bit, and where it is open a linear one of its neighbours' bits.
    pub open_neighbours: f64,
    /// A function of its own bit, and where it is open a linear one of all other bits.
    pub open_all: f64,
    /// The vessel forced open in every sample: what is left is p² times the variance of the contribution if open.
    pub forced: f64,
}

/// An upper bound of the share of second-order interactions, from Cov(Y(X), Y(X′)) = Σ_k r^k V_k, where X′ keeps each
/// bit of X with probability r and draws it anew otherwise: (Cov - r V_1) / r² = V_2 + r V_3 + ...
pub fn second_order(model: &Model, seed: u64, blocks: u64, r: f64, moments: &Moments) -> Vec<f64> {
    let m = model.vessels();
    let (mask, kept) = (Occlusion::new(model.keep.iter().copied()), Occlusion::new(vec![r; m]));
    let part = |part: u64| {
        let (mut work, mut fresh, mut keep) = (Work::default(), Vec::new(), Vec::new());
        let (mut first, mut second) = (vec![0.0; 64 * m], vec![0.0; 64 * m]);
        let mut products = vec![0.0; m];
        for block in blocks * part / PARTS..blocks * (part + 1) / PARTS {
            mask.draw(seed, block, &mut work.masks);
            mask.draw(seed + 1, block, &mut fresh);
            kept.draw(seed + 2, block, &mut keep);
            first.fill(0.0);
            second.fill(0.0);
            model.solve(&mut work, |sample, vessel, y| first[sample * m + vessel] = y);
            for ((x, fresh), keep) in work.masks.iter_mut().zip(&fresh).zip(&keep) {
                *x = *x & keep | fresh & !keep;
            }
            model.solve(&mut work, |sample, vessel, y| second[sample * m + vessel] = y);
            for (a, b) in first.chunks(m).zip(second.chunks(m)) {
                products.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
            }
        }
        products
    };
    let parts: Vec<Vec<f64>> = (0..PARTS).into_par_iter().map(part).collect();
    (0..m)
        .map(|e| {
            let product: f64 = parts.iter().map(|p| p[e]).sum::<f64>() / (64 * blocks) as f64;
            let mean = moments.sum[e] / moments.samples;
            let share = (product - mean * mean) / moments.variance(e);
            (share - r * moments.shares(model, e).all) / (r * r)
        })
        .collect()
}

/// Sums over the samples of one replicate.
pub struct Totals {
    pub samples: f64,
    pub sum: Vec<f64>,
    /// Σ over blocks of the square of the block's sum.
    pub block_square: Vec<f64>,
    open: Vec<f64>,
    pairs: Vec<f64>,
}

impl Totals {
    /// Of the first `samples` samples; with the pairs of bits only where they are asked for.
    pub fn of(model: &Model, masks: &mut Masks, samples: u64, with_pairs: bool, work: &mut Work) -> Self {
        let m = model.vessels();
        let pairs = if with_pairs { vec![0.0; m * m] } else { Vec::new() };
        let mut totals = Self { samples: 0.0, sum: vec![0.0; m], block_square: vec![0.0; m], open: vec![0.0; m], pairs };
        let mut block_sum = vec![0.0; m];
        for block in 0..samples.div_ceil(64) {
            masks.draw(block, &mut work.masks);
            let used = (samples - block * 64).min(64);
            work.masks.iter_mut().for_each(|mask| *mask &= u64::MAX >> (64 - used));
            block_sum.fill(0.0);
            model.solve(work, |_, vessel, y| block_sum[vessel] += y);
            for (e, sum) in block_sum.iter().enumerate() {
                totals.sum[e] += sum;
                totals.block_square[e] += sum * sum;
            }
            totals.count_bits(&work.masks);
            totals.samples += used as f64;
        }
        totals
    }

    fn count_bits(&mut self, masks: &[u64]) {
        let rows = self.pairs.chunks_mut(masks.len());
        for (row, mask) in rows.zip(masks) {
            row.iter_mut().zip(masks).for_each(|(sum, other)| *sum += f64::from((mask & other).count_ones()));
        }
        self.open.iter_mut().zip(masks).for_each(|(sum, mask)| *sum += f64::from(mask.count_ones()));
    }

    /// L of vessel e with a control variate; the coefficients are those of the long run.
    pub fn estimate(&self, control: Control, model: &Model, long: &Moments, e: usize) -> f64 {
        let (n, p, m) = (self.samples, model.keep[e], model.vessels());
        let excess = |i: usize| long.linear(model, e, i).0 * (self.open[i] - n * model.keep[i]);
        let excess_if_open =
            |i: usize| long.linear_if_open(model, e, i).0 * (self.pairs[e * m + i] / self.open[e] - model.keep[i]);
        let sum = self.sum[e];
        if sum == 0.0 {
            return 0.0;
        }
        match control {
            Control::None => sum,
            Control::Own => n * p * sum / self.open[e],
            Control::Neighbours => sum - excess(e) - model.neighbours[e].iter().map(|i| excess(*i)).sum::<f64>(),
            Control::All => sum - (0..m).map(excess).sum::<f64>(),
            Control::OpenNeighbours => {
                n * p * (sum / self.open[e] - model.neighbours[e].iter().map(|i| excess_if_open(*i)).sum::<f64>())
            }
            Control::OpenAll => n * p * (sum / self.open[e] - (0..m).map(excess_if_open).sum::<f64>()),
        }
    }
}

/// What is held against its known mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    None,
    /// The samples with the vessel open: a ratio.
    Own,
    /// Its own bit and its neighbours', by regression.
    Neighbours,
    /// All bits, by regression.
    All,
    /// The ratio, and its neighbours' bits by regression among the samples with the vessel open.
    OpenNeighbours,
    /// The ratio, and all other bits by regression among the samples with the vessel open.
    OpenAll,
}

impl Control {
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Own => "own bit (ratio)",
            Self::Neighbours => "own and neighbours' bits",
            Self::All => "all bits",
            Self::OpenNeighbours => "ratio + neighbours' bits if open",
            Self::OpenAll => "ratio + all bits if open",
        }
    }
}
