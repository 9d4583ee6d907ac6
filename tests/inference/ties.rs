//! Vessels of equal resilience: every order of them is as likely as any other, so symmetric networks have symmetric likelihoods. The truth is
//! brute force: every pattern, every order of the vessels, Kruskal's algorithm on each.

use crate::exact::keep;
use crate::networks::{boundary, pressure, run};
use crate::solvers::agree;
use crate::textbook::Sample;
use crate::vessels::{network, tube};
use willis::internals::decision::{Keep, decide};
use willis::internals::network::{Condition, Network, Vessel};
use willis::internals::sampling::{Coins, Likelihood, SamplingOptions, Solver, Uncertain, infer};
use willis::internals::support::ties::{TIE, exceeds, near_zero, steady};

const SOLVERS: [Solver; 3] = [Solver::Lanes, Solver::Gradients, Solver::Reference];
const SAMPLES: u64 = 10_000;

/// A symmetric network, blood flowing from node 0 to node 1, with rows that mirror each other.
struct Symmetric {
    name: &'static str,
    network: Network,
    mirror: Vec<[usize; 2]>,
}

fn symmetric(name: &'static str, nodes: usize, ends: &[[usize; 2]], mirror: &[[usize; 2]], certain: &[usize]) -> Symmetric {
    let vessels =
        ends.iter().enumerate().map(|(row, ends)| (*ends, Vessel { certain: certain.contains(&row), ..tube(10.0, 1.0) }));
    Symmetric { name, network: network(nodes, vessels), mirror: mirror.to_vec() }
}

/// A circle of equal halves, with uncertain vessels and with halves that are certain; the Wheatstone bridge; four vessels side by side; three
/// routes of which the direct one is twice as long as a vessel of the others.
fn networks() -> Vec<Symmetric> {
    let circle = [[0, 2], [2, 3], [3, 1], [4, 5], [0, 4], [1, 5]];
    let halves = [[0, 4], [1, 3], [2, 5]];
    let mut theta = symmetric("three routes", 4, &[[0, 1], [0, 2], [2, 1], [3, 1], [0, 3]], &[[1, 4], [2, 3], [1, 2]], &[]);
    theta.network.vessel_mut(0).length *= 2.0;
    vec![
        symmetric("circle", 6, &circle, &halves, &[]),
        symmetric("circle with a certain half", 6, &circle, &[[0, 1], [1, 2], [3, 4], [4, 5]], &[0, 1, 2]),
        symmetric("certain circle", 6, &circle, &halves, &[0, 1, 2, 3, 4, 5]),
        symmetric("bridge", 4, &[[0, 2], [0, 3], [1, 3], [2, 3], [1, 2]], &[[0, 1], [2, 4], [0, 2]], &[]),
        symmetric("four", 2, &[[0, 1]; 4], &[[0, 1], [1, 2], [2, 3]], &[]),
        theta,
    ]
}

fn conditions() -> [(usize, Condition); 2] {
    [(0, pressure(100.0)), (1, pressure(0.0))]
}

fn options(solver: Solver) -> SamplingOptions {
    SamplingOptions { solver, samples: SAMPLES, epsilon: 0.3, seed: 5, uncertain: Uncertain::All, ..SamplingOptions::default() }
}

/// All orders of some rows.
fn orders(rows: &[usize]) -> Vec<Vec<usize>> {
    if rows.is_empty() {
        return vec![Vec::new()];
    }
    let first = |at: usize| {
        let mut rest = rows.to_vec();
        let row = rest.remove(at);
        orders(&rest).into_iter().map(move |rest| [vec![row], rest].concat())
    };
    (0..rows.len()).flat_map(first).collect()
}

