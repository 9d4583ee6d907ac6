//! The pulse: closed forms of one tube, of outlets and of a fork, laws of conservation, and what must not change the answer.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use willis::internals::flow::{WallLaw, poiseuille::resistance};
use willis::internals::network::waveform::{Quantity, Waveform};
use willis::internals::network::{Condition, Network, Vessel, Wall, Windkessel};
use willis::internals::perturbation::{Stenosis, StretchPlace};
use willis::internals::simulation::pulse::Friction;
use willis::internals::simulation::pulse::arrival::rises;
use willis::internals::simulation::pulse::fourier::{Indices, behind};
use willis::internals::simulation::pulse::fourier::{coefficients, samples};
use willis::internals::simulation::pulse::womersley::{Fluid, TubeSegment, viscous};
use willis::internals::simulation::{Change, Perturbation};

use crate::draw::Draw;
use crate::networks::{MMHG, VISCOSITY, random_network};
use crate::pulse_case::{BLOOD, Case, RESISTANCE, flow, pressure_wave};
use crate::vessels::{network, tube};

fn c(re: f64, im: f64) -> Complex64 {
    Complex64::new(re, im)
}

fn near(got: Complex64, expected: Complex64, within: f64, what: &str) {
    assert!((got - expected).norm() <= within * expected.norm(), "{what}: {got} for {expected}");
}

fn outlet(resistance: f64) -> Condition {
    Condition::Resistance { resistance, venous: 0.0 }
}

/// Values with twelve digits of another program, which checked them against the Bessel functions of SciPy.
#[test]
fn the_viscous_function_is_that_of_bessel_functions() {
    let values = [
        (0.5, 0.998_212_970_577, -0.041_589_499_638),
        (1.0, 0.972_184_730_686, -0.161_862_361_410),
        (2.0, 0.689_791_018_450, -0.452_446_061_801),
        (3.0, 0.319_966_968_109, -0.445_324_179_923),
        (5.0, 0.077_311_365_420, -0.229_102_204_616),
        (10.0, 0.010_499_846_222, -0.068_669_962_532),
        (20.0, 0.001_363_773_623, -0.018_585_311_548),
    ];
    assert_eq!(viscous(0.0), Complex64::ONE);
    for (alpha, re, im) in values {
        assert!((viscous(alpha) - c(re, im)).norm() < 1e-12, "{alpha}");
    }
    // 1 - F10 = 1 - 2 e^{-iπ/4}/α + ... far above.
    let far = viscous(1e3) * c(0.0, 1e6 / 8.0);
    near(far, Complex64::ONE - Complex64::cis(-PI / 4.0) * 2e-3, 2e-6, "α = 1000");
    // 2 ive(1, x)/(x ive(0, x)) of SciPy, x = α√i, on both sides of where the series takes over; and 2/x - 1/x², so far that no fraction gets there.
    let values = [
        (1e4, 1.414_213_564_141_112e-4, -1.414_113_560_605_328e-4, 1e-10),
        (2e4, 7.071_067_814_075_34e-5, -7.070_817_809_655_764e-5, 1e-10),
        (1e10, 1.414_213_562_373_095e-10, -1.414_213_562_273_095e-10, 1e-5),
    ];
    for (alpha, re, im, within) in values {
        let f10 = Complex64::ONE - viscous(alpha) * c(0.0, alpha * alpha / 8.0);
        near(f10, c(re, im), within, "F10 far above");
    }
}

/// A tube of 200 mm, 2 mm and 8 m/s that ends in 7.5 mmHg·s/mL before 0.016 mL/mmHg beside 37.5 mmHg·s/mL.
fn tube_with_windkessel() -> Network {
    let mut tubes = network(2, [([0, 1], Vessel { wall: Some(Wall::Speed(8.0)), ..tube(200.0, 2.0) })]);
    tubes.node_mut(1).windkessel = Windkessel { proximal: Some(7.5 * RESISTANCE), compliance: Some(0.016 / RESISTANCE) }.stated();
    tubes
}

