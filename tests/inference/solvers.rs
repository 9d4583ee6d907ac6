//! The fast kernels (star-mesh lanes, conjugate gradients, on full and on reduced graphs) against the paper's loop as it is written.

use crate::draw::Draw;
use crate::networks;
use crate::networks::{radii, random_conditions, random_network, run};
use crate::vessels;
use proptest::prelude::*;
use std::path::Path;
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::io::{Content, ReadOptions, read};
use willis::internals::sampling::{Likelihood, SamplingOptions, Solver, Uncertain, Weight, infer};

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
        weight in prop::sample::select(Weight::ALL.to_vec()),
        uncertain in prop::sample::select(Uncertain::ALL.to_vec()),
        epsilon in 0.05..0.9_f64,
        one_radius in any::<bool>(),
    ) {
        let mut draw = Draw::new(seed);
        let nodes = 5 + draw.below(30);
        let radius = if one_radius { radii(1.0, 1.0) } else { radii(0.3, 2.0) };
        let mut network = random_network(&mut draw, nodes, 2 * nodes, radius);
        network.add_vessel([1, 1], vessels::tube(10.0, 1.0));
        network.vessel_mut(draw.below(nodes)).certain = true;
        let conditions = random_conditions(&mut draw, nodes);
        let of = |solver| {
            run(&network, &conditions, &SamplingOptions { solver, seed, weight, uncertain, epsilon, samples: 150, ..SamplingOptions::default() })
        };
        let reference = of(Solver::Reference);
        for solver in [Solver::Auto, Solver::Lanes, Solver::Gradients] {
            let fast = of(solver);
            agree(&format!("{solver:?}"), &reference, &fast);
            let (a, b) = (reference.network_resilience, fast.network_resilience);
            prop_assert!((a - b).abs() <= 1e-9 * a, "{solver:?}: {a} and {b}");
        }
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
