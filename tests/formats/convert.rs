//! Conversion from every format into every other: what comes back is what went in, and what cannot is named.

use std::fs;

use crate::command::{folder, stderr, willis};
use crate::peers::{FILES, converted, network_of};
use crate::refused::{contents, refused};
use willis::internals::formats::convert::{Target, losses};
use willis::internals::formats::{ReadOptions, read};
use willis::internals::network::units::{metres, millimetres};
use willis::internals::network::{Condition, Network, Node, Origin, PathPoint, RadiusRule, Vessel, Wall};
use willis::internals::support::geometry::distance;

/// Labels that formats must carry without taking them for something of their own.
const LABELS: [&str; 9] = ["L-A1", "16", "3", "<b>&\"x\"</b>", "é ü µ", "a, b; c", "", "100%20", "Name = x"];

/// Eight nodes in the plane of a circle, joined by a ring, chords, a parallel vessel and a loop from a node to itself; every node
/// has three ends or one, every vessel points of its own. Figures with all their digits.
fn network() -> Network {
    let mut state = 7_u64;
    let mut figure = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut network = Network::new();
    for row in 0..9 {
        let angle = f64::from(row) * 0.7;
        let position = [20.0 * angle.cos() + figure(), 20.0 * angle.sin() - figure(), 5.0 * figure()].map(metres);
        network.add_node(Node {
            id: row.to_string(),
            position: Some(position),
            radius: Some(metres(0.5 + figure())),
            ..Node::default()
        });
    }
    let ends = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 5], [2, 6], [3, 7], [4, 5], [4, 5], [6, 7], [6, 7], [0, 8], [8, 8]];
    for (row, [a, b]) in ends.into_iter().enumerate() {
        let [p, q] = [a, b].map(|end| network.node(end).clone());
        let point = |node: &Node| PathPoint { position: node.position.unwrap(), radius: node.radius.unwrap(), id: None };
        let mut path = vec![point(&p)];
        for step in 1..5 {
            let share = f64::from(step) / 5.0;
            let mut at = [0, 1, 2].map(|axis| p.position.unwrap()[axis] * (1.0 - share) + q.position.unwrap()[axis] * share);
            at = at.map(|x| x + metres(figure() - 0.5));
            path.push(PathPoint { position: at, radius: metres(0.3 + figure()), id: None });
        }
        path.push(point(&q));
        let vessel = Vessel { label: LABELS[row % LABELS.len()].into(), ..Vessel::along(path, RadiusRule::Mean) };
        network.add_vessel([a, b], vessel);
    }
    network
}

/// Writes a network in a format and reads it again.
fn through(network: &Network, (word, name): (&str, &str)) -> Network {
    let here = folder();
    let target = Target::new(&here.path().join(name), Some(word)).unwrap();
    let files = converted(network, &target);
    let mut options = ReadOptions::default();
    for (path, bytes) in &files {
        fs::write(path, bytes).unwrap();
        if path.to_string_lossy().ends_with(".loops.csv") {
            options.loops = Some(path.clone());
        }
    }
    network_of(read(&files[0].0, &options).unwrap_or_else(|e| panic!("{word}: {e}")))
}

