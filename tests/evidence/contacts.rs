//! Contacts: clusters of junctions, what the mask tells of two ends, and what becomes of a crossing.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;

use crate::command::{data, folder, stderr, willis};
use crate::draw::Draw;
use crate::refused::refused;
use willis::internals::contacts::branches::{BranchEnd, Branches};
use willis::internals::contacts::features::{PairTable, pairs_among, skeleton_feature_names};
use willis::internals::contacts::model::{ContactModel, Crowding};
use willis::internals::contacts::partition::{Blocks, PARTITION_FEATURES, SIZES, most_probable, pair_probabilities, partitions};
use willis::internals::contacts::sections::section;
use willis::internals::contacts::split::{Opened, Pairings, split};
use willis::internals::contacts::{Basis, pair_features};
use willis::internals::formats::{ReadOptions, read_mask, write_nifti};
use willis::internals::masks::{Field, Foreground, Mask};
use willis::internals::network::{
    Frame, GraphEditor, Network, Node, Origin, PathPoint, RadiusRule, Vessel, cycles, dependents, fragments, if_parted,
};
use willis::internals::support::geometry::{Point, distance};
use willis::internals::support::statistics::sigmoid;

/// A network of nodes (mm) and straight vessels between them, of 1 mm radius.
fn network(nodes: &[Point], vessels: &[[usize; 2]]) -> Network {
    let mut network = Network::new();
    for (row, at) in nodes.iter().enumerate() {
        network.add_node(Node {
            id: row.to_string(),
            position: Some(at.map(|x| x / 1e3)),
            radius: Some(1e-3),
            ..Node::default()
        });
    }
    for [a, b] in vessels {
        let at = |share: f64| [0, 1, 2].map(|k| (nodes[*a][k] + share * (nodes[*b][k] - nodes[*a][k])) / 1e3);
        let path = (0..=20).map(|n| PathPoint { position: at(f64::from(n) / 20.0), radius: 1e-3, id: None }).collect();
        network.add_vessel([*a, *b], Vessel::along(path, RadiusRule::Mean));
    }
    network
}

/// Two vessels along x and along y that cross, with junctions 1 mm apart where they share a stretch.
fn crossing() -> Network {
    let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [-20.0, 0.0, 0.0], [0.0, -20.0, 0.0], [21.0, 0.0, 0.0], [1.0, 20.0, 0.0]];
    network(&nodes, &[[2, 0], [3, 0], [0, 1], [1, 4], [1, 5]])
}

#[test]
fn junctions_within_each_others_lumen_are_one_cluster() {
    let branches = Branches::new(&crossing());
    assert_eq!(branches.clusters.len(), 1);
    let cluster = &branches.clusters[0];
    assert_eq!((cluster.nodes.as_slice(), cluster.inner.len(), cluster.ends.len()), (&[0, 1][..], 1, 4));
    // Three millimetres apart they are two: the sum of the radii is two.
    let nodes = [[0.0; 3], [3.0, 0.0, 0.0], [-20.0, 0.0, 0.0], [0.0, -20.0, 0.0], [23.0, 0.0, 0.0], [3.0, 20.0, 0.0]];
    let apart = Branches::new(&network(&nodes, &[[2, 0], [3, 0], [0, 1], [1, 4], [1, 5]]));
    assert_eq!(apart.clusters.iter().map(|c| c.ends.len()).collect::<Vec<usize>>(), [3, 3]);
}

#[test]
fn a_vessel_that_a_candidate_splits_is_one_branch() {
    let nodes = [[0.0; 3], [10.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, -9.0, 0.0]];
    let branches = Branches::new(&network(&nodes, &[[0, 1], [2, 1], [0, 3], [0, 4]]));
    let long = branches.branches.iter().find(|b| b.vessels.len() == 2).expect("a branch of two vessels");
    assert_eq!((long.nodes.as_slice(), &long.vessels[1]), (&[0, 1, 2][..], &(1, true)));
    // Lengths have 32 bits.
    assert!((long.length / 20e-3 - 1.0).abs() < 1e-9);
}

#[test]
fn the_ends_of_a_vessel_that_passes_straight_are_the_straightest() {
    let branches = Branches::new(&crossing());
    let features = pair_features(&branches, None, None);
    let ends = &branches.clusters[0].ends;
    let row = |i, j| pairs_among(ends.len()).position(|pair| pair == [i, j]).expect("a pair");
    let end_of =
        |vessel: usize| ends.iter().position(|end| branches.branches[end.branch].vessels[0].0 == vessel).expect("an end");
    let straight = skeleton_feature_names().iter().position(|name| name == "straight_far").expect("a feature");
    let pair = |a, b| {
        let (i, j) = (end_of(a), end_of(b));
        features[[row(i.min(j), i.max(j)), straight]]
    };
    assert!(pair(0, 3) > 0.99 && pair(1, 4) > 0.99, "{} {}", pair(0, 3), pair(1, 4));
    assert!(pair(0, 1).abs() < 0.1 && pair(0, 4).abs() < 0.1);
    assert_eq!(features.dim(), (6, Basis::Skeleton.feature_names().len()));
}

