//! Hypertension: the distribution of the hypertension force over vessels and instances, and the share above a threshold of risk (Moriconi et
//! al. 2019).

use super::Modulation;
use crate::support::gamma::{Gamma, GammaFit};
use crate::support::{quantile, ties::exceeds};

/// The bins of equal width in a histogram.
pub const BINS: usize = 50;
/// The bins end at this quantile; one more bin holds the rest.
const COVERED: f64 = 0.99;
/// The share of the unperturbed vessels that lie above the threshold of risk.
const AT_RISK: f64 = 0.05;

/// The default threshold of risk, Pa/m²: above it is a twentieth of the unperturbed vessels, or a little more, those of the largest forces. It lies
/// halfway from the least force above it to the next smaller one, so that it never is the force of a vessel, as the 95th percentile is where the
/// widest forces are those of mirror vessels. Without a smaller one it is the force itself; NaN without any.
pub fn risk_threshold(unperturbed: &[f64]) -> f64 {
    let mut falling: Vec<f64> = unperturbed.iter().copied().filter(|f| !f.is_nan()).collect();
    falling.sort_unstable_by(|a, b| b.total_cmp(a));
    let at_risk = (AT_RISK * falling.len() as f64).ceil() as usize;
    let Some(above) = at_risk.checked_sub(1).map(|last| falling[last]) else { return f64::NAN };
    falling.iter().find(|force| exceeds(above, **force)).map_or(above, |below| f64::midpoint(above, *below))
}

/// The edges of the bins that all `classes` of forces share, rising from 0: 50 bins of equal width end at the largest 99th
/// percentile of the classes, and one more ends at the largest force. Empty without a positive force.
pub fn histogram_edges<'a>(classes: impl IntoIterator<Item = &'a [f64]>) -> Vec<f64> {
    let (mut covered, mut most) = (0.0_f64, 0.0_f64);
    for forces in classes {
        let positive = positive(forces);
        covered = covered.max(quantile(&positive, COVERED).unwrap_or(0.0));
        most = positive.iter().copied().fold(most, f64::max);
    }
    if covered <= 0.0 {
        return Vec::new();
    }
    // The last one as it is, not rounded: it may be the largest force.
    let mut edges: Vec<f64> = (0..BINS).map(|i| covered * i as f64 / BINS as f64).chain([covered]).collect();
    if most > covered {
        edges.push(most);
    }
    edges
}

/// The forces to which a gamma distribution is fitted.
fn positive(forces: &[f64]) -> Vec<f64> {
    forces.iter().copied().filter(|f| *f > 0.0).collect()
}

/// How the forces of a class are distributed.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypertension {
    /// The number of positive forces in each bin; a bin includes its upper edge.
    pub counts: Vec<u64>,
    /// The gamma distribution fitted to the positive forces; `None` when these are all equal. Its standard errors assume independent
    /// draws, which the vessels of one network are not, so they are lower bounds.
    pub fit: Option<GammaFit>,
    /// The Kolmogorov-Smirnov distance between the positive forces and the fit; NaN without one.
    pub distance: f64,
    /// The share of forces that are zero, negative or undefined; the fit leaves them out.
    pub without_force: f64,
    /// The share of all forces above the threshold.
    pub above: f64,
    /// The same share according to the fit: its survival function times the share of positive forces; NaN without a fit.
    pub above_by_fit: f64,
}

impl Hypertension {
    /// The distribution of `forces` (Pa/m²) over the bins between `edges`, and the share above `threshold`.
    pub fn of(forces: &[f64], edges: &[f64], threshold: f64) -> Self {
        let positive = positive(forces);
        let mut counts = vec![0; edges.len().saturating_sub(1)];
        for force in &positive {
            let bin = edges.partition_point(|edge| edge < force);
            if let Some(count) = bin.checked_sub(1).and_then(|bin| counts.get_mut(bin)) {
                *count += 1;
            }
        }
        let n = forces.len() as f64;
        let with_force = positive.len() as f64 / n;
        let fit = Gamma::fit(&positive);
        let by_fit = |of: &dyn Fn(&Gamma) -> f64| fit.as_ref().map_or(f64::NAN, |fit| of(&fit.gamma));
        Self {
            counts,
            distance: by_fit(&|gamma| gamma.distance(&positive)),
            without_force: 1.0 - with_force,
            above: forces.iter().filter(|f| **f > threshold).count() as f64 / n,
            above_by_fit: by_fit(&|gamma| with_force * gamma.survival(threshold)),
            fit,
        }
    }
}

/// The hypertension of every class, with the same bins and the same threshold.
#[derive(Debug, Clone, PartialEq)]
pub struct HypertensionByClass {
    /// A vessel above this force is at risk, Pa/m²; NaN when no vessel has a pressure.
    pub threshold: f64,
    /// The edges of the bins, Pa/m².
    pub edges: Vec<f64>,
    /// Of the one instance without modulation.
    pub unperturbed: Hypertension,
    /// By class.
    pub classes: Vec<Hypertension>,
}

impl HypertensionByClass {
    /// The hypertension of all vessels and instances. The default `threshold` (Pa/m²) has a twentieth of the unperturbed
    /// vessels above it.
    pub fn of(modulation: &Modulation, threshold: Option<f64>) -> Self {
        let at_rest = &modulation.unperturbed.force;
        let forces = || modulation.classes.iter().map(|(_, instances)| &instances.force[..]);
        let threshold = threshold.unwrap_or_else(|| risk_threshold(at_rest));
        let edges = histogram_edges(forces().chain([&at_rest[..]]));
        Self {
            unperturbed: Hypertension::of(at_rest, &edges, threshold),
            classes: forces().map(|forces| Hypertension::of(forces, &edges, threshold)).collect(),
            threshold,
            edges,
        }
    }
}
