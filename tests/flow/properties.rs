//! Properties of vessels, candidates, flow and forests on networks that proptest draws and shrinks. Truth is an invariant of the textbook, or petgraph.

use std::collections::BTreeSet;

use crate::networks::{MMHG, VISCOSITY, boundary};
use crate::vessels::{network, tube};
use petgraph::algo::min_spanning_tree;
use petgraph::data::Element;
use petgraph::graph::UnGraph;
use proptest::collection::vec;
use proptest::prelude::*;
use willis::internals::candidates::{Attach, CandidateOptions as Rules, build};
use willis::internals::flow::pressures::pressures;
use willis::internals::flow::{Boundary, Circuit};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::{Condition, Network, Origin, RadiusRule, contract};
use willis::internals::sampling::{Coins, Kruskal, SamplingOptions, Solver, Uncertain, infer};
use willis::internals::support::geometry::{Point, distance};

/// A random tree of points in a box of 20 mm, each linked to an earlier one, with radii, m; and further links.
fn points() -> impl Strategy<Value = (Vec<(Point, f64)>, Vec<[u32; 2]>)> {
    let coordinate = || (-1e-2..1e-2_f64).prop_map(|x| (x * 1e7).round() / 1e7);
    let point = ([coordinate(), coordinate(), coordinate()], 2e-4..2e-3_f64);
    (vec(point, 3..40), vec((any::<u32>(), any::<u32>()), 0..6), vec(any::<u32>(), 40)).prop_map(|(points, more, parents)| {
        let n = points.len() as u32;
        let tree = (1..n).map(|child| [parents[child as usize] % child, child]);
        let more = more.into_iter().map(|(a, b)| [a % n, b % n]);
        let mut links: Vec<[u32; 2]> = Vec::new();
        for [a, b] in tree.chain(more) {
            if a != b && !links.iter().any(|link| *link == [a, b] || *link == [b, a]) {
                links.push([a, b]);
            }
        }
        (points, links)
    })
}

fn lines(points: &[(Point, f64)], links: &[[u32; 2]]) -> Centerlines {
    let mut lines = Centerlines::default();
    for (row, (position, radius)) in points.iter().enumerate() {
        lines.add_point(*position, *radius, row as u64, 0);
    }
    for link in links {
        lines.add_link(*link, "");
    }
    lines
}

fn near(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs())
}

/// A connected network of vessels between rows of nodes: radii of a few sizes, so that there are ties.
fn vessels() -> impl Strategy<Value = Network> {
    let size = (1..40_u32, 2..6_u32);
    (3..16_usize, vec((any::<usize>(), any::<usize>(), size), 2..30)).prop_map(|(nodes, drawn)| {
        let drawn: Vec<_> = drawn.into_iter().chain(std::iter::repeat_n((0, 0, (7, 3)), nodes)).collect();
        let pairs = drawn.iter().enumerate().filter_map(|(row, (a, b, (length, radius)))| {
            let pair = if row + 1 < nodes { [a % (row + 1), row + 1] } else { [a % nodes, b % nodes] };
            (pair[0] != pair[1]).then(|| (pair, tube(f64::from(*length), f64::from(*radius) * 0.2)))
        });
        network(nodes, pairs.collect::<Vec<_>>())
    })
}

fn solved(network: &Network, conditions: &[(usize, Condition)], open: impl Fn(usize) -> bool) -> Vec<Option<f64>> {
    let circuit = Circuit::new(network, &boundary(network, conditions), VISCOSITY).unwrap();
    pressures(&circuit, open).unwrap()
}

/// The pressure at `to` over a node on the ground when a flow of 1e-6 m³/s enters at `from`.
fn transfer(network: &Network, ground: usize, from: usize, to: usize, open: impl Fn(usize) -> bool) -> f64 {
    let conditions = [(ground, Condition::Pressure(0.0)), (from, Condition::Flow(1e-6))];
    solved(network, &conditions, open)[to].unwrap()
}