/// E(ρ) and the frequency of each vessel in the forest, over all patterns and all orders of their vessels.
fn brute_force(network: &Network) -> [Vec<f64>; 2] {
    let vessels = network.vessel_count();
    let (keep, mut likelihood, mut frequency) = (keep(network, 0.3, Uncertain::All), vec![0.0; vessels], vec![0.0; vessels]);
    for mask in 0_u32..1 << vessels {
        let open: Vec<bool> = (0..vessels).map(|row| mask >> row & 1 == 1).collect();
        let probability: f64 = open.iter().zip(&keep).map(|(open, k)| if *open { *k } else { 1.0 - k }).product();
        if probability == 0.0 {
            continue;
        }
        let mut rho = vec![0.0; vessels];
        let flows = Sample { network, conditions: &conditions(), open }.resiliences();
        // What a bridge between equal pressures has is rounding.
        flows.iter().filter(|(_, x)| *x > 1e-9).for_each(|(row, x)| rho[*row] = *x);
        let orders = orders(&(0..vessels).filter(|row| rho[*row] > 0.0).collect::<Vec<_>>());
        for mut order in orders.iter().cloned() {
            let nine_digits = |row: usize| format!("{:.8e}", rho[row]).parse::<f64>().unwrap();
            order.sort_by(|a, b| nine_digits(*b).total_cmp(&nine_digits(*a)));
            let mut label: Vec<usize> = (0..network.node_count()).collect();
            for row in order {
                let [a, b] = network.ends(row).map(|node| label[node]);
                if a != b {
                    label.iter_mut().filter(|l| **l == a).for_each(|l| *l = b);
                    likelihood[row] += rho[row] * probability / orders.len() as f64;
                    frequency[row] += probability / orders.len() as f64;
                }
            }
        }
    }
    [likelihood, frequency]
}

/// 1e-9 for sums in another order.
#[test]
fn an_enumeration_expects_every_order_of_equals_alike() {
    for Symmetric { name, network, .. } in networks() {
        let [likelihood, frequency] = brute_force(&network);
        for solver in SOLVERS {
            let exact = run(&network, &conditions(), &SamplingOptions { exact: true, samples: 1, ..options(solver) });
            for (row, (got, expected)) in exact.likelihood.iter().zip(&likelihood).enumerate() {
                assert!((got - expected).abs() <= 1e-9 * expected, "{name}, {solver:?}, {row}: {got} for {expected}");
                assert!((exact.frequency[row] - frequency[row]).abs() <= 1e-9, "{name}, {solver:?}, {row}");
            }
        }
    }
}

/// Mirror vessels within four of their standard errors of each other, and all vessels within five of brute force (certain vessels that close a loop
/// have an error of their own, though nothing is occluded); every solver finds the same forests.
#[test]
fn what_is_symmetric_has_a_symmetric_likelihood() {
    for Symmetric { name, network, mirror } in networks() {
        let [likelihood, frequency] = brute_force(&network);
        let reference = run(&network, &conditions(), &options(Solver::Reference));
        for solver in SOLVERS {
            let result = run(&network, &conditions(), &options(solver));
            agree(&format!("{name}, {solver:?}"), &reference, &result);
            let error = |row: usize| {
                let of_frequency = (SAMPLES as f64 * frequency[row] * (1.0 - frequency[row])).sqrt();
                result.std_error[row].max(of_frequency * likelihood[row] / frequency[row])
            };
            for [a, b] in &mirror {
                let apart = (result.likelihood[*a] - result.likelihood[*b]).abs();
                assert!(apart <= 4.0 * (error(*a) + error(*b)), "{name}, {solver:?}: {a} and {b} are {apart} apart");
            }
            for (row, (got, expected)) in result.likelihood.iter().zip(&likelihood).enumerate() {
                let (off, error) = ((got - SAMPLES as f64 * expected).abs(), error(row));
                assert!(off <= 5.0 * error + 1e-9 * got, "{name}, {solver:?}, {row}: {off} for an error of {error}");
            }
        }
    }
}

