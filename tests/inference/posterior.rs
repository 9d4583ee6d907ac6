//! The posterior over forests of fragments, against the list of all explanations, exact marginals to 400 digits
//! (tests/inference/posterior/reference.py), NetworkX, and invariants.
//!
//! Largest relative error of a marginal over the references (`--nocapture` prints it by name), ε = 2⁻⁵² = 2.2e-16, beside
//! that of w (G_cc - G_pc) with NumPy's inverse:
//!
//! | family | smallest marginal | here | G_cc - G_pc |
//! |---|---|---|---|
//! | wide | 4e-57 | 4.7e-16 | 2e22 |
//! | mutual | 2e-45 | 6.9e-16 | 7e8, and one of 5 is singular |
//! | grid | 1e-69 | 5.8e-16 | 4e26 |
//! | hub | 2e-73 | 4.1e-16 | 1e24 |

mod listed;
mod networkx;

use crate::draw::Draw;
use crate::figure::Figure;
use listed::{Listed, random};
use serde::Deserialize;
use willis::internals::forest_posterior::absorbing_walk::AbsorbingWalk;
use willis::internals::forest_posterior::absorbing_walk::escapes;
use willis::internals::forest_posterior::clique_tree::cliques;
use willis::internals::forest_posterior::clique_tree::complete;
use willis::internals::forest_posterior::{Edge, Forests, arborescence, log_likelihood, marginals, rooted_in};
use willis::internals::support::elimination::least_degree;

/// Relative error that a marginal may have: 36 ε.
const TOLERANCE: f64 = 8e-15;

fn near(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * b.abs()
}

#[derive(Deserialize)]
struct Reference {
    name: String,
    log_total: Figure,
    /// Log weight, probability.
    roots: Vec<(Figure, Figure)>,
    /// Child, parent, log weight, probability.
    bridges: Vec<(usize, usize, Figure, Figure)>,
}

#[test]
fn every_marginal_is_right_in_its_own_digits() {
    let all: Vec<Reference> = serde_json::from_str(include_str!("posterior/reference.json")).expect("reference.json");
    assert_eq!(all.len(), 12);
    for Reference { name, log_total, roots, bridges } in all {
        let bridge = |b: &(usize, usize, Figure, Figure)| Edge { child: b.0, parent: b.1, log_weight: b.2.0 };
        let forests = Forests::new(roots.iter().map(|r| r.0.0).collect(), bridges.iter().map(bridge).collect()).unwrap();
        let got = marginals(&forests);
        let pairs = got.edges.iter().zip(bridges.iter().map(|b| b.3.0));
        let mut worst = 0.0_f64;
        for (got, exact) in pairs.chain(got.roots.iter().zip(roots.iter().map(|r| r.1.0))) {
            worst = worst.max((got - exact).abs() / exact);
            assert!(near(*got, exact, TOLERANCE), "{name}: {got:e} for {exact:e}");
        }
        println!("{name} {worst:.1e}");
        assert!(near(got.log_total, log_total.0, TOLERANCE), "{name}: {} for {}", got.log_total, log_total.0);
    }
}

/// Up to five fragments with parallel bridges: the sums over the list of all explanations.
#[test]
fn marginals_are_sums_over_all_explanations() {
    let mut draw = Draw::new(1);
    for _ in 0..400 {
        let forests = random(&mut draw, 5, 4.0);
        let (listed, got) = (Listed::new(&forests), marginals(&forests));
        for (got, sum) in got.edges.iter().chain(&got.roots).zip(listed.edges().iter().chain(&listed.roots())) {
            assert!(near(*got, *sum, 1e-12), "{forests:?}: {got} for {sum}");
        }
        assert!((got.log_total - listed.total().ln()).abs() < 1e-12);
    }
}

#[test]
fn where_a_tree_is_rooted_is_a_sum_over_all_explanations() {
    let mut draw = Draw::new(9);
    for _ in 0..400 {
        let forests = random(&mut draw, 5, 4.0);
        let marked: Vec<bool> = (0..forests.fragments()).map(|_| draw.below(2) == 0).collect();
        for (got, sum) in rooted_in(&forests, &marked).iter().zip(Listed::new(&forests).rooted_in(&forests, &marked)) {
            assert!(near(*got, sum, 1e-12), "{forests:?} {marked:?}: {got} for {sum}");
        }
    }
}

/// A tree that a fragment is in is rooted in it when it is the root; every tree is rooted somewhere.
#[test]
fn where_trees_are_rooted_agrees_with_the_marginals() {
    let mut draw = Draw::new(10);
    for fragments in [2, 3, 30, 150] {
        let forests = ring(&mut draw, fragments);
        let all = marginals(&forests);
        let mut sums = vec![0.0; forests.fragments()];
        for root in 0..forests.fragments() {
            let marked: Vec<bool> = (0..forests.fragments()).map(|fragment| fragment == root).collect();
            let rooted = rooted_in(&forests, &marked);
            assert!(near(rooted[root], all.roots[root], 1e-12), "{} for {}", rooted[root], all.roots[root]);
            sums.iter_mut().zip(&rooted).for_each(|(sum, p)| *sum += p);
        }
        assert!(sums.iter().all(|sum| near(*sum, 1.0, 1e-12)), "{sums:?}");
        assert!(rooted_in(&forests, &vec![false; forests.fragments()]).iter().all(|p| *p == 0.0));
    }
}