fn impedance(hertz: f64, fluid: Fluid) -> (Complex64, Complex64, f64) {
    let tubes = tube_with_windkessel();
    let conditions = [(0, Condition::Flow(1e-6)), (1, outlet(45.0 * RESISTANCE))];
    let drive = flow(0, &[c(1e-6, 0.0), c(1e-6, 0.0)]);
    let case = Case { law: WallLaw::Stated, fluid, period: 1.0 / hertz, ..Case::new(&tubes, &conditions, vec![drive]) };
    let pulse = case.solve();
    let pressure = pulse.pressure[0].as_ref().expect("a pressure");
    let [first, _, last] = &pulse.vessels[0].flow;
    near(pressure[0], c(45.835_632_051_9e-6 * RESISTANCE, 0.0), 1e-11, "at rest");
    (pressure[1] / 1e-6 / RESISTANCE, last[1] / first[1], pulse.walls[0].halves[0][0].phase_speed(&fluid, TAU * hertz))
}

/// The transmission line, solved with forward and backward waves by another program to eleven digits.
#[test]
fn one_tube_before_a_windkessel() {
    let creeping = Fluid { wall_viscosity: 0.01, ..BLOOD };
    let parabolic = Fluid { friction: Friction::Parabolic, ..BLOOD };
    let cases = [
        (1.0, BLOOD, c(6.492_803_479_8, -7.920_275_837_9), c(0.740_163_618_7, -0.188_009_525_8), 6.488_717_672_670),
        (2.0, BLOOD, c(5.297_783_025_0, -4.160_464_341_3), c(0.687_229_903_4, -0.295_012_644_9), 6.858_600_201_417),
        (2.0, creeping, c(5.348_741_097_8, -3.806_129_136_5), c(0.676_682_837_0, -0.258_406_173_5), 6.996_961_032_755),
        (2.0, parabolic, c(5.092_849_883_6, -4.454_094_419_7), c(0.681_726_195_8, -0.287_779_300_7), 7.752_619_352_848),
        (5.0, BLOOD, c(4.602_745_847_4, -1.764_956_814_8), c(0.427_426_700_2, -0.549_800_355_0), 7.196_333_706_597),
        (10.0, BLOOD, c(4.387_027_240_7, 0.013_254_568_8), c(-0.039_036_105_3, -0.648_506_358_0), 7.407_182_170_329),
    ];
    for (hertz, fluid, input, passed, speed) in cases {
        let (z, ratio, phase) = impedance(hertz, fluid);
        assert!((z - input).norm() < 1.5e-10 && (ratio - passed).norm() < 1.5e-10, "{hertz} Hz: {z}, {ratio}");
        assert!((phase - speed).abs() < 1e-10, "{hertz} Hz: {phase}");
    }
}

/// By hand: a rigid tube of a parabolic profile is R + iωL with L = ρl/A; a resistance before R2 beside C is a Windkessel; what only an
/// elastic tube holds, closed at its far end, is a compliance as long as the wave is long.
#[test]
fn resistance_inertance_and_compliance() {
    let (length, radius, frequency): (f64, f64, f64) = (0.1, 2e-3, TAU);
    let tubes = network(2, [([0, 1], tube(100.0, 2.0))]);
    let conditions = [(0, Condition::Pressure(100.0)), (1, outlet(2e9))];
    let drives = || vec![pressure_wave(0, &[c(100.0, 0.0), c(1.0, 0.0)])];
    let fluid = Fluid { friction: Friction::Parabolic, ..BLOOD };
    let rigid = Case { law: WallLaw::Rigid, fluid, time_constant: None, ..Case::new(&tubes, &conditions, drives()) };
    let area = PI * radius * radius;
    let line = c(resistance(1.0, radius, VISCOSITY) * length, frequency * 1060.0 * length / area);
    near(rigid.solve().vessels[0].flow[1][1], (line + 2e9).inv(), 1e-12, "R and L");

    let mut behind = tubes.clone();
    behind.node_mut(1).windkessel = Windkessel { proximal: Some(5e8), compliance: Some(1e-10) }.stated();
    let case = Case { law: WallLaw::Rigid, fluid, ..Case::new(&behind, &conditions, drives()) };
    let z = line + 5e8 + (c(1.0 / 1.5e9, 1e-10 * frequency)).inv();
    near(case.solve().vessels[0].flow[1][1], z.inv(), 1e-12, "R, C and R");
    behind.node_mut(1).windkessel = Windkessel { proximal: Some(0.0), compliance: Some(1e-10) }.stated();
    let case = Case { law: WallLaw::Rigid, fluid, ..Case::new(&behind, &conditions, drives()) };
    near(case.solve().vessels[0].flow[1][1], (line + c(1.0 / 2e9, 1e-10 * frequency).inv()).inv(), 1e-12, "R and C");

    // Two tubes at the inlet, one of them a dead end: it breathes.
    let dead = network(3, [([0, 1], tube(100.0, 2.0)), ([0, 2], tube(10.0, 2.0))]);
    let case = Case { law: WallLaw::Speed(8.0), ..Case::new(&dead, &conditions, drives()) };
    let compliance = area / (1060.0 * 64.0) * 0.01;
    near(case.solve().vessels[1].flow[0][1], c(0.0, compliance * frequency), 1e-3, "a dead end");
}

