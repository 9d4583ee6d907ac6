//! The answer by brute force: every subgraph of a small network, dense elimination, every spanning forest (exact.rs).

use crate::draw::Draw;
use crate::exact::{enumerate, keep};
use crate::networks::{log_radii, radii, random_conditions, random_network, run};
use crate::textbook::{Sample, kruskal};
use crate::vessels;
use willis::internals::network::{Condition, Network};
use willis::internals::perturbation::Occlusion;
use willis::internals::sampling::{SamplingOptions, Solver, Uncertain, Weight};

const SAMPLES: u64 = 20_000;

/// 6 or 7 nodes, 9 to 11 vessels; every kind of condition; one vessel never occluded, one a self-loop in every third.
fn small(seed: u64) -> (Network, Vec<(usize, Condition)>) {
    let mut draw = Draw::new(seed);
    let (nodes, vessels) = (6 + draw.below(2), 9 + draw.below(3));
    let mut network = random_network(&mut draw, nodes, vessels - usize::from(seed.is_multiple_of(3)), radii(0.3, 2.0));
    if seed.is_multiple_of(3) {
        let node = draw.below(nodes);
        network.add_vessel([node, node], vessels::tube(10.0, 1.0));
    }
    network.vessel_mut(draw.below(vessels)).certain = true;
    let conditions = random_conditions(&mut draw, nodes);
    (network, conditions)
}

/// How many of its standard errors a mean over the samples is off. Where a figure cannot vary (variance below rounding)
/// 1e-9 of it counts as one: what sums of 20,000 equal terms keep to with room to spare.
fn z(mean: f64, expected: f64, variance: f64) -> f64 {
    let rounding = 1e-9 * expected.abs();
    let error = (variance.max(0.0) / SAMPLES as f64).sqrt().max(rounding).max(f64::MIN_POSITIVE);
    (mean - expected).abs() / error
}

/// Five standard errors: one figure in two million is further off; about 3,000 are compared, at fixed seeds.
#[test]
fn every_figure_is_within_five_standard_errors_of_enumeration() {
    let mut worst = 0.0_f64;
    for seed in 0..12 {
        let (network, conditions) = small(seed);
        for uncertain in [Uncertain::All, Uncertain::Candidates] {
            let epsilon = [0.5, 0.3, 0.2][seed as usize % 3];
            let exact = enumerate(&network, &conditions, &keep(&network, epsilon, uncertain));
            for weight in [Weight::Resilience, Weight::Count, Weight::Global] {
                for solver in [Solver::Lanes, Solver::Gradients, Solver::Reference] {
                    let params = SamplingOptions {
                        epsilon,
                        samples: SAMPLES,
                        seed,
                        uncertain,
                        weight,
                        solver,
                        ..SamplingOptions::default()
                    };
                    let result = run(&network, &conditions, &params);
                    let moments = exact.moments(weight);
                    let mut check = |what: &str, row: usize, got: f64, expected: f64, variance: f64| {
                        let z = z(got, expected, variance);
                        worst = worst.max(z);
                        assert!(z < 5.0, "graph {seed}, {params:?}: {what} {row}: {got}, exactly {expected}: z = {z}");
                    };
                    for row in 0..network.vessel_count() {
                        let f = exact.frequency[row];
                        check("L", row, result.likelihood[row] / SAMPLES as f64, moments.mean[row], moments.variance[row]);
                        check("frequency", row, result.frequency[row], f, f * (1.0 - f));
                    }
                    let [mean, variance] = exact.network_resilience;
                    check("resilience of the network", 0, result.network_resilience, mean, variance);
                }
            }
        }
    }
    println!("worst |z|: {worst:.2}");
}

/// The standard error is the square root of n Var; it is itself off by about sqrt(kurtosis / 4n), here under 10 %. Where
/// nothing varies, the difference of two sums of squares leaves sqrt(2^-52) of L at the most.
#[test]
fn the_standard_error_is_that_of_enumeration() {
    for seed in 0..12 {
        let (network, conditions) = small(seed);
        let params = SamplingOptions { samples: SAMPLES, seed, uncertain: Uncertain::All, ..SamplingOptions::default() };
        let exact = enumerate(&network, &conditions, &keep(&network, params.epsilon, params.uncertain));
        let result = run(&network, &conditions, &params);
        let moments = exact.moments(Weight::Resilience);
        for row in (0..network.vessel_count()).filter(|row| exact.frequency[*row] > 0.02) {
            let expected = (SAMPLES as f64 * moments.variance[row].max(0.0)).sqrt();
            let off = (result.std_error[row] - expected).abs();
            assert!(
                off <= 0.1 * expected + 1.5e-8 * result.likelihood[row],
                "graph {seed}, vessel {row}: {} for {expected}",
                result.std_error[row]
            );
        }
    }
}

