//! The rules of boundary conditions, each on a network made for it.

use crate::networks::{MMHG, pressure};
use crate::vessels::{network, tube};
use willis::internals::flow::boundary_conditions::FreeEnds;
use willis::internals::flow::boundary_conditions::{Total, find_again, stated};
use willis::internals::flow::{Boundary, FoundOutlets, Given};
use willis::internals::network::{Condition, ConditionFrom, Network, Node, Origin, PathPoint, RadiusRule, Role, Vessel};
use willis::internals::support::geometry::distance;

/// Stars side by side, one per slice: node by node the free ends with these radii (mm), then the center. A star of two is a
/// vessel with a joint in its middle.
fn stars(radii: &[&[f64]]) -> Network {
    let mut vessels = Vec::new();
    let mut nodes = 0;
    for star in radii {
        let center = nodes + star.len();
        vessels.extend(star.iter().enumerate().map(|(i, r)| ([nodes + i, center], tube(10.0, *r))));
        nodes = center + 1;
    }
    network(nodes, vessels)
}

fn resolve(network: &Network, given: &[Given]) -> Boundary {
    Boundary::resolve(network, given, FoundOutlets::Ground).unwrap()
}

fn inlet(node: usize) -> Given {
    Given { node, role: Role::Inlet, condition: pressure(100.0) }
}

fn outlet(node: usize) -> Given {
    Given { node, role: Role::Outlet, condition: pressure(0.0) }
}

/// Roles, conditions and the two lists tell one story, in node order.
fn consistent(boundary: &Boundary) {
    assert!(boundary.conditions.windows(2).all(|w| w[0].0 < w[1].0));
    for (node, role) in boundary.roles.iter().enumerate() {
        assert_eq!(boundary.condition(node).is_some(), *role != Role::Inner, "node {node}");
    }
    assert!(boundary.found_inlets.iter().all(|n| boundary.condition(*n) == Some(pressure(100.0))));
}

#[test]
fn the_three_widest_ends_are_inlets_and_all_others_outlets() {
    let boundary = resolve(&stars(&[&[1.0, 3.0, 2.0, 5.0, 4.0]]), &[]);
    assert_eq!((&boundary.found_inlets[..], &boundary.found_outlets[..]), (&[1, 3, 4][..], &[0, 2][..]));
    assert_eq!(boundary.condition(0), Some(Condition::Pressure(0.0)));
    assert_eq!(boundary.roles[5], Role::Inner);
    consistent(&boundary);
}

#[test]
fn equal_ends_come_in_node_order() {
    let boundary = resolve(&stars(&[&[1.0, 1.0, 1.0, 1.0, 1.0]]), &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![0, 1, 2], vec![3, 4]));
    let boundary = resolve(&stars(&[&[1.0, 2.0, 1.0, 2.0, 2.0, 2.0]]), &[]);
    assert_eq!(boundary.found_inlets, [1, 3, 4]);
}

/// Stars of nodes 0-2, 4-6, 8-10, 12-14 and 16-17. The three widest ends lie in the first two; the other fragments get none.
#[test]
fn a_fragment_gets_no_inlet_of_its_own() {
    let network = stars(&[&[9.0, 8.0, 1.0], &[1.0, 7.0, 1.0], &[2.0, 3.0, 1.0], &[1.0, 1.0, 1.0], &[0.5, 0.6]]);
    let boundary = resolve(&network, &[]);
    assert_eq!(boundary.found_inlets, [0, 1, 5]);
    assert_eq!(boundary.found_outlets, [2, 4, 6, 8, 9, 10, 12, 13, 14, 16, 17]);
    consistent(&boundary);
    // Where no inlet feeds them they are no outlets of the topology: nothing flows there, at no known pressure.
    let held = boundary.held(&network, |_| true);
    assert_eq!(held.found_outlets, [2, 4, 6]);
    assert_eq!((held.roles[8], held.condition(8)), (Role::Inner, None));
    consistent(&held);
}

