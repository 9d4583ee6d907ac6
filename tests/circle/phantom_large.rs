//! The phantoms of any size: against the laws that they state (Murray, trees, degrees, connection), and their broken forms against
//! the whole ones.

use std::collections::{BTreeSet, HashSet};

use crate::command::{folder, stderr, willis};
use crate::refused::refused;
use willis::internals::formats::{graph_columns, write_graphml};
use willis::internals::network::units::pascals;
use willis::internals::network::{Condition, Network, Origin, Role, cycles, fragments};
use willis::internals::phantom::{Anatomy, Gaps, Large, Recipe, Truth, arterial, capillary, over_connected, with_gaps};
use willis::internals::support::geometry::distance;

const KINDS: [Anatomy; 2] = [Anatomy::Arterial, Anatomy::Capillary];
const SIZES: [usize; 4] = [100, 101, 700, 3000];

fn large(edges: usize, seed: u64) -> Large {
    Large { edges, seed, spacing: None }
}

fn recipe(edges: usize, seed: u64) -> Recipe {
    Recipe { edges: Some(edges), seed, spacing: None }
}

/// Every kind, size and two seeds.
fn each(check: impl Fn(Anatomy, &Recipe, &Network)) {
    for kind in KINDS {
        for recipe in SIZES.into_iter().flat_map(|edges| [recipe(edges, 0), recipe(edges, 5)]) {
            check(kind, &recipe, &kind.network(&recipe).unwrap());
        }
    }
}

fn role(network: &Network, role: Role) -> Vec<usize> {
    (0..network.node_count()).filter(|row| network.node(*row).role == Some(role)).collect()
}

#[test]
fn the_size_is_the_one_asked_for() {
    each(|kind, recipe, network| {
        let (wanted, made) = (recipe.edges.unwrap(), network.vessel_count());
        let off = if kind == Anatomy::Arterial { 0.0 } else { 0.02 };
        assert!(wanted.abs_diff(made) as f64 <= off * wanted as f64, "{kind} {made} of {wanted}");
        assert!(network.nodes().zip(1..).all(|(node, id)| node.id == id.to_string() && node.radius.is_some()));
        assert!(network.vessels().all(|(_, vessel)| vessel.length > 0.0 && vessel.radius > 0.0 && vessel.path.is_empty()));
        assert!(network.vessels().all(|([a, b], vessel)| {
            let [a, b] = [a, b].map(|node| network.node(node).position.unwrap());
            vessel.length == distance(a, b)
        }));
    });
}

/// A forest of 12 has 12 nodes more than edges. Every end is the root of its tree or an outlet.
#[test]
fn arteries_are_twelve_trees_from_inlets_to_outlets() {
    for network in SIZES.map(|edges| arterial(&large(edges, 1))) {
        assert_eq!(network.node_count(), network.vessel_count() + 12);
        assert_eq!((cycles(&network), fragments(&network, |_, _| true).count), (0, 12));
        let degree = network.degrees(|_| true);
        let free: Vec<usize> = (0..degree.len()).filter(|row| degree[*row] == 1).collect();
        let (inlets, outlets) = (role(&network, Role::Inlet), role(&network, Role::Outlet));
        assert_eq!(free.into_iter().collect::<BTreeSet<_>>(), inlets.iter().chain(&outlets).copied().collect());
        let trees = fragments(&network, |_, _| true);
        assert_eq!(inlets.iter().map(|row| trees.of_node[*row]).collect::<BTreeSet<_>>().len(), 12);
        assert!(degree.iter().all(|degree| (1..=3).contains(degree)) && degree.contains(&2));
        assert!(inlets.iter().all(|row| network.node(*row).condition == Some(Condition::Pressure(pascals(100.0)))));
    }
}

/// r0^3 = r1^3 + r2^3 where three vessels meet, one radius where two do; so the outlets together take what the roots ask for:
/// 12 times 250 mL/min (1.2/2)^3 at 100 mmHg.
#[test]
fn arteries_keep_murrays_law() {
    let network = arterial(&large(3000, 2));
    let mut cubes = vec![Vec::new(); network.node_count()];
    for (ends, vessel) in network.vessels() {
        for end in ends {
            cubes[end].push(vessel.radius.powi(3));
        }
    }
    for cubes in &mut cubes {
        cubes.sort_by(f64::total_cmp);
        match cubes[..] {
            [_] => {}
            [one, other] => assert_eq!(one, other),
            [one, other, parent] => assert!((parent / (one + other) - 1.0).abs() < 1e-12),
            _ => panic!("{} vessels meet", cubes.len()),
        }
    }
    let conductance = |node: &willis::internals::network::Node| match node.condition {
        Some(Condition::Resistance { resistance, .. }) => 1.0 / resistance,
        _ => 0.0,
    };
    let flow = network.nodes().map(conductance).sum::<f64>() * pascals(100.0) * 6e7;
    assert!((flow / (12.0 * 250.0 * 0.6_f64.powi(3)) - 1.0).abs() < 1e-9, "{flow} mL/min");
}

