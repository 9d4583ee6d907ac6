//! The gamma distribution: fit by maximum likelihood, density, survival function, Kolmogorov-Smirnov distance.

use statrs::function::erf::erfc;
use statrs::function::gamma::{digamma, gamma_lr, gamma_ur, ln_gamma};

/// Newton steps at the most; five suffice from Minka's start.
const STEPS: usize = 100;
/// Values of a smaller spread, ln(mean x) - mean(ln x), do not differ but for rounding: their relative deviation is some 1e-6.
const LEAST_SPREAD: f64 = 1e-12;
/// From this shape on, differences that would cancel are taken from their series.
pub const LARGE: f64 = 1e3;
/// From this shape on, probabilities come from their uniform expansion: a continued fraction would take as many steps as the shape's root.
const NEAR_NORMAL: f64 = 1e6;

/// A gamma distribution: density x^(k-1) exp(-x/θ) / (Γ(k) θ^k) for x > 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gamma {
    /// Shape k, positive.
    pub shape: f64,
    /// Scale θ, positive, in the unit of x.
    pub scale: f64,
}

/// A fitted distribution with the standard errors of independent draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GammaFit {
    /// The distribution of highest likelihood.
    pub gamma: Gamma,
    /// Standard error of the shape.
    pub shape_error: f64,
    /// Standard error of the scale, in the unit of x.
    pub scale_error: f64,
}

impl Gamma {
    /// The distribution of highest likelihood for positive values; `None` when they do not differ.
    ///
    /// The shape solves ln k - ψ(k) = ln(mean x) - mean(ln x) by Newton's method on 1/k (Minka 2002, *Estimating a Gamma
    /// distribution*); then θ = mean/k. The standard errors are those of the inverse Fisher information of n draws:
    /// var k = k/(n D), var θ = θ² ψ'(k)/(n D), D = k ψ'(k) - 1.
    pub fn fit(values: &[f64]) -> Option<GammaFit> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let spread = -values.iter().map(|x| (x / mean).ln()).sum::<f64>() / n;
        if !(spread.is_normal() && spread > LEAST_SPREAD) {
            return None;
        }
        let mut shape = (3.0 - spread + ((spread - 3.0).powi(2) + 24.0 * spread).sqrt()) / (12.0 * spread);
        for _ in 0..STEPS {
            let gap = log_gap(shape) - spread;
            let next = 1.0 / (1.0 / shape - gap / (shape * information(shape)));
            // 1/(2k) < ln k - ψ(k) < 1/k: the shape lies between, and so does every step.
            let next = next.clamp(0.5 / spread, 1.0 / spread);
            let settled = (next - shape).abs() <= 4.0 * f64::EPSILON * shape;
            shape = next;
            if settled {
                break;
            }
        }
        let gamma = Self { shape, scale: mean / shape };
        let information = n * information(shape);
        let fit = GammaFit {
            gamma,
            shape_error: (shape / information).sqrt(),
            scale_error: gamma.scale * (trigamma(shape) / information).sqrt(),
        };
        (shape.is_normal() && shape > 0.0 && gamma.scale.is_normal()).then_some(fit)
    }

    /// The density at x, over the unit of x; zero for x <= 0.
    pub fn density(&self, x: f64) -> f64 {
        let t = x / self.scale;
        if t > 0.0 { ((self.shape - 1.0) * t.ln() - t - ln_gamma(self.shape)).exp() / self.scale } else { 0.0 }
    }

    /// The probability of more than x.
    pub fn survival(&self, x: f64) -> f64 {
        self.tail(x / self.scale, 1.0)
    }

    /// The probability of x or less.
    pub fn cumulative(&self, x: f64) -> f64 {
        self.tail(x / self.scale, -1.0)
    }

    /// The probability of more than t scales where `side` is 1, of t or less where it is -1.
    fn tail(&self, t: f64, side: f64) -> f64 {
        let is_above = side > 0.0;
        if t == f64::INFINITY {
            f64::from(!is_above)
        } else if t <= 0.0 || t.is_nan() {
            f64::from(is_above)
        } else if self.shape >= NEAR_NORMAL {
            near_normal(self.shape, t, side)
        } else if is_above {
            gamma_ur(self.shape, t)
        } else {
            gamma_lr(self.shape, t)
        }
    }

    /// The Kolmogorov-Smirnov distance: the largest gap between the values' empirical distribution and this one.
    pub fn distance(&self, values: &[f64]) -> f64 {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len() as f64;
        let gap = |(i, x): (usize, &f64)| {
            let p = self.cumulative(*x);
            ((i + 1) as f64 / n - p).max(p - i as f64 / n)
        };
        sorted.iter().enumerate().map(gap).fold(0.0, f64::max)
    }
}

/// Q(k, t), and P(k, t) where `side` is -1, for a large shape k: the first two terms of the uniform expansion (DLMF 8.12.3 and 8.12.4;
/// what is left out is below k^(-3/2)/500).
fn near_normal(shape: f64, t: f64, side: f64) -> f64 {
    let mu = t / shape - 1.0;
    let half_square = if mu.abs() < 1e-3 { mu * mu * (0.5 - mu * (1.0 / 3.0 - mu * (0.25 - mu * 0.2))) } else { mu - mu.ln_1p() };
    let eta = (2.0 * half_square).sqrt().copysign(mu);
    let first = if mu.abs() < 1e-3 { -1.0 / 3.0 + mu / 12.0 } else { 1.0 / mu - 1.0 / eta };
    let bell = (-shape * half_square).exp() / (2.0 * std::f64::consts::PI * shape).sqrt();
    (0.5 * erfc(side * eta * (shape / 2.0).sqrt()) + side * bell * first).clamp(0.0, 1.0)
}

/// ln k - ψ(k).
pub fn log_gap(shape: f64) -> f64 {
    if shape < LARGE { shape.ln() - digamma(shape) } else { (0.5 + (1.0 - 0.1 / (shape * shape)) / (12.0 * shape)) / shape }
}

/// k ψ'(k) - 1.
pub fn information(shape: f64) -> f64 {
    if shape < LARGE { shape * trigamma(shape) - 1.0 } else { (0.5 + (1.0 - 0.2 / (shape * shape)) / (6.0 * shape)) / shape }
}

/// The Bernoulli numbers B_2, B_4, ..
const BERNOULLI: [f64; 7] = [1.0 / 6.0, -1.0 / 30.0, 1.0 / 42.0, -1.0 / 30.0, 5.0 / 66.0, -691.0 / 2730.0, 7.0 / 6.0];

/// ψ'(x) for x > 0: by ψ'(x) = ψ'(x + 1) + 1/x² up to 10, from there by its asymptotic series (Abramowitz & Stegun 6.4.12).
pub fn trigamma(mut x: f64) -> f64 {
    debug_assert!(x > 0.0, "{x}");
    let mut below = 0.0;
    while x < 10.0 {
        below += 1.0 / (x * x);
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series = BERNOULLI.iter().rev().fold(0.0, |sum, b| (sum + b) * inverse);
    below + (1.0 + series + 0.5 / x) / x
}
