//! Circuits solved by hand in the comment above each: pressures of every solver, then resilience and forest.
//!
//! Vessels are 1 mm in radius and 10 mm long per unit of resistance Ω = 8µ·10 mm/(π mm⁴); pressures in mmHg, so flows are in
//! mmHg/Ω. With one radius ρ goes as the square of the flow, and vessels in series tie.

use std::f64::consts::PI;

use crate::networks::{MMHG, VISCOSITY, boundary, pressure, run};
use crate::vessels::{network, tube};
use willis::internals::flow::batch::conductances::MaskedRows;
use willis::internals::flow::floating_components::stranded;
use willis::internals::flow::pressures::pressures;
use willis::internals::flow::{BatchSolver, Circuit};
use willis::internals::network::{Condition, Network};
use willis::internals::sampling::{Likelihood, SamplingOptions, Solver, reference};

/// Ω in Pa s/m³.
const OHM: f64 = 8.0 * VISCOSITY * 0.01 / (PI * 1e-12);

/// A network of vessels with these resistances in Ω.
fn resistors(nodes: usize, vessels: &[(usize, usize, f64)]) -> Network {
    network(nodes, vessels.iter().map(|(a, b, ohms)| ([*a, *b], tube(10.0 * ohms, 1.0))))
}

fn terminal(ohms: f64, venous: f64) -> Condition {
    Condition::Resistance { resistance: ohms * OHM, venous: venous * MMHG }
}

/// A flow in mmHg/Ω.
fn flow(q: f64) -> Condition {
    Condition::Flow(q * MMHG / OHM)
}

/// Compares the pressures (mmHg) of `steady`, of star-mesh and of Cholesky with the solution by hand. 1e-12 of 100 mmHg: a
/// hundred roundings or so, for a dozen operations.
fn check_open(network: &Network, conditions: &[(usize, Condition)], open: &[bool], by_hand: &[Option<f64>]) {
    let circuit = Circuit::new(network, &boundary(network, conditions), VISCOSITY).unwrap();
    let close = |got: f64, mmhg: f64| (got / MMHG - mmhg).abs() <= 1e-10;
    for (node, got) in pressures(&circuit, |v| open[v]).unwrap().into_iter().enumerate() {
        match (got, by_hand[node]) {
            (None, None) => {}
            (Some(got), Some(expected)) => assert!(close(got, expected), "node {node}: {} for {expected}", got / MMHG),
            other => panic!("node {node}: {other:?}"),
        }
    }
    // The solvers themselves give zero above the level where the pressure floats. All lanes but the last are closed.
    let masks: Vec<u64> = open.iter().map(|open| u64::from(*open) << 7).collect();
    let program = BatchSolver::star_mesh(&circuit, usize::MAX).unwrap();
    let mut work = program.workspace::<8>();
    let rows = MaskedRows { conductance: &circuit.conductance, masks: &masks, first: 0 };
    program.solve(willis::internals::support::simd::Scalar::new(), &rows, 0, &stranded(&circuit, &masks, 8), &mut work);
    let lanes = |node: usize| work.pressure()[program.slot(node)][7];
    let sparse = reference::pressures(&circuit, |v| open[v]).unwrap();
    for (node, expected) in by_hand.iter().enumerate() {
        for (solver, got) in [("lanes", lanes(node)), ("cholesky", sparse[node])] {
            let right = expected.map_or(got == 0.0, |mmhg| close(got + circuit.level, mmhg));
            assert!(right, "{solver}, node {node}: {} for {expected:?}", (got + circuit.level) / MMHG);
        }
    }
}

fn check(network: &Network, conditions: &[(usize, Condition)], by_hand: &[Option<f64>]) {
    check_open(network, conditions, &vec![true; network.vessel_count()], by_hand);
}

fn all(by_hand: &[f64]) -> Vec<Option<f64>> {
    by_hand.iter().copied().map(Some).collect()
}

