//! The weights of every fragment divided by its largest: no marginal changes by that, and nothing overflows.

use super::{Bridge, Forests};
use crate::elimination::{Star, least_degree};

/// Weights relative to the largest of the same fragment.
#[derive(Debug, Clone)]
pub struct Scaled {
    /// Per bridge, 0 to 1.
    pub bridge: Vec<f64>,
    /// Per fragment, above 0, up to 1.
    pub root: Vec<f64>,
    /// ln of the product of what was divided by.
    pub log_scale: f64,
}

impl Scaled {
    /// Scales the weights.
    pub fn new(forests: &Forests) -> Self {
        let mut most = forests.log_roots.clone();
        for bridge in &forests.bridges {
            most[bridge.child] = most[bridge.child].max(bridge.log_weight);
        }
        // Exponents first: the difference of two logarithms would be rounded by more than the quotient of two weights.
        let bridge = forests.bridges.iter().map(|b| b.log_weight.exp() / most[b.child].exp()).collect();
        let root = forests.log_roots.iter().zip(&most).map(|(root, most)| root.exp() / most.exp()).collect();
        Self { bridge, root, log_scale: most.iter().sum() }
    }

    /// The bridges that can be, each with its row and scaled weight.
    pub fn possible<'a>(&'a self, forests: &'a Forests) -> impl Iterator<Item = (usize, &'a Bridge, f64)> {
        let bridges = forests.bridges.iter().zip(&self.bridge).enumerate();
        bridges.filter(|(_, (_, weight))| **weight > 0.0).map(|(row, (bridge, weight))| (row, bridge, *weight))
    }

    /// The order in which fragments are eliminated, each with its neighbours then: least degree over the bridges that can be.
    pub fn stars(&self, forests: &Forests) -> Vec<Star> {
        let links: Vec<[usize; 2]> = self.possible(forests).map(|(_, bridge, _)| [bridge.child, bridge.parent]).collect();
        // Without a limit there is always an order.
        least_degree(forests.fragments(), &links, usize::MAX).unwrap_or_default()
    }
}
