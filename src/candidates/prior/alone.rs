//! What speaks for leaving a fragment alone when a forest is decided.

use crate::candidates::evidence::Extraction;
use crate::posterior::Marginals;

/// A fragment that blood enters is no false one, so leaving it alone can only lose a connection.
const FED: f64 = 0.3;
/// With so many fragments half of the probability of being alone counts: in a circle of few fragments one lost connection
/// changes the whole, in a brain of a hundred one false twig more joins it.
const HALF: f64 = 10.0;
/// Where no inlet is given, so many of the widest free ends are taken for inlets ...
const LIKELY_INLETS: usize = 3;
/// ... and the others that nobody marked make every fragment somewhat more likely to lead to one.
const UNMARKED: f64 = 0.7;

/// Per fragment P(root) times 0.3 where blood enters it, times n/(n + 10) elsewhere, n the number of fragments; times 0.7 when no
/// inlet is given.
pub fn alone(extraction: &Extraction, marginals: &Marginals) -> Vec<f64> {
    let n = extraction.fragments.len() as f64;
    let mut fed = vec![false; extraction.fragments.len()];
    for point in entries(extraction) {
        fed[extraction.fragment[point]] = true;
    }
    let unmarked = if extraction.inlets.is_empty() { UNMARKED } else { 1.0 };
    marginals.roots.iter().zip(fed).map(|(p, fed)| p * unmarked * if fed { FED } else { n / (n + HALF) }).collect()
}

/// The points where blood enters: the inlets given, without any the three widest free ends.
pub fn entries(extraction: &Extraction) -> Vec<usize> {
    if !extraction.inlets.is_empty() {
        return extraction.inlets.clone();
    }
    let mut ends: Vec<_> = extraction.ends.iter().collect();
    ends.sort_by(|a, b| b.radius.total_cmp(&a.radius).then(a.point.cmp(&b.point)));
    ends.iter().take(LIKELY_INLETS).map(|end| end.point).collect()
}
