//! Large graphs: three solvers with nothing in common find the same forests, edge for edge, on graphs reduced first, and as graphs of the
//! same kind that are not reduced do.

use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::network::Network;
use willis::internals::phantom::{Anatomy, Recipe, over_connected};
use willis::internals::sampling::{Likelihood, Method, SamplingOptions, Solver, Uncertain, infer};

const KINDS: [Anatomy; 2] = [Anatomy::Arterial, Anatomy::Capillary];
/// With more vessels than this a graph is reduced for every solver.
const REDUCED_ABOVE: usize = 4096;

fn broken(kind: Anatomy, edges: usize, seed: u64) -> Network {
    let recipe = Recipe { edges: Some(edges), seed, spacing: None };
    let whole = kind.network(&recipe).expect("a phantom");
    over_connected(whole, &kind.gaps(&recipe).expect("gaps"), 6).expect("broken").0
}

fn sampled(network: &Network, solver: Solver, uncertain: Uncertain, samples: u64) -> (Likelihood, Method) {
    let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground).expect("conditions");
    let params = SamplingOptions { epsilon: 0.75, samples, solver, uncertain, ..SamplingOptions::default() };
    infer(network, &boundary, &params, &mut |_: u64, _: u64| true).expect("sampled")
}

/// 1e-7 of L: what iteration to 1e-13 of the energy leaves of the smallest flows.
fn agree(name: &str, a: &Likelihood, b: &Likelihood) {
    let differ = a.frequency.iter().zip(&b.frequency).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "{name}: forests");
    let largest = a.likelihood.iter().copied().fold(0.0, f64::max);
    for (row, (x, y)) in a.likelihood.iter().zip(&b.likelihood).enumerate() {
        assert!((x - y).abs() <= 1e-7 * x.max(*y) + 1e-15 * largest, "{name}, vessel {row}: {x} and {y}");
    }
}

fn solvers_agree(kind: Anatomy, edges: usize, seed: u64) {
    let network = broken(kind, edges, seed);
    assert!(network.vessel_count() > REDUCED_ABOVE);
    let name = format!("{kind} of {edges}, seed {seed}");
    let (gradients, method) = sampled(&network, Solver::Gradients, Uncertain::Candidates, 64);
    assert!(method.solver == "gradients" && gradients.residual < 1e-11, "{name}: {method:?}, {}", gradients.residual);
    agree(&name, &gradients, &sampled(&network, Solver::Reference, Uncertain::Candidates, 64).0);
    // Elimination of a large mesh fills in.
    if kind == Anatomy::Arterial || edges <= 10_000 {
        agree(&name, &gradients, &sampled(&network, Solver::Lanes, Uncertain::Candidates, 64).0);
    }
}

/// Lanes take a graph of so few vessels as it is.
#[test]
fn reduced_and_whole_graphs_have_the_same_forests() {
    for kind in KINDS {
        for (seed, uncertain) in [(0, Uncertain::Candidates), (1, Uncertain::Candidates), (2, Uncertain::All)] {
            let network = broken(kind, 2500, seed);
            assert!(network.vessel_count() < REDUCED_ABOVE);
            let (whole, _) = sampled(&network, Solver::Lanes, uncertain, 128);
            for solver in [Solver::Gradients, Solver::Reference] {
                agree(&format!("{kind}, seed {seed}, {solver:?}"), &whole, &sampled(&network, solver, uncertain, 128).0);
            }
        }
    }
}

/// Two of each kind; WILLIS_MANY=1 asks for 25 of 10,000 edges and of 100,000 edges three trees and two meshes.
#[test]
fn all_solvers_find_the_same_forests() {
    let many = std::env::var_os("WILLIS_MANY").is_some();
    for kind in KINDS {
        (0..if many { 25 } else { 2 }).for_each(|seed| solvers_agree(kind, 10_000, seed));
        if many {
            (0..if kind == Anatomy::Arterial { 3 } else { 2 }).for_each(|seed| solvers_agree(kind, 100_000, seed));
        }
    }
}
