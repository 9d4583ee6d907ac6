//! Messages along a clique tree: what the rest of the walk looks like from within a clique.
//!
//! Upwards, a clique tells its parent how the walk continues among shared fragments through those below. Downwards, the parent tells
//! each child the same of all others. It never subtracts a child's own message.

use super::absorbing_walk::AbsorbingWalk;
use super::clique_tree::Clique;

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
        let mut kept: Vec<usize> = half.iter().flat_map(shared).copied().collect();
        kept.sort_unstable();
        kept.dedup();
        let (next, _) = reduced(walk, &start.nodes, &kept);
        descend(next, half, cliques, up, place, whole);
    }
}

fn set_places(nodes: &[usize], place: &mut [usize]) {
    for (at, node) in nodes.iter().enumerate() {
        place[*node] = at;
    }
}