/// An end less than half as wide as the widest is no inlet, however few there are.
#[test]
fn inlets_are_wide() {
    let boundary = resolve(&stars(&[&[9.0, 4.6, 4.4, 1.0]]), &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![0, 1], vec![2, 3]));
}

/// However wide they are, a component keeps an outlet when outlets are to be found.
#[test]
fn every_component_keeps_an_outlet() {
    let boundary = resolve(&stars(&[&[9.0, 8.0], &[1.0, 0.9, 0.8]]), &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![0], vec![1, 3, 4, 5]));
    let boundary = resolve(&stars(&[&[9.0, 8.0]]), &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![0], vec![1]));
}

/// Six ends whose widths differ by less than a twentieth: the low ones are inlets, whatever their numbers and the last digits of their
/// radii. Turned upside down, the others are.
#[test]
fn of_equally_wide_ends_the_lower_are_inlets() {
    for (up, expected) in [(1.0, [1, 2, 5]), (-1.0, [0, 3, 4])] {
        let mut network = stars(&[&[2.0, 2.02, 1.97, 2.03, 2.01, 1.98]]);
        for (node, height) in [5.0, 1.0, 2.0, 6.0, 7.0, 3.0].into_iter().enumerate() {
            network.node_mut(node).position = Some([0.0, 0.0, up * height]);
        }
        assert_eq!(resolve(&network, &[]).found_inlets, expected);
    }
}

/// Where the file says which way is up, blood comes in from below; where it does not, the wide ends count.
#[test]
fn inlets_lie_low_where_up_is_known() {
    let mut network = stars(&[&[2.0, 3.0, 2.5, 1.8, 1.0]]);
    for (node, height) in [0.0, 10.0, 9.0, 1.0, 2.0].into_iter().enumerate() {
        network.node_mut(node).position = Some([0.0, 0.0, height]);
    }
    // The two wide ends lie above, so blood comes in from there, and not by the others.
    assert_eq!(resolve(&network, &[]).found_inlets, [1, 2]);
    network.frame = willis::internals::network::Frame::Ras;
    assert_eq!(resolve(&network, &[]).found_inlets, [0, 3, 4]);
}

/// The ends of the arteries of a head, mm: two carotids, two vertebral arteries below them, both M1, as wide as these or wider, and both A2.
const HEAD: [([f64; 3], f64); 8] = [
    ([-20.0, 0.0, 30.0], 2.0),
    ([20.0, 0.0, 30.0], 2.0),
    ([-15.0, 0.0, 0.0], 1.4),
    ([15.0, 0.0, 2.0], 1.35),
    ([-60.0, 0.0, 100.0], 1.5),
    ([60.0, 0.0, 100.0], 1.4),
    ([-4.0, 50.0, 120.0], 1.3),
    ([4.0, 50.0, 120.0], 1.3),
];

/// A star with these ends, its axes in another order, in file order `order`; and by end its node.
fn head(ends: &[([f64; 3], f64)], axes: [usize; 3], order: &[usize]) -> (Network, Vec<usize>) {
    let radii: Vec<f64> = order.iter().map(|end| ends[*end].1).collect();
    let mut network = stars(&[&radii]);
    for (node, end) in order.iter().enumerate() {
        network.node_mut(node).position = Some(axes.map(|axis| ends[*end].0[axis] * 1e-3));
    }
    let node_of = (0..ends.len()).map(|end| order.iter().position(|e| *e == end).unwrap()).collect();
    (network, node_of)
}