#[test]
fn a_crossing_becomes_two_vessels_and_a_contact() {
    let network = crossing();
    let branches = Branches::new(&network);
    let ends = &branches.clusters[0].ends;
    // Vessels 0 and 3 are one, 1 and 4 the other.
    let of_end: Vec<usize> =
        ends.iter().map(|end| usize::from([1, 4].contains(&branches.branches[end.branch].vessels[0].0))).collect();
    let blocks = if of_end[0] == 0 { of_end } else { of_end.iter().map(|block| 1 - block).collect() };
    let graph =
        split(&network, &branches, &[Blocks { of_end: blocks, joined: vec![([0, 1], 0.25)], ..Blocks::default() }], |p| 2.0 * p)
            .graph;
    let observed = fragments(&graph, |_, v| v.origin == Origin::Observed);
    let through = |a: usize, b: usize| {
        let vessel = |at: Point| {
            let near = |row: &usize| graph.node(*row).position.is_some_and(|p| distance(p, at.map(|x| x / 1e3)) < 1e-9);
            (0..graph.node_count()).find(near).map(|row| observed.of_node[row])
        };
        let place = |row: usize| network.node(row).position.unwrap_or_default().map(|x| x * 1e3);
        vessel(place(a)) == vessel(place(b))
    };
    assert!(through(2, 4) && through(3, 5) && !through(2, 3) && !through(2, 5));
    let contacts: Vec<&Vessel> = graph.vessels().map(|(_, v)| v).filter(|v| v.origin == Origin::Contact).collect();
    assert_eq!(contacts.len(), 1);
    // P is what the calibration makes of the partitions; a decision goes by these.
    let stated = contacts[0].evidence().map(|e| (e.probability, e.attached));
    assert_eq!((contacts[0].prior, stated), (0.5, Some((0.5, [0.125; 2]))));
    assert!(contacts[0].length > 0.0);
    // Each vessel has the shared stretch, and the contact joins them again: nothing is lost.
    let length = |n: &Network| n.vessels().filter(|(_, v)| v.origin == Origin::Observed).map(|(_, v)| v.length).sum::<f64>();
    assert!((length(&graph) - length(&network) - 1e-3).abs() < 1e-9);
    assert_eq!(fragments(&graph, |_, _| true).of_node.iter().filter(|part| **part == 0).count(), graph.node_count());
    assert_eq!(cycles(&graph), 0);
}

/// A candidate at the middle of the shared stretch of a crossing, which neither of the vessels has that part at its ends, goes on to where it ends then;
/// the junction in the middle is gone.
#[test]
fn points_of_a_candidate_end_at_its_nodes_where_a_contact_is_opened() {
    let nodes =
        [[0.0; 3], [1.0, 0.0, 0.0], [0.4, 0.0, 0.0], [-20.0, 0.0, 0.0], [0.0, -20.0, 0.0], [21.0, 0.0, 0.0], [1.0, 20.0, 0.0]];
    for ends in [[2, 7], [7, 2]] {
        let mut network =
            network(&[&nodes[..], &[[0.4, 0.0, 9.0]]].concat(), &[[3, 0], [4, 0], [0, 2], [2, 1], [1, 5], [1, 6], ends]);
        network.vessel_mut(6).origin = Origin::Candidate;
        let branches = Branches::new(&network);
        let beside = |end: &BranchEnd| usize::from(branches.branches[end.branch].vessels[0].0 > 3);
        let of_end: Vec<usize> = branches.clusters[0].ends.iter().map(beside).collect();
        assert_eq!(of_end.iter().filter(|block| **block == of_end[0]).count(), 2);
        let of_end = of_end.iter().map(|block| usize::from(*block != of_end[0])).collect();
        let blocks = Blocks { of_end, joined: vec![([0, 1], 0.25)], ..Blocks::default() };
        let Opened { graph, node_now, .. } = split(&network, &branches, &[blocks], |p| p);
        // The middle is gone, and the end of the stretch that is nearer to it stands for it.
        assert_eq!((graph.node_count(), node_now), (7, vec![0, 1, 0, 2, 3, 4, 5, 6]));
        let (now, candidate) = graph.vessels().find(|(_, vessel)| vessel.origin == Origin::Candidate).expect("a candidate");
        assert_eq!(now.map(|node| node == 6), ends.map(|node| node == 7));
        for (node, point) in now.into_iter().zip([0, candidate.path.len() - 1]) {
            assert_eq!(graph.node(node).position, Some(candidate.path[point].position));
        }
        assert_eq!((candidate.length, candidate.path.len()), (network.vessel(6).length, network.vessel(6).path.len() + 1));
    }
}