/// The fragments that the pieces make: polylines of their own, nowhere near to one another's points.
fn fragments() -> impl Strategy<Value = Vec<Vec<(Point, f64)>>> {
    let step = || -8e-4..8e-4_f64;
    let start = || -8e-3..8e-3_f64;
    let piece = ([start(), start(), start()], vec([1e-4..8e-4, step(), step()], 3..12), 3e-4..1.5e-3_f64);
    vec(piece, 2..7).prop_map(|pieces| {
        let along = |(start, steps, radius): (Point, Vec<Point>, f64)| {
            let mut at = start;
            let mut line = vec![(at, radius)];
            for (n, step) in steps.into_iter().enumerate() {
                at = [0, 1, 2].map(|axis| at[axis] + step[axis]);
                line.push((at, radius * (1.0 + 0.01 * n as f64)));
            }
            line
        };
        pieces.into_iter().map(along).collect()
    })
}

fn observed(fragments: &[Vec<(Point, f64)>]) -> Network {
    let mut lines = Centerlines::default();
    for (strand, line) in fragments.iter().enumerate() {
        for (n, (position, radius)) in line.iter().enumerate() {
            let row = lines.add_point(*position, *radius, lines.points.len() as u64, strand as u32);
            if n > 0 {
                lines.add_link([row - 1, row], "");
            }
        }
    }
    contract(&lines, RadiusRule::Mean, None).unwrap().network
}