/// Label and points with radii (mm) of every vessel, whichever way round and in whichever order they stand.
fn courses(network: &Network) -> Vec<(Vec<[f64; 4]>, String)> {
    let mut all: Vec<_> = network
        .vessels()
        .map(|(_, vessel)| {
            let mut course: Vec<[f64; 4]> =
                (vessel.path.iter()).map(|p| [p.position[0], p.position[1], p.position[2], p.radius].map(millimetres)).collect();
            if course.first() > course.last() || (course.first() == course.last() && course[1] > course[course.len() - 2]) {
                course.reverse();
            }
            (course, vessel.label.clone())
        })
        .collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

fn assert_same(found: &Network, expected: &Network, how: &str) {
    assert_eq!((found.node_count(), found.vessel_count()), (expected.node_count(), expected.vessel_count()), "{how}");
    for ((a, name), (b, expected)) in courses(found).iter().zip(&courses(expected)) {
        assert_eq!((name, a.len()), (expected, b.len()), "{how}");
        for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{how}: {a} {b}");
        }
    }
    let degrees = |network: &Network| {
        let mut all: Vec<_> = (network.nodes().zip(network.degrees(|_| true)))
            .map(|(node, degree)| (node.position.unwrap().map(|x| (millimetres(x) * 1e6).round()), degree))
            .collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    assert_eq!(degrees(found), degrees(expected), "{how}");
}

#[test]
fn every_format_into_every_other_keeps_points_radii_labels_and_topology() {
    let start = network();
    // Voreen's tables hold no course.
    let formats = || FILES.into_iter().filter(|(word, _)| *word != "voreen");
    for from in formats() {
        let first = through(&start, from);
        assert_same(&first, &start, from.0);
        for to in formats() {
            assert_same(&through(&first, to), &start, &format!("{} -> {}", from.0, to.0));
        }
    }
}

/// Four nodes, each joined to every other, known by their nodes alone.
fn straight() -> Network {
    straight_between(
        &[[0.0, 0.0, 0.0], [7.1, 0.3, 0.0], [-3.0, 4.4, 0.0], [0.0, -5.3, 2.0]],
        &[([0, 1], 2.1, "a"), ([0, 2], 0.4, ""), ([3, 0], 1.3, "c"), ([1, 2], 0.2, "d"), ([2, 3], 0.7, ""), ([1, 3], 1.0, "f")],
    )
}

/// Nodes at places (mm), and straight vessels with radii (mm) and labels between them.
fn straight_between(places: &[[f64; 3]], vessels: &[([usize; 2], f64, &str)]) -> Network {
    let mut network = Network::new();
    for (row, position) in places.iter().enumerate() {
        network.add_node(Node { id: row.to_string(), position: Some(position.map(metres)), ..Node::default() });
    }
    for (ends, radius, label) in vessels {
        let [p, q] = ends.map(|end| network.node(end).position.unwrap());
        let vessel = Vessel::new(distance(p, q), metres(*radius), Origin::Observed);
        network.add_vessel(*ends, Vessel { label: (*label).into(), ..vessel });
    }
    network
}

#[test]
fn vessels_without_points_keep_length_and_radius_in_every_format() {
    let ring = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [4.0, 7.0, 0.0], [-5.0, -5.0, 0.0], [14.0, -6.0, 0.0], [4.0, 16.0, 0.0]];
    let pair = [[0.0, 0.0, 0.0], [10.0, 1.0, 0.0]];
    for start in [
        straight(),
        // All of one radius, so that none needs points of its own; one closes a ring.
        straight_between(
            &ring,
            &[
                ([0, 1], 1.0, "a"),
                ([1, 2], 1.0, "b"),
                ([2, 0], 1.0, "c"),
                ([0, 3], 1.0, "d"),
                ([1, 4], 1.0, "e"),
                ([2, 5], 1.0, "f"),
            ],
        ),
        // Several between the same two nodes.
        straight_between(&pair, &[([0, 1], 2.1, "a"), ([0, 1], 0.4, "b"), ([1, 0], 0.5, "c"), ([1, 0], 0.6, "d")]),
        straight_between(&pair, &[([0, 1], 1.0, "a"), ([0, 1], 1.0, "b"), ([1, 0], 1.0, "c"), ([1, 0], 1.0, "d")]),
    ] {
        assert_kept_in_every_format(&start);
    }
}

