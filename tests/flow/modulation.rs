//! Resistance modulation against an independent dense solve, against one solve an instance, and across thread counts.

use crate::draw::Draw;
use crate::networks;
use crate::networks::{VISCOSITY, boundary, radii, random_conditions, random_network};
use crate::vessels;
use rand_distr::{Distribution as _, Gamma as Draws};
use std::f64::consts::PI;
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::state::State;
use willis::internals::flow::{Boundary, FoundOutlets, Tube};
use willis::internals::modulation::hypertension::{histogram_edges, risk_threshold};
use willis::internals::modulation::{
    Class, Hypertension, Instances, Modulation, ModulationOptions, Reading, hypertension_force, modulate,
};
use willis::internals::network::{Condition, Network};
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::internals::support::Distribution;
use willis::internals::support::gamma::{Gamma, LARGE, information, log_gap, trigamma};
use willis::internals::support::random::stream;

fn circle() -> Network {
    cerebral(&circle_of_willis(1e-3))
}

fn run(network: &Network, boundary: &Boundary, params: &ModulationOptions) -> Modulation {
    modulate(network, boundary, params, &mut |_done: u64, _total: u64| true).expect("runs")
}

/// The published conditions, the terminal resistances replaced by ground when `ground`.
fn conditions(network: &Network, ground: bool) -> Boundary {
    let mut boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground).expect("conditions");
    for (_, condition) in &mut boundary.conditions {
        if ground && matches!(condition, Condition::Resistance { .. }) {
            *condition = Condition::Pressure(0.0);
        }
    }
    boundary
}

/// The change that modulation makes to ρ_G, to the total inflow (ratios) and to the mean pressure of all nodes, those of fixed
/// pressure among them (mmHg), with the standard deviation of each over the instances.
fn changes(ground: bool, class: Class, reading: Reading) -> [(f64, f64); 3] {
    let network = circle();
    let params = ModulationOptions { classes: vec![class], reading, samples: 4000, seed: 11, ..ModulationOptions::default() };
    let result = run(&network, &conditions(&network, ground), &params);
    let (rest, instances) = (&result.unperturbed, &result.classes[0].1);
    let all = vec![true; network.node_count()];
    let [rest_pressure] = Instances::means(&rest.pressure, all.len(), &all, |p| p)[..] else { panic!("one row") };
    let pressures = Instances::means(&instances.pressure, all.len(), &all, |p| p);
    let of = |values: Vec<f64>| {
        let d = Distribution::of(values);
        (d.mean, d.std)
    };
    [
        of(instances.network_resilience.iter().map(|r| r / rest.network_resilience[0]).collect()),
        of(instances.inflow.iter().map(|q| q / rest.inflow[0]).collect()),
        of(pressures.iter().map(|p| (p - rest_pressure) / networks::MMHG).collect()),
    ]
}

