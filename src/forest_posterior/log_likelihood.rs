//! The log-likelihood of a case whose true bridges are known, and its gradient: what weights are fitted by.

use super::Forests;
use super::marginals::Marginals;

/// Derivatives of the log-likelihood.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// Per bridge, with respect to ln w.
    pub bridges: Vec<f64>,
    /// Per fragment, with respect to ln v.
    pub roots: Vec<f64>,
}

/// ln of the probability that every fragment hangs by one of its allowed bridges, or is a root where none is allowed:
/// Σ_c ln Σ_allowed w - ln Z. Its gradient is the share of a bridge among those allowed to its fragment less its marginal.
///
/// `allowed` has shape (bridges); the true bridges must close no cycle, then one explanation or a product of choices per
/// fragment is summed. A fragment whose allowed bridges all weigh nothing makes it -∞.
///
/// # Panics
///
/// `allowed` or `marginals` belong to other forests.
pub fn log_likelihood(forests: &Forests, marginals: &Marginals, allowed: &[bool]) -> (f64, Gradient) {
    assert_eq!(allowed.len(), forests.bridges().len(), "one mark per bridge");
    assert_eq!(marginals.bridges.len(), allowed.len(), "marginals of the same forests");
    let mut most = vec![None::<f64>; forests.fragments()];
    let chosen = || forests.bridges().iter().zip(allowed).filter(|(_, allowed)| **allowed).map(|(bridge, _)| bridge);
    for bridge in chosen() {
        let most = &mut most[bridge.child];
        *most = Some(most.map_or(bridge.log_weight, |most| most.max(bridge.log_weight)));
    }
    // Relative to the largest; a fragment whose allowed bridges cannot be keeps a sum of zero.
    let relative = |log_weight: f64, most: Option<f64>| most.map_or(0.0, |most| (log_weight - most.max(f64::MIN)).exp());
    let mut sum = vec![0.0; forests.fragments()];
    for bridge in chosen() {
        sum[bridge.child] += relative(bridge.log_weight, most[bridge.child]);
    }
    let terms = most.iter().zip(&sum).zip(forests.log_roots()).map(|((most, sum), root)| most.map_or(*root, |m| m + sum.ln()));
    let value = terms.sum::<f64>() - marginals.log_total;
    let bridges = forests.bridges().iter().zip(allowed).zip(&marginals.bridges).map(|((bridge, allowed), p)| {
        let share = if *allowed {
            relative(bridge.log_weight, most[bridge.child]) / sum[bridge.child].max(f64::MIN_POSITIVE)
        } else {
            0.0
        };
        share - p
    });
    let roots = most.iter().zip(&marginals.roots).map(|(most, p)| f64::from(u8::from(most.is_none())) - p);
    (value, Gradient { bridges: bridges.collect(), roots: roots.collect() })
}
