//! The fast kernels (star-mesh lanes, conjugate gradients, on full and on reduced graphs) against the paper's loop as it is written.

use crate::draw::Draw;
use crate::networks;
use crate::networks::{radii, random_conditions, random_network, run};
use crate::vessels;
use proptest::prelude::*;
use std::path::Path;
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::formats::{Content, ReadOptions, read};
use willis::internals::sampling::{Likelihood, SamplingOptions, Solver, Uncertain, Weight, infer};
use willis::internals::support::elimination::graph::{BitMatrix, Lists};
use willis::internals::support::elimination::order::{MOST_IN_BITS, Star, by_degree, least_degree, least_fill};

/// 1e-9 of L: a thousand samples of a few hundred roundings each leave 1e-12 or so. What a factorisation keeps of a drop that
/// is itself 1e-8 of the pressure is less: 1e-15 of the largest L, for ρ is a drop squared.
pub fn agree(name: &str, a: &Likelihood, b: &Likelihood) {
    assert_eq!((&a.frequency, a.perfused), (&b.frequency, b.perfused), "{name}");
    let largest = a.likelihood.iter().copied().fold(0.0, f64::max);
    for (row, (x, y)) in a.likelihood.iter().zip(&b.likelihood).enumerate() {
        assert!((x - y).abs() <= 1e-9 * x.max(*y) + 1e-15 * largest, "{name}, vessel {row}: {x} and {y}");
    }
}

#[test]
fn on_two_hundred_random_graphs() {
    for seed in 0..200 {
        let mut draw = Draw::new(5000 + seed);
        let nodes = 5 + draw.below(40);
        let vessels = nodes + draw.below(nodes);
        let network = random_network(&mut draw, nodes, vessels, radii(0.3, 2.0));
        let conditions = random_conditions(&mut draw, nodes);
        let of = |solver| {
            let params = SamplingOptions {
                solver,
                seed,
                samples: 200,
                uncertain: Uncertain::All,
                epsilon: 0.3,
                ..SamplingOptions::default()
            };
            run(&network, &conditions, &params)
        };
        let lanes = of(Solver::Lanes);
        agree(&format!("graph {seed}"), &lanes, &of(Solver::Reference));
        agree(&format!("graph {seed}"), &lanes, &of(Solver::Gradients));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Networks with terminal resistances and injected flows, parallel vessels, a self-loop and a certain one, under every weight and
    /// occlusion of both kinds.
    #[test]
    fn the_kernels_find_what_the_paper_says(
        seed in 0_u64..1 << 40,
        weight in prop::sample::select(vec![Weight::Resilience, Weight::Count, Weight::Global]),
        uncertain in prop::sample::select(vec![Uncertain::Candidates, Uncertain::All]),
        epsilon in 0.05..0.9_f64,
        one_radius in any::<bool>(),
    ) {
        kernels_agree(seed, weight, uncertain, epsilon, one_radius);
    }
}

/// The drops along two equal vessels in series have eight right digits here; a coin says which of the two a forest leaves out.
#[test]
fn equal_vessels_in_series_tie_where_pressures_have_few_digits() {
    kernels_agree(854_634_542_677, Weight::Resilience, Uncertain::Candidates, 0.05, true);
}

fn kernels_agree(seed: u64, weight: Weight, uncertain: Uncertain, epsilon: f64, one_radius: bool) {
    let mut draw = Draw::new(seed);
    let nodes = 5 + draw.below(30);
    let radius = if one_radius { radii(1.0, 1.0) } else { radii(0.3, 2.0) };
    let mut network = random_network(&mut draw, nodes, 2 * nodes, radius);
    network.add_vessel([1, 1], vessels::tube(10.0, 1.0));
    network.vessel_mut(draw.below(nodes)).certain = true;
    let conditions = random_conditions(&mut draw, nodes);
    let of = |solver| {
        run(
            &network,
            &conditions,
            &SamplingOptions { solver, seed, weight, uncertain, epsilon, samples: 150, ..SamplingOptions::default() },
        )
    };
    let reference = of(Solver::Reference);
    for solver in [Solver::Auto, Solver::Lanes, Solver::Gradients] {
        let fast = of(solver);
        agree(&format!("{solver:?}"), &reference, &fast);
        let (a, b) = (reference.network_resilience, fast.network_resilience);
        assert!((a - b).abs() <= 1e-9 * a, "{solver:?}: {a} and {b}");
    }
}

/// Of so many vessels a node that elimination leaves a core for conjugate gradients.
#[test]
fn on_dense_random_graphs() {
    for seed in 0..20 {
        let mut draw = Draw::new(7000 + seed);
        let nodes = 60 + draw.below(60);
        let network = random_network(&mut draw, nodes, 8 * nodes, radii(0.3, 2.0));
        let conditions = random_conditions(&mut draw, nodes);
        let of = |solver| {
            let params = SamplingOptions {
                solver,
                seed,
                samples: 100,
                uncertain: Uncertain::All,
                epsilon: 0.2,
                ..SamplingOptions::default()
            };
            run(&network, &conditions, &params)
        };
        agree(&format!("graph {seed}"), &of(Solver::Lanes), &of(Solver::Gradients));
    }
}

#[test]
fn on_the_benchmark_graphs() {
    for name in ["cow-30-80", "extraction-45-165", "brain-206-726", "brain-206-726-13-terminals"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bench").join(name).with_extension("graphml");
        if !path.exists() {
            eprintln!("skipped: no {}", path.display());
            continue;
        }
        let Content::Graph(network) = read(&path, &ReadOptions::default()).expect("read").content else { panic!("a graph") };
        let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground).expect("conditions");
        let of = |solver| {
            let params =
                SamplingOptions { solver, samples: 2000, uncertain: Uncertain::All, epsilon: 0.3, ..SamplingOptions::default() };
            infer(&network, &boundary, &params, &mut |_: u64, _: u64| true).expect("sampled").0
        };
        let lanes = of(Solver::Lanes);
        agree(name, &lanes, &of(Solver::Reference));
        agree(name, &lanes, &of(Solver::Gradients));
    }
}