/// A dense NumPy solve of the same 20 vessels, 200 to 400 draws of each class. NaN where the table is empty.
#[test]
fn an_independent_solver_finds_the_same_changes() {
    const NONE: f64 = f64::NAN;
    let class = |low, high| Class { low, high };
    let table = [
        (class(0.0, 0.2), Reading::Increment, [0.916, 0.912, 0.0, 1.086, 0.992, -0.35]),
        (class(0.2, 0.3), Reading::Increment, [0.801, 0.801, 0.0, 1.202, 0.981, -0.88]),
        (class(0.3, 0.5), Reading::Increment, [0.717, 0.716, 0.0, 1.314, 0.970, -1.39]),
        (class(0.3, 0.5), Reading::Conductance, [NONE, NONE, NONE, 1.522, 0.951, -2.30]),
        (class(0.0, 0.2), Reading::Literal, [1.126, 1.118, 0.0, 0.920, 1.008, 0.37]),
        (class(0.3, 0.5), Reading::Literal, [1.717, 1.683, 0.0, 0.649, 1.032, 1.49]),
    ];
    let rounding = [5e-4, 5e-4, 5e-2, 5e-4, 5e-4, 5e-3];
    let mut wrong = Vec::new();
    for (class, reading, reference) in table {
        let found = [changes(true, class, reading), changes(false, class, reading)].concat();
        for (at, ((mean, std), known)) in found.iter().zip(reference).enumerate().filter(|(_, (_, known))| !known.is_nan()) {
            // The reference's own draws scatter: 200 of them at the least, against 4000 here.
            let error = std * (1.0_f64 / 200.0 + 1.0 / 4000.0).sqrt();
            println!("{class} {reading:?} {at}: {mean:.4} against {known}, standard error {error:.4}");
            if (mean - known).abs() > 3.5 * error + rounding[at] {
                wrong.push(format!("{class} {reading:?} {at}: {mean} against {known}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Every instance again by itself, from the factors that the run says it drew.
fn agrees_with_single_solves(name: &str, network: &Network, boundary: &Boundary, params: &ModulationOptions, within: f64) {
    let result = run(network, boundary, params);
    let (nodes, vessels) = (network.node_count(), network.vessel_count());
    for (class, instances) in &result.classes {
        assert_eq!(instances.count() as u64, params.samples);
        for i in 0..instances.count() {
            let row = |table: &[f64], width: usize| table[i * width..][..width].to_vec();
            let [resistance, radius, length] =
                [&instances.resistance_factor, &instances.radius_factor, &instances.length_factor].map(|t| row(t, vessels));
            let tubes: Vec<Tube> = network
                .vessels()
                .enumerate()
                .map(|(v, (_, vessel))| {
                    let tube = Tube::of(vessel, VISCOSITY);
                    Tube {
                        resistance: tube.resistance * resistance[v],
                        volume: tube.volume * (radius[v] * radius[v] * length[v]),
                        radius: tube.radius * radius[v],
                    }
                })
                .collect();
            let alone = State::solve(network, boundary, &tubes, VISCOSITY).expect("solved");
            let near = |a: f64, b: f64| (a.is_nan() && b.is_nan()) || (a - b).abs() <= within * a.abs().max(b.abs());
            for (found, known) in row(&instances.pressure, nodes).iter().zip(&alone.pressure) {
                assert!(near(*found, known.unwrap_or(f64::NAN)), "{name} {class} {i}: {found} {known:?}");
            }
            for (found, known) in row(&instances.flow, vessels).iter().zip(&alone.vessels) {
                assert!(near(*found, known.flow), "{name} {class} {i}: {found} {}", known.flow);
            }
            assert!(near(instances.network_resilience[i], alone.network_resilience) && near(instances.inflow[i], alone.inflow));
        }
    }
}

#[test]
fn instances_side_by_side_are_what_each_is_alone() {
    let network = circle();
    for reading in [Reading::Increment, Reading::Conductance, Reading::Literal, Reading::Geometry] {
        let params = ModulationOptions { samples: 131, reading, ..ModulationOptions::default() };
        for ground in [true, false] {
            agrees_with_single_solves("circle", &network, &conditions(&network, ground), &params, 1e-12);
        }
    }
    for seed in 0..100 {
        let mut draw = Draw::new(seed);
        let nodes = 6 + draw.below(20);
        let vessels = nodes + draw.below(nodes);
        let network = random_network(&mut draw, nodes, vessels, radii(0.3, 2.0));
        let conditions = boundary(&network, &random_conditions(&mut draw, nodes));
        agrees_with_single_solves(
            "random",
            &network,
            &conditions,
            &ModulationOptions { samples: 9, seed, ..ModulationOptions::default() },
            1e-12,
        );
    }
}

/// A complete graph of 240 nodes takes more mesh updates than the lanes are given.
#[test]
fn a_dense_network_goes_to_the_sparse_solver() {
    let mut draw = Draw::new(3);
    let pairs = (0..240).flat_map(|a| (0..a).map(move |b| [b, a]));
    let network = vessels::network(240, pairs.map(|ends| (ends, vessels::tube(draw.within(5.0, 20.0), draw.within(0.3, 2.0)))));
    let conditions = boundary(&network, &[(0, Condition::Pressure(100.0 * networks::MMHG)), (1, Condition::Pressure(0.0))]);
    let params = ModulationOptions { samples: 2, classes: Class::PAPER[..1].to_vec(), ..ModulationOptions::default() };
    assert_eq!(run(&network, &conditions, &params).solver, "gradients");
    // Alone it is solved by iteration.
    agrees_with_single_solves("dense", &network, &conditions, &params, 1e-9);
}

fn bits(result: &Modulation) -> Vec<u64> {
    let tables = |i: &Instances| {
        [i.pressure.clone(), i.drop.clone(), i.flow.clone(), i.resilience.clone(), i.force.clone(), i.inflow.clone()].concat()
    };
    result.classes.iter().flat_map(|(_, i)| tables(i)).map(f64::to_bits).collect()
}

#[test]
fn one_two_and_eight_threads_give_the_same_bits() {
    let network = circle();
    let boundary = conditions(&network, false);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            bits(&run(
                &network,
                &boundary,
                &ModulationOptions { samples: 1000, reading: Reading::Geometry, ..ModulationOptions::default() },
            ))
        })
    };
    let one = on(1);
    assert!(one == on(2) && one == on(8));
}

/// Neither how many instances are asked for, nor what the other classes hold, nor which other vessels are modulated changes
/// a draw; the seed does.
#[test]
fn an_instance_depends_on_seed_class_and_index_alone() {
    let network = circle();
    let boundary = conditions(&network, false);
    let of = |params: ModulationOptions| run(&network, &boundary, &params);
    let whole = of(ModulationOptions { samples: 200, ..ModulationOptions::default() });
    let short = of(ModulationOptions { samples: 70, ..ModulationOptions::default() });
    let vessels = network.vessel_count();
    for (long, short) in whole.classes.iter().zip(&short.classes) {
        assert_eq!(long.1.resistance_factor[..70 * vessels], short.1.resistance_factor);
        assert_eq!(long.1.flow[..70 * vessels], short.1.flow);
    }
    let first = of(ModulationOptions { samples: 200, classes: Class::PAPER[..1].to_vec(), ..ModulationOptions::default() });
    assert_eq!(first.classes[0], whole.classes[0]);
    let one: Vec<bool> = (0..vessels).map(|v| v == 3).collect();
    let single = of(ModulationOptions { samples: 200, vessels: Some(one), ..ModulationOptions::default() });
    for (alone, all) in
        single.classes[1].1.resistance_factor.chunks(vessels).zip(whole.classes[1].1.resistance_factor.chunks(vessels))
    {
        assert!(alone.iter().enumerate().all(|(v, f)| *f == if v == 3 { all[3] } else { 1.0 }));
    }
    assert_ne!(bits(&of(ModulationOptions { samples: 200, seed: 1, ..ModulationOptions::default() })), bits(&whole));
}

/// By hand: when every vessel is modulated by the same u (a class of no width to speak of) and outlets are ground, pressures
/// stay, flows fall by the factor of the resistance, and resilience falls by that times the factor of the volume.
#[test]
fn one_common_modulation_scales_the_flow() {
    let (network, u) = (circle(), 0.3_f64);
    let boundary = conditions(&network, true);
    let geometry = (1.0 + u) / (1.0 - u).powi(4);
    for (reading, resistance, volume) in [
        (Reading::Increment, 1.0 + u, 1.0),
        (Reading::Conductance, 1.0 / (1.0 - u), 1.0),
        (Reading::Literal, 1.0 - u, 1.0),
        (Reading::Geometry, geometry, (1.0 - u).powi(2) * (1.0 + u)),
    ] {
        let classes = vec![Class { low: u, high: u + 1e-13 }];
        let result =
            run(&network, &boundary, &ModulationOptions { classes, reading, samples: 3, ..ModulationOptions::default() });
        let (rest, found) = (&result.unperturbed, &result.classes[0].1);
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-10 * b.abs();
        for i in 0..3 {
            assert!(near(found.inflow[i] * resistance, rest.inflow[0]), "{reading:?}");
            assert!(near(found.network_resilience[i] * resistance * volume, rest.network_resilience[0]), "{reading:?}");
            assert!(
                found.pressure.chunks(rest.pressure.len()).all(|row| row.iter().zip(&rest.pressure).all(|(a, b)| near(*a, *b)))
            );
        }
    }
}

/// Every draw lies in its class; mean and variance are those of the uniform distribution: 60,000 draws, five standard errors.
#[test]
fn draws_are_uniform_within_their_class() {
    let network = circle();
    let result = run(&network, &conditions(&network, true), &ModulationOptions { samples: 3000, ..ModulationOptions::default() });
    for (class, instances) in &result.classes {
        let u: Vec<f64> = instances.resistance_factor.iter().map(|f| f - 1.0).collect();
        let (n, width) = (u.len() as f64, class.high - class.low);
        assert!(u.iter().all(|u| *u >= class.low - 1e-15 && *u <= class.high));
        let mean = u.iter().sum::<f64>() / n;
        let variance = u.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / n;
        assert!((mean - f64::midpoint(class.low, class.high)).abs() < 5.0 * width / (12.0 * n).sqrt());
        // The variance of a uniform distribution's sample variance is w⁴/180 over n.
        assert!((variance - width * width / 12.0).abs() < 5.0 * width * width / (180.0 * n).sqrt());
    }
}

fn gamma_draws(shape: f64, scale: f64, seed: u64, n: usize) -> Vec<f64> {
    let mut rng = stream(seed, 0);
    let draws = Draws::new(shape, scale).expect("a gamma distribution");
    (0..n).map(|_| draws.sample(&mut rng)).collect()
}

/// 50 seeds of 100,000 draws: the errors of shape and scale over their standard errors have a mean square of 1 ± 5 √(2/50).
#[test]
fn a_gamma_fit_errs_by_its_standard_errors() {
    for (shape, scale) in [(0.7, 3.0), (2.5, 40.0), (30.0, 0.01)] {
        let (mut squares, mut sums) = ([0.0; 2], [0.0; 2]);
        for seed in 0..50 {
            let fit = Gamma::fit(&gamma_draws(shape, scale, seed, 100_000)).expect("a fit");
            let z = [(fit.gamma.shape - shape) / fit.shape_error, (fit.gamma.scale - scale) / fit.scale_error];
            for (at, z) in z.into_iter().enumerate() {
                squares[at] += z * z / 50.0;
                sums[at] += z / 50.0;
            }
        }
        println!("shape {shape}, scale {scale}: mean squares {squares:?}, means {sums:?}");
        assert!(squares.iter().all(|s| (s - 1.0).abs() < 5.0 * (2.0_f64 / 50.0).sqrt()), "{squares:?}");
        assert!(sums.iter().all(|s| s.abs() < 5.0 / 50.0_f64.sqrt()), "{sums:?}");
    }
}

const SCIPY: &str = r"
import sys
import numpy as np, scipy.stats as st
rows = [np.array(line.split(), float) for line in sys.stdin]
for row in rows:
    k, _, scale = st.gamma.fit(row, floc=0)
    d = st.kstest(row, st.gamma(k, scale=scale).cdf).statistic
    print(repr(float(k)), repr(float(scale)), repr(float(d)), repr(float(st.gamma.sf(1.5, k, scale=scale))), repr(float(st.gamma.pdf(1.5, k, scale=scale))))
";

/// Shape and scale to 1e-6, where scipy's own search stops; the functions of the distribution to 1e-6 with them.
#[test]
fn scipy_fits_the_same_gamma_distribution() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return;
    };
    let cases = [(0.3, 5.0), (1.0, 1.0), (2.5, 0.7), (12.0, 0.1), (300.0, 0.005)];
    let rows: Vec<Vec<f64>> = (0..).zip(cases).map(|(seed, (k, s))| gamma_draws(k, s, seed, 5000)).collect();
    let text: String = rows.iter().map(|r| r.iter().map(f64::to_string).collect::<Vec<_>>().join(" ") + "\n").collect();
    let mut child =
        Command::new(python).args(["-c", SCIPY]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("python starts");
    child.stdin.take().expect("its input").write_all(text.as_bytes()).expect("written");
    let output = child.wait_with_output().expect("python ends");
    assert!(output.status.success());
    let said = String::from_utf8(output.stdout).expect("text");
    assert_eq!(said.lines().count(), cases.len());
    for (row, line) in rows.iter().zip(said.lines()) {
        let known: Vec<f64> = line.split_whitespace().map(|x| x.parse().expect("a number")).collect();
        let gamma = Gamma::fit(row).expect("a fit").gamma;
        let found = [gamma.shape, gamma.scale, gamma.distance(row), gamma.survival(1.5), gamma.density(1.5)];
        println!("{found:?} against {known:?}");
        for (found, known) in found.iter().zip(&known) {
            assert!((found - known).abs() <= 1e-6 * known.abs().max(1e-3), "{found} against {known}");
        }
    }
}

/// Three classes of one width, each of several blocks: what is drawn of the width for one vessel never comes again.
#[test]
fn no_two_instances_are_drawn_from_one_stream() {
    let network = circle();
    let classes = [0.0, 0.2, 0.4].map(|low| Class { low, high: low + 0.2 });
    let params = ModulationOptions { classes: classes.to_vec(), samples: 256, seed: 4, ..ModulationOptions::default() };
    let result = run(&network, &conditions(&network, true), &params);
    let mut drawn: Vec<f64> = Vec::new();
    for (class, instances) in &result.classes {
        let first = instances.resistance_factor.iter().step_by(network.vessel_count());
        drawn.extend(first.map(|factor| factor - 1.0 - class.low));
    }
    drawn.sort_by(f64::total_cmp);
    assert_eq!(drawn.len(), 3 * 256);
    let nearest = drawn.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    assert!(nearest > 1e-12, "{nearest}");
}

#[test]
fn the_trigamma_function_has_its_known_values() {
    let pi_squared = std::f64::consts::PI.powi(2);
    // Abramowitz & Stegun 6.4.2 - 6.4.5; the last is scipy.special.polygamma(1, 1000).
    for (x, known) in
        [(1.0, pi_squared / 6.0), (0.5, pi_squared / 2.0), (2.0, pi_squared / 6.0 - 1.0), (1e3, 0.001_000_500_166_666_633_4)]
    {
        assert!((trigamma(x) / known - 1.0).abs() < 1e-14, "{x}: {}", trigamma(x));
    }
}

#[test]
fn an_exponential_distribution_is_the_gamma_of_shape_one() {
    let gamma = Gamma { shape: 1.0, scale: 2.0 };
    for x in [0.1, 1.0, 7.0] {
        assert!((gamma.density(x) - (-x / 2.0).exp() / 2.0).abs() < 1e-15);
        assert!((gamma.survival(x) - (-x / 2.0).exp()).abs() < 1e-15);
    }
    assert_eq!(gamma.survival(-1.0), 1.0);
    assert_eq!((gamma.survival(1e308), gamma.cumulative(1e308)), (0.0, 1.0));
    assert_eq!((Gamma { scale: 0.01, ..gamma }).survival(1e308), 0.0);
}

/// Values m(1 ± d) in equal number: with the variance d² of x/m, k is 1/d² but for terms of order 1.
#[test]
fn values_that_hardly_differ_are_fitted_or_refused() {
    for exponent in 1..=16 {
        let d = 10_f64.powi(-exponent);
        let values: Vec<f64> = (0..100).map(|i| 3.0 * if i % 2 == 0 { 1.0 + d } else { 1.0 - d }).collect();
        match Gamma::fit(&values) {
            Some(fit) => {
                assert!(exponent < 7 && (fit.gamma.shape * d * d - 1.0).abs() < 2.0 * d * d + 1e-3, "{d}: {fit:?}");
                assert!(fit.shape_error > 0.0 && fit.shape_error.is_finite());
            }
            None => assert!(exponent >= 6, "{d}"),
        }
    }
}

/// Below the limit of the series the difference rounds to some 1e-16 ln(k)/(1/2k), 3e-12 of itself.
#[test]
fn series_and_differences_meet() {
    for (figure, most) in [(log_gap as fn(f64) -> f64, 1e-11), (information, 1e-11)] {
        let (below, above) = (figure(LARGE.next_down()), figure(LARGE));
        assert!((below / above - 1.0).abs() < most, "{below} {above}");
    }
}

/// scipy.special.gammaincc(k, k + z √k).
#[test]
fn a_large_shape_has_its_known_tails() {
    let known = [
        (1e6, 997_000.0, 0.998_661_895_832_686_4),
        (1e6, 999_500.0, 0.691_374_443_109_184_7),
        (1e6, 1e6, 0.499_867_019_239_127_4),
        (1e6, 1_000_010.0, 0.495_877_683_203_090_5),
        (1e6, 1_002_000.0, 0.022_804_095_898_769_836),
        (1e6, 1_005_000.0, 2.987_490_140_114_635e-7),
        (3e9, 2_999_835_683.232_748_5, 0.998_650_317_731_204),
        (3e9, 3e9, 0.499_997_572_114_598_67),
        (3e9, 3_000_273_861.278_753, 2.868_687_884_830_747_7e-7),
    ];
    for (shape, t, tail) in known {
        let gamma = Gamma { shape, scale: 0.5 };
        assert!((gamma.survival(0.5 * t) / tail - 1.0).abs() < 1e-7, "{shape} {t}: {}", gamma.survival(0.5 * t));
        assert!((gamma.cumulative(0.5 * t) / (1.0 - tail) - 1.0).abs() < 1e-7, "{shape} {t}");
    }
    assert_eq!((Gamma { shape: 5e11, scale: 1.0 }).survival(1e300), 0.0);
}

#[test]
fn values_without_spread_have_no_fit() {
    assert_eq!(Gamma::fit(&[]), None);
    assert_eq!(Gamma::fit(&[3.0]), None);
    assert_eq!(Gamma::fit(&[3.0, 3.0, 3.0]), None);
}

#[test]
fn forces_fall_into_their_bins_by_hand() {
    let forces = [0.0, f64::NAN, 1.0, 2.0, 2.0, 10.0];
    let edges = [0.0, 1.0, 2.0, 10.0];
    let found = Hypertension::of(&forces, &edges, 2.0);
    assert_eq!(found.counts, [1, 2, 1]);
    assert!((found.without_force - 1.0 / 3.0).abs() < 1e-15);
    assert!((found.above - 1.0 / 6.0).abs() < 1e-15);
    assert!(histogram_edges([&[0.0, f64::NAN][..]]).is_empty());
    // 50 times some of these, divided by 50, is less. Whatever is the largest, it is in the last bin.
    for largest in (1..1000).map(|n| f64::from(n) / 7.0) {
        let forces = [largest; 3];
        let edges = histogram_edges([&forces[..]]);
        assert_eq!(Hypertension::of(&forces, &edges, 0.0).counts.last(), Some(&3), "{largest}");
    }
    assert!((hypertension_force([Some(3.0), Some(1.0)], 0.5) - 2.0 / (PI * 0.25)).abs() < 1e-15);
    assert!(hypertension_force([None, Some(1.0)], 0.5).is_nan());
}

/// By hand: of 20 vessels one is a twentieth; two mirror vessels at the top are both above, whatever their last bits.
#[test]
fn the_threshold_lies_below_a_twentieth_of_the_vessels() {
    let rising: Vec<f64> = (1..=20).map(f64::from).collect();
    assert!((risk_threshold(&rising) - 19.5).abs() < 1e-12);
    let twice = [&rising[..], &rising[..], &[f64::NAN]].concat();
    assert!((risk_threshold(&twice) - 19.5).abs() < 1e-12);
    let mirror = [&rising[..19], &[19.0 * (1.0 + 1e-15)]].concat();
    assert!((risk_threshold(&mirror) - 18.5).abs() < 1e-12);
    assert!((risk_threshold(&[3.0, 3.0]) - 3.0).abs() < 1e-12);
    assert!(risk_threshold(&[f64::NAN]).is_nan() && risk_threshold(&[]).is_nan());
}

#[test]
fn every_field_out_of_its_range_is_refused_by_name() {
    let class = |low, high| ModulationOptions { classes: vec![Class { low, high }], ..ModulationOptions::default() };
    let twice = vec![Class { low: 0.0, high: 0.2 }; 2];
    let cases = [
        (class(0.5, 0.2), "0.5:0.2: the class ends before it begins"),
        (class(0.2, 0.2), "0.2:0.2: the class ends before it begins"),
        (class(-0.1, 0.2), "-0.1:0.2: expected LOW:HIGH with 0 <= low < high < 1"),
        (class(0.5, 1.0), "0.5:1: expected"),
        (class(f64::NAN, 0.5), "NaN:0.5: expected"),
        (ModulationOptions { classes: Vec::new(), ..ModulationOptions::default() }, "classes of 0"),
        (ModulationOptions { classes: twice, ..ModulationOptions::default() }, "0:0.2: given twice"),
        (ModulationOptions { samples: 0, ..ModulationOptions::default() }, "samples 0"),
        (ModulationOptions { samples: 1 << 25, ..ModulationOptions::default() }, "samples 33554432"),
        (ModulationOptions { viscosity: 0.0, ..ModulationOptions::default() }, "viscosity 0"),
    ];
    for (params, words) in cases {
        let said = params.validate().expect_err("refused").to_string();
        assert!(said.contains(words), "{said}");
    }
    assert!(ModulationOptions::default().validate().is_ok());
}
