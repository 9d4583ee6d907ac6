//! The log-likelihood of a case whose true edges are known, and its gradient: what weights are fitted by.

use super::Forests;
use super::marginals::Marginals;

/// Derivatives of the log-likelihood.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestGradient {
    /// Per edge, with respect to ln w.
    pub edges: Vec<f64>,
    /// Per fragment, with respect to ln v.
    pub roots: Vec<f64>,
}

/// ln of the probability that every fragment is attached by one of its allowed edges, or is a root where none is allowed:
/// Σ_c ln Σ_allowed w - ln Z. Its gradient is the share of an edge among those allowed to its fragment less its marginal.
///
/// `allowed` has shape (edges); the true edges must close no cycle, then one forest or a product of choices per
/// fragment is summed. A fragment whose allowed edges all weigh nothing makes it -∞.
///
/// # Panics
///
/// `allowed` or `marginals` belong to other forests.
pub fn log_likelihood(forests: &Forests, marginals: &Marginals, allowed: &[bool]) -> (f64, ForestGradient) {
    assert_eq!(allowed.len(), forests.edges().len(), "one mark per edge");
    assert_eq!(marginals.edges.len(), allowed.len(), "marginals of the same forests");
    let mut most = vec![None::<f64>; forests.fragments()];
    let chosen = || forests.edges().iter().zip(allowed).filter(|(_, allowed)| **allowed).map(|(edge, _)| edge);
    for edge in chosen() {
        let most = &mut most[edge.child];
        *most = Some(most.map_or(edge.log_weight, |most| most.max(edge.log_weight)));
    }
    // Relative to the largest; a fragment whose allowed edges cannot be keeps a sum of zero.
    let relative = |log_weight: f64, most: Option<f64>| most.map_or(0.0, |most| (log_weight - most.max(f64::MIN)).exp());
    let mut sum = vec![0.0; forests.fragments()];
    for edge in chosen() {
        sum[edge.child] += relative(edge.log_weight, most[edge.child]);
    }
    let terms = most.iter().zip(&sum).zip(forests.log_roots()).map(|((most, sum), root)| most.map_or(*root, |m| m + sum.ln()));
    let value = terms.sum::<f64>() - marginals.log_total;
    let edges = forests.edges().iter().zip(allowed).zip(&marginals.edges).map(|((edge, allowed), p)| {
        let share =
            if *allowed { relative(edge.log_weight, most[edge.child]) / sum[edge.child].max(f64::MIN_POSITIVE) } else { 0.0 };
        share - p
    });
    let roots = most.iter().zip(&marginals.roots).map(|(most, p)| f64::from(u8::from(most.is_none())) - p);
    (value, ForestGradient { edges: edges.collect(), roots: roots.collect() })
}