/// (Y0 - Y1 - Y2)/(Y0 + Y1 + Y2) of a fork whose daughters end in their own wave impedance, by another program.
#[test]
fn a_fork_reflects() {
    let speed = |speed: f64, vessel: Vessel| Vessel { wall: Some(Wall::Speed(speed)), ..vessel };
    let admittance = |radius: f64, speed: f64| {
        let area = PI * radius * radius;
        let segment = TubeSegment { length: 1.0, radius, compliance: area / (1060.0 * speed * speed), excess: 0.0 };
        let (z, y) = segment.line(&BLOOD, TAU);
        ((y / z).sqrt(), (z * y).sqrt())
    };
    let ((y0, gamma), (y1, _), (y2, _)) = (admittance(2e-3, 8.0), admittance(1.5e-3, 10.0), admittance(1.2e-3, 12.0));
    let reflection = (y0 - y1 - y2) / (y0 + y1 + y2);
    assert!((reflection - c(0.281_827, -0.074_511)).norm() < 1e-6, "{reflection}");
    // Tubes so long that nothing returns from their ends are their own wave impedance.
    let long = |radius_mm: f64, own: f64| speed(own, tube(200_000.0, radius_mm));
    let fork = network(4, [([0, 1], speed(8.0, tube(200.0, 2.0))), ([1, 2], long(1.5, 10.0)), ([1, 3], long(1.2, 12.0))]);
    let conditions = [(0, Condition::Flow(1e-6)), (2, outlet(1e9)), (3, outlet(1e9))];
    let drives = vec![flow(0, &[c(1e-6, 0.0), c(1e-6, 0.0)])];
    let pulse = Case { law: WallLaw::Stated, ..Case::new(&fork, &conditions, drives) }.solve();
    let back = reflection * (gamma * -0.4).exp();
    let expected = (Complex64::ONE + back) / (Complex64::ONE - back) / y0;
    near(pulse.pressure[0].as_ref().expect("a pressure")[1] / 1e-6, expected, 1e-10, "input impedance");
}

/// Olufsen 1999, by another program; the law as the one that a graph may state.
#[test]
fn walls_give_their_wave_speed() {
    let speeds =
        [(0.73, 17.241_255_407), (1.0, 13.659_539_515), (1.43, 10.225_975_230), (2.0, 8.263_927_989), (4.0, 7.386_196_350)];
    for (mm, speed) in speeds {
        let radius = mm / 1e3;
        let compliance = WallLaw::OLUFSEN.compliance(radius, None, 1060.0, "it").expect("a wall");
        let segment = TubeSegment { length: 1.0, radius, compliance, excess: 0.0 };
        assert!((segment.wave_speed(&BLOOD) - speed).abs() < 1e-8, "{mm}");
        // c0² = (2/3)(Eh/r)/ρ.
        let stiffness = 1.5 * 1060.0 * speed * speed * radius;
        let same = WallLaw::Stiffness(stiffness).compliance(radius, None, 1060.0, "it").expect("a wall");
        assert!((same / compliance - 1.0).abs() < 1e-8);
        let stated = Some(Wall::Elastic { young: stiffness / 2e-4, thickness: 2e-4 });
        let same = WallLaw::Stated.compliance(radius, stated, 1060.0, "it").expect("a wall");
        assert!((same / compliance - 1.0).abs() < 1e-8);
    }
    let negative = WallLaw::Olufsen { k1: 2e6, k2: -2253.0, k3: -1e5 };
    let refused = negative.compliance(4e-3, None, 1060.0, "L-ICA I").expect_err("negative").to_string();
    assert!(refused.contains("L-ICA I of radius 4 mm") && refused.contains("positive"), "{refused}");
    assert!(WallLaw::Stated.compliance(4e-3, None, 1060.0, "L-ICA I").is_err());
}

