//! Forward simulation: circuits solved by hand in the comment above each, identities of the physics, and the values of an
//! independent dense solve of the Circle of Willis.

use crate::draw::Draw;
use crate::networks::{MMHG, VISCOSITY, boundary, log_radii, pressure, random_conditions, random_network};
use crate::vessels::{network, tube};
use willis::internals::flow::state::State;
use willis::internals::flow::{Boundary, Tube};
use willis::internals::network::{Condition, Network, Vessel};
use willis::internals::perturbation::{Stenosis, StretchPlace};
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::internals::simulation::{Change, Perturbation, gains, perturbed, reversals, simulate};

/// Ω in Pa s/m³; with pressures in mmHg, flows below are in mmHg/Ω.
const OHM: f64 = 1e9;

/// Vessels that state these resistances in Ω.
fn resistors(nodes: usize, vessels: &[(usize, usize, f64)]) -> Network {
    let stated = |ohms: f64| Vessel { resistance: Some(ohms * OHM), ..tube(10.0, 1.0) };
    network(nodes, vessels.iter().map(|(a, b, ohms)| ([*a, *b], stated(*ohms))))
}

fn solve(network: &Network, conditions: &[(usize, Condition)], viscosity: f64) -> State {
    simulate(network, &boundary(network, conditions), viscosity, &[]).unwrap().unperturbed
}

/// The state after `changes`, vessel and change.
fn after(network: &Network, conditions: &[(usize, Condition)], changes: &[(usize, Change)]) -> State {
    let changes: Vec<Perturbation> =
        changes.iter().map(|(vessel, change)| Perturbation { vessel: *vessel, change: *change }).collect();
    simulate(network, &boundary(network, conditions), VISCOSITY, &changes).unwrap().perturbed.expect("a perturbed state")
}

fn close(got: f64, expected: f64, scale: f64) {
    assert!((got - expected).abs() <= 1e-12 * scale.abs(), "{got} for {expected}");
}

/// Compares pressures (mmHg), flows and total inflow (mmHg/Ω) with the solution by hand.
fn check(network: &Network, conditions: &[(usize, Condition)], pressures: &[f64], flows: &[f64], inflow: f64) {
    let state = State::solve(network, &boundary(network, conditions), &Tube::at_rest(network, VISCOSITY), VISCOSITY).unwrap();
    for (got, expected) in state.pressure.iter().zip(pressures) {
        close(got.unwrap() / MMHG, *expected, 100.0);
    }
    for (got, expected) in state.vessels.iter().zip(flows) {
        close(got.flow * OHM / MMHG, *expected, inflow);
    }
    close(state.inflow * OHM / MMHG, inflow, inflow);
}

/// 8192 Pa at the outlet and 2⁻²⁰ Pa more at the inlet, over 1 Ω and 2 Ω in series: drops of 2⁻²⁰/3 and 2⁻¹⁹/3 Pa. Doubles beside 8192
/// lie 2⁻³⁹ apart, six millionths of the smaller drop.
#[test]
fn drops_keep_their_digits_above_a_high_level() {
    let series = resistors(3, &[(0, 1, 1.0), (1, 2, 2.0)]);
    let [low, high] = [8192.0, 8192.0 + 2_f64.powi(-20)].map(Condition::Pressure);
    let state = solve(&series, &[(0, high), (2, low)], VISCOSITY);
    for (vessel, expected) in state.vessels.iter().zip([2_f64.powi(-20) / 3.0, 2_f64.powi(-19) / 3.0]) {
        assert!((vessel.drop / expected - 1.0).abs() < 1e-15, "{} for {expected}", vessel.drop);
    }
}

/// A Wheatstone bridge out of balance: 0-1 and 2-3 of 1 Ω, 0-2 and 1-3 of 2 Ω, the bridge 1-2 of 1 Ω. Turning it end for end
/// gives P1 = 100 - x, P2 = x; at node 1, x = (100 - x)/2 + (100 - 2x), so x = 300/7. In flow 300/7 + 200/7.
#[test]
fn a_bridge_out_of_balance() {
    let bridge = resistors(4, &[(0, 1, 1.0), (0, 2, 2.0), (1, 2, 1.0), (1, 3, 2.0), (2, 3, 1.0)]);
    let x = 300.0 / 7.0;
    check(
        &bridge,
        &[(0, pressure(100.0)), (3, pressure(0.0))],
        &[100.0, 100.0 - x, x, 0.0],
        &[x, 200.0 / 7.0, 100.0 / 7.0, 200.0 / 7.0, x],
        500.0 / 7.0,
    );
}