/// Blood comes in from one side: by two carotids and two vertebral arteries, whichever way the axes point and in whatever order the ends are
/// numbered. M1 of the same width lies on the other side.
#[test]
fn two_carotids_and_two_vertebral_arteries_are_four_inlets() {
    for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        for order in [[0, 1, 2, 3, 4, 5, 6, 7], [7, 3, 5, 1, 6, 2, 4, 0]] {
            let (network, node_of) = head(&HEAD, axes, &order);
            let mut expected = [0, 1, 2, 3].map(|end| node_of[end]);
            expected.sort_unstable();
            assert_eq!(resolve(&network, &[]).found_inlets, expected, "axes {axes:?}, order {order:?}");
        }
    }
    // With a basilar artery, and P2 as wide halfway up, there are three.
    let mut ends = HEAD;
    (ends[2], ends[3]) = (([0.0, 0.0, 20.0], 1.4), ([15.0, -40.0, 60.0], 1.4));
    let (network, _) = head(&ends, [0, 1, 2], &[0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(resolve(&network, &[]).found_inlets, [0, 1, 2]);
}

/// A wide piece far away that nothing can join to the rest, as of a sinus, moves no role of the rest. One that may be joined is a part of it.
#[test]
fn a_piece_far_away_takes_no_inlet() {
    let (mut network, _) = head(&HEAD, [0, 1, 2], &[0, 1, 2, 3, 4, 5, 6, 7]);
    for frame in [willis::internals::network::Frame::Unknown, willis::internals::network::Frame::Ras] {
        network.frame = frame;
        let alone = resolve(&network, &[]);
        let mut with = network.clone();
        for x in [1000.0, 1005.0] {
            with.add_node(Node { position: Some([x * 1e-3, 0.0, -0.5]), ..Node::default() });
        }
        with.add_vessel([9, 10], tube(5.0, 5.0));
        let both = resolve(&with, &[]);
        assert_eq!(both.found_inlets, alone.found_inlets);
        assert_eq!(both.roles[..9], alone.roles);
        with.add_vessel([8, 9], Vessel { origin: Origin::Candidate, prior: 0.01, ..tube(5.0, 1.0) });
        assert!(resolve(&with, &[]).found_inlets.contains(&10));
    }
}

/// Known inlets come before all others, and no other is added.
#[test]
fn known_inlets_are_the_inlets() {
    let network = stars(&[&[1.0, 3.0, 2.0, 5.0, 4.0]]);
    let knowing = |known: &[usize]| Boundary::resolve_knowing(&network, &[], FoundOutlets::Ground, known).unwrap();
    assert_eq!((knowing(&[0]).found_inlets, knowing(&[0]).found_outlets), (vec![0], vec![1, 2, 3, 4]));
    // The middle of the star is no free end.
    assert_eq!(knowing(&[5]).found_inlets, [1, 3, 4]);
}

/// Two rings with a tail each: every component has one free end. The wider is the inlet, the other the outlet.
#[test]
fn two_free_ends_are_enough_wherever_they_are() {
    let rings = [([0, 1], 1.0), ([1, 1], 1.0), ([2, 3], 2.0), ([3, 3], 1.0)];
    let network = network(4, rings.map(|(ends, r)| (ends, tube(10.0, r))));
    let boundary = resolve(&network, &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![2], vec![0]));
}

#[test]
fn given_inlets_stay_exactly_those() {
    let network = stars(&[&[9.0, 1.0, 8.0], &[7.0, 6.0]]);
    let boundary = resolve(&network, &[inlet(1)]);
    assert!(boundary.found_inlets.is_empty());
    assert_eq!(boundary.found_outlets, [0, 2, 4, 5]);
    assert_eq!(boundary.count(Role::Inlet), 1);
    let at_a_junction = resolve(&network, &[inlet(3)]);
    assert_eq!(at_a_junction.found_outlets, [0, 1, 2, 4, 5]);
    consistent(&at_a_junction);
}

#[test]
fn with_outlets_alone_inlets_are_found_and_no_further_outlet() {
    let boundary = resolve(&stars(&[&[9.0, 1.0, 8.0, 7.0, 6.0]]), &[outlet(0), outlet(1)]);
    assert_eq!((&boundary.found_inlets[..], boundary.found_outlets.len()), (&[2, 3, 4][..], 0));
    // No end needs to be spared for an outlet: one is given.
    let boundary = resolve(&stars(&[&[9.0, 8.0]]), &[outlet(0)]);
    assert_eq!(boundary.found_inlets, [1]);
    consistent(&boundary);
}