/// The expected forest of the open network, by all solvers, which must agree.
fn whole(network: &Network, conditions: &[(usize, Condition)]) -> Likelihood {
    let exact = SamplingOptions { epsilon: 0.0, samples: 1, exact: true, ..SamplingOptions::default() };
    let of = |solver| run(network, conditions, &SamplingOptions { solver, ..exact.clone() });
    let [lanes, reference, gradients] = [Solver::Lanes, Solver::Reference, Solver::Gradients].map(of);
    assert_eq!(lanes.frequency, reference.frequency);
    assert_eq!(lanes.frequency, gradients.frequency);
    lanes
}

/// The forest is these vessels, each with ρ = ΔP·Q/(π r² l) = R Q²/(π r² l) for its flow by hand (mmHg/Ω).
fn check_forest(network: &Network, conditions: &[(usize, Condition)], flows: &[(usize, f64)]) {
    let whole: Vec<_> = flows.iter().map(|(row, flow)| (*row, *flow, 1.0)).collect();
    check_shares(network, conditions, &whole);
}

/// The same where vessels are equal: each is in this share of the forests, over all orders of the equal ones.
fn check_shares(network: &Network, conditions: &[(usize, Condition)], flows: &[(usize, f64, f64)]) {
    let result = whole(network, conditions);
    for row in 0..network.vessel_count() {
        let (by_hand, share) = flows.iter().find(|(r, ..)| *r == row).map_or((0.0, 0.0), |(_, q, share)| {
            let q = q * MMHG / OHM;
            (share * OHM * q * q / (PI * 1e-6 * 0.01), *share)
        });
        let got = result.likelihood[row];
        assert!((got - by_hand).abs() <= 1e-11 * by_hand, "vessel {row}: {got} for {by_hand}");
        assert!((result.frequency[row] - share).abs() < 1e-14, "vessel {row}: {} for {share}", result.frequency[row]);
    }
}

/// 0 -1Ω- 1 -3Ω- 2, from 100 to 0: Q = 25, P1 = 100 - 25 = 75.
#[test]
fn series() {
    let circuit = resistors(3, &[(0, 1, 1.0), (2, 1, 3.0)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(0.0))];
    check(&circuit, &conditions, &all(&[100.0, 75.0, 0.0]));
    check_forest(&circuit, &conditions, &[(0, 25.0), (1, 25.0)]);
}

/// 1Ω and 3Ω side by side make 3/4Ω; with 1/4Ω after them Q = 100 and P1 = 25. Through the 1Ω vessel 75, the other 25: the
/// forest holds the first only.
#[test]
fn parallel_vessels() {
    let circuit = resistors(3, &[(0, 1, 1.0), (1, 0, 3.0), (1, 2, 0.25)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(0.0))];
    check(&circuit, &conditions, &all(&[100.0, 25.0, 0.0]));
    check_forest(&circuit, &conditions, &[(0, 75.0), (2, 100.0)]);
}

/// Two equal vessels side by side tie: either stays in half of the forests. R = 1/2 + 1/2, Q = 100, P1 = 50, 50 through each.
#[test]
fn of_equal_parallel_vessels_either_stays() {
    let circuit = resistors(3, &[(0, 1, 1.0), (0, 1, 1.0), (1, 2, 0.5)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(0.0))];
    check(&circuit, &conditions, &all(&[100.0, 50.0, 0.0]));
    check_shares(&circuit, &conditions, &[(0, 50.0, 0.5), (1, 50.0, 0.5), (2, 100.0, 1.0)]);
}