#[test]
fn margins_and_pairings_of_a_table_are_those_by_hand() {
    let table = PairTable::of(4, -9.0, |i, j| [[0.0, 5.0, 1.0, 2.0], [0.0, 0.0, 3.0, 0.5], [0.0, 0.0, 0.0, 4.0], [0.0; 4]][i][j]);
    // Of 0 the best other partner gives 2, of 1 it gives 3.
    assert_eq!(table.margins([0, 1], -1.0), [2.0, 3.0]);
    // 0-1 and 2-3 give 9; apart, 0-2 and 1-3 give 1.5, 0-3 and 1-2 give 5.
    assert_eq!(table.pairing_gains().get(0, 1), 4.0);
    // Every way to part two ends and to pair two others, of tables with many equal values.
    let mut draw = Draw::new(11);
    for size in [2, 3, 4, 5, 7, 9] {
        let values: Vec<f64> = (0..size * size).map(|_| draw.below(6) as f64).collect();
        let table = PairTable::of(size, -9.0, |i, j| values[i * size + j]);
        let gains = table.pairing_gains();
        for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let two = |p: &usize, q: &usize| p != q && ![*p, *q].iter().any(|end| [i, j].contains(end));
            let others = (0..size).flat_map(|p| (0..size).map(move |q| (p, q))).filter(|(p, q)| two(p, q));
            let [mut together, mut apart] = [f64::NEG_INFINITY; 2];
            for (p, q) in others {
                together = together.max(table.get(p, q));
                apart = apart.max(table.get(i, p) + table.get(j, q));
            }
            assert_eq!(gains.get(i, j), if size < 4 { 0.0 } else { table.get(i, j) + together - apart }, "{size}: {i} {j}");
        }
    }
}

/// A star of three hundred legs, as a wrong mask may have, is looked at in a time that grows with the cube of their number at the most: it took
/// half a minute, and an hour for a thousand.
#[test]
fn a_star_of_many_legs_takes_no_time() {
    let mut text = String::from("1 2 0 0 0 1 -1\n");
    for leg in 0..300 {
        let (height, turn) = (1.0 - f64::from(2 * leg + 1) / 300.0, f64::from(leg) * 2.4);
        let across = f64::sqrt(1.0 - height * height);
        for step in 1..=10 {
            let [x, y, z] = [across * turn.cos(), across * turn.sin(), height].map(|x| 10.0 * f64::from(step) * x);
            let id = 1 + leg * 10 + step;
            let parent = if step == 1 { 1 } else { id - 1 };
            writeln!(text, "{id} 2 {x} {y} {z} 1 {parent}").expect("written");
        }
    }
    let here = folder();
    fs::write(here.path().join("star.swc"), text).expect("written");
    let before = std::time::Instant::now();
    let output = willis(here.path(), &["candidates", "star.swc", "--cut", "always", "--prior", "uniform", "-o", "star.graphml"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(before.elapsed().as_secs() < 10, "{:?}", before.elapsed());
}

/// A tube along x of a radius in voxels of 0.5 mm, its wall cut at the middle of voxels.
fn tube(radius: f64) -> Mask {
    let shape = [60, 40, 40];
    let is = |row: usize| {
        let [y, z] = [row / 60 % 40, row / 2400].map(|x| x as f64 - 19.5);
        (y * y + z * z).sqrt() <= radius
    };
    let classes = (0..shape.iter().product()).map(|row| u8::from(is(row))).collect();
    Mask::new(shape, classes, [[0.5, 0.0, 0.0, -15.0], [0.0, 0.5, 0.0, -9.75], [0.0, 0.0, 0.5, -9.75]])
}

#[test]
fn the_section_of_a_tube_is_its_circle() {
    for radius in [4.0, 8.0] {
        let field = Field::of(&Foreground::of(&tube(radius)).expect("a tube"));
        for direction in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]] {
            // Nineteen samples over so much: six to a radius.
            let found = section(&field, [0.0; 3], direction, 1.6 * radius * 0.5e-3);
            // Oblique sections are ellipses, longer by the cosine.
            let lengthening = if direction[1] > 0.0 { 2.0_f64.sqrt() } else { 1.0 };
            let truth = PI * (radius * 0.5e-3).powi(2) * lengthening;
            assert!((found.area / truth - 1.0).abs() < 0.12, "{radius} {direction:?}: {} of {truth}", found.area);
            assert!((found.elongation / lengthening - 1.0).abs() < 0.12, "{}", found.elongation);
            // Depth falls from the axis to the wall, so 1.2 radii along the ellipse 1 - 1.2/√2 of it is left, up to a voxel; across the
            // circle nothing.
            assert!(distance(found.shift, [0.0; 3]) < 0.1e-3, "{:?}", found.shift);
            let left = (1.0 - 1.2 / lengthening).max(0.0);
            assert!((found.second - left).abs() < 1.0 / radius, "{} of {left}", found.second);
        }
        // On the axis, which lies between voxels, the wall is a radius away up to a voxel; outside it is on the other side.
        assert!((field.signed([0.0; 3]) - radius * 0.5e-3).abs() < 0.5e-3);
        assert!(field.signed([0.0, (radius + 1.0) * 0.5e-3, 0.0]) < 0.0);
        assert_eq!(field.depth([0.0, 9e-3, 0.0]), 0.0);
    }
}

/// Rows of edges.csv as maps from column to text.
fn rows(out: &std::path::Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = std::fs::read_to_string(out.join("edges.csv")).expect("edges.csv");
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
    lines.map(|line| names.iter().cloned().zip(line.split(',').map(str::to_owned)).collect()).collect()
}

