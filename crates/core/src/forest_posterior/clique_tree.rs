//! The clique tree of an elimination: a large sparse problem as small dense ones that share fragments.
//!
//! A fragment and its neighbours at its elimination are a clique. Cliques are merged as long as one larger dense problem
//! is less work than two and the messages between them. What a message costs depends on what else is merged, so two guesses
//! at it make two trees, and the one of less work is taken: many small branches on one fragment want one, a dense tangle
//! the other.
//!
//! Messages along it say what the rest of the walk looks like from within a clique.
//! Upwards, a clique tells its parent how the walk continues among shared fragments through those below. Downwards, the parent tells
//! each child the same of all others. It never subtracts a child's own message.

use super::absorbing_walk::AbsorbingWalk;
use crate::support::{counted, distinct, elimination::Star, placed};

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

/// A walk among some fragments.
struct Message {
    nodes: Vec<usize>,
    walk: AbsorbingWalk,
}

/// The walk within every clique, with all fragments outside of it eliminated; and the part of ln det L that the cliques with
/// a parent make up.
pub fn complete(cliques: &[Clique], own: Vec<AbsorbingWalk>) -> (Vec<AbsorbingWalk>, f64) {
    let fragments = cliques.iter().flat_map(|clique| &clique.nodes).max().map_or(0, |most| most + 1);
    let mut place = vec![0; fragments];
    let mut children = vec![Vec::new(); cliques.len()];
    let (mut up, mut log_sum) = (Vec::with_capacity(cliques.len()), 0.0);
    for (number, clique) in cliques.iter().enumerate() {
        let Some(parent) = clique.parent else {
            up.push(None);
            continue;
        };
        let walk = with(&own[number], &clique.nodes, &children[number], &up, &mut place);
        let (message, sum) = reduced(walk, &clique.nodes, &clique.nodes[clique.pivots..]);
        log_sum += sum;
        up.push(Some(message));
        children[parent].push(number);
    }
    let mut whole = own;
    for number in (0..cliques.len()).rev() {
        let clique = &cliques[number];
        let start = Message { nodes: clique.nodes.clone(), walk: whole[number].clone() };
        descend(start, &children[number], cliques, &up, &mut place, &mut whole);
        whole[number] = with(&whole[number], &clique.nodes, &children[number], &up, &mut place);
    }
    (whole, log_sum)
}

/// A walk with the messages of some cliques added.
fn with(walk: &AbsorbingWalk, nodes: &[usize], from: &[usize], up: &[Option<Message>], place: &mut [usize]) -> AbsorbingWalk {
    let mut walk = walk.clone();
    set_places(nodes, place);
    for message in from.iter().filter_map(|child| up[*child].as_ref()) {
        let at: Vec<usize> = message.nodes.iter().map(|node| place[*node]).collect();
        walk.add_all(&message.walk, &at);
    }
    walk
}

/// A walk on `nodes` with all but `kept` eliminated, and Σ ln S of those.
fn reduced(walk: AbsorbingWalk, nodes: &[usize], kept: &[usize]) -> (Message, f64) {
    let gone: Vec<usize> = (0..nodes.len()).filter(|at| !kept.contains(&nodes[*at])).collect();
    let stays: Vec<usize> = (0..nodes.len()).filter(|at| kept.contains(&nodes[*at])).collect();
    let order: Vec<usize> = gone.iter().chain(&stays).copied().collect();
    let mut walk = if order.iter().copied().eq(0..nodes.len()) { walk } else { walk.part(&order) };
    let log_sum = walk.eliminate(gone.len());
    let last: Vec<usize> = (gone.len()..nodes.len()).collect();
    (Message { nodes: stays.iter().map(|at| nodes[*at]).collect(), walk: walk.part(&last) }, log_sum)
}

/// Adds to each child the messages of all but the child itself: halves of the children share the work.
fn descend(
    start: Message,
    children: &[usize],
    cliques: &[Clique],
    up: &[Option<Message>],
    place: &mut [usize],
    whole: &mut [AbsorbingWalk],
) {
    let shared = |child: &usize| &cliques[*child].nodes[cliques[*child].pivots..];
    if let [child] = children {
        let (message, _) = reduced(start.walk, &start.nodes, shared(child));
        set_places(&cliques[*child].nodes, place);
        let at: Vec<usize> = message.nodes.iter().map(|node| place[*node]).collect();
        whole[*child].add_all(&message.walk, &at);
        return;
    }
    let (first, second) = children.split_at(children.len() / 2);
    for (half, others) in [(first, second), (second, first)] {
        if half.is_empty() {
            continue;
        }
        let walk = with(&start.walk, &start.nodes, others, up, place);
        let kept = distinct(half.iter().flat_map(shared).copied());
        let (next, _) = reduced(walk, &start.nodes, &kept);
        descend(next, half, cliques, up, place, whole);
    }
}

fn set_places(nodes: &[usize], place: &mut [usize]) {
    for (at, node) in nodes.iter().enumerate() {
        place[*node] = at;
    }
}
