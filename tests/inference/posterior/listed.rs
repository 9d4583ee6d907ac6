//! All explanations of a few fragments, one by one: every choice for every fragment, cycles left out.

use willis::internals::forest_posterior::{Edge, Forests};

use crate::draw::Draw;

/// Explanations with their weights.
pub struct Listed {
    pub explanations: Vec<(Vec<Option<usize>>, f64)>,
    edges: usize,
}

impl Listed {
    pub fn new(forests: &Forests) -> Self {
        let mut explanations = vec![(Vec::new(), 1.0)];
        for fragment in 0..forests.fragments() {
            let mut choices = vec![(None, forests.log_roots()[fragment].exp())];
            let own = forests.edges().iter().enumerate().filter(|(_, b)| b.child == fragment);
            choices.extend(own.map(|(row, b)| (Some(row), b.log_weight.exp())));
            let longer = explanations.iter().flat_map(|(before, weight): &(Vec<Option<usize>>, f64)| {
                choices.iter().map(move |(choice, w)| ([before.as_slice(), &[*choice]].concat(), weight * w))
            });
            explanations = longer.collect();
        }
        let parents: Vec<usize> = forests.edges().iter().map(|b| b.parent).collect();
        explanations.retain(|(choices, _)| ends(choices, &parents));
        Self { explanations, edges: parents.len() }
    }

    pub fn total(&self) -> f64 {
        self.explanations.iter().map(|(_, weight)| weight).sum()
    }

    fn probability(&self, holds: impl Fn(&[Option<usize>]) -> bool) -> f64 {
        self.explanations.iter().filter(|(choices, _)| holds(choices)).map(|(_, weight)| weight).sum::<f64>() / self.total()
    }

    pub fn edges(&self) -> Vec<f64> {
        (0..self.edges).map(|row| self.probability(|choices| choices.contains(&Some(row)))).collect()
    }

    pub fn roots(&self) -> Vec<f64> {
        (0..self.explanations[0].0.len()).map(|fragment| self.probability(|choices| choices[fragment].is_none())).collect()
    }

    /// Per fragment, that the root of its tree is marked.
    pub fn rooted_in(&self, forests: &Forests, marked: &[bool]) -> Vec<f64> {
        let root = |choices: &[Option<usize>], from: usize| {
            let mut at = from;
            while let Some(row) = choices[at] {
                at = forests.edges()[row].parent;
            }
            at
        };
        (0..marked.len()).map(|from| self.probability(|choices| marked[root(choices, from)])).collect()
    }

    /// ln of the share of explanations in which every fragment does what it may.
    pub fn log_likelihood(&self, forests: &Forests, allowed: &[bool]) -> f64 {
        let any = |fragment| forests.edges().iter().zip(allowed).any(|(b, allowed)| *allowed && b.child == fragment);
        let may = |(fragment, choice): (usize, &Option<usize>)| choice.map_or(!any(fragment), |row| allowed[row]);
        self.probability(|choices| choices.iter().enumerate().all(may)).ln()
    }

    /// Sum of scores and sum of rows; `None` when it is no explanation.
    pub fn figure(&self, choices: &[Option<usize>], edges: &[f64], roots: &[f64]) -> Option<(f64, usize)> {
        let known = self.explanations.iter().any(|(c, _)| c == choices);
        let each =
            choices.iter().enumerate().map(|(c, choice)| choice.map_or((roots[c], edges.len() + c), |row| (edges[row], row)));
        known.then(|| each.fold((0.0, 0), |sum, x| (sum.0 + x.0, sum.1 + x.1)))
    }

    /// The largest sum of scores, and the smallest sum of rows among those (to 1e-9) that have it.
    pub fn best(&self, edges: &[f64], roots: &[f64]) -> (f64, usize) {
        let all: Vec<(f64, usize)> =
            self.explanations.iter().map(|(c, _)| self.figure(c, edges, roots).expect("itself")).collect();
        let most = all.iter().map(|x| x.0).fold(f64::NEG_INFINITY, f64::max);
        (most, all.iter().filter(|x| x.0 > most - 1e-9).map(|x| x.1).min().expect("one"))
    }
}

/// Whether every fragment comes to a root: no cycle.
fn ends(choices: &[Option<usize>], parents: &[usize]) -> bool {
    (0..choices.len()).all(|from| {
        let mut at = Some(from);
        for _ in 0..choices.len() {
            at = at.and_then(|fragment| choices[fragment].map(|row| parents[row]));
        }
        at.is_none()
    })
}

/// Two to `most` fragments, up to ten edges, parallel ones among them; log weights up to ±`spread`.
pub fn random(draw: &mut Draw, most: usize, spread: f64) -> Forests {
    let fragments = 2 + draw.below(most - 1);
    let roots = (0..fragments).map(|_| draw.within(-spread, spread)).collect();
    let mut edges = Vec::new();
    for _ in 0..draw.below(11) {
        let child = draw.below(fragments);
        let parent = (child + 1 + draw.below(fragments - 1)) % fragments;
        edges.push(Edge { child, parent, log_weight: draw.within(-spread, spread) });
    }
    Forests::new(roots, edges).unwrap()
}