/// An R-2R ladder from 80 mmHg: rails 0-1 and 1-2 of 1 Ω, rungs of 2 Ω to ground at node 1 and two at node 2. From node 2 the
/// network is 1 Ω, from node 1 it is 2 Ω beside 1 + 1 Ω, again 1 Ω: the pressure halves at each step.
#[test]
fn a_ladder_halves_the_pressure_at_each_step() {
    let ladder = resistors(4, &[(0, 1, 1.0), (1, 3, 2.0), (2, 1, 1.0), (2, 3, 2.0), (3, 2, 2.0)]);
    check(
        &ladder,
        &[(0, pressure(80.0)), (3, pressure(0.0))],
        &[80.0, 40.0, 20.0, 0.0],
        // The third and the last vessel run against the flow.
        &[40.0, 20.0, -20.0, 10.0, -10.0],
        40.0,
    );
}

/// A cube of 1 Ω from corner to opposite corner: by symmetry a third of the flow in each of three edges, a sixth in each of
/// six, a third in each of three, so R = 1/3 + 1/6 + 1/3 = 5/6 Ω and Q = 120 at 100 mmHg. Corners are numbered in binary.
#[test]
fn a_cube_across_its_diagonal() {
    let edges: Vec<(usize, usize, f64)> =
        (0..8).flat_map(|a| [1, 2, 4].into_iter().filter(move |bit| a & bit == 0).map(move |bit| (a, a | bit, 1.0))).collect();
    let level = |corner: usize| [100.0, 60.0, 40.0, 0.0][corner.count_ones() as usize];
    let pressures: Vec<f64> = (0..8).map(level).collect();
    let flows: Vec<f64> = edges.iter().map(|(a, b, _)| level(*a) - level(*b)).collect();
    check(&resistors(8, &edges), &[(0, pressure(100.0)), (7, pressure(0.0))], &pressures, &flows, 120.0);
}

/// Kirchhoff's current law at every node without a condition, to 1e-12 of the total inflow.
#[test]
fn what_flows_into_a_node_flows_out() {
    let mut draw = Draw::new(11);
    for _ in 0..100 {
        let nodes = 6 + draw.below(30);
        let network = random_network(&mut draw, nodes, 2 * nodes, log_radii(0.7, 2.5));
        let conditions = random_conditions(&mut draw, nodes);
        let state = solve(&network, &conditions, VISCOSITY);
        let mut net = vec![0.0; nodes];
        for ((ends, _), vessel) in network.vessels().zip(&state.vessels) {
            net[ends[0]] -= vessel.flow;
            net[ends[1]] += vessel.flow;
        }
        for (node, net) in net.iter().enumerate().filter(|(node, _)| conditions.iter().all(|(n, _)| n != node)) {
            assert!(net.abs() <= 1e-12 * state.inflow, "node {node}: {net} of {}", state.inflow);
        }
    }
}

#[test]
fn reversing_all_pressures_reverses_all_flows() {
    let mut draw = Draw::new(12);
    for _ in 0..20 {
        let network = random_network(&mut draw, 20, 35, log_radii(0.7, 2.5));
        let [forth, back] = [1.0, -1.0].map(|sign| {
            let conditions = [(0, pressure(sign * 100.0)), (1, pressure(0.0)), (2, pressure(sign * 93.0))];
            solve(&network, &conditions, VISCOSITY)
        });
        for (f, b) in forth.vessels.iter().zip(&back.vessels) {
            close(f.flow, -b.flow, forth.inflow);
            close(f.resilience, b.resilience, forth.vessels.iter().map(|v| v.resilience).fold(0.0, f64::max));
        }
        close(forth.inflow, back.inflow, forth.inflow);
    }
}