/// A weak link that costs a factorisation all its digits is refused, not solved wrongly.
#[test]
fn a_span_of_conductances_beyond_a_factorisation_is_refused() {
    let tube = vessels::tube;
    let weak = vessels::network(
        5,
        [([0, 1], tube(10.0, 1.0)), ([1, 2], tube(10.0, 1e-4)), ([2, 3], tube(10.0, 1.0)), ([2, 4], tube(10.0, 1.0))],
    );
    let conditions = [(0, networks::pressure(100.0)), (3, networks::pressure(0.0)), (4, networks::pressure(10.0))];
    let boundary = networks::boundary(&weak, &conditions);
    let of = |solver| {
        let params = SamplingOptions { solver, uncertain: Uncertain::All, ..SamplingOptions::default() };
        infer(&weak, &boundary, &params, &mut |_: u64, _: u64| true)
    };
    let refused = of(Solver::Reference).expect_err("sixteen orders").to_string();
    assert!(refused.contains("`solver`: lanes"), "{refused}");
    assert!(of(Solver::Lanes).is_ok());
}

/// A 4 x 4 grid.
fn grid() -> Vec<[usize; 2]> {
    let right = (0..16).filter(|i| i % 4 < 3).map(|i| [i, i + 1]);
    right.chain((0..12).map(|i| [i, i + 4])).collect()
}

#[test]
fn both_orders_eliminate_every_node_once_and_join_neighbours() {
    for stars in [least_degree(16, &grid(), usize::MAX), least_fill(16, &grid(), 60_000)] {
        let stars = stars.expect("below the limit");
        let mut seen: Vec<usize> = stars.iter().map(|s| s.center).collect();
        let place: Vec<usize> = (0..16).map(|n| seen.iter().position(|s| *s == n).expect("each node")).collect();
        for star in &stars {
            assert!(star.neighbours.iter().all(|n| place[*n] > place[star.center]));
            let first = star.neighbours.iter().min_by_key(|n| place[**n]);
            let later = |n: &&usize| Some(*n) != first;
            assert!(first.is_none_or(|f| star.neighbours.iter().filter(later).all(|n| stars[place[*f]].neighbours.contains(n))));
        }
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..16));
    }
}

/// By hand: a ring of four with a tail. The tail goes first, then the ring is closed by the edge 1-3.
#[test]
fn the_order_and_the_fill_of_a_ring_with_a_tail() {
    let stars = least_degree(5, &[[0, 1], [1, 2], [2, 3], [3, 0], [2, 4], [4, 2]], 2);
    let star = |center, neighbours: &[usize]| Star { center, neighbours: neighbours.to_vec() };
    assert_eq!(stars, Some(vec![star(4, &[2]), star(0, &[1, 3]), star(1, &[2, 3]), star(2, &[3]), star(3, &[])]));
    assert_eq!(least_degree(5, &[[0, 1], [1, 2], [2, 3], [3, 0], [2, 4], [4, 2]], 1), None);
}

#[test]
fn bits_and_lists_give_the_same_order() {
    let links: Vec<[usize; 2]> = (0..300).flat_map(|i| [[i, (i + 1) % 300], [i, (i * i + 7) % 300]]).collect();
    let stars = by_degree(300, &mut BitMatrix::new(300, &links), usize::MAX, usize::MAX).expect("no limit");
    assert!(stars.len() == 300 && stars[0].neighbours.len() < 10);
    assert_eq!(Some(stars), by_degree(300, &mut Lists::new(300, &links), usize::MAX, usize::MAX));
}

/// A cube of 26³ places, each beside up to six others: more than are bits, with a dense rest.
#[test]
fn a_large_graph_is_eliminated_in_the_same_order_as_lists() {
    const SIDE: usize = 26;
    const NODES: usize = SIDE * SIDE * SIDE;
    let steps = [1, SIDE, SIDE * SIDE];
    let next = |i: usize, step: usize| (i / step % SIDE + 1 < SIDE).then_some([i, i + step]);
    let links: Vec<[usize; 2]> = (0..NODES).flat_map(|i| steps.map(|step| next(i, step))).flatten().collect();
    let whole = by_degree(NODES, &mut BitMatrix::new(NODES, &links), usize::MAX, usize::MAX).expect("no limit");
    let lists = least_degree(NODES, &links, usize::MAX).expect("no limit");
    assert!(NODES > MOST_IN_BITS && whole.iter().any(|star| star.neighbours.len() > 320));
    assert!(whole == lists);
    let pairs: usize = whole.iter().map(Star::pairs).sum();
    assert!(least_degree(NODES, &links, pairs).is_some() && least_degree(NODES, &links, pairs - 1).is_none());
}

#[test]
fn a_limit_ends_the_search_for_an_order() {
    assert_eq!(least_degree(16, &grid(), 10), None);
    assert_eq!(least_degree(3, &[[0, 1], [1, 2], [2, 2]], 0).map(|s| s.len()), Some(3));
}
