//! How many errors a decision is expected to make.

use super::Marginals;

/// Expected errors of a set of kept bridges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Links kept that are not there.
    pub wrong: f64,
    /// Links there that are not kept.
    pub missed: f64,
}

/// The errors expected of `kept`, per fragment the bridge it hangs by.
///
/// `link` has shape (bridges) and numbers links: bridges that are the same link, as the two directions of one, share a number.
/// They must exclude one another, so that their probabilities add up.
///
/// # Panics
///
/// `link` and `marginals` differ in length, or a kept bridge is not there.
pub fn expected(marginals: &Marginals, link: &[usize], kept: &[Option<usize>]) -> Expected {
    assert_eq!(link.len(), marginals.bridges.len(), "one link per bridge");
    let links = link.iter().max().map_or(0, |most| most + 1);
    let (mut probability, mut keeps) = (vec![0.0_f64; links], vec![false; links]);
    for (link, p) in link.iter().zip(&marginals.bridges) {
        probability[*link] += p;
    }
    kept.iter().flatten().for_each(|bridge| keeps[link[*bridge]] = true);
    let of = |wanted: bool| probability.iter().zip(&keeps).filter(move |(_, keeps)| **keeps == wanted).map(|(p, _)| *p);
    Expected { wrong: of(true).map(|p| (1.0 - p).max(0.0)).sum(), missed: of(false).sum() }
}