#[test]
fn doubling_the_viscosity_halves_all_flows() {
    let network = random_network(&mut Draw::new(13), 20, 35, log_radii(0.7, 2.5));
    let conditions = [(0, pressure(100.0)), (1, pressure(0.0))];
    let [thin, thick] = [VISCOSITY, 2.0 * VISCOSITY].map(|viscosity| solve(&network, &conditions, viscosity));
    for (thin, thick) in thin.vessels.iter().zip(&thick.vessels) {
        close(thick.flow, 0.5 * thin.flow, thin.flow);
        close(thick.reynolds, 0.25 * thin.reynolds, thin.reynolds);
        close(thick.wall_shear, thin.wall_shear, thin.wall_shear);
    }
}

/// A line of vessels of these lengths and radii (mm), 100 mmHg at one end and ground at the other.
fn line(vessels: &[(f64, f64)]) -> (Network, [(usize, Condition); 2]) {
    let vessels: Vec<_> = vessels.iter().enumerate().map(|(i, (l, r))| ([i, i + 1], tube(*l, *r))).collect();
    let last = vessels.len();
    (network(last + 1, vessels), [(0, pressure(100.0)), (last, pressure(0.0))])
}

/// 100 Ω between inlet and outlet, and beside it 10¹⁸ Ω behind 10⁻² Ω, and behind 10⁻² Ω twice: the flow of the last ones is 10⁻¹⁶ of the
/// first, and their first drops are lost beside the pressures, but each passes on what the last one carries. A dead end carries nothing.
#[test]
fn however_little_a_vessel_carries_the_one_before_it_carries_too() {
    let ways = [(0, 1, 100.0), (0, 2, 1e-2), (2, 1, 1e18), (0, 3, 1e-2), (3, 4, 1e-2), (1, 4, 1e18), (3, 5, 1e-2), (5, 6, 1e-2)];
    let network = resistors(7, &ways);
    let state = solve(&network, &[(0, pressure(100.0)), (1, pressure(0.0))], VISCOSITY);
    let little = 100.0 * MMHG / OHM / 1e18;
    let expected = [MMHG / OHM, little, little, little, little, -little, 0.0, 0.0];
    for (row, (vessel, expected)) in state.vessels.iter().zip(expected).enumerate() {
        assert!((vessel.flow - expected).abs() <= 1e-12 * expected.abs(), "{row}: {} for {expected}", vessel.flow);
        assert_eq!(vessel.diffused, expected != 0.0, "{row}");
    }
}

/// What flows into a node flows out of it, in networks of vessels whose sizes differ by powers of ten: to 1e-12 of both together, and to 1e-6
/// where that is less than 10⁻¹² of the largest flow.
#[test]
fn flows_balance_however_far_apart_sizes_are() {
    let mut draw = Draw::new(70);
    let mut solved = 0;
    for _ in 0..20_000 {
        let nodes = 3 + draw.below(5);
        let mut size = |least: f64, most: f64| 10_f64.powf(draw.within(least, most)).max(1e-9);
        let tubes: Vec<Vessel> = (0..nodes + 2).map(|_| tube(size(-1.0, 2.0), size(-2.0, 1.5))).collect();
        let ends: Vec<[usize; 2]> = tubes.iter().map(|_| [draw.below(nodes), draw.below(nodes)]).collect();
        let vessels = ends.into_iter().zip(tubes).filter(|([a, b], _)| a != b);
        let network = network(nodes, vessels);
        let conditions = [(0, pressure(100.0)), (1, pressure(0.0))];
        let Ok(found) = simulate(&network, &boundary(&network, &conditions), VISCOSITY, &[]) else { continue };
        let (mut net, mut all, mut largest) = (vec![0.0; nodes], vec![0.0; nodes], 0.0_f64);
        for (([a, b], _), vessel) in network.vessels().zip(&found.unperturbed.vessels) {
            net[a] += vessel.flow;
            net[b] -= vessel.flow;
            all[a] += vessel.flow.abs();
            all[b] += vessel.flow.abs();
            largest = largest.max(vessel.flow.abs());
        }
        for node in 2..nodes {
            let share = if all[node] >= 1e-12 * largest { 1e-12 } else { 1e-6 };
            assert!(net[node].abs() <= share * all[node], "{node}: {} of {}, {largest}", net[node], all[node]);
        }
        solved += 1;
    }
    assert!(solved > 5000, "{solved}");
}

