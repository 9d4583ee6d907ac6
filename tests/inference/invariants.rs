//! What must hold for every network, whatever its figures: Kirchhoff's law, scaling, relabelling, the size of forests.

use crate::draw::Draw;
use crate::exact;
use crate::networks;
use crate::networks::{VISCOSITY, boundary, log_radii, pressure, radii, random_conditions, random_network, run};
use crate::textbook::{Sample, conductance, rank};
use crate::vessels::{network, tube};
use willis::internals::flow::pressures::pressures;
use willis::internals::flow::resilience::resilience;
use willis::internals::flow::{Boundary, Circuit, FoundOutlets, Given};
use willis::internals::network::{Condition, Network, Role, Vessel};
use willis::internals::perturbation::Occlusion;
use willis::internals::sampling::{Coins, Likelihood, SamplingOptions, Solver, Uncertain, Weight};

const SOLVERS: [Solver; 3] = [Solver::Lanes, Solver::Gradients, Solver::Reference];

fn wide(seed: u64, nodes: usize, vessels: usize) -> (Network, Vec<(usize, Condition)>) {
    let mut draw = Draw::new(seed);
    let network = random_network(&mut draw, nodes, vessels, log_radii(0.05, 2.5));
    let conditions = random_conditions(&mut draw, nodes);
    (network, conditions)
}

fn moderate(seed: u64, nodes: usize, vessels: usize) -> (Network, Vec<(usize, Condition)>) {
    let mut draw = Draw::new(seed);
    let network = random_network(&mut draw, nodes, vessels, radii(0.3, 2.0));
    let conditions = random_conditions(&mut draw, nodes);
    (network, conditions)
}

fn trial(seed: u64, solver: Solver) -> SamplingOptions {
    SamplingOptions { seed, solver, uncertain: Uncertain::All, ..SamplingOptions::default() }
}

/// What flows in flows out: to 1e-12 of all flow at the node, and no better than pressures that are themselves rounded to
/// 2^-53 (twice that for the elimination) allow, which is what counts where a wide vessel lies behind a narrow one.
#[test]
fn kirchhoffs_current_law_at_every_free_node() {
    for seed in 0..200 {
        let (network, conditions) = wide(seed, 40, 60);
        let mut draw = Draw::new(seed + 1000);
        let open: Vec<bool> = (0..60).map(|_| draw.below(4) > 0).collect();
        let circuit = Circuit::new(&network, &boundary(&network, &conditions), VISCOSITY).unwrap();
        let p = pressures(&circuit, |v| open[v]).unwrap();
        let (mut net, mut gross, mut rounding) = (vec![0.0; 40], vec![0.0; 40], vec![0.0; 40]);
        for row in (0..60).filter(|row| open[*row]) {
            let [a, b] = network.ends(row);
            assert_eq!(p[a].is_some(), p[b].is_some());
            let (Some(pa), Some(pb)) = (p[a], p[b]) else { continue };
            let (c, q) = (conductance(&network, row), conductance(&network, row) * (pa - pb));
            net[a] += q;
            net[b] -= q;
            for node in [a, b] {
                gross[node] += q.abs();
                rounding[node] += c * pa.abs().max(pb.abs());
            }
        }
        for (node, condition) in &conditions {
            let Some(at) = p[*node] else { continue };
            let outflow = match condition {
                Condition::Pressure(fixed) => {
                    assert!((at - fixed).abs() <= 1e-15 * fixed);
                    -net[*node]
                }
                Condition::Resistance { resistance, venous } => {
                    rounding[*node] += at / resistance;
                    (at - venous) / resistance
                }
                Condition::Flow(q) => -q,
            };
            net[*node] += outflow;
            gross[*node] += outflow.abs();
        }
        for node in 0..40 {
            let allowed = 1e-12 * gross[node] + 4.0 * f64::EPSILON * rounding[node];
            assert!(net[node].abs() <= allowed, "graph {seed}, node {node}: {} of {}", net[node], gross[node]);
        }
    }
}