/// What the large-graph benchmarks count on: about as many nodes as vessels, a quarter of them outlets.
#[test]
fn a_quarter_of_the_arterial_nodes_are_outlets() {
    let network = arterial(&large(10_000, 0));
    let outlets = role(&network, Role::Outlet).len() as f64 / network.node_count() as f64;
    assert!((0.23..0.27).contains(&outlets), "{outlets}");
}

/// Leaves fill the box evenly: no eighth of it has more than twice the leaves of another.
#[test]
fn arteries_fill_space() {
    let network = arterial(&large(10_000, 0));
    let mut leaves = [0; 8];
    for row in role(&network, Role::Outlet) {
        let at = network.node(row).position.unwrap();
        leaves[(0..3).map(|axis| usize::from(at[axis] > [0.069, 0.055, 0.040][axis]) << axis).sum::<usize>()] += 1;
    }
    assert!(leaves.iter().max() < leaves.iter().min().map(|least| 2 * least).as_ref(), "{leaves:?}");
}

#[test]
fn capillaries_are_one_mesh_of_degree_three() {
    for edges in SIZES {
        let network = capillary(&large(edges, 3)).unwrap();
        assert_eq!(fragments(&network, |_, _| true).count, 1);
        let degree = network.degrees(|_| true);
        assert!(degree.iter().all(|degree| (1..=3).contains(degree)));
        assert!(edges < 3000 || degree.iter().filter(|degree| **degree == 3).count() > degree.len() / 2);
        let (inlets, outlets) = (role(&network, Role::Inlet), role(&network, Role::Outlet));
        assert!(!inlets.is_empty() && inlets.len() == outlets.len());
        let top = |row: &usize| network.node(*row).position.unwrap()[2];
        let deepest_mouth = inlets.iter().chain(&outlets).map(top).fold(f64::INFINITY, f64::min);
        let others = (0..network.node_count()).filter(|row| network.node(*row).role == Some(Role::Inner));
        assert!(others.map(|row| top(&row)).all(|z| z < deepest_mouth));
        assert!(inlets.iter().chain(&outlets).all(|row| degree[*row] == 1));
        assert!(outlets.iter().all(|row| network.node(*row).condition == Some(Condition::Pressure(0.0))));
        let pairs: HashSet<[usize; 2]> = network.vessels().map(|([a, b], _)| [a.min(b), a.max(b)]).collect();
        assert_eq!(pairs.len(), network.vessel_count());
    }
    assert_eq!(role(&capillary(&large(10_000, 0)).unwrap(), Role::Inlet).len(), 10);
}

/// Of 3000 normal deviates of ln r the median is within four of its standard errors, 1.25 s/sqrt(n).
#[test]
fn capillary_radii_are_log_normal() {
    let network = capillary(&large(3000, 0)).unwrap();
    let mut logs: Vec<f64> = network.vessels().map(|(_, v)| (v.radius / 2.7e-6).ln()).collect();
    logs.sort_by(f64::total_cmp);
    // Feeders, 4 to 8 micrometres, are less than one in twenty and move the median by less than their share.
    assert!(logs[logs.len() / 2].abs() < 4.0 * 1.25 * 0.25 / 3000_f64.sqrt() + 0.05, "{}", logs[logs.len() / 2]);
    let width = logs[logs.len() / 4 * 3] - logs[logs.len() / 4];
    assert!((width / (2.0 * 0.6745 * 0.25) - 1.0).abs() < 0.15, "{width}");
}

#[test]
fn a_seed_gives_the_same_bytes_and_another_seed_others() {
    for kind in KINDS {
        let bytes = |seed| {
            let (network, mut file) = (kind.network(&recipe(500, seed)).unwrap(), Vec::new());
            let (nodes, vessels) = graph_columns(&network);
            write_graphml(&mut file, &network, &nodes, &vessels).unwrap();
            file
        };
        assert_eq!(bytes(0), bytes(0));
        assert_ne!(bytes(0), bytes(1));
    }
}

