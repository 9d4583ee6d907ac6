//! How wide a segment is along most of it: the 25th percentile of the radii of its points.

use crate::network::Network;
use crate::stats::quantile;

/// PComm is the wider one of the two above this ratio to P1 (Musio et al. 2026).
const FETAL_RATIO: f64 = 1.05;

/// Whether the first vessels are wider than the second ones by more than the ratio; false where either is nothing.
pub(super) fn is_wider(network: &Network, pcomm: &[usize], p1: &[usize]) -> bool {
    match (lower_quartile(network, pcomm), lower_quartile(network, p1)) {
        (Some(pcomm), Some(p1)) => pcomm > FETAL_RATIO * p1,
        _ => false,
    }
}

/// The 25th percentile (m), linear between the two radii around it; a vessel without points has its own radius.
fn lower_quartile(network: &Network, vessels: &[usize]) -> Option<f64> {
    let mut radii = Vec::new();
    for vessel in vessels.iter().map(|row| network.vessel(*row)) {
        radii.extend(vessel.path.iter().map(|point| point.radius));
        if vessel.path.is_empty() {
            radii.push(vessel.radius);
        }
    }
    quantile(&radii, 0.25)
}