/// e^-200 in its own digits, by hand: fragment 0 almost surely stays alone, else hangs on the marked one.
#[test]
fn an_improbable_root_keeps_its_digits() {
    let bridges = vec![Edge { child: 0, parent: 1, log_weight: -100.0 }];
    let forests = Forests::new(vec![100.0, 0.0], bridges).unwrap();
    assert!(near(rooted_in(&forests, &[false, true])[0], (-200.0_f64).exp(), 1e-13));
}

#[test]
fn the_log_likelihood_and_its_gradient_are_those_of_the_list() {
    let mut draw = Draw::new(2);
    let mut none_allowed = 0;
    for _ in 0..200 {
        let forests = random(&mut draw, 5, 3.0);
        // Allowed bridges lead to lower fragments: no cycle.
        let mark = |b: &Edge| b.parent < b.child && draw.below(2) == 0;
        let allowed: Vec<bool> = forests.edges().iter().map(mark).collect();
        none_allowed += usize::from(!allowed.contains(&true));
        let of_list = |forests: &Forests| Listed::new(forests).log_likelihood(forests, &allowed);
        let (value, gradient) = log_likelihood(&forests, &marginals(&forests), &allowed);
        assert!((value - of_list(&forests)).abs() < 1e-11, "{value} for {}", of_list(&forests));
        let step = 1e-4;
        let moved = |at: usize, by: f64| {
            let (mut roots, mut bridges) = (forests.log_roots().to_vec(), forests.edges().to_vec());
            match at.checked_sub(roots.len()) {
                None => roots[at] += by,
                Some(bridge) => bridges[bridge].log_weight += by,
            }
            of_list(&Forests::new(roots, bridges).unwrap())
        };
        for (at, slope) in gradient.roots.iter().chain(&gradient.edges).enumerate() {
            let difference = (moved(at, step) - moved(at, -step)) / (2.0 * step);
            assert!((slope - difference).abs() < 1e-7, "{slope} for {difference}");
        }
    }
    assert!((1..100).contains(&none_allowed));
}

#[test]
fn the_gradient_is_right_far_from_balance() {
    let bridges =
        vec![Edge { child: 0, parent: 1, log_weight: -90.0 }, Edge { child: 0, parent: 1, log_weight: f64::NEG_INFINITY }];
    let forests = Forests::new(vec![90.0, 0.0], bridges).unwrap();
    let all = marginals(&forests);
    assert!(near(all.edges[0], (-180.0_f64).exp(), 1e-13) && all.edges[1] == 0.0);
    let (value, gradient) = log_likelihood(&forests, &all, &[true, true]);
    assert!(near(value, -180.0, 1e-14));
    assert_eq!((gradient.edges, gradient.roots), (vec![1.0 - all.edges[0], 0.0], vec![-1.0, 0.0]));
    let (value, gradient) = log_likelihood(&forests, &all, &[false, true]);
    assert_eq!(value, f64::NEG_INFINITY);
    assert!(gradient.edges.iter().chain(&gradient.roots).all(|slope| slope.is_finite()));
}

#[test]
fn a_fragment_without_bridges_is_a_root() {
    let forests = Forests::new(vec![-100.0, 3.0, 100.0], Vec::new()).unwrap();
    let all = marginals(&forests);
    assert_eq!((all.roots, all.edges.len()), (vec![1.0; 3], 0));
    assert!(near(all.log_total, 3.0, 1e-15));
    assert_eq!(marginals(&Forests::new(Vec::new(), Vec::new()).unwrap()).log_total, 0.0);
}

/// Both ends of the range at once: what the weights may be never becomes 0, infinite or no number.
#[test]
fn the_whole_range_stays_finite() {
    let mut draw = Draw::new(3);
    for _ in 0..200 {
        let fragments = 2 + draw.below(40);
        let mut extreme = || if draw.below(2) == 0 { -100.0 } else { 100.0 };
        let roots = (0..fragments).map(|_| extreme()).collect();
        let bridges: Vec<Edge> = (0..4 * fragments)
            .map(|row| Edge {
                child: row % fragments,
                parent: (row % fragments + 1 + row / fragments) % fragments,
                log_weight: extreme(),
            })
            .filter(|b| b.child != b.parent)
            .collect();
        let all = marginals(&Forests::new(roots, bridges).unwrap());
        assert!(all.log_total.is_finite());
        assert!(all.edges.iter().chain(&all.roots).all(|p| *p > 0.0 && *p <= 1.0));
    }
}

