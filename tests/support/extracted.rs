//! Extractions of networks as they are drawn, without points at one step.

use willis::error::Result;
use willis::internals::candidates::features::Extraction;
use willis::internals::network::{Network, Origin};
use willis::internals::support::geometry::distance;
use willis::internals::support::statistics::median;

/// The points of a network's observed vessels with their median distance as spacing.
pub fn extracted(network: &Network, inlets: &[usize]) -> Result<Extraction> {
    let mut steps = Vec::new();
    for (ends, vessel) in network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Observed) {
        let [first, last] = ends.map(|node| network.node(node).position.unwrap_or_default());
        let inner = vessel.path.iter().take(vessel.path.len().saturating_sub(1)).skip(1).map(|point| point.position);
        let line: Vec<_> = std::iter::once(first).chain(inner).chain([last]).collect();
        steps.extend(line.windows(2).map(|w| distance(w[0], w[1])));
    }
    Extraction::new(network, inlets, median(&steps).filter(|h| *h > 0.0).unwrap_or(1.0))
}
