//! Tells whether the root of a tracing is where its blood comes from: the widest end of one tree that gets narrower from there.

use super::Network;
use super::walks::{other_end, vessels_at};

/// The other free ends have at most this share of the radius of the root.
const MOST_WIDTH: f64 = 0.95;
/// No vessel is wider than this many times the narrowest one between it and the root. In a circle of arteries one comes from a carotid by
/// narrow vessels to the next carotid.
const MOST_RISE: f64 = 1.2;

/// Whether the network is one tree, `root` a free end of it and the widest of all, and vessels get narrower from there.
pub(crate) fn falls_from(network: &Network, root: usize) -> bool {
    if network.vessel_count() + 1 != network.node_count() {
        return false;
    }
    let vessels_at = vessels_at(network, |_| true);
    let [first] = vessels_at[root][..] else { return false };
    let end_radius = |row: usize, node: usize| network.vessel(row).end_radius(network.ends(row)[1] == node);
    let most = MOST_WIDTH * end_radius(first, root);
    // The nodes reached, each with the vessel that leads to it and the narrowest radius up to there.
    let (mut open, mut reached) = (vec![(root, first, f64::INFINITY)], 1);
    while let Some((node, from, narrowest)) = open.pop() {
        for row in vessels_at[node].iter().copied().filter(|row| node == root || *row != from) {
            let (next, vessel) = (other_end(network, row, node), network.vessel(row));
            let is_end = vessels_at[next].len() == 1;
            // A ring leads back; it leaves other nodes unreached.
            if next == node || vessel.radius > MOST_RISE * narrowest || (is_end && end_radius(row, next) > most) {
                return false;
            }
            reached += 1;
            if reached > network.node_count() {
                return false;
            }
            open.push((next, row, narrowest.min(vessel.radius)));
        }
    }
    reached == network.node_count()
}