/// Womersley's rigid tube: the flow is the integral of the profile (1 - J0(zr/R)/J0(z))/(iωρ), which is (1 - F10) A/(iωρ).
#[test]
fn a_stiff_wall_is_womersleys_rigid_tube() {
    let tubes = network(2, [([0, 1], tube(100.0, 2.0))]);
    let conditions = [(0, Condition::Pressure(100.0)), (1, Condition::Pressure(0.0))];
    let case = |law| Case { law, ..Case::new(&tubes, &conditions, vec![pressure_wave(0, &[c(100.0, 0.0), c(1.0, 0.0)])]) };
    // The Bessel series J0(x) = Σ (-x²/4)^k/(k!)², J1(x) = (x/2) Σ (-x²/4)^k/(k!(k+1)!), at α = 2.76.
    let alpha = 2e-3 * (TAU * 1060.0 / VISCOSITY).sqrt();
    let z = Complex64::cis(0.75 * PI) * alpha;
    let (mut j0, mut j1, mut term) = (Complex64::ZERO, Complex64::ZERO, Complex64::ONE);
    for k in 0..60_u32 {
        j0 += term;
        j1 += term / f64::from(k + 1);
        term *= -z * z / 4.0 / f64::from((k + 1) * (k + 1));
    }
    let f10 = j1 * z / 2.0 * 2.0 / (z * j0);
    let expected = (Complex64::ONE - f10) * (PI * 4e-6) / c(0.0, TAU * 1060.0 * 0.1);
    near(case(WallLaw::Rigid).solve().vessels[0].flow[1][1], expected, 1e-12, "rigid");
    near(case(WallLaw::Speed(1e7)).solve().vessels[0].flow[1][1], expected, 1e-10, "stiff");
}

/// A random network with three outlets, driven at node 0.
fn random_case(draw: &mut Draw) -> (Network, Vec<(usize, Condition)>, Vec<Complex64>) {
    let nodes = 6 + draw.below(20);
    let network = random_network(draw, nodes, nodes + nodes / 2, |draw| draw.within(0.4, 2.5));
    let mut conditions = vec![(0, Condition::Pressure(100.0 * MMHG))];
    for node in 1..4 {
        let venous = draw.within(0.0, 5.0) * MMHG;
        conditions.push((node, Condition::Resistance { resistance: draw.within(1e9, 2e10), venous }));
    }
    let mut wave = vec![c(100.0 * MMHG, 0.0)];
    wave.extend((1..9).map(|n| c(draw.within(-1.0, 1.0), draw.within(-1.0, 1.0)) * (2000.0 / f64::from(n))));
    (network, conditions, wave)
}

/// Kirchhoff's law at every node and harmonic, the energy that goes in against what vessels and outlets lose, and no vessel that makes any.
#[test]
fn mass_and_energy_are_kept_at_every_harmonic() {
    let mut draw = Draw::new(11);
    for round in 0..25 {
        let (network, conditions, wave) = random_case(&mut draw);
        let pulse = Case::new(&network, &conditions, vec![pressure_wave(0, &wave)]).solve();
        let pressure = |node: usize, n: usize| pulse.pressure[node].as_ref().expect("a pressure")[n];
        for n in 1..wave.len() {
            let mut left = vec![Complex64::ZERO; network.node_count()];
            let (mut lost, mut scale) = (0.0, 0.0_f64);
            for (row, vessel) in pulse.vessels.iter().enumerate() {
                let ([a, b], [first, _, last]) = (network.ends(row), &vessel.flow);
                left[a] += first[n];
                left[b] -= last[n];
                let power = (pressure(a, n) * first[n].conj()).re - (pressure(b, n) * last[n].conj()).re;
                lost += power;
                scale = scale.max(first[n].norm());
                assert!(power >= -1e-12 * (pressure(a, n) * first[n]).norm(), "round {round}: vessel {row} makes {power} W");
            }
            let mut given = (pressure(0, n) * left[0].conj()).re;
            for (node, condition) in &conditions[1..] {
                // What leaves through a Windkessel is -left; its power is never negative.
                let power = (pressure(*node, n) * -left[*node].conj()).re;
                assert!(power > 0.0);
                lost += power;
                let Condition::Resistance { resistance, .. } = condition else { continue };
                let z = pressure(*node, n) / -left[*node];
                assert!(z.re > 0.0 && z.norm() <= resistance * (1.0 + 1e-9), "round {round}: {z}");
            }
            for (node, left) in left.iter().enumerate().skip(4) {
                assert!(left.norm() <= 1e-11 * scale, "round {round}: node {node} keeps {left} of {scale}");
            }
            given -= lost;
            assert!(given.abs() <= 1e-11 * lost, "round {round}, harmonic {n}: {given} of {lost}");
        }
    }
}

