//! How a sample is distributed: mean, standard deviation, quantiles.

use super::quantile_of_sorted;

/// A sample in a few figures, all in its unit; NaN of a sample without values or with values that are no number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution {
    /// The mean.
    pub mean: f64,
    /// The standard deviation √(Σ (x - mean)²/(n - 1)); NaN of a single value.
    pub std: f64,
    /// The quantiles of [`Distribution::LEVELS`], by linear interpolation between order statistics.
    pub quantiles: [f64; 5],
}

impl Distribution {
    /// Which quantiles are kept.
    pub const LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

    /// The distribution of a sample, in the order in which its values are summed.
    pub fn of(mut values: Vec<f64>) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        let std = if values.len() > 1 { (squares / (n - 1.0)).sqrt() } else { f64::NAN };
        values.sort_unstable_by(f64::total_cmp);
        let quantile = |q| if mean.is_nan() { f64::NAN } else { quantile_of_sorted(&values, q).unwrap_or(f64::NAN) };
        Self { mean, std, quantiles: Self::LEVELS.map(quantile) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figures_are_those_of_numpy() {
        // numpy: mean, std(ddof=1), quantile of [3, 1, 4, 1, 5]
        let d = Distribution::of(vec![3.0, 1.0, 4.0, 1.0, 5.0]);
        assert!((d.mean - 2.8).abs() < 1e-15 && (d.std - 1.788_854_381_999_831_6).abs() < 1e-15);
        assert_eq!(d.quantiles, [1.0, 1.0, 3.0, 4.0, 4.8]);
        assert!(Distribution::of(vec![1.0, f64::NAN]).quantiles[0].is_nan());
        assert!(Distribution::of(Vec::new()).mean.is_nan());
    }
}