/// No pressure lies beyond those of the conditions when nothing is injected (the discrete maximum principle). Exact up
/// to a few roundings.
#[test]
fn pressures_stay_between_those_of_the_conditions() {
    for seed in 0..100 {
        let (network, mut conditions) = wide(seed, 40, 60);
        conditions.retain(|(_, c)| !matches!(c, Condition::Flow(_)));
        let circuit = Circuit::new(&network, &boundary(&network, &conditions), VISCOSITY).unwrap();
        let top = 100.0 * networks::MMHG * (1.0 + 1e-14);
        assert!(pressures(&circuit, |_| true).unwrap().into_iter().flatten().all(|p| (0.0..=top).contains(&p)));
    }
}

fn scaled(conditions: &[(usize, Condition)], s: f64) -> Vec<(usize, Condition)> {
    let scale = |c: &Condition| match *c {
        Condition::Pressure(p) => Condition::Pressure(p * s),
        Condition::Resistance { resistance, venous } => Condition::Resistance { resistance, venous: venous * s },
        Condition::Flow(q) => Condition::Flow(q * s),
    };
    conditions.iter().map(|(node, c)| (*node, scale(c))).collect()
}

/// Flow is linear in the conditions and ρ goes as its square; powers of two are exact in binary, so to the last bit.
#[test]
fn likelihood_scales_with_the_square_of_the_pressure() {
    for seed in 0..30 {
        for solver in SOLVERS {
            let (network, conditions) = moderate(seed, 20, 32);
            let base = run(&network, &conditions, &trial(seed, solver));
            for s in [2.0, 0.25] {
                let result = run(&network, &scaled(&conditions, s), &trial(seed, solver));
                for row in 0..32 {
                    let (got, expected) = (result.likelihood[row], s * s * base.likelihood[row]);
                    assert_eq!(got.to_bits(), expected.to_bits(), "{solver:?}, graph {seed}, vessel {row}");
                }
            }
        }
    }
}

/// The same network with its nodes renumbered and its vessels turned round at random, in the same order of vessels, so that
/// every sample has the same mask.
fn relabelled(network_: &Network, conditions: &[(usize, Condition)], draw: &mut Draw) -> (Network, Vec<(usize, Condition)>) {
    let mut to: Vec<usize> = (0..network_.node_count()).collect();
    draw.shuffle(&mut to);
    let vessels: Vec<([usize; 2], Vessel)> = network_
        .vessels()
        .map(|([a, b], vessel)| (if draw.below(2) == 0 { [to[a], to[b]] } else { [to[b], to[a]] }, vessel.clone()))
        .collect();
    let conditions = conditions.iter().map(|(node, c)| (to[*node], *c)).collect();
    (network(to.len(), vessels), conditions)
}

fn same(a: &Likelihood, b: &Likelihood, tolerance: f64, what: &str) {
    for row in 0..a.likelihood.len() {
        let (x, y) = (a.likelihood[row], b.likelihood[row]);
        assert_eq!(a.frequency[row], b.frequency[row], "{what}, vessel {row}");
        assert!((x - y).abs() <= tolerance * x.abs().max(y.abs()), "{what}, vessel {row}: {x} and {y}");
    }
}

/// Names do not matter: the same forests, and L up to the rounding of another order of elimination, 1e-9.
#[test]
fn relabelling_changes_nothing() {
    for seed in 0..40 {
        let (network, conditions) = moderate(seed, 20, 32);
        let (other, moved) = relabelled(&network, &conditions, &mut Draw::new(seed + 500));
        for solver in SOLVERS {
            let (a, b) = (run(&network, &conditions, &trial(seed, solver)), run(&other, &moved, &trial(seed, solver)));
            same(&a, &b, 1e-9, &format!("{solver:?}, graph {seed}"));
        }
    }
}

