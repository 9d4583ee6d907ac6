//! Runs of vessels that follow each other at nodes where nothing else begins.

use super::Network;

/// The vessels at every node that `counts` admits, a vessel from a node to itself twice.
pub fn vessels_at(network: &Network, counts: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let mut at = vec![Vec::new(); network.node_count()];
    for (row, (ends, _)) in network.vessels().enumerate().filter(|(row, _)| counts(*row)) {
        for node in ends {
            at[node].push(row);
        }
    }
    at
}

/// Every vessel in one run, each with the node where it begins in the direction of the run. A run goes on at the nodes that `passes` admits, where
/// just two vessels of `at` have to be; it has the direction of the first of its vessels. A ring of such nodes begins where its first vessel ends.
pub fn runs(network: &Network, at: &[Vec<usize>], passes: impl Fn(usize) -> bool) -> Vec<Vec<(usize, usize)>> {
    let mut is_used = vec![false; network.vessel_count()];
    // The vessels from a node on, the first one given.
    let along = |from: usize, first: usize| {
        let (mut node, mut steps) = (other_end(network, first, from), vec![(first, from)]);
        while passes(node) {
            let [a, b] = at[node][..] else { break };
            let row = if a == steps[steps.len() - 1].0 { b } else { a };
            if row == first {
                break;
            }
            steps.push((row, node));
            node = other_end(network, row, node);
        }
        (steps, node)
    };
    let mut found = Vec::new();
    for row in 0..network.vessel_count() {
        if is_used[row] {
            continue;
        }
        let [_, b] = network.ends(row);
        let (back, start) = along(b, row);
        let (run, _) = along(start, back[back.len() - 1].0);
        for (row, _) in &run {
            is_used[*row] = true;
        }
        found.push(run);
    }
    found
}

/// The node at the other end of a vessel.
pub fn other_end(network: &Network, row: usize, node: usize) -> usize {
    let [a, b] = network.ends(row);
    if a == node { b } else { a }
}