fn assert_kept_in_every_format(start: &Network) {
    let figures = |network: &Network| {
        let mut all: Vec<(String, f64, f64)> = network.vessels().map(|(_, v)| (v.label.clone(), v.length, v.radius)).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    let expected = figures(start);
    for to in FILES {
        let back = through(start, to);
        let found = figures(&back);
        assert_eq!((found.len(), back.node_count()), (start.vessel_count(), start.node_count()), "{}", to.0);
        for (a, b) in found.iter().zip(&expected) {
            assert!((a.1 - b.1).abs() < 1e-12 * b.1 && (a.2 - b.2).abs() < 1e-12 * b.2, "{}: {a:?} {b:?}", to.0);
            assert_eq!(a.0, b.0, "{}", to.0);
        }
        assert!(losses(start, &Target::new("x".as_ref(), Some(to.0)).unwrap()).is_empty(), "{}", to.0);
    }
}

#[test]
fn what_a_format_cannot_hold_is_named() {
    let mut network = straight();
    network.add_node(Node { id: "alone".into(), label: "x".into(), position: Some([0.0; 3]), ..Node::default() });
    let (far, plain) = (metres(9.0), network.vessel(1).clone());
    for (id, position) in [("4", [far, 0.0, 0.0]), ("5", [far, far, 0.0])] {
        network.add_node(Node { id: id.into(), position: Some(position), ..Node::default() });
    }
    for ends in [[1, 5], [5, 6]] {
        let [p, q] = ends.map(|end| network.node(end).position.unwrap());
        let length = distance(p, q);
        network.add_vessel(ends, Vessel { length, label: String::new(), ..plain.clone() });
    }
    network.node_mut(1).condition = Some(Condition::Pressure(1e4));
    network.node_mut(2).radius = Some(1e-3);
    let vessel = network.vessel_mut(0);
    (vessel.origin, vessel.prior, vessel.certain, vessel.resistance) = (Origin::Candidate, 0.5, true, Some(1e9));
    (vessel.length, vessel.wall) = (2.0 * vessel.length, Some(Wall::Speed(7.0)));
    let lost = |word: &str| losses(&network, &Target::new("x".as_ref(), Some(word)).unwrap());
    assert_eq!(lost("graphml"), [""; 0]);
    assert_eq!(lost("csv"), [""; 0]);
    let nodes = ["the labels of 1 node", "the boundary conditions of 1 node"];
    let vessels = [
        "the origin of 1 candidate",
        "the priors of 1 vessel",
        "the certainty of 1 vessel",
        "the stated resistances of 1 vessel",
        "the stated walls of 1 vessel",
    ];
    let length = "the lengths of 1 vessel, other than along the lines";
    let (ids, joints) = ("the ids of 3 nodes", "1 node between two vessels, which are read again as one");
    assert_eq!(lost("swc"), [&[length, ids][..], &nodes, &vessels, &[joints]].concat());
    assert_eq!(lost("vtp"), [&[length, ids, "1 node without a vessel"][..], &nodes, &vessels, &[joints]].concat());
    assert_eq!(lost("voreen"), [&[ids, "the radii of 1 node"][..], &nodes, &vessels].concat());
    // Models of solvers have the conditions, the walls, and each something of its own.
    let model = [ids, "1 node without a vessel", "the radii of 1 node"];
    assert_eq!(lost("svzerod"), [&model[..], &["the labels of 4 vessels", nodes[0]]].concat());
    let inlets = "the pressure or flow of 1 inlet, which openBF takes as a course in time from inlet-N.dat";
    assert_eq!(lost("openbf"), [&model[..], &[nodes[0], vessels[3], inlets]].concat());
}

/// By hand: where a branch of radius 0.5 leaves a trunk of radius 2, the line of the branch begins with the radius of the node they share, so
/// its mean over two steps of 1 mm is (1.25 + 0.5)/2.
#[test]
fn a_radius_that_the_end_of_a_line_changes_is_named() {
    let places = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [10.0, 0.0, 0.0], [5.0, 2.0, 0.0]];
    let mut network = straight_between(&places, &[([0, 1], 2.0, "ICA"), ([1, 2], 2.0, ""), ([1, 3], 0.5, "PCom")]);
    let point = |y: f64| PathPoint { position: [5.0, y, 0.0].map(metres), radius: metres(0.5), id: None };
    network.vessel_mut(2).path = [0.0, 1.0, 2.0].map(point).to_vec();
    for to in FILES {
        let back = through(&network, to);
        let [branch] = back.vessels().filter(|(_, v)| v.label == "PCom").map(|(_, v)| v.radius).collect::<Vec<_>>()[..] else {
            panic!("{}", to.0)
        };
        let is_kept = ["graphml", "csv", "voreen"].contains(&to.0);
        let (wanted, lost) =
            (if is_kept { 0.5 } else { 0.875 }, losses(&network, &Target::new("x".as_ref(), Some(to.0)).unwrap()));
        assert!((millimetres(branch) - wanted).abs() < 1e-9, "{}: {branch}", to.0);
        let said = lost.contains(&"the radii of 1 vessel, other than the mean over the points".to_owned());
        assert!(said != is_kept, "{}: {lost:?}", to.0);
    }
}