/// Wheatstone's bridge, S-A 1Ω, S-B 2Ω, A-T 2Ω, B-T 1Ω, A-B 1Ω.
/// At A: 100 - A = A/2 + A - B. At B: (100 - B)/2 + A - B = B. So A = 5B/2 - 50 and 21B/4 = 225: B = 300/7, A = 400/7.
/// Flows in 100/7: S-A 3, S-B 2, A-T 2, B-T 3, A-B 1. Forest of the squares: S-A, B-T, then S-B or A-T, its equal.
#[test]
fn wheatstone_bridge() {
    let circuit = resistors(4, &[(0, 1, 1.0), (0, 2, 2.0), (1, 3, 2.0), (2, 3, 1.0), (1, 2, 1.0)]);
    let conditions = [(0, pressure(100.0)), (3, pressure(0.0))];
    check(&circuit, &conditions, &all(&[100.0, 400.0 / 7.0, 300.0 / 7.0, 0.0]));
    let most = [(0, 300.0 / 7.0, 1.0), (3, 300.0 / 7.0, 1.0)];
    check_shares(&circuit, &conditions, &[most[0], most[1], (1, 200.0 / 7.0, 0.5), (2, 200.0 / 7.0, 0.5)]);
}

/// Balanced: S-A 1Ω, A-T 3Ω beside S-B 2Ω, B-T 6Ω; A = B = 75, so A-B carries nothing and is no part of any forest, though
/// rounding leaves A and B apart. Flows 25 and 12.5. A drop is exactly zero only up to 1e-12 of the pressure.
#[test]
fn balanced_bridge() {
    for scale in [1.0, 0.1, 0.7, 1.3, 1.0 / 3.0] {
        let ohms = [1.0, 2.0, 3.0, 6.0, 5.0].map(|r| r * scale);
        let circuit = resistors(4, &[(0, 1, ohms[0]), (0, 2, ohms[1]), (1, 3, ohms[2]), (2, 3, ohms[3]), (1, 2, ohms[4])]);
        let conditions = [(0, pressure(100.0)), (3, pressure(0.0))];
        check(&circuit, &conditions, &all(&[100.0, 75.0, 75.0, 0.0]));
        let equal = [(1, 12.5 / scale, 0.5), (3, 12.5 / scale, 0.5)];
        check_shares(&circuit, &conditions, &[(0, 25.0 / scale, 1.0), (2, 25.0 / scale, 1.0), equal[0], equal[1]]);
    }
}

/// 0 -1Ω- 1 -1Ω- 3, and at 1 a dead end of 5Ω to 2 with the ring 2 -1Ω- 4 -2Ω- 5 -3Ω- 2: nothing flows there, P = 50.
#[test]
fn dead_end_with_a_ring() {
    let vessels = [(0, 1, 1.0), (1, 3, 1.0), (1, 2, 5.0), (2, 4, 1.0), (4, 5, 2.0), (5, 2, 3.0)];
    let circuit = resistors(6, &vessels);
    let conditions = [(0, pressure(100.0)), (3, pressure(0.0))];
    check(&circuit, &conditions, &all(&[100.0, 50.0, 50.0, 0.0, 50.0, 50.0]));
    check_forest(&circuit, &conditions, &[(0, 50.0), (1, 50.0)]);
}