/// A wide dead end beside a narrow inlet: the last bit of its pressure, times its conductance, is more than 10⁻¹² of what the narrow vessel
/// carries, and yet nothing flows there.
#[test]
fn the_last_bit_of_a_pressure_drives_nothing_into_a_dead_end() {
    let network = network(4, [([0, 1], tube(0.3, 0.01)), ([2, 1], tube(10.0, 0.5)), ([0, 3], tube(70.0, 0.4))]);
    let vessels = solve(&network, &[(0, pressure(100.0)), (2, pressure(0.0))], VISCOSITY).vessels;
    close(vessels[0].flow, -vessels[1].flow, vessels[0].flow);
    assert!((vessels[2].flow, vessels[2].diffused) == (0.0, false), "{}", vessels[2].flow);
}

/// Vessels in series carry one flow; the power ΔP·Q that they dissipate adds up, and the shear is that of the narrow one.
#[test]
fn a_focal_stenosis_is_vessels_in_series() {
    let (whole, ends) = line(&[(30.0, 1.5)]);
    let (parts, part_ends) = line(&[(12.0, 1.5), (8.0, 0.6), (10.0, 1.5)]);
    let stenosis = Stenosis { stretch: Some(8e-3), ..Stenosis::of_diameter(0.6) };
    let one = after(&whole, &ends, &[(0, Change::Stenosis(stenosis))]).vessels[0];
    let series = solve(&parts, &part_ends, VISCOSITY).vessels;
    close(one.flow, series[0].flow, one.flow);
    close(one.resistance, series.iter().map(|v| v.resistance).sum(), one.resistance);
    close(one.wall_shear, series[1].wall_shear, one.wall_shear);
    close(one.velocity, series[1].velocity, one.velocity);
    close(one.reynolds, series[1].reynolds, one.reynolds);
    let volumes: Vec<f64> = Tube::at_rest(&parts, VISCOSITY).iter().map(|tube| tube.volume).collect();
    let power: f64 = series.iter().zip(&volumes).map(|(v, volume)| v.resilience * volume).sum();
    close(one.resilience * volumes.iter().sum::<f64>(), power, power);
}

#[test]
fn a_uniform_stenosis_and_tortuosity_are_a_thinner_and_a_longer_vessel() {
    let (plain, ends) = line(&[(30.0, 1.5), (20.0, 1.0)]);
    let same = |changes: &[(usize, Change)], vessels: &[(f64, f64)]| {
        let (other, ends_of_other) = line(vessels);
        let (changed, direct) = (after(&plain, &ends, changes), solve(&other, &ends_of_other, VISCOSITY));
        for (c, d) in changed.vessels.iter().zip(&direct.vessels) {
            for (got, expected) in [
                (c.resistance, d.resistance),
                (c.flow, d.flow),
                (c.velocity, d.velocity),
                (c.wall_shear, d.wall_shear),
                (c.reynolds, d.reynolds),
                (c.resilience, d.resilience),
            ] {
                close(got, expected, 10.0 * expected);
            }
        }
        close(changed.network_resilience, direct.network_resilience, 10.0 * direct.network_resilience);
    };
    let half = Change::Stenosis(Stenosis::of_diameter(0.5));
    same(&[(0, half)], &[(30.0, 0.75), (20.0, 1.0)]);
    same(&[(0, Change::Stenosis(Stenosis::of_area(0.75)))], &[(30.0, 0.75), (20.0, 1.0)]);
    same(&[(1, Change::Tortuosity(1.3))], &[(30.0, 1.5), (26.0, 1.0)]);
    same(&[(1, half), (1, Change::Tortuosity(1.3)), (0, half)], &[(30.0, 0.75), (26.0, 0.5)]);
    // A stretch as long as the vessel that tortuosity has made is the whole of it.
    let all = Change::Stenosis(Stenosis { stretch: Some(26e-3), ..Stenosis::of_diameter(0.5) });
    same(&[(1, all), (1, Change::Tortuosity(1.3))], &[(30.0, 1.5), (26.0, 0.5)]);
}

