//! Statistics of plain samples: order statistics, Otsu's threshold, distributions; and the logistic function.

/// The q-quantile by linear interpolation between order statistics, as `numpy.quantile`; `None` without values.
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    quantile_of_sorted(&sorted, q)
}

/// [`quantile`] of values in rising order.
pub fn quantile_of_sorted(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let at = q.clamp(0.0, 1.0) * last as f64;
    let (low, share) = (at.floor() as usize, at.fract());
    let high = (low + 1).min(last);
    Some(sorted[low] + share * (sorted[high] - sorted[low]))
}

/// For each share the least of some values, each with a weight, that values of so great a share of the weight do not exceed; `None` without
/// values.
pub fn weighted_quantiles<const N: usize>(values: impl Iterator<Item = (f64, f64)>, shares: [f64; N]) -> [Option<f64>; N] {
    let mut sorted: Vec<(f64, f64)> = values.collect();
    let total: f64 = sorted.iter().map(|(_, weight)| weight).sum();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    shares.map(|share| {
        let mut sum = 0.0;
        let found = sorted.iter().find(|(_, weight)| {
            sum += weight;
            sum >= share * total
        });
        found.map(|(value, _)| *value)
    })
}

/// σ(x) = 1/(1 + e^-x), the logistic function: the probability of log-odds x.
pub fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// The median: the mean of the two middle values of an even number.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// Otsu's threshold: the cut between two groups that makes the variance between them largest, midway between the
/// groups' nearest values (Otsu 1979, doi:10.1109/TSMC.1979.4310076). Values no further apart than `equal` are in one group. `None` for fewer
/// than two different values.
pub fn otsu(values: &[f64], equal: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (n, total) = (sorted.len() as f64, sorted.iter().sum::<f64>());
    let (mut below, mut best) = (0.0, None);
    for cut in 1..sorted.len() {
        below += sorted[cut - 1];
        if sorted[cut] - sorted[cut - 1] > equal {
            let share = cut as f64 / n;
            let gap = below / cut as f64 - (total - below) / (n - cut as f64);
            let between = share * (1.0 - share) * gap * gap;
            if best.is_none_or(|(most, _)| between > most) {
                best = Some((between, 0.5 * (sorted[cut - 1] + sorted[cut])));
            }
        }
    }
    best.map(|(_, cut)| cut)
}

/// A summary of a sample, all in its unit; NaN for a sample without values or with NaN.
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