/// By hand: two vessels cross, and touch where the contact between them was cut. As lines they are joined there once they are read, so that four vessels meet.
#[test]
fn vessels_that_only_touch_are_said_to_be_read_as_joined() {
    let places = [[-5.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, -5.0, 0.0], [0.0, 5.0, 0.0]];
    let mut network = straight_between(&places, &[([0, 1], 1.0, ""), ([2, 3], 1.0, "")]);
    for (row, axis) in [(0, 0), (1, 1)] {
        let point =
            |x: f64| PathPoint { position: [0, 1, 2].map(|k| if k == axis { metres(x) } else { 0.0 }), radius: 1e-3, id: None };
        network.vessel_mut(row).path = [-5.0, 0.0, 5.0].map(point).to_vec();
    }
    // Voreen has no points between nodes; VTP and VTK keep the two apart by the nodes that the command writes beside their lines, SWC by a comment.
    for to in FILES.into_iter().filter(|(word, _)| !["voreen", "vtp", "vtk", "swc"].contains(word)) {
        let lost = losses(&network, &Target::new("x".as_ref(), Some(to.0)).unwrap());
        let is_told = lost.iter().any(|lost| lost == "that vessels only touch in 1 place, where they are read as joined");
        let vessels = through(&network, to).vessel_count();
        assert_eq!((vessels, is_told), if is_told { (4, true) } else { (2, false) }, "{}", to.0);
        assert_eq!(is_told, !["graphml", "csv"].contains(&to.0), "{}", to.0);
    }
}

/// By hand: at the junction of four vessels a contact was opened and kept, so that two nodes lie there. Lines have one point for both, and four vessels.
#[test]
fn a_vessel_in_one_place_is_said_to_be_lost() {
    let places = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-5.0, 0.0, 0.0], [0.0, -5.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]];
    let ends = [[0, 1], [0, 2], [0, 3], [1, 4], [1, 5]].map(|ends| (ends, 1.0, ""));
    let mut network = straight_between(&places, &ends);
    network.vessel_mut(0).length = metres(0.02);
    // No format takes all for straight.
    let bent = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [5.0, 0.0, 0.0]];
    let path = bent.map(|place| PathPoint { position: place.map(metres), radius: metres(1.0), id: None });
    *network.vessel_mut(3) = Vessel::along(path.to_vec(), RadiusRule::Mean);
    for to in FILES {
        let lost = losses(&network, &Target::new("x".as_ref(), Some(to.0)).unwrap());
        let is_told = lost.iter().any(|lost| lost == "1 vessel in one place, whose two nodes are read again as one");
        assert_eq!(through(&network, to).vessel_count(), if is_told { 4 } else { 5 }, "{}", to.0);
        assert!(!lost.iter().any(|lost| lost.starts_with("the lengths")), "{}: {lost:?}", to.0);
        assert_eq!(is_told, !["graphml", "csv", "voreen"].contains(&to.0), "{}", to.0);
    }
}

const TABLE: &str = "node_a,node_b,length_mm,radius_mm\n0,1,4,1\n1,2,3,1\n";