/// Sample by sample, without any statistics: the same masks, dense elimination and Kruskal. Radii spread so that dense
/// elimination keeps 1e-9 of ρ.
#[test]
fn every_sample_has_the_flow_and_forest_of_the_textbook() {
    for seed in 0..6 {
        let mut draw = Draw::new(100 + seed);
        let network = random_network(&mut draw, 24, 36, radii(0.3, 2.0));
        let conditions = random_conditions(&mut draw, 24);
        let samples = 200;
        let keep = keep(&network, 0.3, Uncertain::All);
        let (mut likelihood, mut count) = (vec![0.0; 36], vec![0_u32; 36]);
        let mut masks = Vec::new();
        for sample in 0..samples {
            Occlusion::new(keep.iter().copied()).draw(seed, sample / 64, &mut masks);
            let open = masks.iter().map(|mask| mask >> (sample % 64) & 1 == 1).collect();
            let diffused = Sample { network: &network, conditions: &conditions, open }.resiliences();
            for row in kruskal(&network, &diffused) {
                likelihood[row] += diffused.iter().find(|(r, _)| *r == row).unwrap().1;
                count[row] += 1;
            }
        }
        for solver in [Solver::Lanes, Solver::Gradients, Solver::Reference] {
            let params =
                SamplingOptions { epsilon: 0.3, samples, seed, uncertain: Uncertain::All, solver, ..SamplingOptions::default() };
            let result = run(&network, &conditions, &params);
            for row in 0..36 {
                let (got, expected) = (result.likelihood[row], likelihood[row]);
                assert_eq!(result.frequency[row], f64::from(count[row]) / samples as f64, "{solver:?} {seed} {row}");
                assert!((got - expected).abs() <= 1e-9 * expected, "{solver:?} {seed} {row}: {got} for {expected}");
            }
        }
    }
}

fn solvers_agree(network: &Network, conditions: &[(usize, Condition)], seed: u64) {
    let of = |solver| {
        run(network, conditions, &SamplingOptions { solver, seed, uncertain: Uncertain::All, ..SamplingOptions::default() })
    };
    let (lanes, reference) = (of(Solver::Lanes), of(Solver::Reference));
    for row in 0..network.vessel_count() {
        let (a, b) = (lanes.likelihood[row], reference.likelihood[row]);
        assert_eq!(lanes.frequency[row], reference.frequency[row], "graph {seed}, vessel {row}");
        assert!((a - b).abs() <= 1e-9 * a.abs().max(b.abs()), "graph {seed}, vessel {row}: {a} and {b}");
    }
}

/// 1e-9: the drop of a vessel keeps about (its conductance over the weakest) x 2^-53 of itself.
#[test]
fn both_solvers_agree() {
    for seed in 0..40 {
        let mut draw = Draw::new(200 + seed);
        let network = random_network(&mut draw, 20, 34, radii(0.3, 2.0));
        let conditions = random_conditions(&mut draw, 20);
        solvers_agree(&network, &conditions, seed);
    }
}

/// From capillary-like 0.05 mm to 2.5 mm: conductances over eight orders. A pressure drop along a wide vessel behind a
/// narrow one is then a small difference of large figures, for which 1e-5 of L is what a factorisation in doubles can
/// promise. Where a whole loop of such vessels has drops of 1e-11 of the pressure (elimination without subtraction still
/// has all digits there, the factorisation none), the two may take different ones: vessels of 1e-15 of the largest ρ, in
/// one sample of 10,000 at the most.
#[test]
fn both_solvers_find_the_same_forests_over_all_vessel_sizes() {
    let mut exchanged = 0.0;
    for seed in 0..60 {
        let mut draw = Draw::new(300 + seed);
        let network = random_network(&mut draw, 20, 30, log_radii(0.05, 2.5));
        let conditions = random_conditions(&mut draw, 20);
        let of = |solver| {
            run(&network, &conditions, &SamplingOptions { solver, seed, uncertain: Uncertain::All, ..SamplingOptions::default() })
        };
        let (lanes, reference) = (of(Solver::Lanes), of(Solver::Reference));
        let largest = lanes.likelihood.iter().copied().fold(0.0, f64::max);
        for row in 0..network.vessel_count() {
            let (a, b) = (lanes.likelihood[row], reference.likelihood[row]);
            assert!((a - b).abs() <= 1e-5 * a.max(b) + 1e-15 * largest, "graph {seed}, vessel {row}: {a} and {b}");
            exchanged += (lanes.frequency[row] - reference.frequency[row]).abs() / 2.0;
        }
    }
    assert!(exchanged / 60.0 <= 1e-4, "{exchanged}");
}