#[test]
fn pieces_direction_and_delay_change_nothing() {
    let mut draw = Draw::new(5);
    for _ in 0..10 {
        let (network_of, conditions, wave) = random_case(&mut draw);
        let pulse = Case::new(&network_of, &conditions, vec![pressure_wave(0, &wave)]).solve();
        let scale = pulse.largest_flow;
        // Every vessel turned round and cut in three.
        let mut pieces = Network::new();
        for node in network_of.nodes() {
            pieces.add_node(node.clone());
        }
        let mut middle = Vec::new();
        for ([a, b], vessel) in network_of.vessels() {
            let cuts = [0, 1].map(|_| pieces.add_node(Default::default()));
            let part = |share: f64| Vessel { length: vessel.length * share, ..vessel.clone() };
            pieces.add_vessel([b, cuts[1]], part(0.2));
            middle.push(pieces.add_vessel([cuts[1], cuts[0]], part(0.6)));
            pieces.add_vessel([cuts[0], a], part(0.2));
        }
        let cut = Case::new(&pieces, &conditions, vec![pressure_wave(0, &wave)]).solve();
        for (row, piece) in middle.iter().enumerate() {
            for n in 0..wave.len() {
                let (whole, piece) = (pulse.vessels[row].flow[1][n], cut.vessels[*piece].flow[1][n]);
                assert!((whole + piece).norm() <= 1e-10 * scale, "{whole} and {piece} of {scale}");
            }
        }
        // A delayed inflow delays everything.
        let delay = |n: usize| Complex64::cis(-TAU * 0.137 * n as f64);
        let late: Vec<Complex64> = wave.iter().enumerate().map(|(n, c)| c * delay(n)).collect();
        let late = Case::new(&network_of, &conditions, vec![pressure_wave(0, &late)]).solve();
        for (a, b) in pulse.vessels.iter().zip(&late.vessels) {
            for n in 0..wave.len() {
                assert!((a.flow[1][n] * delay(n) - b.flow[1][n]).norm() <= 1e-12 * scale);
            }
        }
    }
}

/// A period of 10¹⁵ s is no pulse: the first harmonic is the steady flow of the same amplitude.
#[test]
fn the_limit_of_no_frequency_is_poiseuille() {
    let mut draw = Draw::new(2);
    for _ in 0..10 {
        let (network, conditions, _) = random_case(&mut draw);
        let conditions: Vec<_> = conditions
            .iter()
            .map(|(node, condition)| match condition {
                Condition::Resistance { resistance, .. } => (*node, outlet(*resistance)),
                other => (*node, *other),
            })
            .collect();
        let drives = vec![pressure_wave(0, &[c(100.0 * MMHG, 0.0), c(100.0 * MMHG, 0.0)])];
        let pulse = Case { period: 1e15, ..Case::new(&network, &conditions, drives) }.solve();
        let scale = pulse.largest_flow;
        for ((_, vessel), found) in network.vessels().zip(&pulse.vessels) {
            // Pressures are doubles: their last digits make so much flow through a wide and short vessel.
            let resistance = resistance(1.0, vessel.radius, VISCOSITY) * vessel.length;
            let rounding = 8.0 * f64::EPSILON * 100.0 * MMHG / resistance;
            let off = (found.flow[1][1] - found.flow[1][0]).norm();
            assert!(off <= 1e-12 * scale + rounding, "{off} of {scale}, {rounding}");
        }
    }
}