/// Four radii only, so that vessels in series tie exactly in nearly every sample: the coin of its row decides a tie, whatever
/// the nodes are called.
#[test]
fn relabelling_changes_no_tie() {
    for seed in 0..40 {
        let mut draw = Draw::new(seed + 600);
        let network = random_network(&mut draw, 24, 30, |draw| [0.5, 0.7, 1.0, 1.4][draw.below(4)]);
        let conditions = random_conditions(&mut draw, 24);
        let (other, moved) = relabelled(&network, &conditions, &mut draw);
        let a = run(&network, &conditions, &trial(seed, Solver::Lanes));
        for (solver, network, conditions) in
            [(Solver::Lanes, &other, &moved), (Solver::Reference, &network, &conditions), (Solver::Reference, &other, &moved)]
        {
            same(&a, &run(network, conditions, &trial(seed, solver)), 1e-9, &format!("{solver:?}, graph {seed}"));
        }
    }
}

/// In every sample the forest holds diffused vessels only, no cycle, and as many as span all diffused nodes: nodes less
/// components. One sample per seed; the mask is that of the occlusion, and structure says which vessels blood flows through, however little.
#[test]
fn the_forest_spans_the_diffused_vessels() {
    for seed in 0..2000 {
        let (network, conditions) = wide(seed % 40, 20, 32);
        let keep = exact::keep(&network, 0.3, Uncertain::All);
        let mut masks = Vec::new();
        Occlusion::new(keep).draw(seed, 0, &mut masks);
        let open = masks.iter().map(|mask| mask & 1 == 1).collect();
        let sample = Sample { network: &network, conditions: &conditions, open };
        let diffused: Vec<usize> = (0..32).filter(|row| sample.carries(*row)).collect();
        let params = SamplingOptions { samples: 1, epsilon: 0.3, weight: Weight::Count, ..trial(seed, Solver::Lanes) };
        let result = run(&network, &conditions, &params);
        let forest: Vec<usize> = (0..32).filter(|row| result.likelihood[*row] > 0.0).collect();
        assert!(forest.iter().all(|row| diffused.contains(row)), "seed {seed}");
        assert_eq!(forest.len(), rank(&network, &diffused), "seed {seed}");
        assert_eq!(forest.len(), rank(&network, &forest), "seed {seed}: a cycle");
        assert!((0..32).all(|row| result.likelihood[row] == result.frequency[row]));
    }
}

/// 24 significant bits, to the nearest: rounding on either side of a short figure ties, so that the coin alone decides; 2^-22 of it does not tie.
#[test]
fn nearly_equal_resiliences_tie_and_larger_ones_come_first() {
    let (mut draw, coins, mut first) = (Draw::new(2), Coins::new(10, 0), 0);
    for sample in 0..1000 {
        let coin = coins.of_block(sample / 64)[sample as usize % 64];
        let key = |rho: f64, vessel: usize| coins.key(rho, vessel, coin);
        let x = f64::from(draw.below(1 << 24) as u32 + 1) * 2_f64.powi(draw.below(80) as i32 - 40);
        let (below, above) = (x * (1.0 - 1e-12), x * (1.0 + 1e-12));
        assert_eq!(key(below, 7), key(above, 7));
        assert_eq!(key(below, 3) > key(above, 4), key(above, 3) > key(below, 4));
        first += usize::from(key(below, 3) > key(above, 4));
        assert_eq!([3, 4].map(|vessel| coins.vessel(key(x, vessel))), [3, 4]);
        assert!(key(x * (1.0 + 2_f64.powi(-22)), 4) > key(x, 3));
    }
    assert!((400..600).contains(&first), "{first} of 1000");
}

