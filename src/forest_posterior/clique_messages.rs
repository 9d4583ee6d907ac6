//! Messages along a clique tree: what the rest of the walk looks like from within a clique.
//!
//! Upwards, a clique tells its parent how the walk continues among shared fragments through those below. Downwards, the parent tells
//! each child the same of all others. It never subtracts a child's own message.

use super::absorbing_walk::Walk;
use super::clique_tree::Clique;

/// A walk among some fragments.
struct Message {
    nodes: Vec<usize>,
    walk: Walk,
}

/// The walk within every clique, with all fragments outside of it eliminated; and the part of ln det L that the cliques with
/// a parent make up.
pub fn complete(cliques: &[Clique], own: Vec<Walk>) -> (Vec<Walk>, f64) {
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
fn with(walk: &Walk, nodes: &[usize], from: &[usize], up: &[Option<Message>], place: &mut [usize]) -> Walk {
    let mut walk = walk.clone();
    set_places(nodes, place);
    for message in from.iter().filter_map(|child| up[*child].as_ref()) {
        let at: Vec<usize> = message.nodes.iter().map(|node| place[*node]).collect();
        walk.add_all(&message.walk, &at);
    }
    walk
}

/// A walk on `nodes` with all but `kept` eliminated, and Σ ln S of those.
fn reduced(walk: Walk, nodes: &[usize], kept: &[usize]) -> (Message, f64) {
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
    whole: &mut [Walk],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forest_posterior::clique_tree::cliques;
    use crate::forest_posterior::escape_probability::escapes;
    use crate::support::elimination::least_degree;

    /// `chains` chains of `length` links on node 0, each link both ways with odds of its own.
    fn hub(chains: usize, length: usize) -> (usize, Vec<(usize, usize, f64)>) {
        let mut links = Vec::new();
        for node in 1..=chains * length {
            let above = if node % length == 1 { 0 } else { node - 1 };
            links.extend([(node, above, 0.1 * node as f64), (above, node, 3.0 / node as f64)]);
        }
        (chains * length + 1, links)
    }

    /// A square grid, odds larger to the right.
    fn grid(side: usize) -> (usize, Vec<(usize, usize, f64)>) {
        let right = (0..side * side).filter(|i| i % side + 1 < side).map(|i| (i, i + 1));
        let links: Vec<(usize, usize)> = right.chain((0..side * (side - 1)).map(|i| (i, i + side))).collect();
        (side * side, links.iter().flat_map(|(a, b)| [(*a, *b, 1.0 + *a as f64), (*b, *a, 0.3)]).collect())
    }

    #[test]
    fn in_cliques_it_is_the_same_as_in_one_piece() {
        for ((nodes, links), least) in [(hub(60, 5), 40), (grid(20), 2)] {
            let pairs: Vec<[usize; 2]> = links.iter().map(|(a, b, _)| [*a, *b]).collect();
            let cliques = cliques(&least_degree(nodes, &pairs, usize::MAX).expect("no limit"));
            let children = |number| cliques.iter().filter(|c| c.parent == Some(number)).count();
            assert!((0..cliques.len()).map(children).max() >= Some(least) && cliques.len() > 6);
            let mut whole = Walk::new(nodes);
            whole.death = (0..nodes).map(|node| 0.01 + 1e-3 * node as f64).collect();
            for (from, to, odds) in &links {
                whole.add(*from, *to, *odds);
            }
            let mut own: Vec<Walk> = cliques.iter().map(|clique| Walk::new(clique.nodes.len())).collect();
            for (clique, own) in cliques.iter().zip(&mut own) {
                for (at, node) in clique.nodes[..clique.pivots].iter().enumerate() {
                    own.death[at] = whole.death[*node];
                    for (other, to) in clique.nodes.iter().enumerate() {
                        own.add(at, other, whole.row(*node)[*to]);
                        if other >= clique.pivots {
                            own.add(other, at, whole.row(*to)[*node]);
                        }
                    }
                }
            }
            let (exact, log_det) = escapes(&whole);
            let (walks, mut sum) = complete(&cliques, own);
            for (clique, walk) in cliques.iter().zip(&walks) {
                let (q, log_root) = escapes(walk);
                sum += if clique.parent.is_none() { log_root } else { 0.0 };
                for (i, a) in clique.nodes.iter().enumerate() {
                    for (j, b) in clique.nodes.iter().enumerate() {
                        let (got, exact) = (q.get(i, j), exact.get(*a, *b));
                        assert!((got - exact).abs() <= 1e-13 * exact, "{a} {b}: {got} for {exact}");
                    }
                }
            }
            assert!((sum - log_det).abs() < 1e-12 * log_det.abs());
        }
    }
}