#[test]
fn the_command_says_what_it_wrote_and_refuses_what_it_cannot() {
    let here = folder();
    let made = willis(here.path(), &["phantom", "cerebral", "-o", "a.vtp"]);
    assert!(made.status.success(), "{}", stderr(&made));
    // What states no frame is not turned, and 3D Slicer takes it as LPS all the same.
    fs::write(here.path().join("l.swc"), "1 0 0 0 0 1 -1\n2 0 9 0 0 1 1\n").unwrap();
    let said = |frame: &[&str]| stderr(&willis(here.path(), &[&["convert", "l.swc", "c.json", "--force"], frame].concat()));
    let (untold, told) = (said(&[]), ["RAS", "LPS"].map(|frame| said(&["--frame", frame])));
    let note = "no frame is stated, and markups call positions LPS: --frame says";
    assert!(
        untold.contains(note) && told.iter().all(|said| said.contains("written") && !said.contains(note)),
        "{untold}{told:?}"
    );
    let done = willis(here.path(), &["convert", "a.vtp", "b.swc", "--json"]);
    let said = stderr(&done);
    assert!(done.status.success() && said.contains("the links that close loops are in b.loops.csv"), "{said}");
    let record: serde_json::Value = serde_json::from_slice(&done.stdout).expect("JSON");
    assert_eq!(record["output"], serde_json::json!(["b.swc", "b.loops.csv"]));
    assert_eq!(record["counts"], serde_json::json!({ "nodes": 20, "vessels": 20 }));
    assert_eq!((&record["input"]["path"], &record["input"]["format"]), (&"a.vtp".into(), &"VTP".into()));
    let back = willis(here.path(), &["convert", "b.swc", "c.vtp", "--loops", "b.loops.csv", "-q"]);
    assert!(back.status.success() && stderr(&back).is_empty(), "{}", stderr(&back));
    let before = contents(here.path());
    let again = willis(here.path(), &["convert", "a.vtp", "b.swc"]);
    assert_eq!((again.status.code(), contents(here.path())), (Some(2), before));
    // What is written again is not lost, whatever the format, and neither is the array that was asked for.
    let lost = |arguments: &[&str]| {
        let done = willis(here.path(), &[&["convert"][..], arguments, &["--force"]].concat());
        let said = stderr(&done);
        assert!(done.status.success(), "{arguments:?}: {said}");
        said.lines().find_map(|line| line.trim().strip_prefix("lost  the columns ")).unwrap_or_default().to_owned()
    };
    let graph = "node_a,node_b,length_mm,radius_mm,sum\n0,1,4,1,7\n1,2,3,1,7\n";
    fs::write(here.path().join("edges.csv"), graph).unwrap();
    fs::write(here.path().join("nodes.csv"), "node,x_mm,y_mm,z_mm,role\n0,0,0,0,inlet\n1,4,0,0,\n2,4,3,0,outlet\n").unwrap();
    assert_eq!(lost(&["edges.csv", "d.graphml"]), "sum");
    assert_eq!(lost(&["d.graphml", "e.graphml"]), "");
    for name in ["f.vtp", "f.vtk"] {
        lost(&["d.graphml", name]);
        assert_eq!(lost(&[name, "g.graphml"]), "origin, prior", "{name}");
        assert_eq!(lost(&[name, "g.graphml", "--radius-array", "prior"]), "origin", "{name}");
    }
    let table: &[(&str, &[u8])] = &[("edges.csv", TABLE.as_bytes())];
    refused(table, &["convert", "edges.csv", "a.vtp"], &["a.vtp", "VTP cannot hold the network", "node 0 has no position"]);
    refused(table, &["convert", "edges.csv", "a.xyz"], &["a.xyz", ".graphml", "--to"]);
    refused(table, &["convert", "edges.csv", "nodes.csv"], &["nodes.csv", "the table of nodes"]);
    refused(table, &["convert", "edges.csv", "a.csv", "--to", "voren"], &["voren", "voreen"]);
    refused(table, &["convert", "edges.csv", "b.graphml", "--observed"], &["--observed"]);
}

#[test]
fn a_vessel_with_several_labels_has_that_of_its_longest_part() {
    let here = folder();
    // Three of the five links, 4 mm of 6 mm, lead to points of type 7.
    let text = "1 0 0 0 0 1 -1\n2 5 1 0 0 1 1\n3 7 2 0 0 1 2\n4 7 3 0 0 1 3\n5 7 5 0 0 1 4\n6 5 6 0 0 1 5\n";
    fs::write(here.path().join("a.swc"), text).unwrap();
    let done = willis(here.path(), &["convert", "a.swc", "a.csv"]);
    assert!(stderr(&done).contains("1 vessel with more than one label along them"), "{}", stderr(&done));
    let table = fs::read_to_string(here.path().join("a.csv")).unwrap();
    let row: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(row[table.lines().next().unwrap().split(',').position(|c| c == "label").unwrap()], "7");
}

/// Ends are one place within a millionth of the diagonal of the box, here 20 mm, and no further: a real gap is for the inference.
#[test]
fn only_a_gap_of_rounding_is_closed() {
    for (gap, edges) in [(1e-5, 1), (1e-4, 2)] {
        let here = folder();
        let points = format!("0 0 0 10 0 0 {} 0 0 20 0 0", 10.0 + gap);
        let text = format!(
            "# vtk DataFile Version 3.0\ntwo lines\nASCII\nDATASET POLYDATA\nPOINTS 4 double\n{points}\nLINES 2 6\n2 0 1\n2 2 3\n\
             POINT_DATA 4\nSCALARS Radius double 1\nLOOKUP_TABLE default\n1 1 1 1\n"
        );
        fs::write(here.path().join("lines.vtk"), text).unwrap();
        let output = willis(here.path(), &["convert", "lines.vtk", "lines.graphml"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let graph = fs::read_to_string(here.path().join("lines.graphml")).unwrap();
        assert_eq!(graph.matches("<edge ").count(), edges, "a gap of {gap} mm");
    }
}