#[test]
fn a_spacing_puts_points_along_the_vessels() {
    for (kind, spacing) in [(Anatomy::Arterial, 1e-3), (Anatomy::Capillary, 1e-5)] {
        let straight = kind.network(&recipe(200, 0)).unwrap();
        let network = kind.network(&Recipe { spacing: Some(spacing), ..recipe(200, 0) }).unwrap();
        for (row, (ends, vessel)) in network.vessels().enumerate() {
            assert_eq!((ends, vessel.length, vessel.radius), {
                let same = straight.vessel(row);
                (straight.ends(row), same.length, same.radius)
            });
            let steps = vessel.path.windows(2).map(|p| distance(p[0].position, p[1].position));
            assert!(steps.clone().all(|step| step < 1.51 * spacing));
            assert!((steps.sum::<f64>() / vessel.length - 1.0).abs() < 1e-9);
        }
    }
}

/// Joins the two sides of every gap and counts the parts of what `links` join.
fn parts(points: usize, links: impl Iterator<Item = [usize; 2]>, truth: &Truth) -> [usize; 2] {
    let mut union = petgraph::unionfind::UnionFind::<usize>::new(points);
    for [a, b] in links {
        union.union(a, b);
    }
    let count = |union: &petgraph::unionfind::UnionFind<usize>| (0..points).map(|p| union.find(p)).collect::<HashSet<_>>().len();
    let before = count(&union);
    for gap in &truth.breaks {
        union.union(gap.ids[0] as usize - 1, gap.ids[1] as usize - 1);
    }
    [before, count(&union)]
}

/// The share of vessels, rounded; each at two loose ends a third of the vessel apart, and put right the network is whole again.
#[test]
fn broken_centerlines_have_their_gaps_and_no_other_damage() {
    each(|kind, recipe, network| {
        for spacing in [None, Some(2e-5)].into_iter().take(if kind == Anatomy::Capillary { 2 } else { 1 }) {
            let gaps = Gaps { spacing, ..kind.gaps(recipe).unwrap() };
            let (lines, truth) = with_gaps(network, &gaps).unwrap();
            let share = if kind == Anatomy::Arterial { 0.025 } else { 0.02 };
            assert_eq!(truth.breaks.len(), (share * network.vessel_count() as f64).round() as usize);
            assert_eq!(truth.breaks.iter().map(|gap| gap.vessel).collect::<HashSet<_>>().len(), truth.breaks.len());
            let mut degree = vec![0; lines.points.len()];
            for point in lines.links.iter().flatten() {
                degree[*point as usize] += 1;
            }
            for gap in &truth.breaks {
                let [a, b] = gap.ids.map(|id| id as usize - 1);
                assert_eq!([degree[a], degree[b]], [1, 1]);
                let third = distance(lines.points[a], lines.points[b]) / network.vessel(gap.vessel).length;
                assert!((third - gap.length() / network.vessel(gap.vessel).length).abs() < 1e-9);
                assert!(if spacing.is_none() { (third - 1.0 / 3.0).abs() < 1e-9 } else { (0.19..0.61).contains(&third) });
            }
            let links = lines.links.iter().map(|link| link.map(|point| point as usize));
            let [broken, whole] = parts(lines.points.len(), links, &truth);
            assert_eq!(broken, truth.spurious.len());
            assert_eq!(whole, fragments(network, |_, _| true).count);
            assert!(truth.lost.is_empty() && truth.spurious.iter().all(|spurious| !spurious));
            assert_eq!(truth.inlets.len(), role(network, Role::Inlet).len());
            if spacing.is_none() {
                assert_eq!(lines.points.len(), network.node_count() + 2 * truth.breaks.len());
            }
        }
    });
}