/// ρ = ΔP Q/(π r² l) = τ²/(2µ) with τ = ΔP r/(2 l), for Poiseuille's Q. 1e-14: a dozen roundings.
#[test]
fn resilience_is_the_square_of_the_wall_shear_stress() {
    let mut draw = Draw::new(1);
    for _ in 0..1000 {
        let vessel = tube(draw.within(0.1, 100.0), draw.within(0.05, 2.5));
        let network = network(2, [([0, 1], vessel.clone())]);
        let drop = draw.within(-1e4, 1e4);
        let tau = drop * vessel.radius / (2.0 * vessel.length);
        let rho = resilience(drop, drop * conductance(&network, 0), vessel.volume());
        let expected = tau * tau / (2.0 * VISCOSITY);
        assert!((rho - expected).abs() <= 1e-14 * expected, "{rho} for {expected}");
        let conditions = [(0, Condition::Pressure(drop.abs())), (1, Condition::Pressure(0.0))];
        let result = run(&network, &conditions, &SamplingOptions { epsilon: 0.0, samples: 1, ..SamplingOptions::default() });
        assert!((result.likelihood[0] - expected).abs() <= 1e-14 * expected);
    }
}

/// The cells of the matrix: upper triangle in order, parallel vessels added up, nothing for self-loops, and the whole of L in
/// all. 1e-14 for sums in another order.
#[test]
fn the_matrix_adds_up_parallel_vessels() {
    for seed in 0..20 {
        let (mut network, conditions) = moderate(seed, 8, 20);
        network.add_vessel([3, 3], tube(10.0, 1.0));
        let result = run(&network, &conditions, &trial(seed, Solver::Auto));
        let cells = result.matrix(&network);
        assert!(cells.iter().all(|(a, b, x)| a < b && *x > 0.0));
        assert!(cells.windows(2).all(|w| (w[0].0, w[0].1) < (w[1].0, w[1].1)));
        for a in 0..8 {
            for b in a + 1..8 {
                let between = |row: &usize| network.ends(*row) == [a, b] || network.ends(*row) == [b, a];
                let sum: f64 = (0..21).filter(between).map(|row| result.likelihood[row]).sum();
                let cell = cells.iter().find(|c| (c.0, c.1) == (a as u32, b as u32)).map_or(0.0, |c| c.2);
                assert!((cell - sum).abs() <= 1e-14 * sum, "{a} {b}: {cell} for {sum}");
            }
        }
    }
}

#[test]
fn the_order_of_conditions_is_irrelevant() {
    for seed in 0..20 {
        let (network, conditions) = moderate(seed, 20, 32);
        let given: Vec<Given> = (conditions.iter())
            .map(|(node, condition)| Given {
                node: *node,
                role: if *condition == pressure(0.0) { Role::Outlet } else { Role::Inlet },
                condition: *condition,
            })
            .collect();
        let mut other = given.clone();
        Draw::new(seed).shuffle(&mut other);
        let [a, b] = [given, other].map(|g| Boundary::resolve(&network, &g, FoundOutlets::Ground).unwrap());
        assert_eq!(a, b);
        let [a, b] = [a, b].map(|b| run(&network, &b.conditions, &trial(seed, Solver::Auto)));
        assert_eq!(a, b);
    }
}

/// Closing vessels that never open, or adding a piece that floats, leaves L of the others as it is, up to
/// the rounding of another order of elimination, 1e-12.
#[test]
fn what_no_blood_reaches_changes_nothing() {
    for seed in 0..20 {
        let (network, conditions) = moderate(seed, 20, 32);
        let base = run(&network, &conditions, &trial(seed, Solver::Lanes));
        let mut more = network.clone();
        let nodes =
            [0, 1].map(|i| more.add_node(willis::internals::network::Node { id: format!("far {i}"), ..Default::default() }));
        more.add_vessel(nodes, Vessel { prior: 0.0, ..tube(5.0, 1.0) });
        more.add_vessel([0, nodes[0]], Vessel { prior: 0.0, ..tube(5.0, 1.0) });
        more.add_vessel(nodes, Vessel { certain: true, ..tube(5.0, 1.0) });
        let result = run(&more, &conditions, &trial(seed, Solver::Lanes));
        assert_eq!(result.likelihood[32..], [0.0; 3]);
        same(&base, &Likelihood { likelihood: result.likelihood[..32].to_vec(), ..result.clone() }, 1e-12, "floating");
    }
}