/// 4 Ω over 10 mm with 2 mm of it at half the diameter: 4·(0.8 + 0.2·16) Ω.
#[test]
fn a_stated_resistance_is_multiplied() {
    let network = resistors(2, &[(0, 1, 4.0)]);
    let stenosis = Change::Stenosis(Stenosis { stretch: Some(2e-3), ..Stenosis::of_diameter(0.5) });
    let state = after(&network, &[(0, pressure(100.0)), (1, pressure(0.0))], &[(0, stenosis), (0, Change::Tortuosity(1.0))]);
    close(state.vessels[0].resistance / OHM, 16.0, 16.0);
}

#[test]
fn an_occlusion_is_the_removal_of_the_vessel() {
    let mut draw = Draw::new(14);
    for vessel in 0..12 {
        let network = random_network(&mut draw, 12, 24, log_radii(0.7, 2.5));
        let conditions = [(0, pressure(100.0)), (1, pressure(0.0)), (2, pressure(90.0))];
        let occluded = after(&network, &conditions, &[(vessel, Change::Occlusion), (vessel, Change::Tortuosity(2.0))]);
        let (without, rows) = network.subgraph(|row| row != vessel);
        let removed = solve(&without, &conditions, VISCOSITY);
        for (row, v) in rows.iter().zip(&removed.vessels) {
            close(occluded.vessels[*row].flow, v.flow, removed.inflow);
        }
        let closed = occluded.vessels[vessel];
        assert_eq!((closed.flow, closed.drop, closed.resilience, closed.velocity), (0.0, 0.0, 0.0, 0.0));
        assert!(closed.resistance == f64::INFINITY && !closed.diffused);
        close(occluded.network_resilience, removed.network_resilience, removed.network_resilience);
        close(occluded.inflow, removed.inflow, removed.inflow);
    }
}

/// With everything closed nothing flows, and that is an answer.
#[test]
fn a_network_closed_altogether_is_at_rest() {
    let (network, ends) = line(&[(30.0, 1.5)]);
    let state = after(&network, &ends, &[(0, Change::Occlusion)]);
    assert_eq!((state.inflow, state.network_resilience, state.diffused()), (0.0, 0.0, 0));
}