#[test]
fn what_is_cut_at_contacts_is_reconnected_while_that_joins_parts() {
    let at = folder();
    let scan = data("scan.nii.gz");
    let components = |name: &str, more: &[&str]| {
        let out = at.path().join(name);
        let ran = willis(at.path(), &[&["infer", &scan, "-o", name, "-n", "1", "--json", "--quiet"], more].concat());
        assert!(ran.status.success(), "{}", stderr(&ran));
        let run: serde_json::Value = serde_json::from_slice(&ran.stdout).expect("JSON");
        (run["counts"]["topology"]["components"].as_u64().expect("a count"), rows(&out))
    };
    let (uncut, all) = components("uncut", &["--cut", "never"]);
    assert!(all.iter().all(|row| row["origin"] != "contact"));
    // Everything that a cut sets apart is joined again, and doubtful joins may join more.
    let (joined, rows) = components("cut", &["--keep", "reconnect=0"]);
    assert!(joined <= uncut, "{joined} of {uncut}");
    let contacts: Vec<_> = rows.iter().filter(|row| row["origin"] == "contact").collect();
    assert!(!contacts.is_empty());
    for row in contacts {
        let p: f64 = row["probability"].parse().expect("a probability");
        assert!((0.0..=1.0).contains(&p) && ["0", "1"].contains(&row["kept"].as_str()));
    }
    // The graph holds its contacts: handed back it gives the same answer.
    let ran = willis(
        at.path(),
        &["infer", "cut/candidates.graphml", "-o", "again", "--keep", "reconnect=0", "-n", "1", "--json", "--quiet"],
    );
    assert!(ran.status.success(), "{}", stderr(&ran));
    let again: serde_json::Value = serde_json::from_slice(&ran.stdout).expect("JSON");
    assert_eq!(again["counts"]["topology"]["components"].as_u64(), Some(joined));
}

/// Vessels of 10 and 20 mm cross others of 30 and 40 mm. Parted, the shorter has 30 mm; with 5 mm from the one to the other, both stay connected by
/// 20 + 5 + 40 mm, and what is far from them counts for nothing.
#[test]
fn what_depends_on_a_crossing_is_the_shorter_side_or_the_way_round() {
    let nodes =
        [[0.0; 3], [-10.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, -30.0, 0.0], [0.0, 40.0, 0.0], [90.0, 0.0, 0.0], [99.0, 0.0, 0.0]];
    let mut graph = network(&nodes, &[[1, 0], [0, 2], [3, 0], [0, 4], [5, 6], [2, 4]]);
    graph.vessel_mut(5).length = 0.005;
    let ends = [(0, 0, 0), (1, 0, 0), (2, 0, 1), (3, 0, 1)];
    let mm = |kept: [bool; 6], ends: &[(usize, usize, usize)]| (if_parted(&graph, &kept, ends) * 1e6).round() / 1e3;
    let without = [true, true, true, true, true, false];
    assert_eq!(mm(without, &ends), 30.0);
    assert_eq!(mm([true; 6], &ends), 65.0);
    // A vessel cut off by itself, and a block of which nothing is kept.
    assert_eq!(mm(without, &[(0, 0, 0), (1, 0, 1), (2, 0, 1), (3, 0, 1)]), 10.0);
    assert_eq!(mm([true, true, false, false, true, false], &ends), 0.0);
}

/// On a vessel at the end of a row hangs nothing at all, and on the one before it that vessel: 6.5 + 4.1 - 6.5 - 4.1 is not zero in m.
#[test]
fn nothing_hangs_on_the_last_vessel_of_a_row() {
    let nodes = [[0.0; 3], [4.1, 0.0, 0.0], [10.6, 0.0, 0.0], [11.6, 0.0, 0.0]];
    let mut graph = network(&nodes, &[[0, 1], [1, 2], [2, 3]]);
    for (row, mm) in [4.1, 6.5, 1.0].into_iter().enumerate() {
        graph.vessel_mut(row).length = mm / 1e3;
    }
    assert_eq!(dependents(&graph, &[true, true, false])[..2], [0.0, 0.0]);
    let hangs = dependents(&graph, &[true; 3]);
    assert_eq!((hangs[0], hangs[2]), (0.0, 0.0));
    assert!((hangs[1] - 0.001).abs() < 1e-15, "the shorter side of {hangs:?}");
}