#[test]
fn a_narrowing_is_a_narrower_vessel_and_its_place_is_noticed() {
    let line = |radii: [f64; 3], lengths: [f64; 3], behind: Windkessel| {
        let mut line = network(4, [0, 1, 2].map(|k| ([k, k + 1], tube(lengths[k], radii[k]))));
        line.node_mut(3).windkessel = behind.stated();
        line
    };
    let wave = [c(100.0 * MMHG, 0.0), c(1000.0, 0.0), c(300.0, 200.0)];
    let ends = [(0, Condition::Pressure(100.0 * MMHG)), (3, outlet(5e9))];
    let solve = |network: &Network, conditions: &[(usize, Condition)], perturbations: Vec<Perturbation>| {
        Case { perturbations, ..Case::new(network, conditions, vec![pressure_wave(0, &wave)]) }.solve()
    };
    // The outlet is the same whatever is narrowed.
    let behind = Windkessel { proximal: Some(4e8), compliance: Some(1e-10) };
    let mut whole = network(2, [([0, 1], tube(60.0, 2.0))]);
    whole.node_mut(1).windkessel = behind.stated();
    let conditions = [(0, ends[0].1), (1, ends[1].1)];
    let narrowed = |place| {
        let change = Change::Stenosis(Stenosis { stretch: Some(0.012), place, ..Stenosis::of_diameter(0.5) });
        solve(&whole, &conditions, vec![Perturbation { vessel: 0, change }])
    };
    let cases = [
        (StretchPlace::Middle, [2.0, 1.0, 2.0], [24.0, 12.0, 24.0]),
        (StretchPlace::Start, [1.0, 2.0, 2.0], [12.0, 24.0, 24.0]),
        (StretchPlace::End, [2.0, 2.0, 1.0], [24.0, 24.0, 12.0]),
    ];
    let mut inflows = Vec::new();
    for (place, radii, lengths) in cases {
        let (one, parts) = (narrowed(place), solve(&line(radii, lengths, behind), &ends, Vec::new()));
        for n in 0..3 {
            near(one.vessels[0].flow[0][n], parts.vessels[0].flow[0][n], 1e-10, "in");
            near(one.vessels[0].flow[2][n], parts.vessels[2].flow[2][n], 1e-10, "out");
        }
        inflows.push(one.vessels[0].flow[0][1]);
    }
    assert!((inflows[1] - inflows[2]).norm() > 1e-3 * inflows[0].norm(), "the place makes a difference");
    let longer = vec![Perturbation { vessel: 0, change: Change::Tortuosity(1.5) }];
    let mut by_hand = network(2, [([0, 1], tube(90.0, 2.0))]);
    by_hand.node_mut(1).windkessel = behind.stated();
    let (longer, by_hand) = (solve(&whole, &conditions, longer), solve(&by_hand, &conditions, Vec::new()));
    near(longer.vessels[0].flow[1][2], by_hand.vessels[0].flow[1][2], 1e-12, "longer");
    let mut stated = whole.clone();
    stated.vessel_mut(0).resistance = Some(resistance(1.0, 2e-3, VISCOSITY) * 0.06);
    near(
        solve(&stated, &conditions, Vec::new()).vessels[0].flow[1][1],
        solve(&whole, &conditions, Vec::new()).vessels[0].flow[1][1],
        1e-12,
        "its own resistance",
    );
}

fn waveform(times: &[f64], values: &[f64]) -> Waveform {
    Waveform { quantity: Quantity::Pressure, times: times.to_vec(), values: values.to_vec() }
}

