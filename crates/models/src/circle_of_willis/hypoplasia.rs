//! Hypoplasia: segments of a circle that are there, but thin.

use super::arteries::{Artery, RING};
use super::circle::Circle;
use willis_core::network::Network;

/// The least diameter of a segment that is not hypoplastic, m, unless another is stated (Hindenes et al., PLoS ONE 15:e0241373, 2020).
pub const LEAST_DIAMETER: f64 = 1e-3;
/// Its least share of the diameter of its opposite.
const LEAST_SHARE: f64 = 0.5;

/// Which segments of [`RING`] are thin: below a diameter of `least`, m, or below half the diameter of their opposite. `diameters` in m; a segment
/// without one is not.
pub fn hypoplastic(diameters: &[Option<f64>; 7], least: f64) -> [bool; 7] {
    let of = |artery: Artery| RING.iter().position(|other| *other == artery).and_then(|row| diameters[row]);
    RING.map(|artery| {
        let is_thin = |own: f64| own < least || of(artery.opposite()).is_some_and(|other| own < LEAST_SHARE * other);
        of(artery).is_some_and(is_thin)
    })
}

/// The mean diameter along the vessels of each segment of [`RING`] in the topology of the vessels `kept`, m; `None` where it has none of its
/// own, as P1 under the label of the whole posterior cerebral artery.
pub fn segment_diameters(circle: &Circle, network: &Network, kept: impl Fn(usize) -> bool) -> [Option<f64>; 7] {
    let (network, rows) = &network.subgraph(kept);
    circle.restricted_to(rows).artery_vessels(network).segments.map(|rows| {
        let vessels = || rows.iter().map(|row| network.vessel(*row));
        let length: f64 = vessels().map(|vessel| vessel.length).sum();
        (length > 0.0).then(|| 2.0 * vessels().map(|vessel| vessel.radius * vessel.length).sum::<f64>() / length)
    })
}