/// Sparse, so that cliques exchange messages: scaling a fragment's weights, moving the numbers of fragments and the order of
/// bridges, and putting two problems side by side change nothing.
#[test]
fn scaling_renumbering_and_company_change_nothing() {
    let mut draw = Draw::new(4);
    for fragments in [3, 30, 300] {
        let forests = ring(&mut draw, fragments);
        let all = marginals(&forests);
        for fragment in 0..fragments {
            let own = forests.edges().iter().zip(&all.edges).filter(|(b, _)| b.child == fragment).map(|(_, p)| p);
            assert!((own.sum::<f64>() + all.roots[fragment] - 1.0).abs() < 1e-14);
        }
        let shift: Vec<f64> = (0..fragments).map(|_| draw.within(-30.0, 30.0)).collect();
        let mut number: Vec<usize> = (0..fragments).collect();
        draw.shuffle(&mut number);
        let mut order: Vec<usize> = (0..forests.edges().len()).collect();
        draw.shuffle(&mut order);
        // Another problem takes the numbers behind.
        let other = ring(&mut draw, 20);
        let mut roots = vec![0.0; fragments];
        for (old, new) in number.iter().enumerate() {
            roots[*new] = forests.log_roots()[old] + shift[old];
        }
        roots.extend(other.log_roots());
        let moved = |row: &usize| {
            let Edge { child, parent, log_weight } = forests.edges()[*row];
            Edge { child: number[child], parent: number[parent], log_weight: log_weight + shift[child] }
        };
        let behind = other.edges().iter().map(|b| Edge { child: b.child + fragments, parent: b.parent + fragments, ..*b });
        let both = marginals(&Forests::new(roots, order.iter().map(moved).chain(behind).collect()).unwrap());
        for (at, row) in order.iter().enumerate() {
            assert!(near(both.edges[at], all.edges[*row], 1e-12));
        }
        for (old, new) in number.iter().enumerate() {
            assert!(near(both.roots[*new], all.roots[old], 1e-12));
        }
        let totals = all.log_total + marginals(&other).log_total + shift.iter().sum::<f64>();
        assert!((both.log_total - totals).abs() < 1e-9);
    }
}

/// Fragments on a ring with bridges to those near, and some across.
fn ring(draw: &mut Draw, fragments: usize) -> Forests {
    let roots = (0..fragments).map(|_| draw.within(-6.0, 3.0)).collect();
    let mut bridges = Vec::new();
    for child in 0..fragments {
        for _ in 0..5 {
            let far = if draw.below(40) == 0 { fragments } else { 4.min(fragments) };
            let parent = (child + 1 + draw.below(far)) % fragments;
            if parent != child {
                let turned = draw.below(2) == 0;
                let [child, parent] = if turned { [parent, child] } else { [child, parent] };
                bridges.push(Edge { child, parent, log_weight: draw.within(-5.0, 5.0) });
            }
        }
    }
    Forests::new(roots, bridges).unwrap()
}

#[test]
fn the_arborescence_is_the_best_of_all_explanations() {
    let mut draw = Draw::new(5);
    for round in 0..600 {
        let forests = random(&mut draw, 5, 1.0);
        // Every second time whole numbers, so that many explanations tie.
        let mut score = || if round % 2 == 0 { draw.within(-3.0, 3.0) } else { draw.below(4) as f64 - 1.0 };
        let bridges: Vec<f64> = forests.edges().iter().map(|_| score()).collect();
        let roots: Vec<f64> = forests.log_roots().iter().map(|_| score()).collect();
        let got = arborescence(&forests, &bridges, &roots);
        let (value, rows) = Listed::new(&forests).figure(&got, &bridges, &roots).expect("no cycle");
        let (best, least) = Listed::new(&forests).best(&bridges, &roots);
        assert!((value - best).abs() < 1e-12, "{value} for {best}");
        assert_eq!(rows, least);
    }
}

#[test]
fn what_is_no_problem_is_refused_by_name() {
    let bridge = |child, parent, log_weight| Edge { child, parent, log_weight };
    let refused = |roots: &[f64], bridges: &[Edge]| Forests::new(roots.to_vec(), bridges.to_vec()).unwrap_err().to_string();
    assert_eq!(refused(&[0.0, f64::NAN], &[]), "log weight of root 1 NaN: a number from -100 to 100");
    assert_eq!(refused(&[f64::NEG_INFINITY], &[]), "log weight of root 0 -inf: a number from -100 to 100");
    assert_eq!(refused(&[0.0; 2], &[bridge(0, 1, 100.5)]), "log weight of edge 0 100.5: a number from -100 to 100, or -inf");
    assert_eq!(refused(&[0.0; 2], &[bridge(1, 1, 0.0)]), "ends of edge 0 1, 1: two different fragments below 2");
    assert_eq!(
        refused(&[0.0; 2], &[bridge(0, 1, 0.0), bridge(0, 2, 0.0)]),
        "ends of edge 1 0, 2: two different fragments below 2"
    );
}

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
        let mut whole = AbsorbingWalk::new(nodes);
        whole.death = (0..nodes).map(|node| 0.01 + 1e-3 * node as f64).collect();
        for (from, to, odds) in &links {
            whole.add(*from, *to, *odds);
        }
        let mut own: Vec<AbsorbingWalk> = cliques.iter().map(|clique| AbsorbingWalk::new(clique.nodes.len())).collect();
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