/// The same bytes at 1, 2 and 7 threads.
#[test]
fn coins_do_not_depend_on_threads() {
    let bits = |result: &Likelihood| result.likelihood.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    for Symmetric { name, network, .. } in networks() {
        let boundary = boundary(&network, &conditions());
        for solver in SOLVERS {
            let runs = [1, 2, 7].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| bits(&infer(&network, &boundary, &options(solver), &mut |_: u64, _: u64| true).unwrap().0))
            });
            assert!(runs.iter().all(|run| *run == runs[0]), "{name}, {solver:?}");
        }
    }
}

/// Of three equal vessels each of the six orders comes up in a sixth of 64,000 samples, and after each order each one: within five standard
/// errors. Another seed has other orders.
#[test]
fn every_order_of_equals_comes_up_as_often() {
    let order = |coins: &Coins, coin: f64| {
        let mut rows = [3, 50, 97];
        rows.sort_by_key(|row| coins.key(1.5, *row, coin));
        orders(&[3, 50, 97]).iter().position(|order| *order == rows).unwrap()
    };
    let of = |seed: u64| {
        let coins = Coins::new(100, seed);
        (0..1000).flat_map(|block| coins.of_block(block).map(|coin| order(&coins, coin))).collect::<Vec<usize>>()
    };
    let all = of(1);
    let within = |count: usize, of: f64, p: f64| (count as f64 - of * p).abs() <= 5.0 * (of * p * (1.0 - p)).sqrt();
    for first in 0..6 {
        assert!(within(all.iter().filter(|order| **order == first).count(), 64e3, 1.0 / 6.0), "{first}");
        for second in 0..6 {
            assert!(within(all.windows(2).filter(|two| *two == [first, second]).count(), 64e3, 1.0 / 36.0), "{first} {second}");
        }
    }
    assert_ne!(all, of(2));
}

/// L of mirror vessels differs in its last bits only; whatever these are, the answer is symmetric: the bridge of equal vessels keeps all
/// four that carry the flow or none of them.
#[test]
fn the_last_bits_of_a_likelihood_decide_nothing() {
    for Symmetric { name, network, mirror } in networks() {
        for solver in SOLVERS {
            let exact = run(&network, &conditions(), &SamplingOptions { exact: true, ..options(solver) });
            for rule in [Keep::Median, Keep::Quantile(0.3), Keep::Otsu, Keep::Value(exact.likelihood[mirror[0][0]])] {
                let kept = decide(rule, &network, &exact).unwrap().kept;
                assert!(mirror.iter().all(|[a, b]| kept[*a] == kept[*b]), "{name}, {solver:?}, {rule}: {kept:?}");
            }
        }
    }
}

#[test]
fn what_rounding_parts_exceeds_nothing() {
    assert!(!exceeds(0.1 + 0.2, 0.3) && !exceeds(0.3, 0.1 + 0.2) && !exceeds(0.0, 0.0));
    assert!(exceeds(1.0 + 2.0 * TIE, 1.0) && !exceeds(1.0, 1.0 + 2.0 * TIE) && exceeds(1.0, 0.0) && exceeds(1.0, -1.0));
    assert!(!exceeds(f64::NAN, 0.0) && exceeds(f64::MIN_POSITIVE, 0.0));
}

#[test]
fn differences_that_are_rounding_are_zero() {
    assert_eq!([near_zero(0.3 - 0.1 - 0.2), near_zero(-1e-12), near_zero(1.0 / 3.0 - 0.25)], [0.0, 0.0, near_zero(1.0 / 12.0)]);
    assert_eq!(near_zero(-1e-12).to_bits(), 0);
}

#[test]
fn what_rounding_parts_is_equal_again_and_what_differs_stays_different() {
    assert_eq!(steady(0.1 + 0.2), steady(0.3));
    assert_eq!(steady(-3.000_000_000_000_000_4), -3.0);
    assert_eq!([steady(0.0), steady(1.5), steady(f64::INFINITY)], [0.0, 1.5, f64::INFINITY]);
    assert!(steady(1.0 + 1e-9) > 1.0 && (steady(0.7) - 0.7).abs() < 1e-9);
}