/// The places that candidates join, in tenths of micrometres.
fn joined(graph: &Network, turn: impl Fn(Point) -> Point) -> BTreeSet<[[i64; 3]; 2]> {
    let place = |node: usize| turn(graph.node(node).position.unwrap()).map(|x| (x * 1e7).round() as i64);
    let candidates = graph.vessels().filter(|(_, vessel)| vessel.origin == Origin::Candidate);
    candidates.map(|([a, b], _)| [place(a).min(place(b)), place(a).max(place(b))]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    /// Nodes are the points without exactly two links, one more for each ring without such a point; the length of all vessels
    /// is that of all links, and each link is part of one vessel.
    #[test]
    fn contraction_keeps_every_length((points, links) in points()) {
        let lines = lines(&points, &links);
        let made = contract(&lines, RadiusRule::Mean, None);
        let length = |[a, b]: &[u32; 2]| distance(points[*a as usize].0, points[*b as usize].0);
        prop_assume!(links.iter().all(|link| length(link) > 0.0));
        let network = made.unwrap().network;
        let mut degree = vec![0; points.len()];
        links.iter().flatten().for_each(|end| degree[*end as usize] += 1);
        // The points are linked as a tree and more: only a cycle of all of them has no node.
        prop_assert_eq!(network.node_count(), degree.iter().filter(|d| **d != 2).count().max(1));
        let total: f64 = network.vessels().map(|(_, vessel)| vessel.length).sum();
        prop_assert!(near(total, links.iter().map(length).sum(), 1e-12));
        prop_assert_eq!(network.vessels().map(|(_, vessel)| vessel.path.len() - 1).sum::<usize>(), links.len());
    }

    /// The effective radius keeps the resistance of the tapering vessel, R = Σ 8µ/π ∫ dz/r⁴; of a cone from p to q over l that is
    /// l (p² + pq + q²)/(3 p³q³). A point more on a link's way, where the cone has it, changes no vessel.
    #[test]
    fn contraction_keeps_every_resistance((points, links) in points(), at in any::<usize>(), share in 0.1..0.9_f64) {
        let length = |[a, b]: &[u32; 2]| distance(points[*a as usize].0, points[*b as usize].0);
        prop_assume!(links.iter().all(|link| length(link) > 1e-6));
        let network = contract(&lines(&points, &links), RadiusRule::Effective, None).unwrap().network;
        for (_, vessel) in network.vessels() {
            let of_path: f64 = vessel.path.windows(2).map(|pair| {
                let (p, q) = (pair[0].radius, pair[1].radius);
                distance(pair[0].position, pair[1].position) * (p * p + p * q + q * q) / (3.0 * p.powi(3) * q.powi(3))
            }).sum();
            prop_assert!(near(vessel.length / vessel.radius.powi(4), of_path, 1e-12));
        }
        let [a, b] = links[at % links.len()];
        let ((p, r), (q, s)) = (points[a as usize], points[b as usize]);
        let (mut more, mut cut) = (points.clone(), links.clone());
        more.push(([0, 1, 2].map(|axis| p[axis] + share * (q[axis] - p[axis])), r + share * (s - r)));
        cut[at % links.len()] = [a, points.len() as u32];
        cut.push([points.len() as u32, b]);
        let again = contract(&lines(&more, &cut), RadiusRule::Effective, None).unwrap().network;
        prop_assert_eq!((again.node_count(), again.vessel_count()), (network.node_count(), network.vessel_count()));
        let sizes = |network: &Network| {
            let mut sizes: Vec<[f64; 2]> = network.vessels().map(|(_, v)| [v.length, v.length / v.radius.powi(4)]).collect();
            sizes.sort_by(|a, b| a[0].total_cmp(&b[0]));
            sizes
        };
        let total = |network: &Network, of: usize| sizes(network).iter().map(|size| size[of]).sum::<f64>();
        prop_assert!(near(total(&network, 0), total(&again, 0), 1e-9) && near(total(&network, 1), total(&again, 1), 1e-9));
    }

    /// Space has no axes: turned by quarters and mirrored, every candidate is where it was. Squares are summed in another order, so
    /// that only distances apart by more than rounding count, as those drawn are.
    #[test]
    fn candidates_turn_with_the_fragments(fragments in fragments(), axes in Just([0, 1, 2]).prop_shuffle(), mirror in 0..8_u8, k in 1..5_usize) {
        let sign = |axis: usize| if mirror >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let turn = |p: Point| [0, 1, 2].map(|axis| sign(axis) * p[axes[axis]]);
        let rules = Rules { k: Some(k), ..Rules::default() };
        let turned: Vec<Vec<_>> = fragments.iter().map(|line| line.iter().map(|(p, r)| (turn(*p), *r)).collect()).collect();
        let [one, other] = [&fragments, &turned].map(|fragments| build(&observed(fragments), &rules).unwrap());
        prop_assert_eq!(joined(&one, turn), joined(&other, |p| p));
    }

    /// Fragments in another order make the same candidates between free ends; there are at most k for each, and none between the two
    /// ends of one fragment.
    #[test]
    fn candidates_do_not_go_by_the_order_of_fragments(fragments in fragments(), k in 1..5_usize) {
        let rules = Rules { k: Some(k), attach: Attach::Ends, ..Rules::default() };
        let reversed: Vec<_> = fragments.iter().rev().cloned().collect();
        let graph = build(&observed(&fragments), &rules).unwrap();
        prop_assert_eq!(joined(&graph, |p| p), joined(&build(&observed(&reversed), &rules).unwrap(), |p| p));
        let candidates = graph.vessel_count() - fragments.len();
        prop_assert!(candidates <= k * 2 * fragments.len());
        for ([a, b], _) in graph.vessels().skip(fragments.len()) {
            let own = |row: usize| graph.ends(row) == [a, b] || graph.ends(row) == [b, a];
            prop_assert!(!(0..fragments.len()).any(own));
        }
    }

    /// Reciprocity: what flow at a makes of the pressure at b, flow at b makes of the pressure at a (Maxwell). And Rayleigh's
    /// monotonicity: closing a vessel never makes a way wider.
    #[test]
    fn flow_is_reciprocal_and_monotone(network in vessels(), at in any::<[usize; 3]>(), closed in any::<usize>()) {
        let [ground, a, b] = at.map(|node| node % network.node_count());
        prop_assume!(a != ground && b != ground);
        let [there, back] = [(a, b), (b, a)].map(|(from, to)| transfer(&network, ground, from, to, |_| true));
        prop_assert!(near(there, back, 1e-10), "{} {}", there, back);
        let closed = closed % network.vessel_count();
        let open = |row: usize| row != closed;
        let conditions = [(ground, Condition::Pressure(0.0)), (a, Condition::Flow(1e-6))];
        if let Some(narrower) = reached(&network, ground, a, closed).then(|| solved(&network, &conditions, open)[a].unwrap()) {
            prop_assert!(narrower >= transfer(&network, ground, a, a, |_| true) * (1.0 - 1e-10));
        }
    }

    /// Every vessel twice as long: half the conductance, the same pressures between fixed ones, twice those of a flow. Powers of two
    /// are exact, so to the last bit.
    #[test]
    fn flow_scales_with_the_conductances(network in vessels(), at in any::<[usize; 2]>()) {
        let [a, b] = at.map(|node| node % network.node_count());
        prop_assume!(a != b);
        let mut long = network.clone();
        (0..long.vessel_count()).for_each(|row| long.vessel_mut(row).length *= 2.0);
        let fixed = [(a, Condition::Pressure(100.0 * MMHG)), (b, Condition::Pressure(0.0))];
        prop_assert_eq!(solved(&network, &fixed, |_| true), solved(&long, &fixed, |_| true));
        let [short, long] = [&network, &long].map(|network| transfer(network, b, a, a, |_| true));
        prop_assert_eq!((2.0 * short).to_bits(), long.to_bits());
    }

    /// The solvers are three algorithms for one answer: votes exactly, ties among them, and likelihoods to 1e-9. An edge that hardly
    /// carries blood is known to the rounding of the edge that carries most: its flow is a difference of large pressures.
    #[test]
    fn solvers_agree(network in vessels(), at in any::<[usize; 2]>(), seed in any::<u64>()) {
        let [a, b] = at.map(|node| node % network.node_count());
        prop_assume!(a != b);
        let conditions = [(a, Condition::Pressure(100.0 * MMHG)), (b, Condition::Pressure(0.0))];
        let boundary: Boundary = boundary(&network, &conditions);
        let run = |solver| {
            let params = SamplingOptions { seed, solver, samples: 64, uncertain: Uncertain::All, ..SamplingOptions::default() };
            infer(&network, &boundary, &params, &mut |_, _| true).unwrap().0
        };
        let lanes = run(Solver::Lanes);
        for other in [run(Solver::Gradients), run(Solver::Reference)] {
            prop_assert_eq!(&lanes.frequency, &other.frequency);
            let rounding = 1e-15 * lanes.likelihood.iter().copied().fold(0.0, f64::max);
            let pairs = || lanes.likelihood.iter().zip(&other.likelihood);
            prop_assert!(pairs().all(|(a, b)| near(*a, *b, 1e-9) || (a - b).abs() <= rounding));
        }
    }

    /// The forest is petgraph's minimum spanning forest of the order of resilience, then coin; under ties too, for then the order
    /// still has no two alike.
    #[test]
    fn the_forest_is_that_of_petgraph(nodes in 2..20_usize, drawn in vec((any::<usize>(), any::<usize>(), 1..5_u32), 1..50)) {
        let ends: Vec<[usize; 2]> = drawn.iter().map(|(a, b, _)| [a % nodes, b % nodes]).collect();
        let mut order: Vec<usize> = (0..ends.len()).collect();
        let coins = Coins::new(drawn.len(), 0);
        let coin = coins.of_block(0)[nodes];
        order.sort_by_key(|row| (std::cmp::Reverse((drawn[*row].2, coins.toss(coins.of_vessel(*row), coin))), *row));
        let mut graph = UnGraph::<(), usize>::new_undirected();
        let at: Vec<_> = (0..nodes).map(|_| graph.add_node(())).collect();
        order.iter().enumerate().for_each(|(place, row)| {
            graph.add_edge(at[ends[*row][0]], at[ends[*row][1]], place);
        });
        let expected: BTreeSet<usize> = min_spanning_tree(&graph)
            .filter_map(|element| if let Element::Edge { weight, .. } = element { Some(order[weight]) } else { None })
            .collect();
        let mut forest = Kruskal::default();
        forest.clear();
        drawn.iter().enumerate().for_each(|(row, (_, _, resilience))| forest.add(coins.key(f64::from(*resilience), row, coin)));
        let mut taken = Vec::new();
        forest.grow(nodes, &ends, |key| coins.vessel(key), |row| taken.push(row));
        prop_assert!(taken.windows(2).all(|pair| drawn[pair[0]].2 >= drawn[pair[1]].2));
        prop_assert_eq!(taken.into_iter().collect::<BTreeSet<_>>(), expected);
    }
}

/// Whether a way without one vessel leads from a node to another.
fn reached(network: &Network, from: usize, to: usize, closed: usize) -> bool {
    let (mut seen, mut open) = (vec![false; network.node_count()], vec![from]);
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut seen[node], true) {
            let rows = (0..network.vessel_count()).filter(|row| *row != closed).map(|row| network.ends(row));
            open.extend(rows.filter(|ends| ends.contains(&node)).flatten());
        }
    }
    seen[to]
}