#[test]
fn nothing_is_added_to_a_source_and_a_sink() {
    let network = stars(&[&[9.0, 1.0, 8.0], &[7.0, 6.0]]);
    let boundary = resolve(&network, &[outlet(2), inlet(0)]);
    assert_eq!(boundary.conditions, [(0, pressure(100.0)), (2, pressure(0.0))]);
    assert_eq!(boundary, resolve(&network, &[inlet(0), outlet(2)]));
    let flow = Given { node: 1, role: Role::Inlet, condition: Condition::Flow(1e-6) };
    assert_eq!(resolve(&network, &[flow, outlet(2)]).conditions.len(), 2);
}

/// The error names the option to give and counts the free ends.
#[test]
fn no_free_end_to_find_is_an_error_that_names_the_option() {
    let message = |network: &Network, given: &[Given]| {
        let error = Boundary::resolve(network, given, FoundOutlets::Ground).unwrap_err();
        assert!(error.is_usage());
        error.to_string()
    };
    let ring = network(2, [([0, 1], tube(10.0, 1.0)), ([1, 0], tube(20.0, 1.0))]);
    let neither = message(&ring, &[]);
    assert!(
        neither.contains("`inlet=NODE`") && neither.contains("`outlet=NODE`") && neither.contains("0 free ends"),
        "{neither}"
    );
    let no_outlet = message(&ring, &[inlet(0)]);
    assert!(
        no_outlet.contains("no outlet") && no_outlet.contains("`outlet=NODE`") && !no_outlet.contains("--inlet"),
        "{no_outlet}"
    );
    let no_inlet = message(&ring, &[outlet(0)]);
    assert!(no_inlet.contains("no inlet") && no_inlet.contains("`inlet=NODE`") && !no_inlet.contains("--outlet"), "{no_inlet}");
    let tail = network(2, [([0, 1], tube(10.0, 1.0)), ([1, 1], tube(20.0, 1.0))]);
    assert!(message(&tail, &[]).contains("1 free ends"));
    assert_eq!(resolve(&tail, &[outlet(1)]).found_inlets, [0]);
}

/// Free ends are those of the observed vessels: a candidate at an end leaves it free, and makes none of its own. But an end that a
/// candidate probably joins is no inlet.
#[test]
fn candidates_make_and_hide_no_free_end() {
    let of = |prior: f64| {
        let mut network = stars(&[&[3.0, 2.0], &[1.0, 1.0]]);
        let end = network.add_node(Node { id: "loose".into(), ..Node::default() });
        for ends in [[0, 3], [4, end]] {
            network.add_vessel(ends, Vessel { origin: Origin::Candidate, prior, ..tube(5.0, 9.0) });
        }
        network
    };
    let boundary = resolve(&of(0.1), &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![0], vec![1, 3, 4]));
    let network = of(0.9);
    let boundary = resolve(&network, &[]);
    assert_eq!((&boundary.found_inlets[..], &boundary.found_outlets[..]), (&[1][..], &[0, 3, 4][..]));
    // Row 4 joins node 0 and 3, row 5 leaves node 4.
    let provisional: Vec<_> = boundary.provisional(&network).into_iter().collect();
    assert_eq!(provisional, [(0, vec![4]), (3, vec![4]), (4, vec![5])]);
    assert_eq!(boundary.held(&network, |row| row < 4).conditions.len(), 2, "the second part has no inlet");
    let joined = boundary.held(&network, |row| row != 5);
    assert_eq!((joined.found_inlets, joined.found_outlets), (vec![1], vec![4]));
}

