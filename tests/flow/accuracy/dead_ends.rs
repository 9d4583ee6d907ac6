//! Parts of a circuit that no blood flows through: their pressure is that of the node they hang on, by Kirchhoff's law.
//!
//! In doubles a drop there is a few roundings of the pressure, far below [`willis::internals::flow::resilience::DROP_CUT`]: the weight of a leaf's
//! only ray is c (1/c), the weights of several rays add up to 1 only within rounding, and so does the pressure beside a
//! node of fixed pressure, (C p) (1/C).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use willis::internals::flow::resilience::is_diffused;
use willis::internals::flow::state::{AT_REST, Balanced};
use willis::internals::flow::{BatchSolver, Circuit};

use super::{DROP_TOLERANCE, circuit, lanes, numberings, renumbered, star_mesh};

const TRIALS: u64 = 200;
const PRESSURE: f64 = 13332.2;

/// Twenty-four nodes; vessels of conductances over seven decades; the first node of `inlets` at 100 mmHg, the others at
/// pressures below it, the grounds at zero.
fn random(seed: u64, links: &[(usize, usize)], inlets: &[usize], grounds: &[usize]) -> Circuit {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut conductance = || 10_f64.powf(rng.random_range(-15.0..-8.0));
    let mut circuit = circuit(24, links.iter().map(|(a, b)| (*a, *b, conductance())));
    for (rank, node) in inlets.iter().enumerate() {
        circuit.fixed[*node] = Some(PRESSURE * rng.random_range(0.5..1.0) / (rank + 1) as f64);
    }
    for node in grounds {
        circuit.fixed[*node] = Some(0.0);
    }
    circuit
}

/// Four free nodes 2, 3, 4, 5, each joined to each; blood flows from node 0 through them to node 1.
const CORE: [(usize, usize); 8] = [(0, 2), (2, 3), (2, 4), (2, 5), (3, 4), (3, 5), (4, 5), (5, 1)];
/// Trees on the nodes 2 and 4, with two vessels side by side.
const TREES: [(usize, usize); 14] = [
    (2, 6),
    (6, 7),
    (6, 8),
    (8, 9),
    (8, 10),
    (10, 11),
    (11, 12),
    (12, 11),
    (4, 13),
    (13, 14),
    (14, 15),
    (15, 16),
    (15, 17),
    (2, 18),
];

/// Of the vessels from `first` on: how many have a drop, and the largest in ε of the pressure, over numberings and
/// conductances. None may be more than rounding.
fn drops(links: &[(usize, usize)], first: usize, fixed: (&[usize], &[usize])) -> (usize, f64) {
    let (mut count, mut largest) = (0, 0.0_f64);
    for seed in 0..TRIALS {
        let circuit = random(seed, links, fixed.0, fixed.1);
        for name in numberings() {
            let p = star_mesh(&renumbered(&circuit, name));
            for (a, b) in &links[first..] {
                let (a, b) = (p[name(*a)], p[name(*b)]);
                assert!(a > 0.0 && (a - b).abs() <= DROP_TOLERANCE * a && !is_diffused(a - b, a, b), "{a} {b}");
                count += usize::from(a != b);
                largest = largest.max((a - b).abs() / (a * f64::EPSILON));
            }
        }
    }
    (count, largest)
}

#[test]
fn dead_trees_on_a_cycle_have_drops_of_rounding_at_most() {
    let links = [&CORE[..], &TREES].concat();
    println!("dead trees on a cycle: {:?}", drops(&links, CORE.len(), (&[0], &[1])));
}

#[test]
fn dead_trees_on_a_tree_have_drops_of_rounding_at_most() {
    let links = [(0, 2), (2, 3), (3, 1), (2, 4), (4, 5), (4, 6), (6, 7), (6, 8)];
    println!("dead trees on a tree: {:?}", drops(&links, 3, (&[0], &[1])));
}

#[test]
fn dead_trees_on_a_fixed_pressure_have_drops_of_rounding_at_most() {
    println!("a leaf on a fixed pressure: {:?}", drops(&[(0, 1)], 0, (&[0], &[])));
    println!("a tree on a fixed pressure: {:?}", drops(&[(0, 1), (1, 2), (1, 3), (3, 4), (3, 5)], 0, (&[0], &[])));
}

#[test]
fn dead_ends_on_a_ground_have_no_pressure_at_all() {
    let links = [(0, 2), (2, 1), (1, 3), (3, 4), (4, 5), (5, 3), (5, 6)];
    for seed in 0..TRIALS {
        for name in numberings() {
            let p = star_mesh(&renumbered(&random(seed, &links, &[0], &[1]), name));
            assert!((3..7).all(|n| p[name(n)] == 0.0), "{p:?}");
        }
    }
}