/// The same dead end behind a vessel 1/20 as wide, so 160,000 times the resistance, with a wide leaf on its ring. P = 50.
#[test]
fn dead_end_behind_a_narrow_vessel() {
    let mut vessels: Vec<_> = [[0, 1], [1, 3], [1, 2], [2, 4], [4, 5], [5, 2], [4, 6]].map(|ends| (ends, tube(10.0, 2.0))).into();
    for row in [2, 3, 5] {
        vessels[row].1.radius = 1e-4;
    }
    let circuit = network(7, vessels);
    let conditions = [(0, pressure(100.0)), (3, pressure(0.0))];
    let result = whole(&circuit, &conditions);
    assert_eq!(result.frequency, [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

/// 2Ω, then 3Ω and 6Ω to ground, 2Ω together: P1 = 50, Q = 25 = 50/3 + 25/3.
#[test]
fn bifurcation() {
    let circuit = resistors(4, &[(0, 1, 2.0), (1, 2, 3.0), (1, 3, 6.0)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(0.0)), (3, pressure(0.0))];
    check(&circuit, &conditions, &all(&[100.0, 50.0, 0.0, 0.0]));
    check_forest(&circuit, &conditions, &[(0, 25.0), (1, 50.0 / 3.0), (2, 25.0 / 3.0)]);
}

/// Inlets of 100 behind 1Ω and 90 behind 2Ω, one outlet behind 2Ω: (100 - P) + (90 - P)/2 = P/2, P = 72.5. Behind 20Ω:
/// 145 = 1.55 P, P = 2900/31 = 93.5: blood leaves by the weaker inlet.
#[test]
fn two_inlets_at_different_pressures() {
    let conditions = [(0, pressure(100.0)), (1, pressure(90.0)), (3, pressure(0.0))];
    let weak = resistors(4, &[(0, 2, 1.0), (1, 2, 2.0), (2, 3, 2.0)]);
    check(&weak, &conditions, &all(&[100.0, 90.0, 72.5, 0.0]));
    check_forest(&weak, &conditions, &[(0, 27.5), (1, 8.75), (2, 36.25)]);
    let strong = resistors(4, &[(0, 2, 1.0), (1, 2, 2.0), (2, 3, 20.0)]);
    let p = 2900.0 / 31.0;
    check(&strong, &conditions, &all(&[100.0, 90.0, p, 0.0]));
    check_forest(&strong, &conditions, &[(0, 100.0 - p), (1, 0.5 * (p - 90.0)), (2, 0.05 * p)]);
}

/// Two inlets of one pressure and nothing else: no flow, although 1 has no condition.
#[test]
fn inlets_of_one_pressure_move_nothing() {
    let circuit = resistors(3, &[(0, 1, 0.3), (1, 2, 0.7), (0, 1, 1.1)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(100.0))];
    check(&circuit, &conditions, &all(&[100.0; 3]));
    check_forest(&circuit, &conditions, &[]);
}

/// A vessel that no condition reaches has no pressure and no resilience; it still counts in |Ẽ| of ρ_G.
#[test]
fn floating_piece() {
    let circuit = resistors(5, &[(0, 1, 1.0), (1, 2, 3.0), (3, 4, 1.0)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(0.0))];
    check(&circuit, &conditions, &[Some(100.0), Some(75.0), Some(0.0), None, None]);
    check_forest(&circuit, &conditions, &[(0, 25.0), (1, 25.0)]);
    let result = whole(&circuit, &conditions);
    let mean = (result.likelihood[0] + result.likelihood[1]) / 3.0;
    assert!((result.network_resilience - mean).abs() <= 1e-15 * mean);
}

/// Closing a vessel cuts off what is behind it: 1 is at the inlet's pressure, 2 floats.
#[test]
fn closed_vessels() {
    let circuit = resistors(4, &[(0, 1, 1.0), (1, 2, 1.0), (2, 3, 1.0)]);
    check_open(&circuit, &[(0, pressure(100.0))], &[true, false, true], &[Some(100.0), Some(100.0), None, None]);
}

/// 1Ω and then a terminal resistance of 4Ω to 10 mmHg: Q = 90/5 = 18, P1 = 82. A second terminal of 4Ω to 30 mmHg at the
/// same distance of 1Ω from the inlet: Q = 70/5 = 14, P2 = 86.
#[test]
fn terminal_resistance_to_a_venous_pressure() {
    let circuit = resistors(3, &[(0, 1, 1.0), (0, 2, 1.0)]);
    let conditions = [(0, pressure(100.0)), (1, terminal(4.0, 10.0)), (2, terminal(4.0, 30.0))];
    check(&circuit, &conditions, &all(&[100.0, 82.0, 86.0]));
    check_forest(&circuit, &conditions, &[(0, 18.0), (1, 14.0)]);
}

/// Terminals alone ground a network too: from 60 mmHg behind 1Ω by 2Ω to 20 mmHg behind 1Ω, Q = 10, P = 50 and 30.
#[test]
fn two_terminals_and_no_fixed_pressure() {
    let circuit = resistors(2, &[(0, 1, 2.0)]);
    let conditions = [(0, terminal(1.0, 60.0)), (1, terminal(1.0, 20.0))];
    check(&circuit, &conditions, &all(&[50.0, 30.0]));
    check_forest(&circuit, &conditions, &[(0, 10.0)]);
}

/// 10 mmHg/Ω injected at 0, by 2Ω and 3Ω to ground: P1 = 30, P0 = 50. Withdrawn: the same below zero.
#[test]
fn injected_flow() {
    let circuit = resistors(3, &[(0, 1, 2.0), (1, 2, 3.0)]);
    for q in [10.0, -10.0] {
        let conditions = [(0, flow(q)), (2, pressure(0.0))];
        check(&circuit, &conditions, &all(&[5.0 * q, 3.0 * q, 0.0]));
        check_forest(&circuit, &conditions, &[(0, 10.0), (1, 10.0)]);
    }
}

/// Injected flow without a ground has nowhere to go: undefined there, and no flow. Once more with a ground elsewhere.
#[test]
fn stranded_flow() {
    let alone = resistors(2, &[(0, 1, 2.0)]);
    check(&alone, &[(0, flow(10.0))], &[None, None]);
    check_forest(&alone, &[(0, flow(10.0))], &[]);
    let beside = resistors(5, &[(0, 1, 2.0), (1, 2, 3.0), (3, 4, 1.0)]);
    let conditions = [(0, flow(10.0)), (3, pressure(100.0)), (4, pressure(0.0))];
    check(&beside, &conditions, &[None, None, None, Some(100.0), Some(0.0)]);
    check_forest(&beside, &conditions, &[(2, 100.0)]);
    let cut = resistors(3, &[(0, 1, 2.0), (1, 2, 3.0)]);
    let grounded = [(0, flow(10.0)), (2, pressure(0.0))];
    check_open(&cut, &grounded, &[true, false], &[None, None, Some(0.0)]);
    check_open(&cut, &grounded, &[false, true], &[None, Some(0.0), Some(0.0)]);
}

/// A self-loop at the middle of a series, at the inlet, and in a floating piece changes nothing.
#[test]
fn self_loops_carry_nothing() {
    let circuit = resistors(4, &[(1, 1, 0.5), (0, 1, 1.0), (0, 0, 2.0), (1, 2, 3.0), (3, 3, 1.0)]);
    let conditions = [(0, pressure(100.0)), (2, pressure(0.0))];
    check(&circuit, &conditions, &[Some(100.0), Some(75.0), Some(0.0), None]);
    check_forest(&circuit, &conditions, &[(1, 25.0), (3, 25.0)]);
}

/// A vessel between two fixed pressures needs no solving: Q = (100 - 40)/3 = 20.
#[test]
fn between_fixed_pressures() {
    let circuit = resistors(2, &[(0, 1, 3.0)]);
    let conditions = [(0, pressure(100.0)), (1, pressure(40.0))];
    check(&circuit, &conditions, &all(&[100.0, 40.0]));
    check_forest(&circuit, &conditions, &[(0, 20.0)]);
}

/// A ring of six equal vessels, 0-1-2-3 and 0-4-5-3, with 100/3 through each: all six tie, and each is the one that goes in a sixth.
#[test]
fn a_ring_of_equal_vessels_loses_each_alike() {
    let circuit = resistors(6, &[(0, 1, 1.0), (1, 2, 1.0), (2, 3, 1.0), (0, 4, 1.0), (4, 5, 1.0), (5, 3, 1.0)]);
    let conditions = [(0, pressure(100.0)), (3, pressure(0.0))];
    let p = 100.0 / 3.0;
    check(&circuit, &conditions, &all(&[100.0, 2.0 * p, p, 0.0, 2.0 * p, p]));
    check_shares(&circuit, &conditions, &[0, 1, 2, 3, 4, 5].map(|row| (row, p, 5.0 / 6.0)));
}
