//! The clique tree of an elimination: a large sparse problem as small dense ones that share fragments.
//!
//! A fragment and its neighbours at its elimination are a clique. Cliques are merged as long as one larger dense problem
//! is less work than two and the messages between them. What a message costs depends on what else is merged, so two guesses
//! at it make two trees, and the one of less work is taken: many small branches on one fragment want one, a dense tangle
//! the other.

use crate::support::elimination::Star;
use crate::support::numbered::{counted, placed};

/// Fragments that are solved together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clique {
    /// First those that are eliminated here, then those that are in the parent too.
    pub nodes: Vec<usize>,
    /// How many are eliminated here.
    pub pivots: usize,
    /// The clique that holds all others; it comes later in the list.
    pub parent: Option<usize>,
}

/// The cliques, children before parents.
pub fn cliques(stars: &[Star]) -> Vec<Clique> {
    let [few, many] = [Guess::Whole, Guess::First].map(|guess| merged(stars, guess));
    if work(&few) <= work(&many) { few } else { many }
}

/// What a message out of a parent is taken to cost: as much as all of it, or as what it was before anything was merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Guess {
    Whole,
    First,
}

/// The cliques under one guess.
fn merged(stars: &[Star], guess: Guess) -> Vec<Clique> {
    let place = placed(stars.len(), stars.iter().map(|star| star.center));
    let (mut pivots, mut shared): (Vec<Vec<usize>>, Vec<Vec<usize>>) =
        stars.iter().map(|star| (vec![star.center], star.neighbours.clone())).unzip();
    let parent: Vec<Option<usize>> = shared.iter().map(|nodes| nodes.iter().map(|node| place[*node]).min()).collect();
    let mut merged = vec![false; pivots.len()];
    for (child, parent) in parent.iter().enumerate() {
        let Some(parent) = *parent else { continue };
        let [small, large] = [child, parent].map(|clique| pivots[clique].len() + shared[clique].len());
        let message = if guess == Guess::Whole { large } else { 1 + shared[parent].len() };
        let separate = escapes(small) + escapes(large) + cube(message) / 3.0 + CLIQUE;
        if escapes(pivots[child].len() + large) <= separate {
            let moved = std::mem::take(&mut pivots[child]);
            pivots[parent].splice(0..0, moved);
            shared[child].clear();
            merged[child] = true;
        }
    }
    // From the last: where each elimination ended up.
    let mut owner: Vec<usize> = (0..parent.len()).collect();
    for at in (0..parent.len()).rev() {
        if let (true, Some(parent)) = (merged[at], parent[at]) {
            owner[at] = owner[parent];
        }
    }
    let kept: Vec<usize> = (0..parent.len()).filter(|at| !merged[*at]).collect();
    let number = placed(parent.len(), kept.iter().copied());
    let clique = |at: &usize| {
        let (own, mut rest) = (std::mem::take(&mut pivots[*at]), std::mem::take(&mut shared[*at]));
        rest.sort_unstable_by_key(|node| place[*node]);
        let parent = parent[*at].map(|parent| number[owner[parent]]);
        Clique { pivots: own.len(), nodes: own.into_iter().chain(rest).collect(), parent }
    };
    kept.iter().map(clique).collect()
}

/// Multiplications that the management of a clique is worth.
const CLIQUE: f64 = 6000.0;

fn cube(nodes: usize) -> f64 {
    (nodes as f64).powi(3)
}

/// Multiplications for the escapes of a clique.
fn escapes(nodes: usize) -> f64 {
    4.0 / 3.0 * cube(nodes)
}

/// Multiplications for all of them, about: children share the work of the messages down to them.
fn work(cliques: &[Clique]) -> f64 {
    let children = counted(cliques.len(), cliques.iter().filter_map(|clique| clique.parent));
    let each = cliques.iter().zip(children).map(|(clique, children)| {
        let messages = [0.0, 1.0 / 3.0, 1.0][children.min(2)];
        escapes(clique.nodes.len()) + messages * cube(clique.nodes.len()) + CLIQUE
    });
    each.sum()
}