/// What enters at one end of a vessel that is broken leaves at the other. While nothing probably joins its pieces, each has an inlet.
#[test]
fn a_broken_vessel_keeps_an_outlet() {
    let of = |prior: f64| {
        let mut network = network(4, [([0, 1], tube(10.0, 1.0)), ([2, 3], tube(10.0, 1.0))]);
        network.add_vessel([1, 2], Vessel { origin: Origin::Candidate, prior, ..tube(5.0, 1.0) });
        network
    };
    assert_eq!(resolve(&of(0.1), &[]).found_inlets, [0, 2]);
    let held = resolve(&of(0.9), &[]).held(&of(0.9), |_| true);
    assert_eq!((held.found_inlets, held.found_outlets), (vec![0], vec![3]));
}

/// Terminals that are left share what all had: Murray's total is that of the topology. What a person stated stays as it is.
#[test]
fn the_ends_that_hold_share_the_total() {
    let flow = 700.0 / 6e7;
    let mut network = stars(&[&[5.0, 1.0, 2.0], &[1.5, 1.2, 0.5]]);
    network.add_vessel([1, 4], Vessel { origin: Origin::Candidate, prior: 0.9, ..tube(5.0, 1.0) });
    let boundary = Boundary::resolve(&network, &[], FoundOutlets::Murray(Total::Flow(flow))).unwrap();
    assert_eq!(boundary.found_outlets, [1, 2, 4, 5, 6]);
    let held = boundary.held(&network, |_| true);
    assert_eq!(held.found_outlets, [2, 5, 6]);
    let terminal = |boundary: &Boundary, node| match boundary.condition(node) {
        Some(Condition::Resistance { resistance, .. }) => 100.0 * MMHG / resistance,
        other => panic!("node {node}: {other:?}"),
    };
    let all: f64 = held.found_outlets.iter().map(|node| terminal(&held, *node)).sum();
    assert!((all / flow - 1.0).abs() < 1e-14, "{all}");
    // 2³ : 1.2³, as before.
    assert!((terminal(&held, 2) / terminal(&held, 5) / (8.0 / 1.728) - 1.0).abs() < 1e-14);
    // An outlet that a landmark names shares with them: the ends of gaps that are left take no more than their part.
    network.node_mut(6).role = Some(Role::Outlet);
    let named = Boundary::resolve(&network, &[], FoundOutlets::Murray(Total::Flow(flow))).unwrap();
    assert_eq!((&named.found_outlets[..], &named.named_outlets[..]), (&[1, 2, 4, 5][..], &[6][..]));
    // Who reads it from a file shares the total in the same way, and knows that it holds wherever it is.
    assert_eq!(named.stated()[6].2, ConditionFrom::Landmark);
    let file = named.stated_in(network.clone());
    assert_eq!(resolve(&file, &stated(&file)), named);
    let named = named.held(&network, |_| true);
    assert!(named.conditions == held.conditions && !named.is_found(6));
    // One that a person states there stays as it is, and so do the shares of the others.
    network.node_mut(6).condition = boundary.condition(6);
    let file = Boundary { found_outlets: vec![1, 2, 4, 5], ..boundary.clone() }.held(&network, |_| true);
    assert_eq!((file.condition(2), file.condition(6)), (held.condition(2), boundary.condition(6)));
    let given = [inlet(0), Given { condition: Condition::Resistance { resistance: 1e9, venous: 0.0 }, ..outlet(1) }];
    let stated = resolve(&network, &given);
    assert_eq!(stated.held(&network, |_| true), stated);
}

/// In a graph of candidates alone every vessel counts.
#[test]
fn without_observed_vessels_all_count() {
    let mut network = stars(&[&[3.0, 2.0, 1.0]]);
    for row in 0..3 {
        network.vessel_mut(row).origin = Origin::Candidate;
    }
    let boundary = resolve(&network, &[]);
    assert_eq!((boundary.found_inlets, boundary.found_outlets), (vec![0, 1], vec![2]));
}

