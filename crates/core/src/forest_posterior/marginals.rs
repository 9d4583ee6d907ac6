//! The probability of every edge and every root, and that a fragment's tree is rooted in one of some fragments; and the log-likelihood of a
//! case whose true edges are known, with its gradient: what weights are fitted by.

use super::absorbing_walk::{AbsorbingWalk, escapes};
use super::clique_tree::{Clique, cliques, complete};
use super::{Edge, Forests};
use crate::support::elimination::{Elimination, Star, least_degree};
use crate::support::grouped;

/// Marginal probabilities of the posterior; those of a fragment's edges and its root sum to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Marginals {
    /// Per edge, that it is the one that attaches its child.
    pub edges: Vec<f64>,
    /// Per fragment, that it is a root.
    pub roots: Vec<f64>,
    /// ln Z: the log of the sum of the weights of all forests.
    pub log_total: f64,
}

/// Pairs of neighbours at the elimination of all fragments, at the most: 1,400 fragments each of which may be joined to each, or over 10,500 on a
/// lattice, each of which may be joined to the six around it (`benches/layouts.py`).
pub const MOST_PAIRS: usize = 500_000_000;

/// Whether the elimination of fragments between which there are these links brings together more than 500 million pairs of them.
pub fn is_tangle(fragments: usize, links: &[[usize; 2]]) -> bool {
    least_degree(fragments, links, MOST_PAIRS).is_none()
}

/// The marginals, each accurate to about n units in its last place whatever its size.
///
/// Work grows with the cube of the largest clique that elimination makes: n³ at worst, for a hundred fragments a
/// millisecond.
pub fn marginals(forests: &Forests) -> Marginals {
    let scaled = Scaled::new(forests);
    let cliques = cliques(&scaled.stars(forests));
    let mut log_total = scaled.log_scale;
    // The clique in which each fragment is eliminated, and its place there.
    let mut home = vec![0; forests.fragments()];
    for (number, clique) in cliques.iter().enumerate() {
        clique.nodes[..clique.pivots].iter().for_each(|node| home[*node] = number);
    }
    let possible = scaled.possible(forests);
    let held = grouped(cliques.len(), possible.map(|(row, edge, _)| (home[edge.child].min(home[edge.parent]), row)));
    let mut place = vec![0; forests.fragments()];
    let own = cliques.iter().zip(&held).map(|(clique, held)| own_walk(clique, held, forests, &scaled, &mut place)).collect();
    let (walks, log_sum) = complete(&cliques, own);
    log_total += log_sum;
    let mut escape = vec![0.0; forests.edges().len()];
    for ((clique, walk), held) in cliques.iter().zip(&walks).zip(&held) {
        let (q, log_det) = escapes(walk);
        if clique.parent.is_none() {
            log_total += log_det;
        }
        clique.nodes.iter().enumerate().for_each(|(at, node)| place[*node] = at);
        for row in held {
            let Edge { child, parent, .. } = forests.edges()[*row];
            escape[*row] = q.get(place[parent], place[child]);
        }
    }
    let odds: Vec<f64> = scaled.edge.iter().zip(&escape).map(|(w, q)| w * q).collect();
    let mut sum = scaled.root.clone();
    for (edge, odds) in forests.edges().iter().zip(&odds) {
        sum[edge.child] += odds;
    }
    let edges = forests.edges().iter().zip(&odds).map(|(edge, odds)| odds / sum[edge.child]).collect();
    Marginals { edges, roots: scaled.root.iter().zip(&sum).map(|(root, sum)| root / sum).collect(), log_total }
}

/// The walk of a clique from the edges that it holds and the roots that are eliminated there.
fn own_walk(clique: &Clique, held: &[usize], forests: &Forests, scaled: &Scaled, place: &mut [usize]) -> AbsorbingWalk {
    let mut walk = AbsorbingWalk::new(clique.nodes.len());
    for (at, node) in clique.nodes.iter().enumerate() {
        place[*node] = at;
        if at < clique.pivots {
            walk.death[at] = scaled.root[*node];
        }
    }
    for row in held {
        let Edge { child, parent, .. } = forests.edges()[*row];
        walk.add(place[child], place[parent], scaled.edge[*row]);
    }
    walk
}

/// Weights relative to the largest of the same fragment.
#[derive(Debug, Clone)]
pub struct Scaled {
    /// Per edge, 0 to 1.
    pub edge: Vec<f64>,
    /// Per fragment, above 0, up to 1.
    pub root: Vec<f64>,
    /// ln of the product of what was divided by.
    pub log_scale: f64,
}