/// By hand: a square wave has 4/(πn) at odd harmonics, a triangle 8/(πn)²; more points on the same line are the same signal.
#[test]
fn coefficients_of_polylines_and_steps() {
    let square = coefficients(&waveform(&[0.0, 0.5, 0.5, 1.0], &[1.0, 1.0, -1.0, -1.0]), 1.0, 5);
    for (n, found) in square.iter().enumerate().take(6).skip(1) {
        let expected = if n % 2 == 1 { 4.0 / (PI * n as f64) } else { 0.0 };
        assert!((found - c(0.0, -expected)).norm() < 1e-14, "{n}: {found}");
    }
    let triangle = coefficients(&waveform(&[0.0, 1.0], &[1.0, -1.0]), 2.0, 3);
    assert!((triangle[1] - c(8.0 / (PI * PI), 0.0)).norm() < 1e-14 && triangle[2].norm() < 1e-14 && triangle[0].norm() < 1e-15);
    let mut draw = Draw::new(1);
    let times: Vec<f64> = (0..30).map(|k| f64::from(k) * 0.03 + draw.within(0.0, 0.02)).collect();
    let values: Vec<f64> = (0..30).map(|_| draw.within(-1.0, 1.0)).collect();
    let coarse = coefficients(&waveform(&times, &values), 0.95, 20);
    let halfway =
        |x: &[f64]| x.windows(2).flat_map(|pair| [pair[0], f64::midpoint(pair[0], pair[1])]).chain([x[29]]).collect::<Vec<_>>();
    let fine = coefficients(&waveform(&halfway(&times), &halfway(&values)), 0.95, 20);
    for (n, (a, b)) in coarse.iter().zip(&fine).enumerate() {
        assert!((a - b).norm() < 1e-13, "{n}: {a} and {b}");
    }
    // Begun later in the cycle, the signal is the same but for its clock.
    let turned: Vec<f64> = times[10..].iter().copied().chain(times[..10].iter().map(|t| t + 0.95)).collect();
    let turned_values = [&values[10..], &values[..10]].concat();
    for (n, (a, b)) in coarse.iter().zip(coefficients(&waveform(&turned, &turned_values), 0.95, 20)).enumerate() {
        assert!((a - b).norm() < 1e-12, "{n}: {a} and {b}");
    }
}

/// By hand: 2 - 3 cos ωt has mean 2, runs from -1 to 5, and moves back while cos ωt > 2/3.
#[test]
fn indices_of_a_cosine() {
    let found = Indices::of(&[c(2.0, 0.0), c(-3.0, 0.0)], 0.8, 0.0);
    let angle = (2.0_f64 / 3.0).acos();
    let against = (3.0 * angle.sin() - 2.0 * angle) / PI;
    assert!((found.mean - 2.0).abs() < 1e-12 && (found.max - 5.0).abs() < 1e-9 && (found.min + 1.0).abs() < 1e-9);
    assert!((found.pulsatility - 3.0).abs() < 1e-9 && (found.resistive - 1.2).abs() < 1e-9);
    assert!((found.reversed_share - against / (2.0 + 2.0 * against)).abs() < 1e-4, "{}", found.reversed_share);
    assert!((found.reversed - against * 0.8).abs() < 1e-4);
    // The steepest rise is a quarter in; its tangent, 3ω, meets -1 after 3/(3ω) less.
    let [rise] = rises(&[c(2.0, 0.0), c(-3.0, 0.0)], 0.8)[..] else { panic!("one rise") };
    assert!((rise.foot - (0.2 - 0.8 / TAU)).abs() < 1e-9, "{rise:?}");
    assert!(rises(&[c(2.0, 0.0), Complex64::ZERO], 0.8).is_empty());
    assert_eq!(samples(&[c(2.0, 0.0), c(-3.0, 0.0)], 4).map_or_round(), [-1, 2, 5, 2]);
    let back = Indices::of(&[c(-2.0, 0.0), c(3.0, 0.0)], 0.8, 0.0);
    assert!((back.resistive - 1.2).abs() < 1e-9 && behind(back.phase, found.phase, 0.8).abs() < 1e-12);
}

