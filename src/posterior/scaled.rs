//! The weights of every fragment divided by its largest: no marginal changes by that, and nothing overflows.

use super::Forests;

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
}