/// The crossing of `crossing`, opened so that 2-4 and 3-5 are vessels, is decided in each of the fifteen ways to pair four ends: within 4 mm of
/// the middle the ends of a block are joined, and those of two blocks are not.
#[test]
fn a_decision_pairs_vessels_in_any_way() {
    let network = crossing();
    let branches = Branches::new(&network);
    let vessel_of = |end: &BranchEnd| branches.branches[end.branch].vessels[0].0;
    let of_end: Vec<usize> = branches.clusters[0].ends.iter().map(|end| usize::from([1, 4].contains(&vessel_of(end)))).collect();
    let first = of_end[0];
    let of_end = of_end.iter().map(|block| usize::from(*block != first)).collect();
    let opened = split(&network, &branches, &[Blocks { of_end, joined: vec![([0, 1], 0.25)], ..Blocks::default() }], |p| p);
    let [pairings] = &opened.pairings[..] else { panic!("one place") };
    let mut ways = BTreeSet::new();
    for code in 0..256_usize {
        // The blocks of four ends, numbered as they come.
        let blocks = [code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6];
        let mut seen = Vec::new();
        ways.insert(blocks.map(|block| {
            seen.iter().position(|of| *of == block).unwrap_or_else(|| {
                seen.push(block);
                seen.len() - 1
            })
        }));
    }
    assert_eq!(ways.len(), 15);
    let mut edits = 0;
    for way in ways {
        let decision = pairings.decision(&way, &opened.graph).expect("a way");
        let mut editor = GraphEditor::new(opened.graph.clone());
        if let Some(edit) = &decision.part {
            edits += 1;
            editor.edit(edit).expect("made");
        }
        let graph = editor.finish();
        let is_there = |row: usize, vessel: &Vessel| match vessel.origin {
            Origin::Candidate => vessel.certain,
            Origin::Contact => decision.accept.contains(&row) || decision.part.is_some() && vessel.certain,
            Origin::Observed => true,
        };
        let away = |node: usize| distance(graph.node(node).position.expect("a place"), [0.0005, 0.0, 0.0]);
        let near = |node: usize| away(node) < 0.004;
        let whole = fragments(&graph, |row, v| is_there(row, v) && graph.ends(row).into_iter().all(near));
        // Of a vessel that the edit divides its row has the place as an end.
        let place = |vessel: usize| {
            let ends = graph.ends(vessel).into_iter().filter(|node| near(*node));
            whole.of_node[ends.max_by(|a, b| away(*a).total_cmp(&away(*b))).expect("an end")]
        };
        for (a, vessel) in pairings.vessels.iter().enumerate() {
            for (b, other) in pairings.vessels.iter().enumerate() {
                assert_eq!(place(*vessel) == place(*other), way[a] == way[b], "{way:?}: {vessel} and {other}");
            }
        }
    }
    // The way that was taken and that with the contact need none.
    assert_eq!(edits, 13);
}

#[test]
fn pairings_name_the_vessels_that_meet_and_the_way_that_was_taken() {
    let pairings = Pairings {
        position: [0.0; 3],
        vessels: vec![4, 7, 9, 2],
        opened: vec![0, 1, 0, 1],
        ways: vec![(vec![0, 1, 0, 1], 0.8), (vec![0, 0, 1, 1], 0.15)],
        contacts: vec![([0, 1], 0)],
    };
    assert_eq!((pairings.taken(&[false]), pairings.taken(&[true])), (vec![0, 1, 0, 1], vec![0; 4]));
    assert_eq!([pairings.told(&[0, 1, 0, 1]), pairings.told(&[0; 4])], ["4+9 | 7+2", "4+7+9+2"]);

    let at = folder();
    let ran = willis(at.path(), &["infer", &data("scan.nii.gz"), "-o", "out", "-n", "1", "--dpi", "36", "--quiet"]);
    assert!(ran.status.success(), "{}", stderr(&ran));
    let vessels = rows(&at.path().join("out"));
    let table = std::fs::read_to_string(at.path().join("out/pairings.csv")).expect("a table");
    let lines: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(!lines.is_empty());
    for ways in lines.chunk_by(|a, b| a[..3] == b[..3]) {
        let probability: Vec<f64> = ways.iter().filter_map(|way| way[4].parse().ok()).collect();
        assert!(probability.iter().sum::<f64>() <= 1.0 + 1e-9 && probability.is_sorted_by(|a, b| a >= b), "{probability:?}");
        let taken: Vec<&Vec<&str>> = ways.iter().filter(|way| way[5] == "1").collect();
        assert_eq!(taken.len(), 1);
        // The same ends in every way.
        let ends = |way: &str| {
            let mut ends: Vec<usize> = way.split(['+', '|']).map(|end| end.trim().parse().expect("a vessel")).collect();
            ends.sort_unstable();
            ends
        };
        assert!(ways.iter().all(|way| ends(way[3]) == ends(ways[0][3])));
        assert!(ends(ways[0][3]).iter().all(|end| vessels[*end]["origin"] == "observed"));
        // Ends of the taken way that share a node there are in one block.
        let place: [f64; 3] = [0, 1, 2].map(|axis| ways[0][axis].parse().expect("mm"));
        let node_at = |row: usize| {
            let away = |end: &&str| {
                let at = ["x", "y", "z"].map(|axis| vessels[row][&format!("{end}{axis}_mm")].parse().expect("mm"));
                distance(at, place)
            };
            let nearest = ["a", "b"].into_iter().min_by(|a, b| away(a).total_cmp(&away(b))).expect("two ends");
            &vessels[row][&format!("node_{nearest}")]
        };
        let blocks: Vec<Vec<usize>> = taken[0][3].split('|').map(ends).collect();
        for (n, block) in blocks.iter().enumerate() {
            for other in &blocks[n + 1..] {
                let nodes = |block: &[usize]| block.iter().map(|row| node_at(*row)).collect::<BTreeSet<_>>();
                assert!(nodes(block).is_disjoint(&nodes(other)), "{}", taken[0][3]);
            }
        }
    }
}

