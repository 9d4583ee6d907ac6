//! How vessels that break off continue: each by its own odds, the whole by what it feeds.

use std::collections::BTreeMap;

use rand::RngExt;

use super::params::Params;
use crate::network::{END_ODDS, Network, Origin, fragments};
use crate::rng::{BLOCK, stream, streams};

/// What a topology weighs for each known outlet that nothing feeds: as an end that ends where it is. Not nothing, because what feeds it
/// may lie beyond the field of view.
const UNFED: f64 = END_ODDS;

/// What is known of the nodes of a network.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// Per node whether it is known for an inlet or outlet, so that no vessel continues from there.
    pub ends: &'a [bool],
    /// The nodes where blood is known to come in; none when that is not known, and then nothing is asked of the outlets.
    pub inlets: &'a [usize],
}

impl Known<'_> {
    /// The factor of a topology that holds the vessels `kept`: e⁻² for each known outlet that is connected with no known inlet.
    pub(super) fn supply(&self, network: &Network, kept: &[bool]) -> f64 {
        if self.inlets.is_empty() {
            return 1.0;
        }
        let parts = fragments(network, |row, _| kept[row]);
        let mut fed = vec![false; parts.count];
        for inlet in self.inlets {
            fed[parts.of_node[*inlet]] = true;
        }
        let unfed = (0..self.ends.len()).filter(|node| self.ends[*node] && !fed[parts.of_node[*node]]);
        unfed.fold(1.0, |weight, _| weight * UNFED)
    }

    /// Per free end that may continue, its candidates with their odds.
    fn choices(&self, network: &Network) -> Vec<Vec<(usize, f64)>> {
        let degree = network.degrees(|v| v.origin == Origin::Observed || v.certain);
        let mut at: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
        for (row, (ends, vessel)) in network.vessels().enumerate() {
            let Some(evidence) = vessel.evidence.filter(|_| vessel.origin == Origin::Candidate && !vessel.certain) else {
                continue;
            };
            for (node, odds) in ends.into_iter().zip(evidence.continues) {
                if odds > 0.0 && degree[node] <= 1 && !self.ends[node] {
                    at.entry(node).or_default().push((row, odds));
                }
            }
        }
        at.into_values().collect()
    }
}

/// Draws as many topologies as there are samples, each as whether it holds each vessel.
pub(super) fn draw_ends(network: &Network, known: Known<'_>, params: &Params, mut each: impl FnMut(&[bool])) {
    let ends = known.choices(network);
    let given: Vec<bool> = network.vessels().map(|(_, v)| v.origin == Origin::Observed || v.certain).collect();
    for first in (0..params.samples).step_by(BLOCK as usize) {
        let mut rng = stream(params.seed, streams::ends(first / BLOCK));
        for _ in first..params.samples.min(first + BLOCK) {
            let mut kept = given.clone();
            for choices in &ends {
                let total: f64 = 1.0 + choices.iter().map(|(_, odds)| odds).sum::<f64>();
                let mut left = total * rng.random::<f64>() - 1.0;
                for (row, odds) in choices {
                    if left < 0.0 {
                        break;
                    }
                    left -= odds;
                    if left < 0.0 {
                        kept[*row] = true;
                    }
                }
            }
            each(&kept);
        }
    }
}