/// 12 points, radii 1 to 12 mm from the first: the last ten mean 7.5 at the far end and 5.5 at the near one, both more
/// than the 5 of a plain vessel, the wide end less than the 8 of another.
#[test]
fn the_radius_of_an_end_is_the_mean_of_its_last_ten_points() {
    let points =
        (1..=12_u32).map(|i| PathPoint { position: [f64::from(i) * 1e-3, 0.0, 0.0], radius: f64::from(i) * 1e-3, id: None });
    let tapering = Vessel::along(points.collect(), RadiusRule::Mean);
    assert!((tapering.end_radius(true) - 7.5e-3).abs() < 1e-15 && (tapering.end_radius(false) - 5.5e-3).abs() < 1e-15);
    assert!((tapering.length - distance([1e-3, 0.0, 0.0], [12e-3, 0.0, 0.0])).abs() < 1e-15);
    let network = network(2, [([0, 1], tapering)]);
    let ends = FreeEnds::of(&network, &[Role::Inner; 2]);
    assert!((ends.radius[0] - 5.5e-3).abs() < 1e-15 && (ends.radius[1] - 7.5e-3).abs() < 1e-15);
}

/// Murray: R goes as 1/r³, and with every terminal at the inlet pressure 700 mL/min leave in all. 1e-14: a few roundings.
#[test]
fn found_terminal_resistances_obey_murray_and_sum_to_the_flow() {
    let flow = 700.0 / 6e7;
    let network = stars(&[&[5.0, 1.0, 2.0, 1.5], &[0.5, 0.25]]);
    for given in [vec![], vec![inlet(0)], vec![Given { condition: pressure(85.0), ..inlet(0) }]] {
        let boundary = Boundary::resolve(&network, &given, FoundOutlets::Murray(Total::Flow(flow))).unwrap();
        let inlet_pressure = given.first().map_or(100.0 * MMHG, |g| match g.condition {
            Condition::Pressure(p) => p,
            _ => unreachable!(),
        });
        let mut total = 0.0;
        let mut products = Vec::new();
        for node in &boundary.found_outlets {
            let Some(Condition::Resistance { resistance, venous }) = boundary.condition(*node) else { panic!("node {node}") };
            assert_eq!(venous, 0.0);
            total += inlet_pressure / resistance;
            let row = (0..network.vessel_count()).find(|row| network.ends(*row)[0] == *node).unwrap();
            products.push(resistance * network.vessel(row).radius.powi(3));
        }
        assert!(products.len() >= 2);
        assert!((total / flow - 1.0).abs() < 1e-14, "{total}");
        assert!(products.iter().all(|p| (p / products[0] - 1.0).abs() < 1e-14), "{products:?}");
    }
}

/// Side by side the terminals are one resistor of the resistance asked for, whatever the inlet pressure. 1e-14: a few roundings.
#[test]
fn found_terminal_resistances_come_to_the_total() {
    let total = 8.0 * MMHG * 1e6;
    let network = stars(&[&[5.0, 1.0, 2.0, 1.5], &[0.5, 0.25]]);
    for given in [vec![], vec![Given { condition: pressure(85.0), ..inlet(0) }]] {
        let boundary = Boundary::resolve(&network, &given, FoundOutlets::Murray(Total::Resistance(total))).unwrap();
        let conductance = |node: &usize| match boundary.condition(*node) {
            Some(Condition::Resistance { resistance, venous: 0.0 }) => 1.0 / resistance,
            other => panic!("node {node}: {other:?}"),
        };
        let all: f64 = boundary.found_outlets.iter().map(conductance).sum();
        assert!(boundary.found_outlets.len() >= 2 && (all * total - 1.0).abs() < 1e-14, "{all}");
    }
}

/// With a flow for inlet no pressure is stated: the terminals are scaled at 100 mmHg.
#[test]
fn murray_without_a_stated_pressure_takes_the_default() {
    let flow = 300.0 / 6e7;
    let injected = Given { node: 0, role: Role::Inlet, condition: Condition::Flow(5e-6) };
    let boundary = Boundary::resolve(&stars(&[&[2.0, 1.0, 1.0]]), &[injected], FoundOutlets::Murray(Total::Flow(flow))).unwrap();
    for node in [1, 2] {
        let Some(Condition::Resistance { resistance, .. }) = boundary.condition(node) else { panic!() };
        assert!((resistance / (100.0 * MMHG / (0.5 * flow)) - 1.0).abs() < 1e-14);
    }
}