#[test]
fn without_a_mask_cuts_are_suggested_that_always_would_make() {
    let at = folder();
    assert!(willis(at.path(), &["phantom", "capillary", "--edges", "300", "-o", "lines.vtp"]).status.success());
    let counts = |name: &str, cut: &str| {
        let ran =
            willis(at.path(), &["infer", "lines.vtp", "-o", name, "--cut", cut, "-n", "4", "--dpi", "36", "--json", "--quiet"]);
        assert!(ran.status.success(), "{}", stderr(&ran));
        serde_json::from_slice::<serde_json::Value>(&ran.stdout).expect("JSON")["counts"].clone()
    };
    let [suggested, made, none] = ["auto", "always", "never"].map(|cut| counts(cut, cut));
    assert!(suggested["suggested_cuts"].as_u64() > Some(0));
    assert_eq!(suggested["suggested_cuts"], made["cut"]);
    let read = |file: &str| std::fs::read_to_string(at.path().join(file)).expect("a table");
    // Suggestions change nothing.
    assert_eq!(read("auto/edges.csv"), read("never/edges.csv"));
    assert!((none["suggested_cuts"].as_u64(), none["contacts"].as_u64()) == (Some(0), Some(0)));
    assert!(!at.path().join("never/suggested-cuts.csv").exists() && !at.path().join("always/suggested-cuts.csv").exists());
    // The surest first; each is a contact that stays cut, with the same probability.
    let table = read("auto/suggested-cuts.csv");
    let probability = |line: &str| line.rsplit(',').next().and_then(|p| p.parse::<f64>().ok()).expect("a probability");
    let listed: Vec<f64> = table.lines().skip(1).map(probability).collect();
    let cut = rows(&at.path().join("always")).into_iter().filter(|row| row["origin"] == "contact" && row["kept"] == "0");
    let mut expected: Vec<f64> = cut.map(|row| row["probability"].parse().expect("a probability")).collect();
    expected.sort_by(f64::total_cmp);
    assert_eq!(listed, expected);
}

/// A scan's own lines, in RAS as masks are, and the same lines with x and y turned round, which is LPS: contacts are the same in each. A mask far
/// away, or of which hardly a vessel is in the lumen, is as none.
#[test]
fn contacts_by_a_mask_are_the_same_in_either_frame_and_a_mask_of_other_vessels_is_told() {
    let at = folder();
    let scan = data("scan.nii.gz");
    assert!(willis(at.path(), &["skeleton", &scan, "-o", "ras.swc"]).status.success());
    let lines = fs::read_to_string(at.path().join("ras.swc")).expect("lines");
    fs::write(at.path().join("lps.swc"), mirrored(&lines)).expect("written");
    for (name, by) in [("far.nii", 300.0), ("near.nii", 6.0)] {
        let mask = read_mask(scan.as_ref(), &ReadOptions::default(), Frame::Ras).expect("a mask");
        let mask = Mask { affine: mask.affine.map(|[a, b, c, d]| [a, b, c, d + by]), ..mask };
        write_nifti(fs::File::create(at.path().join(name)).expect("a file"), &mask, false).expect("written");
    }
    let run = |lines: &str, more: &[&str]| {
        let words =
            ["infer", lines, "-o", "out", "--force", "--cut", "always", "--prior", "weights:skeleton", "-n", "1", "--dpi", "36"];
        let ran = willis(at.path(), &[&words[..], more].concat());
        assert!(ran.status.success(), "{}", stderr(&ran));
        let contacts = rows(&at.path().join("out")).into_iter().filter(|row| row["origin"] == "contact");
        let figures: Vec<f64> = contacts.map(|row| row["probability"].parse().expect("a probability")).collect();
        (figures, stderr(&ran))
    };
    let [ras, lps] = ["ras.swc", "lps.swc"].map(|lines| run(lines, &["--mask", &scan]));
    assert!(ras.0.len() > 2 && lps.0.len() == ras.0.len(), "{} {}", ras.1, lps.1);
    assert!(ras.0.iter().zip(&lps.0).all(|(a, b)| (a - b).abs() < 1e-6), "{:?} {:?}", ras.0, lps.0);
    assert!(!ras.1.contains("does not show") && !lps.1.contains("does not show"));
    let (without, _) = run("ras.swc", &[]);
    assert_ne!(without, ras.0);
    for (name, why) in [("far.nii", "it lies "), ("near.nii", "most of them lie outside of it")] {
        let (found, said) = run("ras.swc", &["--mask", name]);
        assert!(found == without && said.contains(&format!("{name} does not show the vessels: {why}")), "{said}");
    }
}

