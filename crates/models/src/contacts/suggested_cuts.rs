//! Cuts that are suggested and not made.

use serde::{Deserialize, Serialize};

use super::split::Opened;
use willis_core::decision::{RECONNECT, reconnected};
use willis_core::network::{Network, Origin};
use willis_core::support::geometry::Point;

/// A place where two vessels may only touch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SuggestedCut {
    /// The id of a junction there.
    pub node: String,
    /// The middle of the contact, m.
    pub position: Point,
    /// The radius there, m.
    pub radius: f64,
    /// How probably the two are one vessel all the same.
    pub probability: f64,
}

/// The contacts of a network that stay cut when they are opened ([`reconnected()`]), the least probable to be one vessel first.
pub fn suggested_cuts(network: &Network, opened: &Opened) -> Vec<SuggestedCut> {
    let Opened { graph, junctions, .. } = opened;
    let kept = reconnected(graph, RECONNECT);
    let contacts = graph.vessels().zip(kept).filter(|((_, vessel), _)| vessel.origin == Origin::Contact);
    let cut = contacts.zip(junctions).filter(|((_, kept), _)| !kept);
    let suggested = cut.map(|(((ends, vessel), _), junction)| SuggestedCut {
        node: network.node(*junction).id.clone(),
        position: graph.middle_of(ends, vessel),
        radius: vessel.radius,
        probability: vessel.prior,
    });
    let mut suggested: Vec<SuggestedCut> = suggested.collect();
    suggested.sort_by(|a, b| a.probability.total_cmp(&b.probability));
    suggested
}