#[test]
fn dead_ends_with_cycles_have_drops_of_rounding_at_most() {
    let triangle = [(2, 6), (6, 7), (7, 2)];
    let complete = [(2, 6), (2, 7), (2, 8), (6, 7), (6, 8), (7, 8)];
    let chained = [(4, 6), (6, 7), (7, 8), (8, 6), (8, 9), (9, 10), (10, 11), (11, 12), (12, 9), (12, 10), (12, 13)];
    for (what, dead) in [("triangle", &triangle[..]), ("complete", &complete), ("chained", &chained)] {
        println!("dead {what}: {:?}", drops(&[&CORE, dead].concat(), CORE.len(), (&[0], &[1])));
    }
    println!("dead triangle on a fixed pressure: {:?}", drops(&[(0, 1), (1, 2), (2, 0)], 0, (&[0], &[])));
}

#[test]
fn dead_ends_made_by_closed_vessels_have_drops_of_rounding_at_most() {
    // With the last two vessels open the chain 3-6-7-8-9-10 is a way to the ground; closed, it is a dead end.
    let links = [&CORE[..], &[(3, 6), (6, 7), (7, 8), (8, 9), (9, 10), (10, 1), (8, 5)]].concat();
    let (closed, dead) = (links.len() - 2, CORE.len()..links.len() - 2);
    let present: Vec<u8> = (0..links.len()).map(|v| u8::from(v < closed)).collect();
    let mut count = 0;
    for seed in 0..TRIALS {
        let circuit = random(seed, &links, &[0], &[1]);
        for name in numberings() {
            let p = lanes(&renumbered(&circuit, name), &present);
            for (a, b) in &links[dead.clone()] {
                let (a, b) = (p[name(*a)][0], p[name(*b)][0]);
                assert!(a > 0.0 && (a - b).abs() <= DROP_TOLERANCE * a && !is_diffused(a - b, a, b), "{a} {b}");
                count += usize::from(a != b);
            }
        }
    }
    println!("dead ends by closed vessels: {count} drops of {}", dead.len() * 192 * TRIALS as usize);
}

/// A wide vessel that leads nowhere, at a pressure that rounding blurs: nothing flows in it.
#[test]
fn nothing_flows_in_a_dead_end() {
    let circuit = Circuit {
        ends: vec![[0, 1], [1, 2], [1, 3], [3, 4]],
        conductance: vec![1.0 / 3.0, 1.0 / 7.0, 1e9, 1e5],
        fixes: Vec::new(),
        fixed: vec![Some(1e4), None, Some(0.0), None, None],
        shunt: vec![0.0; 5],
        source: vec![0.0; 5],
        level: 0.0,
    };
    let mut found = BatchSolver::for_few(&circuit).expect("compiles").above_level(&circuit, |_| true).expect("solved");
    for (node, ulps) in [(3, 3.0), (4, -2.0)] {
        found[node] = found[node].map(|p| p * (1.0 + ulps * f64::EPSILON));
    }
    let balanced = Balanced::of(&circuit, &circuit.conductance, &found, None);
    let flow = |row: usize| balanced.drop[row] * circuit.conductance[row];
    assert!((flow(0) / 1e3 - 1.0).abs() < 1e-12 && (flow(1) / 1e3 - 1.0).abs() < 1e-12);
    assert!(flow(2).abs() < 1e3 * AT_REST && flow(3).abs() < 1e3 * AT_REST, "{} {}", flow(2), flow(3));
}

/// Vessels of resistance 1/C and 1 Pa s/m³ in series between 100 Pa and 0: the flow is 100/(1 + 1/C), and each carries it, to the 1e-12 that
/// is promised.
#[test]
fn vessels_in_series_carry_one_flow() {
    for stiff in [1e3, 1e9, 1e12, 1e15, 1e30] {
        let circuit = Circuit {
            ends: vec![[0, 1], [1, 2]],
            conductance: vec![stiff, 1.0],
            fixes: Vec::new(),
            fixed: vec![Some(100.0), None, Some(0.0)],
            shunt: vec![0.0; 3],
            source: vec![0.0; 3],
            level: 0.0,
        };
        let found = BatchSolver::for_few(&circuit).expect("compiles").above_level(&circuit, |_| true).expect("solved");
        let balanced = Balanced::of(&circuit, &circuit.conductance, &found, None);
        let flow = 100.0 / (1.0 + 1.0 / stiff);
        for (drop, conductance) in balanced.drop.iter().zip(&circuit.conductance) {
            assert!((drop * conductance / flow - 1.0).abs() < 1e-12, "{stiff}: {}", drop * conductance);
        }
    }
}