/// Brute force: of all nodes but those it is joined to, the six nearest of every loose end, each pair once.
#[test]
fn the_over_connected_graph_has_the_nearest_nodes_of_every_loose_end() {
    each(|kind, recipe, network| {
        let gaps = kind.gaps(recipe).unwrap();
        let (graph, truth) = over_connected(network.clone(), &gaps, 6).unwrap();
        let count = truth.breaks.len();
        assert_eq!(graph.node_count(), network.node_count() + 2 * count);
        let observed: Vec<[usize; 2]> =
            graph.vessels().filter(|(_, v)| v.origin == Origin::Observed).map(|(ends, _)| ends).collect();
        assert_eq!(observed.len(), network.vessel_count() + count);
        let [broken, whole] = parts(graph.node_count(), observed.iter().copied(), &truth);
        assert_eq!((broken, whole), (truth.spurious.len(), fragments(network, |_, _| true).count));
        assert!((0..network.node_count()).all(|row| graph.node(row) == network.node(row)));

        let pairs: HashSet<[usize; 2]> = observed.iter().copied().collect();
        let mut expected = BTreeSet::new();
        let position = |row: usize| graph.node(row).position.unwrap();
        for end in network.node_count()..graph.node_count() {
            let joined = |row: usize| pairs.contains(&[row, end]) || pairs.contains(&[end, row]);
            let mut near: Vec<(f64, usize)> = (0..graph.node_count())
                .filter(|row| *row != end && !joined(*row))
                .map(|row| (distance(position(row), position(end)), row))
                .collect();
            near.sort_by(|a, b| a.partial_cmp(b).unwrap());
            expected.extend(near[..6].iter().map(|(_, row)| [end.min(*row), end.max(*row)]));
        }
        let candidates = graph.vessels().skip(observed.len());
        let mut seen = BTreeSet::new();
        for ([a, b], vessel) in candidates {
            assert_eq!((vessel.origin, vessel.prior, vessel.certain), (Origin::Candidate, 1.0, false));
            let narrower = graph.node(a).radius.unwrap().min(graph.node(b).radius.unwrap());
            assert!((vessel.radius / narrower - 1.0).abs() < 1e-15);
            assert!((vessel.length / distance(position(a), position(b)) - 1.0).abs() < 1e-15);
            assert!(seen.insert([a.min(b), a.max(b)]));
        }
        assert_eq!(seen, expected);
    });
}

/// Broken and unbroken, drawn and as a graph: one seed, one anatomy and one set of gaps.
#[test]
fn the_gaps_are_the_same_in_lines_and_in_a_graph() {
    for kind in KINDS {
        let (recipe, network) = (recipe(500, 9), kind.network(&recipe(500, 9)).unwrap());
        let gaps = kind.gaps(&recipe).unwrap();
        let broken = |truth: &Truth| truth.breaks.iter().map(|gap| (gap.vessel, gap.stretch)).collect::<Vec<_>>();
        let (_, lines) = with_gaps(&network, &gaps).unwrap();
        let (_, graph) = over_connected(network, &gaps, 6).unwrap();
        assert_eq!(broken(&lines), broken(&graph));
    }
}

#[test]
fn the_command_writes_whole_broken_and_over_connected_phantoms() {
    let here = folder();
    for kind in ["arterial", "capillary"] {
        for rest in
            [&["-o", "a.graphml"][..], &["--break", "-o", "b.swc"], &["--break", "-o", "c.graphml"], &["--break", "-o", "c.csv"]]
        {
            let mut arguments = vec!["phantom", kind, "--edges", "200", "--seed", "4", "--force"];
            arguments.extend(rest);
            let made = willis(here.path(), &arguments);
            assert!(made.status.success(), "{}", stderr(&made));
        }
        let said = stderr(&willis(here.path(), &["infer", "c.graphml", "-o", "run", "-n", "64", "--force"]));
        assert!(said.contains("candidate"), "{said}");
        assert!(here.path().join("run/edges.csv").exists() && here.path().join("c.truth.json").exists());
    }
}

#[test]
fn what_does_not_go_together_is_refused() {
    for (arguments, words) in [
        (&["arterial", "-o", "a.swc"][..], &["edges missing", "100 to 10000000"][..]),
        (&["arterial", "--edges", "99", "-o", "a.swc"], &["edges 99", "100 to 10000000"]),
        (&["capillary", "--edges", "10000001", "-o", "a.swc"], &["edges 10000001", "100 to 10000000"]),
        (&["tree", "--edges", "200", "-o", "a.swc"], &["edges 200", "a size of its own"]),
        (&["tree", "--seed", "1", "-o", "a.swc"], &["--seed 1", "--break"]),
        (&["arterial", "--edges", "200", "--without", "A1", "-o", "a.swc"], &["--without A1", "no labels"]),
        (&["arterial", "--edges", "200", "--break", "-o", "a.vtp"], &["a.vtp", ".swc, .graphml or .csv"]),
        (&["tree", "--break", "-o", "a.graphml"], &["a.graphml", "expected an ending .swc for"]),
        (&["arterial", "--edges", "200", "--spacing", "0", "-o", "a.swc"], &["--spacing", "positive"]),
        (&["arterial", "--edges", "200", "--spacing", "1m", "-o", "a.swc"], &["spacing 1000", "0.01 to 10 mm"]),
    ] {
        refused(&[], &[&["phantom"], arguments].concat(), words);
    }
}
