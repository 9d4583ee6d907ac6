//! Statistics of plain samples: order statistics, distributions, the gamma distribution.

mod distribution;
pub mod gamma;

pub use distribution::Distribution;

/// The q-quantile by linear interpolation between order statistics, as `numpy.quantile`; `None` of nothing.
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

/// σ(x) = 1/(1 + e^-x), the logistic function: the probability of log-odds x.
pub fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// The median: the mean of the two middle values of an even number.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// Otsu's threshold: the cut between two groups that makes the variance between them largest, midway between the
/// groups' nearest values (Otsu 1979, doi:10.1109/TSMC.1979.4310076). `None` of fewer than two different values.
pub fn otsu(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (n, total) = (sorted.len() as f64, sorted.iter().sum::<f64>());
    let (mut below, mut best) = (0.0, None);
    for cut in 1..sorted.len() {
        below += sorted[cut - 1];
        if sorted[cut] > sorted[cut - 1] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_numpy() {
        // numpy.quantile([3, 1, 4, 1, 5, 9, 2, 6], [0.5, 0.1, 0.9])
        let v = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0];
        assert_eq!(median(&v), Some(3.5));
        assert_eq!(quantile(&v, 0.1), Some(1.0));
        assert!((quantile(&v, 0.9).unwrap_or(0.0) - 6.9).abs() < 1e-12);
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn otsu_cuts_between_two_clusters() {
        assert_eq!(otsu(&[1.0, 2.0, 10.0, 11.0]), Some(6.0));
        assert_eq!(otsu(&[2.0, 2.0]), None);
    }
}