/// Roles of conditions that a file states without one.
#[test]
fn stated_conditions_get_their_roles() {
    let roles = |conditions: &[Condition]| {
        let mut network = network(conditions.len(), []);
        for (node, condition) in conditions.iter().enumerate() {
            network.node_mut(node).condition = Some(*condition);
        }
        stated(&network).iter().map(|g| g.role == Role::Inlet).collect::<Vec<_>>()
    };
    let resistance = Condition::Resistance { resistance: 1e9, venous: 80.0 * MMHG };
    assert_eq!(roles(&[pressure(0.0), pressure(100.0), pressure(93.0), pressure(0.0)]), [false, true, true, false]);
    assert_eq!(roles(&[pressure(100.0), pressure(49.0)]), [true, false]);
    assert_eq!(roles(&[pressure(100.0), pressure(61.0), pressure(59.0), pressure(20.0)]), [true, true, false, false]);
    assert_eq!(roles(&[pressure(90.0), pressure(90.0)]), [true, true]);
    assert_eq!(roles(&[pressure(0.0), pressure(0.0)]), [false, false]);
    assert_eq!(roles(&[Condition::Flow(1e-6), Condition::Flow(-1e-6), resistance]), [true, false, false]);
    assert_eq!(roles(&[]), [false; 0]);
}

#[test]
fn a_stated_role_stands_and_inner_is_none() {
    let mut network = network(4, []);
    let all = [(Role::Outlet, 100.0), (Role::Inlet, 0.0), (Role::Inner, 100.0)];
    for (node, (role, mmhg)) in all.into_iter().enumerate() {
        network.node_mut(node).role = Some(role);
        network.node_mut(node).condition = Some(pressure(mmhg));
    }
    network.node_mut(3).role = Some(Role::Inlet);
    let given = stated(&network);
    assert_eq!(
        given.iter().map(|g| (g.node, g.role)).collect::<Vec<_>>(),
        [(0, Role::Outlet), (1, Role::Inlet), (2, Role::Inlet)]
    );
}

/// By hand: a line of four equal vessels, whose inlet and outlet of 2 Pa s/m³ were found. Without the second vessel there are two more ends, and each
/// of the three outlets conducts a third of what one did. Without the first one, blood comes in where that ended. Without any decision on them the
/// conditions stay, and so does a pressure at an inlet whose end does.
#[test]
fn what_was_found_is_found_again_where_the_ends_are_others() {
    let line = network(5, (0..4).map(|at| ([at, at + 1], tube(10.0, 1.0))));
    let found = Boundary::resolve(&line, &[], FoundOutlets::Murray(Total::Resistance(2.0))).expect("two ends");
    let mut file = found.stated_in(line);
    file.node_mut(0).condition = Some(pressure(90.0));
    let told = |row: Option<usize>| {
        let mut decided = file.clone();
        if let Some(row) = row {
            (decided.vessel_mut(row).origin, decided.vessel_mut(row).prior) = (Origin::Candidate, 0.0);
        }
        let boundary = resolve(&find_again(decided), &[]);
        let of = |node: usize| match boundary.condition(node).expect("a condition") {
            Condition::Pressure(p) => (p / MMHG).round(),
            Condition::Resistance { resistance, .. } => resistance.round(),
            Condition::Flow(flow) => flow,
        };
        [&boundary.found_inlets, &boundary.found_outlets].map(|nodes| nodes.iter().map(|n| (*n, of(*n))).collect::<Vec<_>>())
    };
    assert_eq!(told(None), [vec![(0, 90.0)], vec![(4, 2.0)]]);
    assert_eq!(told(Some(1)), [vec![(0, 90.0)], vec![(1, 6.0), (2, 6.0), (4, 6.0)]]);
    assert_eq!(told(Some(0)), [vec![(1, 100.0)], vec![(4, 2.0)]]);
}