/// A mask that states no size of its voxels has that of the lines, which are in voxels: contacts are those by a NIfTI mask that states it.
#[test]
fn a_mask_without_a_spacing_has_that_of_the_lines() {
    let at = folder();
    let scan = data("scan.nii.gz");
    let mask = read_mask(scan.as_ref(), &ReadOptions::default(), Frame::Unknown).expect("a mask");
    let [x, y, z] = mask.shape;
    let head = format!("{{'descr': '|u1', 'fortran_order': True, 'shape': ({x}, {y}, {z}), }}");
    let file = [b"\x93NUMPY\x01\x00\x76\x00".as_slice(), format!("{head:117}\n").as_bytes(), &mask.classes].concat();
    fs::write(at.path().join("mask.npy"), file).expect("written");
    let mm = [0, 1, 2].map(|axis| [0, 1, 2, 3].map(|column| if column == axis { 0.6 } else { 0.0 }));
    write_nifti(fs::File::create(at.path().join("mask.nii")).expect("a file"), &Mask { affine: mm, ..mask }, false)
        .expect("written");
    assert!(willis(at.path(), &["skeleton", "mask.npy", "--spacing", "1", "-o", "voxels.swc"]).status.success());
    let [without, with] = [("mask.npy", "a"), ("mask.nii", "b")].map(|(mask, out)| {
        let words = ["infer", "voxels.swc", "--units", "voxel", "--spacing", "0.6", "--mask", mask, "--cut", "always", "-o", out];
        let ran = willis(at.path(), &[&words[..], &["-n", "1", "--dpi", "36"]].concat());
        assert!(ran.status.success() && !stderr(&ran).contains("does not show"), "{}", stderr(&ran));
        let contacts = rows(&at.path().join(out)).into_iter().filter(|row| row["origin"] == "contact");
        contacts.map(|row| row["probability"].clone()).collect::<Vec<_>>()
    });
    assert!(without.len() > 2 && without == with, "{without:?} {with:?}");
}

/// Lines of SWC in RAS with x and y turned round, as their header then says.
pub fn mirrored(lines: &str) -> String {
    let turned = |line: &str| {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        for word in &mut words[2..4] {
            *word = (-word.parse::<f64>().expect("a coordinate")).to_string();
        }
        words.join(" ")
    };
    let line = |line: &str| if line.starts_with('#') { line.replace("SPACE=RAS", "SPACE=LPS") } else { turned(line) };
    lines.lines().map(|text| line(text) + "\n").collect()
}

/// A model as TOML.
fn written(model: &ContactModel) -> String {
    let mut text = Vec::new();
    model.write(&mut text).expect("TOML");
    String::from_utf8(text).expect("UTF-8")
}

#[test]
fn a_calibration_keeps_the_order_of_contacts() {
    let shipped = ContactModel::shipped().expect("a model");
    assert_eq!(ContactModel::read(&written(&shipped)).expect("the same"), *shipped);
    for part in [&shipped.skeleton, &shipped.mask] {
        let p: Vec<f64> = (0..=1000).map(|n| part.probability(f64::from(n) / 1000.0)).collect();
        assert!(p.is_sorted() && p.iter().all(|p| (0.0..=1.0).contains(p)) && part.crowding.is_some());
        // By hand: odds of one are the odds e^a.
        let odds = part.calibration[0].exp();
        assert!((part.probability(0.5) - odds / (1.0 + odds)).abs() < 1e-12);
    }
    for (name, needed) in [("crowding", false), ("calibration", true)] {
        let mut bare: toml::Table = written(&shipped).parse().expect("TOML");
        for part in ["skeleton", "mask"] {
            assert!(bare[part].as_table_mut().expect("a part").remove(name).is_some());
        }
        assert_eq!(ContactModel::read(&bare.to_string()).is_err(), needed, "{name}");
    }
    let mut turned = (*shipped).clone();
    turned.mask.calibration = [0.0, -1.0];
    let fault =
        ContactModel::read(&written(&turned)).expect_err("the order would turn round").in_file("own.toml".as_ref()).to_string();
    assert!(fault.contains("mask calibration") && fault.contains("b of at least 0"), "{fault}");
}

#[test]
fn handles_and_contacts_are_counted_per_length_in_radii() {
    // A ring of 80 mm with a twig of 20 mm, radii of 1 mm: one handle in 100 radii.
    let nodes = [[0.0; 3], [20.0, 0.0, 0.0], [20.0, 20.0, 0.0], [0.0, 20.0, 0.0], [-20.0, 0.0, 0.0]];
    let ring = network(&nodes, &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4]]);
    let found = Crowding::new(&ring, &Branches::new(&ring), 3);
    assert!((found.handles - 10.0).abs() < 1e-9 && (found.contacts - 30.0).abs() < 1e-9, "{found:?}");
}