impl Scaled {
    /// Scales the weights.
    pub fn new(forests: &Forests) -> Self {
        let mut most = forests.log_roots.clone();
        for edge in &forests.edges {
            most[edge.child] = most[edge.child].max(edge.log_weight);
        }
        // Exponents first: the difference of two logarithms would be rounded by more than the quotient of two weights.
        let edge = forests.edges.iter().map(|b| b.log_weight.exp() / most[b.child].exp()).collect();
        let root = forests.log_roots.iter().zip(&most).map(|(root, most)| root.exp() / most.exp()).collect();
        Self { edge, root, log_scale: most.iter().sum() }
    }

    /// The edges that can be, each with its row and scaled weight.
    pub fn possible<'a>(&'a self, forests: &'a Forests) -> impl Iterator<Item = (usize, &'a Edge, f64)> {
        let edges = forests.edges.iter().zip(&self.edge).enumerate();
        edges.filter(|(_, (_, weight))| **weight > 0.0).map(|(row, (edge, weight))| (row, edge, *weight))
    }

    /// The order in which fragments are eliminated, each with its neighbours then: least degree over the edges that can be.
    pub fn stars(&self, forests: &Forests) -> Vec<Star> {
        let links: Vec<[usize; 2]> = self.possible(forests).map(|(_, edge, _)| [edge.child, edge.parent]).collect();
        // Without a limit there is always an order.
        least_degree(forests.fragments(), &links, usize::MAX).unwrap_or_default()
    }
}

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

/// Per fragment the probability that the root of its tree is `marked`, shape (fragments): Σ G_cr v_r over the marked r, the
/// probability that the walk from c dies in one of them.
///
/// Eliminated without a subtraction, as the marginals are, so each is right in its own digits.
///
/// # Panics
///
/// When there is not one mark per fragment.
pub fn rooted_in(forests: &Forests, marked: &[bool]) -> Vec<f64> {
    assert_eq!(marked.len(), forests.fragments(), "one mark per fragment");
    let scaled = Scaled::new(forests);
    let stars = scaled.stars(forests);
    // Fragments by their places in the order; its meshes, which a tangle has too many of, are not kept.
    let order = Elimination::of_stars(&stars, 0);
    // By place the odds of dying there or in what was eliminated: with a mark, and without.
    let of_star = |star: &Star| {
        let root = scaled.root[star.center];
        if marked[star.center] { [root, 0.0] } else { [0.0, root] }
    };
    let mut death: Vec<[f64; 2]> = stars.iter().map(of_star).collect();
    // By ray the odds of a step along it to the later fragment, and back.
    let (mut out, mut into) = (vec![0.0; order.rays()], vec![0.0; order.rays()]);
    for (_, edge, odds) in scaled.possible(forests) {
        let [child, parent] = [edge.child, edge.parent].map(|fragment| order.place(fragment));
        let steps = if child < parent { &mut out } else { &mut into };
        steps[order.ray_between(child, parent) as usize] += odds;
    }
    let ray_to = order.ray_to();
    for at in 0..order.nodes() {
        // The odds of a fragment become probabilities, and each step to it the steps that lead on.
        let star = order.star(at);
        let sum = death[at].iter().sum::<f64>() + out[star.clone()].iter().sum::<f64>();
        out[star.clone()].iter_mut().chain(&mut death[at]).for_each(|odds| *odds /= sum);
        for i in star.clone() {
            let (to, dies_here) = (ray_to[i] as usize, death[at]);
            for (sum, here) in death[to].iter_mut().zip(dies_here) {
                *sum += into[i] * here;
            }
            // All later neighbours are neighbours of this one; both lists are in order.
            let mut ray = order.star(to).start;
            for j in i + 1..star.end {
                while ray_to[ray] < ray_to[j] {
                    ray += 1;
                }
                out[ray] += into[i] * out[j];
                into[ray] += into[j] * out[i];
            }
        }
    }
    let mut rooted = vec![0.0; order.nodes()];
    for at in (0..rooted.len()).rev() {
        let onwards = order.star(at).map(|ray| out[ray] * rooted[ray_to[ray] as usize]);
        rooted[at] = (death[at][0] + onwards.sum::<f64>()).min(1.0);
    }
    (0..rooted.len()).map(|fragment| rooted[order.place(fragment) as usize]).collect()
}