#[test]
fn perturbations_out_of_range_are_refused() {
    let (network, ends) = line(&[(30.0, 1.5)]);
    let refused = |changes: &[Change], words: [&str; 2]| {
        let changes: Vec<Perturbation> = changes.iter().map(|change| Perturbation { vessel: 0, change: *change }).collect();
        let error = perturbed(&network, &Tube::at_rest(&network, VISCOSITY), &changes).expect_err("refused").to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let stenosis = |open_diameter, stretch| Change::Stenosis(Stenosis { open_diameter, stretch, place: StretchPlace::Middle });
    refused(&[stenosis(0.0, None)], ["stenosis 100%", "occlusion"]);
    refused(&[stenosis(f64::NAN, None)], ["stenosis", "occlusion"]);
    refused(&[stenosis(1.5, None)], ["stenosis -50%", "from 0%"]);
    refused(&[stenosis(0.5, Some(0.031))], ["31 mm", "30 mm"]);
    refused(&[stenosis(0.5, Some(0.0))], ["stenosis", "positive length"]);
    refused(&[Change::Tortuosity(0.9)], ["tortuosity 0.9", "at least 1"]);
    refused(&[Change::Tortuosity(f64::INFINITY)], ["tortuosity inf", "at least 1"]);
    refused(&[Change::Occlusion, Change::Occlusion], ["occlude", "twice"]);
    let driven = |conditions: &[(usize, Condition)]| simulate(&network, &boundary(&network, conditions), VISCOSITY, &[]);
    let error = driven(&[(0, pressure(100.0)), (1, pressure(100.0))]).expect_err("no drop").to_string();
    assert!(error.contains("drive no flow"), "{error}");
    let error = simulate(&network, &boundary(&network, &ends), 0.0, &[]).expect_err("no viscosity").to_string();
    assert!(error.contains("viscosity"), "{error}");
}

/// 100 mmHg over a bridge of 1 Ω vessels in balance, 50 a side. Closing 0-1 leaves 1 + (1 beside 2) = 5/3 Ω: 60 through 0-2, of
/// which 20 cross the bridge from 2 to 1. The gains are 20 and 10, and 1-3 and 2-3 lose.
#[test]
fn collaterals_are_the_vessels_that_gain() {
    let (gains, turned) = after_closing_the_first(&[(0, 1, 1.0), (0, 2, 1.0), (1, 2, 1.0), (1, 3, 1.0), (2, 3, 1.0)]);
    assert_eq!(gains, [(2, 20.0), (1, 10.0)]);
    assert!(turned.is_empty());
}

/// With 0-2 and 1-3 of 2 Ω the bridge carries 100/7 from 1 to 2. Closing 0-1 leaves 2 + (1 beside 3) = 11/4 Ω: 400/11 through
/// 0-2, a quarter of it, 100/11, back over the bridge. 0-2 gains 400/11 - 200/7 = 600/77; 1-3 and 2-3 lose.
#[test]
fn a_flow_that_turns_round_is_reversed() {
    let (gains, turned) = after_closing_the_first(&[(0, 1, 1.0), (0, 2, 2.0), (1, 2, 1.0), (1, 3, 2.0), (2, 3, 1.0)]);
    assert_eq!(gains, [(1, (1e6 * 600.0_f64 / 77.0).round() / 1e6)]);
    assert_eq!(turned, [(2, (1e6 * -100.0_f64 / 11.0).round() / 1e6)]);
}

/// Vessels that gain with their gains, and vessels whose flow turns round with their flow after it, in mmHg/Ω to six decimals.
type Named = Vec<(usize, f64)>;

fn after_closing_the_first(vessels: &[(usize, usize, f64)]) -> (Named, Named) {
    let bridge = resistors(4, vessels);
    let conditions = boundary(&bridge, &[(0, pressure(100.0)), (3, pressure(0.0))]);
    let closed = [Perturbation { vessel: 0, change: Change::Occlusion }];
    let result = simulate(&bridge, &conditions, VISCOSITY, &closed).unwrap();
    let after = result.perturbed.expect("a perturbed state");
    let decimals = |q: f64| (1e6 * q * OHM / MMHG).round() / 1e6;
    let gains = gains(&result.unperturbed, &after, &closed).iter().map(|c| (c.vessel, decimals(c.gain()))).collect();
    let turned = reversals(&result.unperturbed, &after, &closed).iter().map(|c| (c.vessel, decimals(c.after))).collect();
    (gains, turned)
}

const LABELS: [&str; 5] = ["L-ICA II", "L-PComm", "AComm", "L-A1", "L-P1"];

fn row(network: &Network, label: &str) -> usize {
    network.vessels().position(|(_, v)| v.label == label).unwrap_or_else(|| panic!("no {label}"))
}

/// Grounds every outlet and keeps 100 mmHg at the four proximal ends.
fn grounded(network: &Network) -> Boundary {
    let conditions: Vec<(usize, Condition)> = network
        .nodes()
        .enumerate()
        .filter_map(|(row, node)| match node.condition? {
            Condition::Resistance { .. } => Some((row, pressure(0.0))),
            other => Some((row, other)),
        })
        .collect();
    boundary(network, &conditions)
}

/// The dense NumPy solve in `forward-reference.md`, to the digits given there: ρ_G in W/m³, then total flow and the flows of
/// [`LABELS`] in mL/min.
fn agrees(state: &State, network: &Network, rho: f64, half_digit: f64, total: f64, flows: [Option<f64>; 5]) {
    assert!((state.network_resilience - rho).abs() <= half_digit, "ρ_G {} for {rho}", state.network_resilience);
    assert!((state.inflow * 6e7 - total).abs() <= 0.5, "{} for {total}", state.inflow * 6e7);
    for (label, expected) in LABELS.iter().zip(flows) {
        let Some(expected) = expected else { continue };
        let got = state.vessels[row(network, label)].flow * 6e7;
        assert!((got - expected).abs() <= 0.5, "{label}: {got} for {expected}");
    }
}

#[test]
fn the_circle_of_willis_with_grounded_outlets_agrees_with_an_independent_solve() {
    let complete = cerebral(&circle_of_willis(1e-3));
    let (without, _) = complete.subgraph(|row| complete.vessel(row).label != "AComm");
    let cases = [
        (
            &complete,
            [1.811e5, 4.529e5],
            [7366.0, 5333.0],
            [
                [Some(2940.0), Some(-73.0), Some(0.0), Some(990.0), Some(670.0)],
                [Some(369.0), Some(0.0), Some(-1041.0), Some(-487.0), Some(712.0)],
            ],
        ),
        (
            &without,
            [1.907e5, 1.487e5],
            [7366.0, 4852.0],
            [
                [Some(2940.0), Some(-73.0), None, Some(990.0), Some(670.0)],
                [Some(457.0), Some(0.0), None, Some(154.0), Some(728.0)],
            ],
        ),
    ];
    for (network, rho, total, flows) in cases {
        let changes = [
            Perturbation { vessel: row(network, "L-ICA I"), change: Change::Stenosis(Stenosis::of_diameter(0.5)) },
            Perturbation { vessel: row(network, "L-PComm"), change: Change::Occlusion },
        ];
        let result = simulate(network, &grounded(network), VISCOSITY, &changes).unwrap();
        agrees(&result.unperturbed, network, rho[0], 50.0, total[0], flows[0]);
        agrees(&result.perturbed.expect("a perturbed state"), network, rho[1], 50.0, total[1], flows[1]);
        if let Some(communicating) = network.vessels().position(|(_, v)| v.label == "AComm") {
            assert!(!result.unperturbed.vessels[communicating].diffused, "zero by symmetry, exactly");
        }
    }
}

#[test]
fn the_circle_of_willis_with_terminal_resistances_agrees_with_an_independent_solve() {
    let complete = cerebral(&circle_of_willis(1e-3));
    let conditions: Vec<(usize, Condition)> =
        complete.nodes().enumerate().filter_map(|(row, node)| Some((row, node.condition?))).collect();
    let state = solve(&complete, &conditions, VISCOSITY);
    assert!((state.network_resilience - 1230.0).abs() <= 0.5, "{}", state.network_resilience);
    assert!((state.inflow * 6e7 - 555.0).abs() <= 0.5, "{}", state.inflow * 6e7);
    let flow = |label: &str| state.vessels[row(&complete, label)].flow * 6e7;
    for side in ["L", "R"] {
        let figures = [("ICA I", 223.0), ("M1", 125.0), ("A2", 87.0), ("P2", 66.0), ("PComm", -11.0)];
        for (label, expected) in figures {
            let got = flow(&format!("{side}-{label}"));
            assert!((got - expected).abs() <= 0.5, "{side}-{label}: {got} for {expected}");
        }
    }
    let vertebrals = flow("L-VA") + flow("R-VA");
    assert!((vertebrals - 110.0).abs() <= 0.5, "{vertebrals}");
    assert!((flow("L-ICA I") / (state.inflow * 6e7) - 0.40).abs() < 0.005);
}

/// The network of that solve: 20 vessels of the published table, radius the mean of `Rp` and `Rd`, by their two nodes.
#[test]
fn the_phantom_is_the_network_of_the_independent_solve() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/openbf-models/circle_of_willis.yaml");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return;
    };
    let complete = cerebral(&circle_of_willis(1e-3));
    let mut found = 0;
    for entry in text.split("- label:").skip(1) {
        let figure = |key: &str| -> Option<f64> {
            entry.lines().find_map(|line| line.trim().strip_prefix(key)?.strip_prefix(':')?.trim().parse().ok())
        };
        let [sn, tn] = ["sn", "tn"].map(|key| figure(key).expect("a node").to_string());
        let ends = |ends: [usize; 2]| ends.map(|end| complete.node(end).id.clone()) == [sn.clone(), tn.clone()];
        let Some((ends, vessel)) = complete.vessels().find(|(e, _)| ends(*e)) else { continue };
        found += 1;
        let radius = f64::midpoint(figure("Rp").expect("Rp"), figure("Rd").expect("Rd"));
        close(vessel.length, figure("L").expect("L"), vessel.length);
        close(vessel.radius, radius, radius);
        if let Some(resistance) = figure("R1") {
            assert_eq!(complete.node(ends[1]).condition, Some(Condition::Resistance { resistance, venous: 0.0 }));
        }
    }
    assert_eq!(found, complete.vessel_count());
}