#[test]
fn a_mask_more_crowded_than_those_of_the_calibration_is_told_so_by_its_figure() {
    let at = folder();
    let mut few = (*ContactModel::shipped().expect("a model")).clone();
    for part in [&mut few.skeleton, &mut few.mask] {
        part.crowding = Some(Crowding { contacts: 0.001, handles: 1000.0 });
    }
    std::fs::write(at.path().join("few.toml"), written(&few)).expect("a file");
    let notes = |cut: &str| {
        let ran = willis(
            at.path(),
            &["infer", &data("scan.nii.gz"), "-o", "out", "--cut", cut, "-n", "1", "--dpi", "36", "--json", "--quiet", "--force"],
        );
        assert!(ran.status.success(), "{}", stderr(&ran));
        serde_json::from_slice::<serde_json::Value>(&ran.stdout).expect("JSON")["notes"].to_string()
    };
    let told = notes("few.toml");
    assert!(told.contains("contacts (at most 0.0) per 1,000 radii") && !told.contains("handles ("), "{told}");
    assert!(!notes("auto").contains("per 1,000 radii"));
}

#[test]
fn what_is_no_model_of_contacts_is_refused() {
    refused(
        &[("own.toml", b"kind = \"skeleton\"")],
        &["infer", &data("scan.nii.gz"), "-o", "out", "--cut", "own.toml"],
        &["own.toml"],
    );
    refused(&[], &["infer", &data("scan.nii.gz"), "-o", "out", "--cut", "alwais"], &["alwais", "did you mean", "always"]);
    refused(
        &[("lines.swc", b"1 0 0 0 0 1 -1\n2 0 9 0 0 1 1\n")],
        &["infer", "lines.swc", "-o", "out", "--cut", "always", "--mask", "lines.swc"],
        &["lines.swc", "not a mask"],
    );
}

#[test]
fn what_is_half_as_crowded_again_is_told_with_its_figure() {
    let most = Crowding { contacts: 10.0, handles: 4.0 };
    assert_eq!(Crowding { contacts: 15.0, handles: 6.0 }.unlike(most), None);
    let told = Crowding { contacts: 3.0, handles: 6.5 }.unlike(most).expect("a note");
    assert!(told.contains("6.5 handles (at most 4.0)") && !told.contains(" contacts ("), "{told}");
    assert_eq!(most.most(Crowding { contacts: 3.0, handles: 5.0 }), Crowding { contacts: 10.0, handles: 5.0 });
}

#[test]
fn there_are_as_many_partitions_as_bell_counted() {
    let bell = [1, 2, 5, 15, 52, 203];
    assert_eq!([1, 2, 3, 4, 5, 6].map(|n| partitions(n).len()), bell);
    assert!(partitions(4).iter().all(|z| z[0] == 0 && (1..4).all(|n| z[n] <= z[..n].iter().max().unwrap() + 1)));
}

#[test]
fn independent_pairs_of_two_ends_have_the_probability_of_their_score() {
    let scores = PairTable::of(2, 0.0, |_, _| 1.3);
    let weights = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; SIZES];
    let p = pair_probabilities(&scores, &weights)[0];
    assert!((p - sigmoid(1.3)).abs() < 1e-12, "{p}");
    let blocks = most_probable(&PairTable::of(2, 0.0, |_, _| -1.3), &weights, &BTreeSet::new());
    assert_eq!(blocks.of_end, [0, 1]);
    assert!((blocks.joined[0].1 - sigmoid(-1.3)).abs() < 1e-12);
}

#[test]
fn a_crossing_is_two_vessels() {
    // 0-1 and 2-3 pass straight through, the rest bends.
    let scores = PairTable::of(4, 0.0, |i, j| if (i, j) == (0, 1) || (i, j) == (2, 3) { 3.0 } else { -2.0 });
    let weights = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; SIZES];
    let blocks = most_probable(&scores, &weights, &BTreeSet::new());
    assert_eq!(blocks.of_end, [0, 0, 1, 1]);
    // By hand: of the fifteen partitions those where a pair of the two vessels is together.
    let joined =
        ["0000", "0100", "0010", "0001", "0111", "0101", "0110", "0102", "0121", "0120", "0122", "0012", "0112", "0123", "0011"];
    assert_eq!(joined.len(), 15);
    let weight = |z: &str| {
        let z: Vec<u8> = z.bytes().collect();
        let together = |i: usize, j: usize| z[i] == z[j];
        let mut sum = 0.0;
        for (i, j, s) in [(0, 1, 3.0), (2, 3, 3.0), (0, 2, -2.0), (0, 3, -2.0), (1, 2, -2.0), (1, 3, -2.0)] {
            sum += if together(i, j) { s } else { 0.0_f64 };
        }
        let mixed = together(0, 2) || together(0, 3) || together(1, 2) || together(1, 3);
        (sum.exp(), mixed)
    };
    let all: Vec<(f64, bool)> = joined.iter().map(|z| weight(z)).collect();
    let expected = all.iter().filter(|(_, mixed)| *mixed).map(|(w, _)| w).sum::<f64>() / all.iter().map(|(w, _)| w).sum::<f64>();
    assert!((blocks.joined[0].1 - expected).abs() < 1e-12);
}

#[test]
fn a_clump_is_put_together_while_that_pays() {
    let scores = PairTable::of(8, 0.0, |i, j| if i / 4 == j / 4 { 1.0 } else { -1.0 });
    assert_eq!(most_probable(&scores, &[[0.0; PARTITION_FEATURES]; SIZES], &BTreeSet::new()).of_end, [0, 0, 0, 0, 1, 1, 1, 1]);
}