/// A tube without friction that ends in its own wave impedance ρc/A sends nothing back: what enters is everywhere later by x/c, whatever its
/// shape is and whenever its cycle begins, so that its foot is as well.
#[test]
fn in_a_matched_tube_the_pulse_arrives_after_length_over_speed() {
    let (speed, area) = (6.0, PI * 4e-6);
    let fluid = Fluid { viscosity: 1e-12, friction: Friction::Parabolic, ..BLOOD };
    let lengths = [30.0, 250.0, 7.0, 600.0];
    let tubes = network(5, lengths.iter().enumerate().map(|(k, mm)| ([k, k + 1], tube(*mm, 2.0))));
    let ends = [(0, Condition::Pressure(100.0 * MMHG)), (4, outlet(1060.0 * speed / area))];
    let shapes: [(&[f64], &[f64]); 4] = [
        (&[0.0, 0.15, 0.35, 0.42, 0.9], &[80.0, 122.0, 102.0, 104.0, 80.0]),
        (&[0.0, 0.05, 0.3, 0.35, 0.9], &[80.0, 120.0, 90.0, 110.0, 80.0]),
        (&[0.0, 0.1, 0.2, 0.25, 0.9], &[70.0, 95.0, 96.0, 130.0, 70.0]),
        (&[0.0, 0.45, 0.9], &[80.0, 120.0, 80.0]),
    ];
    for (shape, (times, mmhg)) in shapes.into_iter().enumerate() {
        for offset in [0.0, 0.2, 0.45, 0.6, 0.88] {
            for harmonics in [1, 8, 40] {
                let pascals: Vec<f64> = mmhg.iter().map(|p| p * MMHG).collect();
                let wave = coefficients(&waveform(times, &pascals), 0.9, harmonics);
                let late = |n: usize| Complex64::cis(-TAU * n as f64 * offset / 0.9);
                let wave: Vec<Complex64> = wave.iter().enumerate().map(|(n, c)| c * late(n)).collect();
                let case = Case {
                    law: WallLaw::Speed(speed),
                    fluid,
                    period: 0.9,
                    time_constant: None,
                    ..Case::new(&tubes, &ends, vec![pressure_wave(0, &wave)])
                };
                let found = case.solve().arrivals;
                let mut x = 0.0;
                for (row, mm) in lengths.iter().enumerate() {
                    for (place, foot) in [(x + mm / 2e3, found.vessels[row]), (x + mm / 1e3, found.nodes[row + 1])] {
                        let off = foot - found.first - place / speed;
                        assert!(off.abs() < 1e-6, "shape {shape}, {harmonics} harmonics, {offset} s: {off} s off at {place} m");
                    }
                    x += mm / 1e3;
                }
                assert_eq!(found.nodes[0], found.first);
            }
        }
    }
}

/// Whatever comes back, blood pressure rises at no place before it does at the place upstream; nothing rises where pressure is held, nor beyond.
#[test]
fn no_pulse_is_before_the_one_upstream() {
    let pascals: Vec<f64> = [80.0, 122.0, 102.0, 104.0, 80.0].map(|p| p * MMHG).to_vec();
    let wave = coefficients(&waveform(&[0.0, 0.15, 0.35, 0.42, 0.9], &pascals), 0.9, 40);
    let mut draw = Draw::new(8);
    for round in 0..40 {
        let pieces = 2 + draw.below(5);
        let mut line =
            network(pieces + 2, (0..pieces).map(|k| ([k, k + 1], tube(draw.within(5.0, 200.0), draw.within(0.4, 3.0)))));
        line.add_vessel([pieces, pieces + 1], tube(20.0, 1.0));
        let end = if round % 2 == 0 { Condition::Pressure(0.0) } else { outlet(draw.within(1e8, 5e10)) };
        let conditions = [(0, Condition::Pressure(100.0 * MMHG)), (pieces, end)];
        let drive =
            if round % 3 == 0 { flow(0, &wave.iter().map(|c| c * 1e-10).collect::<Vec<_>>()) } else { pressure_wave(0, &wave) };
        let found = Case { period: 0.9, ..Case::new(&line, &conditions, vec![drive]) }.solve().arrivals;
        let mut before = found.first;
        for (row, (vessel, node)) in found.vessels.iter().zip(&found.nodes[1..]).enumerate().take(pieces) {
            assert!(*vessel >= before, "round {round}, vessel {row}: {vessel} after {before}");
            if row + 1 < pieces || round % 2 == 1 {
                assert!(*node >= *vessel && *node < found.first + 0.9, "round {round}, node {}: {node} after {vessel}", row + 1);
                before = *node;
            } else {
                assert!(node.is_nan() && found.vessels[pieces].is_nan(), "round {round}: {node}");
            }
        }
    }
}

trait Rounded {
    fn map_or_round(self) -> Vec<i64>;
}

impl Rounded for Vec<f64> {
    fn map_or_round(self) -> Vec<i64> {
        self.into_iter().map(|x| x.round() as i64).collect()
    }
}
