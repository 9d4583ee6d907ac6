//! The gamma distribution: fit by maximum likelihood, density, survival function, Kolmogorov-Smirnov distance.

use statrs::function::gamma::{digamma, gamma_lr, gamma_ur, ln_gamma};

/// Newton steps at the most; five suffice from Minka's start.
const STEPS: usize = 100;

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
    /// The distribution of highest likelihood for positive values; `None` when there are no two different ones.
    ///
    /// The shape solves ln k - ψ(k) = ln(mean x) - mean(ln x) by Newton's method on 1/k (Minka 2002, *Estimating a Gamma
    /// distribution*); then θ = mean/k. The standard errors are those of the inverse Fisher information of n draws:
    /// var k = k/(n D), var θ = θ² ψ'(k)/(n D), D = k ψ'(k) - 1.
    pub fn fit(values: &[f64]) -> Option<GammaFit> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let spread = -values.iter().map(|x| (x / mean).ln()).sum::<f64>() / n;
        if !(spread.is_normal() && spread > f64::EPSILON) {
            return None;
        }
        let mut shape = (3.0 - spread + ((spread - 3.0).powi(2) + 24.0 * spread).sqrt()) / (12.0 * spread);
        for _ in 0..STEPS {
            let gap = shape.ln() - digamma(shape) - spread;
            let next = 1.0 / (1.0 / shape + gap / (shape * (1.0 - shape * trigamma(shape))));
            let settled = (next - shape).abs() <= 4.0 * f64::EPSILON * shape;
            shape = next;
            if settled {
                break;
            }
        }
        let gamma = Self { shape, scale: mean / shape };
        let information = n * (shape * trigamma(shape) - 1.0);
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
        if x > 0.0 { gamma_ur(self.shape, x / self.scale) } else { 1.0 }
    }

    /// The probability of x or less.
    pub fn cumulative(&self, x: f64) -> f64 {
        if x > 0.0 { gamma_lr(self.shape, x / self.scale) } else { 0.0 }
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

/// ψ'(x) for x > 0: by ψ'(x) = ψ'(x + 1) + 1/x² up to 10, from there by its asymptotic series (Abramowitz & Stegun 6.4.12).
fn trigamma(mut x: f64) -> f64 {
    /// The Bernoulli numbers B_2, B_4, ..
    const BERNOULLI: [f64; 7] = [1.0 / 6.0, -1.0 / 30.0, 1.0 / 42.0, -1.0 / 30.0, 5.0 / 66.0, -691.0 / 2730.0, 7.0 / 6.0];
    let mut below = 0.0;
    while x < 10.0 {
        below += 1.0 / (x * x);
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series = BERNOULLI.iter().rev().fold(0.0, |sum, b| (sum + b) * inverse);
    below + (1.0 + series + 0.5 / x) / x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trigamma_function_has_its_known_values() {
        let pi_squared = std::f64::consts::PI.powi(2);
        // Abramowitz & Stegun 6.4.2 - 6.4.5; the last is scipy.special.polygamma(1, 1000).
        for (x, known) in
            [(1.0, pi_squared / 6.0), (0.5, pi_squared / 2.0), (2.0, pi_squared / 6.0 - 1.0), (1e3, 0.001_000_500_166_666_633_4)]
        {
            assert!((trigamma(x) / known - 1.0).abs() < 1e-14, "{x}: {}", trigamma(x));
        }
    }

    #[test]
    fn an_exponential_distribution_is_the_gamma_of_shape_one() {
        let gamma = Gamma { shape: 1.0, scale: 2.0 };
        for x in [0.1, 1.0, 7.0] {
            assert!((gamma.density(x) - (-x / 2.0).exp() / 2.0).abs() < 1e-15);
            assert!((gamma.survival(x) - (-x / 2.0).exp()).abs() < 1e-15);
        }
        assert_eq!(gamma.survival(-1.0), 1.0);
    }

    #[test]
    fn values_without_spread_have_no_fit() {
        assert_eq!(Gamma::fit(&[]), None);
        assert_eq!(Gamma::fit(&[3.0]), None);
        assert_eq!(Gamma::fit(&[3.0, 3.0, 3.0]), None);
    }
}
