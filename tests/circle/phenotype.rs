//! The phenotype of a Circle of Willis: hand-made circles, the published variants by what their file names say, and real tracings by
//! the table that came with them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use willis::error::{Fault, Place};
use willis::internals::circle_of_willis::Artery::{A1, A2, AComm, Aca, Ba, Ica, M1, M2, Mca, P1, P2, PComm, Pca, ThirdA2, Va};
use willis::internals::circle_of_willis::BodySide::{Left as L, Right as R};
use willis::internals::circle_of_willis::{
    Artery, Circle, Completeness, LabelScheme, Landmark, RING, Variant, artery_of_label, hypoplastic, identify_landmarks,
    segment_diameters, split_where_labels_change,
};
use willis::internals::formats::{Content, ReadOptions, read, read_graphml, read_landmarks};
use willis::internals::network::WELD_TOLERANCE;
use willis::internals::network::units::{LengthUnit, Scale, metres};
use willis::internals::network::{Network, Node, Origin, PathPoint, RadiusRule, Vessel, contract};

/// The variant with all seven segments, both carotids and the basilar artery, and nothing unusual.
const COMPLETE: Variant =
    Variant { present: [true; 7], ica: [true; 2], ba: true, fetal: [false; 2], third_a2: false, fenestration: [false; 5] };

/// Nodes of a circle in mm: x to the right, y to the front, z up. `i` where carotids come in, `c` the origin of PComm, `t` the end of the
/// carotid, `m` `a` `p` outlets of M1, A2 and P2, `j` where AComm and `k` where PComm meet A1 and P1.
const NODES: [(&str, [f64; 3]); 18] = [
    ("li", [-20.0, 0.0, -60.0]),
    ("ri", [20.0, 0.0, -60.0]),
    ("lc", [-9.0, 5.0, -4.0]),
    ("rc", [9.0, 5.0, -4.0]),
    ("lt", [-10.0, 6.0, 0.0]),
    ("rt", [10.0, 6.0, 0.0]),
    ("lm", [-60.0, 6.0, 10.0]),
    ("rm", [60.0, 6.0, 10.0]),
    ("lj", [-2.0, 14.0, 3.0]),
    ("rj", [2.0, 14.0, 3.0]),
    ("la", [-4.0, 40.0, 40.0]),
    ("ra", [4.0, 40.0, 40.0]),
    ("lk", [-6.0, -7.0, 0.0]),
    ("rk", [6.0, -7.0, 0.0]),
    ("lp", [-20.0, -60.0, 5.0]),
    ("rp", [20.0, -60.0, 5.0]),
    ("b", [0.0, -9.0, -1.0]),
    ("v", [0.0, -15.0, -40.0]),
];

/// Vessels of the complete circle: ends, label, radius in mm.
const CIRCLE: [(&str, &str, &str, f64); 18] = [
    ("li", "lc", "L-ICA", 2.0),
    ("ri", "rc", "R-ICA", 2.0),
    ("lc", "lt", "L-ICA", 2.0),
    ("rc", "rt", "R-ICA", 2.0),
    ("lt", "lm", "L-M1", 1.4),
    ("rt", "rm", "R-M1", 1.4),
    ("lt", "lj", "L-A1", 1.2),
    ("rt", "rj", "R-A1", 1.2),
    ("lj", "la", "L-A2", 1.2),
    ("rj", "ra", "R-A2", 1.2),
    ("lj", "rj", "AComm", 0.7),
    ("b", "lk", "L-P1", 1.1),
    ("b", "rk", "R-P1", 1.1),
    ("lk", "lp", "L-P2", 1.1),
    ("rk", "rp", "R-P2", 1.1),
    ("lc", "lk", "L-PComm", 0.7),
    ("rc", "rk", "R-PComm", 0.7),
    ("v", "b", "BA", 1.6),
];

type Edge = (&'static str, &'static str, &'static str, f64);

/// A circle of these vessels, each with points 1 mm apart or so, of one radius.
fn network(edges: &[Edge]) -> Network {
    let mut network = Network::new();
    let position = |id: &str| NODES.iter().find(|(name, _)| *name == id).expect("a node").1.map(metres);
    for (id, _) in NODES {
        network.add_node(Node { id: id.to_owned(), position: Some(position(id)), ..Node::default() });
    }
    for (a, b, label, radius) in edges {
        let (from, to) = (position(a), position(b));
        let point = |i: usize| {
            let share = i as f64 / 10.0;
            let position = [0, 1, 2].map(|x| from[x] + share * (to[x] - from[x]));
            PathPoint { position, radius: metres(*radius), id: None }
        };
        let row = |id: &str| NODES.iter().position(|(name, _)| *name == id).expect("a node");
        let vessel = Vessel::along((0..=10).map(point).collect(), RadiusRule::Mean);
        network.add_vessel([row(a), row(b)], Vessel { label: (*label).to_owned(), ..vessel });
    }
    network
}

fn without(labels: &[&str]) -> Vec<Edge> {
    CIRCLE.into_iter().filter(|edge| !labels.contains(&edge.2)).collect()
}

/// The circle with other radii of some vessels.
fn with_radii(edges: &[Edge], radii: &[(&str, f64)]) -> Vec<Edge> {
    let radius = |label: &str, r: f64| radii.iter().find(|(name, _)| *name == label).map_or(r, |(_, r)| *r);
    edges.iter().map(|(a, b, label, r)| (*a, *b, *label, radius(label, *r))).collect()
}

const ENDS: [(&str, &str); 9] = [
    ("L-ICA", "li"),
    ("R-ICA", "ri"),
    ("L-M1", "lm"),
    ("R-M1", "rm"),
    ("L-A2", "la"),
    ("R-A2", "ra"),
    ("L-P2", "lp"),
    ("R-P2", "rp"),
    ("BA", "v"),
];

fn landmarks(ends: &[(&str, &str)]) -> String {
    let mut text = "label,x_mm,y_mm,z_mm\n".to_owned();
    for (label, id) in ends {
        let [x, y, z] = NODES.iter().find(|(name, _)| name == id).expect("a node").1;
        writeln!(text, "{label},{x},{y},{z}").expect("written");
    }
    text
}

fn marked(landmarks: &str) -> Result<Vec<Landmark>, Fault> {
    read_landmarks(landmarks.as_bytes(), &Scale::default()).and_then(|list| identify_landmarks(list.landmarks))
}

fn by_labels(network: &Network) -> Variant {
    Circle::labelled(network, LabelScheme::Names).expect("a circle").0.variant(network, |_| true)
}

fn by_landmarks(network: &Network, ends: &[(&str, &str)]) -> Variant {
    let landmarks = marked(&landmarks(ends)).expect("landmarks");
    Circle::at(network, &landmarks).expect("a circle").0.variant(network, |_| true)
}

fn missing(variant: &Variant) -> Vec<String> {
    variant.missing().iter().map(ToString::to_string).collect()
}

#[test]
fn the_complete_circle_lacks_nothing() {
    let whole = network(&CIRCLE);
    assert_eq!(by_labels(&whole), COMPLETE);
    assert_eq!(by_landmarks(&whole, &ENDS), COMPLETE);
}

/// Every set of segments of the ring.
fn patterns() -> impl Iterator<Item = Vec<&'static str>> {
    let label = |segment: Artery| CIRCLE.iter().map(|edge| edge.2).find(|label| *label == segment.to_string()).expect("drawn");
    let names = RING.map(label);
    (0_u32..128).map(move |pattern| (0..7).filter(|bit| pattern >> bit & 1 == 1).map(|bit| names[bit]).collect())
}

#[test]
fn absent_segments_are_missing_and_no_others() {
    for absent in patterns() {
        let part = network(&without(&absent));
        for (how, variant) in [("labels", by_labels(&part)), ("landmarks", by_landmarks(&part, &ENDS))] {
            assert_eq!(missing(&variant), absent, "{how}");
            assert_eq!((variant.ica, variant.ba), ([true; 2], true), "{how}: {absent:?}");
            let full = |p1: &str, pcomm: &str| absent.contains(&p1) && !absent.contains(&pcomm);
            assert_eq!(variant.fetal, [full("L-P1", "L-PComm"), full("R-P1", "R-PComm")], "{how}: {absent:?}");
        }
    }
}

/// Twigs with twigs of their own at every node, and a ring that hangs on one, lie between no landmarks.
#[test]
fn what_hangs_on_a_circle_is_no_part_of_it() {
    for absent in patterns() {
        let bare = network(&without(&absent));
        let mut hung = bare.clone();
        let inner = |id: &&str| ["lc", "rc", "lt", "rt", "lj", "rj", "lk", "rk", "b"].contains(id);
        for node in (0..NODES.len()).filter(|row| inner(&NODES[*row].0)) {
            let [a, b, c] = [0, 1, 2].map(|twig| {
                let position = Some(NODES[node].1.map(|x| metres(x + 0.1 + f64::from(twig))));
                hung.add_node(Node { id: format!("{node}-{twig}"), position, ..Node::default() })
            });
            for ends in [[node, a], [a, b], [b, c], [c, a], [a, a]] {
                hung.add_vessel(ends, Vessel::new(1e-3, 5e-4, Origin::Observed));
            }
        }
        assert_eq!(by_landmarks(&hung, &ENDS), by_landmarks(&bare, &ENDS), "{absent:?}");
    }
}

/// A third A2 leaves AComm between the two sides, so that AComm is in pieces: it is there if pieces on either side of the third A2 join the two
/// sides, and not if the third A2 lies between the piece and the other side.
#[test]
fn a_third_a2_divides_acomm_and_takes_it_away_from_none() {
    let with = |vessels: &[(&str, &str, &str)]| {
        let mut network = network(&without(&["AComm"]));
        let row = |network: &Network, id: &str| network.nodes().position(|node| node.id == id).expect("a node");
        for (id, at) in [("x", [-0.7, 14.0, 3.0]), ("y", [0.7, 14.0, 3.0]), ("u", [0.0, 40.0, 40.0])] {
            network.add_node(Node { id: id.to_owned(), position: Some(at.map(metres)), ..Node::default() });
        }
        for (a, b, label) in vessels {
            let ends = [row(&network, a), row(&network, b)];
            let point = |node: usize| PathPoint { position: network.node(node).position.unwrap(), radius: metres(0.7), id: None };
            let vessel = Vessel::along(ends.map(point).to_vec(), RadiusRule::Mean);
            network.add_vessel(ends, Vessel { label: (*label).to_owned(), ..vessel });
        }
        by_labels(&network)
    };
    let (acomm, third) = ("AComm", "3rd-A2");
    let there = [
        &[("lj", "x", acomm), ("x", "rj", acomm), ("x", "u", third)][..],
        &[("lj", "x", acomm), ("x", "y", third), ("y", "rj", acomm), ("y", "u", third)],
        &[("lj", "x", acomm), ("x", "y", third), ("y", "rj", ""), ("x", "u", third)],
    ];
    for vessels in there {
        let variant = with(vessels);
        assert!(variant.third_a2 && missing(&variant).is_empty(), "{vessels:?}: {}", variant.words());
    }
    let not = [
        &[("lj", "x", acomm), ("x", "u", third)][..],
        &[("lj", "x", acomm), ("x", "rj", third), ("x", "u", third)],
        &[("lj", "rj", third), ("lj", "u", third)],
    ];
    for vessels in not {
        let variant = with(vessels);
        assert!(variant.third_a2, "{vessels:?}");
        assert_eq!(missing(&variant), ["AComm"], "{vessels:?}");
    }
}

/// A thin segment is there, and hypoplastic: by labels and by landmarks, below the diameter that is stated, or below half the diameter of its
/// opposite.
#[test]
fn a_thin_segment_is_hypoplastic_however_arteries_are_known() {
    let network_of = |radii: &[(&str, f64)]| network(&with_radii(&CIRCLE, radii));
    let thin = |network: &Network, least: f64| {
        let labelled = Circle::labelled(network, LabelScheme::Names).expect("labels").0;
        let marked = Circle::at(network, &marked(&landmarks(&ENDS)).expect("landmarks")).expect("a circle").0;
        [labelled, marked].map(|circle| {
            assert!(missing(&circle.variant(network, |_| true)).is_empty());
            let thin = hypoplastic(&segment_diameters(&circle, network, |_| true), metres(least));
            RING.iter().zip(thin).filter(|(_, is)| *is).map(|(artery, _)| artery.to_string()).collect::<Vec<_>>()
        })
    };
    let both =
        |names: &[&str]| [names.to_vec(), names.to_vec()].map(|names| names.into_iter().map(str::to_owned).collect::<Vec<_>>());
    assert_eq!(thin(&network_of(&[]), 1.0), both(&[]));
    assert_eq!(thin(&network_of(&[("L-A1", 0.1)]), 1.0), both(&["L-A1"]));
    assert_eq!(thin(&network_of(&[("R-P1", 0.52)]), 1.0), both(&["R-P1"]), "1.04 mm is below half of 2.2 mm");
    assert_eq!(thin(&network_of(&[("R-PComm", 0.45)]), 1.0), both(&["R-PComm"]));
    assert_eq!(thin(&network_of(&[("R-PComm", 0.45)]), 0.8), both(&[]));
    assert_eq!(thin(&network_of(&[]), 1.5), both(&["AComm", "L-PComm", "R-PComm"]));
}

/// The diameter of a segment is the mean along all of it, by labels and by landmarks, also where a branch leaves it: 5 mm of 1 mm and 5 mm of
/// 3 mm are 2 mm.
#[test]
fn a_segment_is_as_wide_as_its_vessels_on_either_side_of_a_branch() {
    let mut whole = network(&CIRCLE);
    for label in ["L-A1", "R-PComm"] {
        let row = whole.vessels().position(|(_, vessel)| vessel.label == label).expect("a segment");
        let ([from, to], vessel) = (whole.ends(row), whole.vessel(row).clone());
        let (mut parted, _) = whole.subgraph(|other| other != row);
        let middle = Node { id: format!("{label} branch"), position: Some(vessel.path[5].position), ..Node::default() };
        let middle = parted.add_node(middle);
        for (ends, path, radius) in [([from, middle], &vessel.path[..=5], 0.5e-3), ([middle, to], &vessel.path[5..], 1.5e-3)] {
            let path = path.iter().map(|point| PathPoint { radius, ..*point }).collect();
            parted.add_vessel(ends, Vessel { label: label.to_owned(), ..Vessel::along(path, RadiusRule::Mean) });
        }
        let away = vessel.path[5].position.map(|x| x + 0.004);
        let end = parted.add_node(Node { id: format!("{label} end"), position: Some(away), ..Node::default() });
        let branch = [vessel.path[5].position, away].map(|position| PathPoint { position, radius: 2e-4, id: None });
        parted.add_vessel([middle, end], Vessel::along(branch.to_vec(), RadiusRule::Mean));
        whole = parted;
    }
    let labelled = Circle::labelled(&whole, LabelScheme::Names).expect("labels").0;
    let placed = Circle::at(&whole, &marked(&landmarks(&ENDS)).expect("landmarks")).expect("a circle").0;
    for circle in [labelled, placed] {
        assert!(missing(&circle.variant(&whole, |_| true)).is_empty());
        let diameters = segment_diameters(&circle, &whole, |_| true);
        for (artery, diameter) in RING.into_iter().zip(diameters).filter(|(artery, _)| [A1(L), PComm(R)].contains(artery)) {
            let diameter = diameter.expect("a diameter");
            assert!((diameter - 2e-3).abs() < 1e-12, "{artery}: {diameter}");
        }
    }
}

#[test]
fn vessels_that_are_not_kept_are_not_there() {
    let whole = network(&CIRCLE);
    let (labelled, _) = Circle::labelled(&whole, LabelScheme::Names).expect("a circle");
    let (placed, _) = Circle::at(&whole, &marked(&landmarks(&ENDS)).expect("landmarks")).expect("a circle");
    for segment in RING {
        let kept = |row: usize| whole.vessel(row).label != segment.to_string();
        assert_eq!(labelled.variant(&whole, kept).missing(), [segment]);
        assert_eq!(placed.variant(&whole, kept).missing(), [segment]);
    }
}

/// Landmarks that were found before nodes had other rows say the same of every segment after it.
#[test]
fn landmarks_follow_their_nodes_to_other_rows() {
    let whole = network(&CIRCLE);
    let meets = [("L-A1/L-A2", "lj"), ("R-P1/R-P2", "rk"), ("BA/L-P1/R-P1", "b"), ("L-ICA/L-M1/L-A1", "lt")];
    let mut circle =
        Circle::at(&whole, &marked(&landmarks(&[&ENDS[..], &meets].concat())).expect("landmarks")).expect("a circle").0;
    let node_now: Vec<usize> = (0..NODES.len()).rev().collect();
    let mut turned = Network::new();
    for row in &node_now {
        turned.add_node(whole.node(*row).clone());
    }
    for (ends, vessel) in whole.vessels() {
        turned.add_vessel(ends.map(|node| node_now[node]), vessel.clone());
    }
    let ids = |circle: &Circle, network: &Network| {
        let of = |nodes: Vec<usize>| nodes.iter().map(|row| network.node(*row).id.clone()).collect::<BTreeSet<String>>();
        [circle.inlets(), circle.outlets(), circle.ends(network)].map(of)
    };
    let before = ids(&circle, &whole);
    circle.follow(&node_now);
    assert_eq!(ids(&circle, &turned), before);
    for segment in RING {
        assert_eq!(circle.variant(&turned, |row| whole.vessel(row).label != segment.to_string()).missing(), [segment]);
    }
}

#[test]
fn a_segment_must_connect_what_it_should() {
    // A stump of A1 that hangs on the carotid alone, in the place of A1.
    let mut stump = without(&["L-A1", "L-A2", "AComm"]);
    stump.push(("lt", "lj", "L-A1", 1.2));
    stump.push(("rj", "la", "L-A2", 1.2));
    let variant = by_labels(&network(&stump));
    assert!(!variant.has(A1(L)) && variant.has(A1(R)), "{variant:?}");
    // A vessel without a label that bridges the gap of a labelled one is a part of it; one with another name is not.
    for (name, there) in [("", true), ("perforator", false), ("R-M1", false)] {
        let mut bridged = without(&["AComm"]);
        bridged.push(("lj", "rj", name, 0.5));
        assert_eq!(by_labels(&network(&bridged)).has(AComm), there, "{name}");
    }
}

/// Where the carotid ends in nothing, an A1 that fills from AComm and a PComm that fills from P1 are there all the same.
#[test]
fn segments_of_an_occluded_carotid_are_there() {
    // The left carotid stops before its end, and M1 is not seen; A1 and PComm have a free end each.
    let part: Vec<Edge> = CIRCLE.into_iter().filter(|edge| edge.2 != "L-M1" && edge.2 != "L-ICA").collect();
    let variant = by_labels(&network(&part));
    assert_eq!((missing(&variant), variant.ica), (vec![], [false, true]));
    // Beside a carotid that is whole, the same A1 connects nothing.
    let mut apart = without(&["L-A1"]);
    apart.push(("lj", "v", "L-A1", 1.0));
    assert_eq!(missing(&by_labels(&network(&apart))), ["L-A1"]);
}

/// Without its outlet in view, a segment is there when the way through both segments that meet there is, or to the bifurcation.
#[test]
fn outlets_beyond_the_field_of_view_are_done_without() {
    for lost in ["L-A2", "R-A2", "L-P2", "R-P2", "L-M1", "R-M1"] {
        let ends: Vec<(&str, &str)> = ENDS.into_iter().filter(|(label, _)| *label != lost).collect();
        assert_eq!(missing(&by_landmarks(&network(&without(&[lost])), &ends)), [""; 0], "{lost}");
        for absent in ["AComm", "L-PComm", "R-P1"] {
            let part = network(&without(&[lost, absent]));
            let variant = by_landmarks(&part, &ends);
            assert!(missing(&variant).iter().any(|name| name == absent), "{lost}, {absent}: {variant:?}");
        }
    }
    let mut ends: Vec<(&str, &str)> = ENDS.into_iter().filter(|(label, _)| !["L-A2", "L-P2"].contains(label)).collect();
    ends.extend([("L-A1/L-A2/AComm", "lj"), ("L-P1/L-P2/L-PComm", "lk")]);
    for absent in RING.map(|segment| segment.to_string()) {
        let part = network(&without(&["L-A2", "L-P2", &absent]));
        assert_eq!(missing(&by_landmarks(&part, &ends)), [absent]);
    }
}

/// A carotid that is interrupted is absent; the way round through the circle does not stand for it.
#[test]
fn a_detour_is_no_carotid() {
    let part: Vec<Edge> = CIRCLE.into_iter().filter(|edge| (edge.0, edge.1) != ("lc", "lt")).collect();
    let variant = by_landmarks(&network(&part), &ENDS);
    assert_eq!((variant.ica, missing(&variant)), ([false, true], vec![]), "{variant:?}");
}

/// Musio et al. 2026: fetal is PComm wider than P1 by more than a twentieth.
#[test]
fn a_wide_pcomm_makes_a_fetal_artery() {
    for (pcomm, p1, fetal) in [(1.0, 1.0, false), (1.04, 1.0, false), (1.06, 1.0, true), (0.7, 1.1, false), (1.5, 0.6, true)] {
        let changed = network(&with_radii(&CIRCLE, &[("L-PComm", pcomm), ("L-P1", p1)]));
        for variant in [by_labels(&changed), by_landmarks(&changed, &ENDS)] {
            assert_eq!(variant.fetal, [fetal, false], "{pcomm} {p1}");
            assert_eq!(variant.missing(), []);
        }
    }
    let words = by_labels(&network(&with_radii(&CIRCLE, &[("R-PComm", 2.0)]))).words();
    assert_eq!(words, "complete circle, right fetal-type PCA, partial (PComm wider than P1)");
}

/// Where one P1 is absent the other one is measured all the same, on either side: the radius is that of the drawing.
#[test]
fn a_p1_is_measured_where_the_other_is_absent() {
    for (absent, other) in [("L-P1", "R-P1"), ("R-P1", "L-P1")] {
        for (radius, fetal) in [(0.8, true), (2.0, false)] {
            let edges: Vec<Edge> = without(&[absent]);
            let network = network(&with_radii(&edges, &[(other, radius), ("L-PComm", 1.0), ("R-PComm", 1.0)]));
            // P1 begins at the basilar tip, where no vessel leaves on the absent side.
            let found = marked(&landmarks(&[&ENDS[..], &[("BA tip", "b")]].concat())).expect("landmarks");
            let circle = Circle::at(&network, &found).expect("a circle").0;
            let diameters = segment_diameters(&circle, &network, |_| true);
            let of = |name: &str| diameters[RING.iter().position(|segment| segment.to_string() == name).expect("a segment")];
            assert_eq!(of(absent), None);
            assert!(
                of(other).is_some_and(|diameter| (diameter - metres(2.0 * radius)).abs() < 1e-12),
                "{other}: {:?}",
                of(other)
            );
            // Of the absent one PComm is all that feeds P2.
            let expected = if absent == "L-P1" { [true, fetal] } else { [fetal, true] };
            assert_eq!(circle.variant(&network, |_| true).fetal, expected, "{other} {radius}");
        }
    }
}

#[test]
fn two_channels_are_a_fenestration_and_the_ring_is_none() {
    let row = |label: &str| ["L-A1", "AComm", "R-A1", "L-P1", "R-P1"].iter().position(|name| *name == label).expect("a segment");
    for (a, b, label) in
        [("lt", "lj", "L-A1"), ("rt", "rj", "R-A1"), ("lj", "rj", "AComm"), ("b", "lk", "L-P1"), ("b", "rk", "R-P1")]
    {
        let mut edges = CIRCLE.to_vec();
        edges.push((a, b, label, 0.5));
        let doubled = network(&edges);
        for variant in [by_labels(&doubled), by_landmarks(&doubled, &ENDS)] {
            let found: Vec<usize> = (0..5).filter(|row| variant.fenestration[*row]).collect();
            assert_eq!(found, [row(label)], "{label}");
            assert!(variant.missing().is_empty());
        }
    }
}

#[test]
fn undivided_arteries_are_judged_by_what_they_touch() {
    let rename = |edges: &[Edge]| -> Vec<Edge> {
        let name = |label: &'static str| match label {
            "L-A1" | "L-A2" => "L-ACA",
            "R-A1" | "R-A2" => "R-ACA",
            "L-P1" | "L-P2" => "L-PCA",
            "R-P1" | "R-P2" => "R-PCA",
            "L-M1" => "L-MCA",
            "R-M1" => "R-MCA",
            "AComm" => "Acom",
            "L-PComm" => "L-Pcom",
            "R-PComm" => "R-Pcom",
            other => other,
        };
        edges.iter().map(|(a, b, label, r)| (*a, *b, name(label), *r)).collect()
    };
    assert_eq!(by_labels(&network(&rename(&CIRCLE))), COMPLETE);
    for absent in RING.map(|segment| segment.to_string()) {
        let variant = by_labels(&network(&rename(&without(&[&absent]))));
        assert_eq!(missing(&variant), [absent.as_str()]);
        assert_eq!(variant.fetal, [absent == "L-P1", absent == "R-P1"]);
    }
    let wide = rename(&with_radii(&CIRCLE, &[("L-PComm", 1.3)]));
    assert_eq!(by_labels(&network(&wide)).fetal, [true, false]);
    let mut third = rename(&CIRCLE);
    third.push(("lj", "v", "3rd-A2", 0.5));
    assert!(by_labels(&network(&third)).third_a2);
}

#[test]
fn spellings_mean_arteries() {
    let names: [(&str, Option<Artery>); 56] = [
        ("L-A1", Some(A1(L))),
        ("A1 L", Some(A1(L))),
        ("left A1", Some(A1(L))),
        ("A1_left", Some(A1(L))),
        ("lA1", Some(A1(L))),
        ("LA1", Some(A1(L))),
        ("A1R", Some(A1(R))),
        ("right_a1", Some(A1(R))),
        ("ACA-A1 R", Some(A1(R))),
        ("L ACA A2", Some(A2(L))),
        ("left ACA", Some(Aca(L))),
        ("left anterior cerebral artery", Some(Aca(L))),
        ("R-A2", Some(A2(R))),
        ("R-A3", Some(A2(R))),
        ("ACoA", Some(AComm)),
        ("Acom", Some(AComm)),
        ("AComm", Some(AComm)),
        ("A.Comm", Some(AComm)),
        ("anterior communicating artery", Some(AComm)),
        ("L-ICA", Some(Ica(L))),
        ("L-ICA I", Some(Ica(L))),
        ("R-ICA II", Some(Ica(R))),
        ("ICA-T L", Some(Ica(L))),
        ("right ICA C7", Some(Ica(R))),
        ("Left internal carotid artery", Some(Ica(L))),
        ("L-M1", Some(M1(L))),
        ("MCA M1 right", Some(M1(R))),
        ("R-M2", Some(M1(R))),
        ("R-MCA", Some(Mca(R))),
        ("RMCA", Some(Mca(R))),
        ("right middle cerebral artery", Some(Mca(R))),
        ("L-P1", Some(P1(L))),
        ("P1 segment of the right PCA", Some(P1(R))),
        ("PCA-P2_L", Some(P2(L))),
        ("L-P3", Some(P2(L))),
        ("R-PCA", Some(Pca(R))),
        ("posterior cerebral artery, left", Some(Pca(L))),
        ("L-PComm", Some(PComm(L))),
        ("L-Pcom", Some(PComm(L))),
        ("PCoA R", Some(PComm(R))),
        ("rPCoA", Some(PComm(R))),
        ("left posterior communicating artery", Some(PComm(L))),
        ("BA", Some(Ba)),
        ("Basilar artery", Some(Ba)),
        ("L-VA", Some(Va(L))),
        ("right vertebral artery", Some(Va(R))),
        ("3rd-A2", Some(ThirdA2)),
        ("A1", None),
        ("PCA", None),
        ("L-CCA", None),
        ("L-ECA", None),
        ("R-SCA", None),
        ("Aortic arch I", None),
        ("Thoracic aorta", None),
        ("left right A1", None),
        ("L-BA", None),
    ];
    for (label, expected) in names {
        assert_eq!(artery_of_label(label, LabelScheme::Names), expected, "{label}");
        assert_eq!(artery_of_label(&label.to_uppercase(), LabelScheme::Names), expected, "{label}");
    }
    // Each is read by the name that is written, and that of the other side differs in the side alone.
    for artery in Artery::all() {
        let name = artery.to_string();
        assert_eq!(artery_of_label(&name, LabelScheme::Names), Some(if let M2(side) = artery { M1(side) } else { artery }));
        let other =
            [("L-", "R-"), ("R-", "L-")].iter().find_map(|(own, other)| Some(other.to_string() + name.strip_prefix(own)?));
        assert_eq!(artery.opposite().to_string(), other.unwrap_or(name));
    }
}

/// iCafe's `VesselType` as the table of the INSIST tracings states it, TopCoW's classes as CoW_Centerline_Extraction does.
#[test]
fn codes_mean_arteries() {
    let icafe = [
        Ica(L),
        Ica(R),
        M1(L),
        M1(R),
        M1(L),
        M1(R),
        A1(L),
        A1(R),
        A2(L),
        A2(R),
        AComm,
        M1(L),
        M1(R),
        Va(L),
        Va(R),
        Ba,
        P1(L),
        P1(R),
        P2(L),
        P2(R),
        PComm(L),
        PComm(R),
    ];
    for (row, expected) in icafe.into_iter().enumerate() {
        assert_eq!(artery_of_label(&(row + 1).to_string(), LabelScheme::ICafe), Some(expected));
    }
    let topcow = [
        (1, Ba),
        (2, Pca(R)),
        (3, Pca(L)),
        (4, Ica(R)),
        (5, Mca(R)),
        (6, Ica(L)),
        (7, Mca(L)),
        (8, PComm(R)),
        (9, PComm(L)),
        (10, AComm),
        (11, Aca(R)),
        (12, Aca(L)),
        (15, ThirdA2),
    ];
    for (code, expected) in topcow {
        assert_eq!(artery_of_label(&code.to_string(), LabelScheme::TopCow), Some(expected));
    }
    for (code, scheme) in [
        ("0", LabelScheme::ICafe),
        ("23", LabelScheme::ICafe),
        ("0", LabelScheme::TopCow),
        ("13", LabelScheme::TopCow),
        ("16", LabelScheme::TopCow),
    ] {
        assert_eq!(artery_of_label(code, scheme), None, "{code}");
    }
    assert_eq!(LabelScheme::of(["1", "2", "16", "0", ""]), Ok(LabelScheme::ICafe));
    assert_eq!(LabelScheme::of(["L-ICA", "7", ""]), Ok(LabelScheme::Names));
    let ambiguous = LabelScheme::of(["1", "10", "2"]).unwrap_err();
    assert!(ambiguous.found.contains("1 2 10") && ambiguous.accepted.contains("`labels=icafe|topcow`"), "{ambiguous:?}");
    assert!(LabelScheme::of(["1", "99"]).is_err());
}

fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/circle-of-willis");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// The segments that a file name says are missing, in the order of the ring.
fn named_missing(file: &Path) -> Vec<String> {
    let stem = file.file_stem().unwrap().to_string_lossy().into_owned();
    let names = RING.map(|segment| segment.to_string());
    if stem == "complete" {
        return Vec::new();
    }
    let mut rest = stem.strip_prefix("without-").unwrap().to_owned();
    // PComm first: no name is then within another one.
    let mut found = BTreeSet::new();
    for (row, name) in names.iter().enumerate() {
        if rest.contains(name.as_str()) {
            rest = rest.replace(name.as_str(), "");
            found.insert(row);
        }
    }
    assert!(rest.chars().all(|c| c == '-'), "{stem}");
    found.into_iter().map(|row| names[row].clone()).collect()
}

/// The complete variant and the ten that Padmos et al. 2022 publish, by their missing segments. A missing P1 with a PComm means a fetal type.
fn published() -> Vec<Variant> {
    let each: [&[Artery]; 11] = [
        &[],
        &[AComm],
        &[A1(L)],
        &[A1(R)],
        &[P1(L)],
        &[P1(R)],
        &[PComm(L)],
        &[PComm(R)],
        &[PComm(L), PComm(R)],
        &[P1(R), PComm(L)],
        &[P1(L), PComm(R)],
    ];
    let lacking = |missing: &&[Artery]| {
        let has = |artery: Artery| !missing.contains(&artery);
        Variant { present: RING.map(has), fetal: [L, R].map(|side| has(PComm(side)) && !has(P1(side))), ..COMPLETE }
    };
    each.iter().map(lacking).collect()
}

#[test]
fn the_published_variants_are_named_right() {
    // Alastruey's numbers of the nodes, which are the ids in the files.
    let ends = [
        ("L-ICA", "6"),
        ("R-ICA", "7"),
        ("R-VA", "8"),
        ("L-VA", "10"),
        ("L-M1", "23"),
        ("R-M1", "24"),
        ("L-A2", "27"),
        ("R-A2", "28"),
        ("L-P2", "29"),
        ("R-P2", "30"),
    ];
    let mut seen = BTreeSet::new();
    for file in shipped() {
        let (network, _) = read_graphml(&std::fs::read(&file).unwrap()[..], &ReadOptions::default()).unwrap();
        let mut text = "label,x_mm,y_mm,z_mm\n".to_owned();
        for (label, id) in ends {
            let node = network.nodes().find(|node| node.id == id).unwrap();
            let [x, y, z] = node.position.unwrap().map(willis::internals::network::units::millimetres);
            writeln!(text, "{label},{x},{y},{z}").expect("written");
        }
        let landmarks = marked(&text).unwrap();
        let (placed, _) = Circle::at(&network, &landmarks).unwrap();
        for variant in [by_labels(&network), placed.variant(&network, |_| true)] {
            assert_eq!(missing(&variant), named_missing(&file), "{}", file.display());
            assert!(variant.is_published() && published().contains(&variant), "{variant:?}");
            seen.insert(variant);
        }
    }
    assert_eq!(seen, published().into_iter().collect());
    assert_eq!(seen.len(), 11);
}

#[test]
fn names_and_words_say_what_is_missing() {
    let of = |absent: &[&str]| by_labels(&network(&without(absent)));
    let told = |absent: &[&str]| (of(absent).name(), of(absent).completeness(), of(absent).words());
    assert_eq!(told(&[]), ("complete".into(), Completeness::Complete, "complete circle".into()));
    let fetal = (
        "without L-P1, R-PComm".into(),
        Completeness::AnteriorComplete,
        "complete anterior part, left fetal-type PCA, R-PComm absent".into(),
    );
    assert_eq!(told(&["R-PComm", "L-P1"]), fetal);
    assert_eq!(told(&["AComm"]).1, Completeness::PosteriorComplete);
    assert_eq!(
        told(&["AComm", "L-PComm"]),
        ("without AComm, L-PComm".into(), Completeness::Incomplete, "AComm absent, L-PComm absent".into())
    );
    assert!(!of(&["AComm", "L-PComm"]).is_published());
}

/// Two branches of M2 with a landmark each: both are outlets, and the artery is there while either hangs on the carotid.
#[test]
fn each_branch_of_m2_may_have_its_landmark() {
    let mut branched = network(&CIRCLE);
    let end = branched.ends(4)[1];
    let from = branched.node(end).position.expect("a position");
    let tips: Vec<usize> = [("up", 8.0), ("down", -8.0)]
        .into_iter()
        .map(|(id, z)| {
            let at = [from[0] + metres(-10.0), from[1], from[2] + metres(z)];
            let tip = branched.add_node(Node { id: id.to_owned(), position: Some(at), ..Node::default() });
            let path = [from, at].map(|position| PathPoint { position, radius: metres(1.0), id: None });
            branched.add_vessel([end, tip], Vessel::along(path.to_vec(), RadiusRule::Mean));
            tip
        })
        .collect();
    let mut text = landmarks(&[&ENDS[..2], &ENDS[3..]].concat());
    for (label, tip) in [("L-M2", tips[0]), ("left M2", tips[1])] {
        let [x, y, z] = branched.node(tip).position.expect("a position").map(|x| x * 1e3);
        writeln!(text, "{label},{x},{y},{z}").expect("written");
    }
    let (circle, _) = Circle::at(&branched, &marked(&text).expect("landmarks")).expect("a circle");
    assert!(tips.iter().all(|tip| circle.outlets().contains(tip)), "{:?} {tips:?}", circle.outlets());
    let last = branched.vessel_count() - 1;
    for lost in [&[last - 1][..], &[last], &[]] {
        assert_eq!(circle.variant(&branched, |row| !lost.contains(&row)), COMPLETE, "without {lost:?}");
    }
    assert!(!circle.variant(&branched, |row| row < last - 1).ica[0]);
    let twice = format!("{text}L-M2,{}\n", text.lines().last().and_then(|line| line.split_once(',')).expect("a place").1);
    assert!(marked(&twice).is_err_and(|fault| fault.accepted.contains("once")));
}

#[test]
fn landmarks_are_refused_with_their_line() {
    let refused = |text: &str, words: &[&str]| {
        let whole = network(&CIRCLE);
        let fault = match marked(text) {
            Err(fault) => fault,
            Ok(landmarks) => Circle::at(&whole, &landmarks).expect_err(text),
        };
        let said = fault.in_file(Path::new("f")).to_string();
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    refused(
        "label,x_mm,y_mm,z_mm\nL-ICA,-20,0,-60\nL-ICA I,-20,0,-59\n",
        &["f:3", "\"L-ICA I\", as on line 2", "every label once"],
    );
    refused("label,x_mm,y_mm,z_mm\nL-ICA,-20,0,-90\n", &["f:2", "\"L-ICA\" lies 30.0 mm", "within 20 mm"]);
    refused("label,x_mm,y_mm,z_mm\nL-M1,-60,6,10\n", &["no inlet", "L-ICA, R-ICA, BA"]);
    refused("label,x_mm,y_mm,z_mm\nfoo,1,2,3\n", &["f:2", "\"foo\"", "expected an inlet"]);
    refused("label,x_mm,y_mm,z_mm\nR-MM1,1,2,3\n", &["f:2", "\"R-MM1\"", "did you mean \"R-M1\"? expected an inlet"]);
    refused("label,x_mm,y_mm,z_mm\nBA/L-P1/R-PP1,1,2,3\n", &["did you mean \"R-P1\"? expected an inlet"]);
    refused("label,x_mm,y_mm,z_mm\nL-A1,1,2,3\n", &["f:2", "\"L-A1\"", "expected an inlet"]);
    refused("label,x_mm,y_mm,z_mm\nL-ICA,1,2\n", &["f:2", "z_mm \"\"", "a finite number"]);
    refused("label,x_mm,y_mm,z_mm\nL-ICA,1,2,nan\n", &["f:2", "z_mm \"nan\"", "a finite number"]);
    refused("label,x_mm,y_mm\nL-ICA,1,2\n", &["f:1", "columns label,x_mm,y_mm", "a column z_mm or z"]);
    refused("label,x_mm,y_mm,z_mm\n", &["no landmark"]);
    let nothing = network(&[("lt", "lm", "L-M1", 1.0)]);
    let fault = Circle::labelled(&nothing, LabelScheme::Names).expect_err("no inlet");
    assert!(fault.found.contains("internal carotid, basilar") && fault.accepted.contains("`landmarks=FILE`"), "{fault:?}");
    assert!(Circle::labelled(&network(&[("lt", "lm", "14", 1.0)]), LabelScheme::TopCow).is_err());
}

/// As other tables: any of three delimiters, quotes, a mark at the beginning, further columns, empty rows, comments; in the unit of the
/// file where the columns name none.
#[test]
fn a_table_of_landmarks_is_read_as_other_tables_are() {
    let plain = marked("label,x_mm,y_mm,z_mm\nL-ICA,-20,0,-60\nL-M1,-60,6,10\n").unwrap();
    let other = "\u{feff}# seen by a reader\r\nnote;Label;Z_mm;y_mm;x_mm\r\na;\"L-ICA\";-60;0;-20\r\n# not sure\r\n;;;;\r\n;L-M1;10;6;-60\r\n";
    for text in [other.to_owned(), other.replace(';', "\t"), other.replace(';', ",")] {
        let found = marked(&text).unwrap();
        let same = |a: &Landmark, b: &Landmark| (&a.label, &a.arteries, a.position) == (&b.label, &b.arteries, b.position);
        assert!(found.len() == 2 && found.iter().zip(&plain).all(|(a, b)| same(a, b)), "{text}: {found:?}");
        assert_eq!([&found[0].place, &found[1].place], [&Place::Line(3), &Place::Line(6)]);
    }
    let cm = Scale { unit: LengthUnit::Centimetre, spacing: None };
    let first = |text: &str| read_landmarks(text.as_bytes(), &cm).unwrap().landmarks[0].position;
    assert_eq!(first("label,x,y,z\nL-ICA,-2,0,-6\n"), [-20.0, 0.0, -60.0].map(metres));
    assert_eq!(first("label,x_mm,y_mm,z_mm\nL-ICA,-2,0,-6\n"), [-2.0, 0.0, -6.0].map(metres));
}

#[test]
fn exchanged_sides_are_told() {
    let warned = |notes: &[String]| notes.iter().any(|note| note.contains("left and right look exchanged"));
    let swap = |label: &str| match label.split_once('-') {
        Some(("L", stem)) => format!("R-{stem}"),
        Some(("R", stem)) => format!("L-{stem}"),
        _ => label.to_owned(),
    };
    let right = network(&CIRCLE);
    let mut wrong = right.clone();
    for row in 0..wrong.vessel_count() {
        wrong.vessel_mut(row).label = swap(&right.vessel(row).label);
    }
    assert!(!warned(&Circle::labelled(&right, LabelScheme::Names).unwrap().1));
    assert!(warned(&Circle::labelled(&wrong, LabelScheme::Names).unwrap().1));
    let names: Vec<(String, &str)> = ENDS.into_iter().map(|(label, id)| (swap(label), id)).collect();
    let swapped: Vec<(&str, &str)> = names.iter().map(|(label, id)| (label.as_str(), *id)).collect();
    for (ends, exchanged) in [(&ENDS[..], false), (&swapped[..], true)] {
        let landmarks = marked(&landmarks(ends)).unwrap();
        assert_eq!(warned(&Circle::at(&right, &landmarks).unwrap().1), exchanged);
    }
}

/// Arteries that lie on the wrong side are told against those that show it: of a circle without carotids these are M1.
#[test]
fn a_pair_on_the_wrong_side_is_told_against_what_is_there() {
    for (lacks, against) in [(&[][..], "the carotids"), (&["L-ICA", "R-ICA"], "both M1")] {
        let mut wrong = network(&without(lacks));
        for row in 0..wrong.vessel_count() {
            let vessel = wrong.vessel_mut(row);
            vessel.label = match vessel.label.as_str() {
                "L-P1" => "R-P1".to_owned(),
                "R-P1" => "L-P1".to_owned(),
                other => other.to_owned(),
            };
        }
        let notes = Circle::labelled(&wrong, LabelScheme::Names).expect("a circle").1;
        let told = format!("L-P1, R-P1 lie on the other side than {against}: left and right look exchanged there");
        assert_eq!(notes, [told]);
    }
}

/// Of two outlets with the same nearest end the further one was not seen.
#[test]
fn an_outlet_that_was_lost_does_not_take_its_neighbours_end() {
    let part = network(&without(&["L-A2"]));
    let mut text = landmarks(&ENDS);
    // Where L-A2 would have been, had it not been cut: nearest to the end of R-A2, 8 mm away.
    assert!(text.contains("L-A2,-4,40,40"));
    text = text.replace("R-A2,4,40,40", "R-A2,4,40,41");
    let (circle, notes) = Circle::at(&part, &marked(&text).unwrap()).unwrap();
    assert!(notes.iter().any(|note| note.starts_with("L-A2 is taken as not seen")), "{notes:?}");
    assert_eq!(circle.variant(&part, |_| true), COMPLETE);
}

/// Of two outlets with the same nearest end, both of which are there, the further one has the next end.
#[test]
fn an_outlet_that_is_cut_short_has_the_end_that_is_left() {
    let whole = network(&CIRCLE);
    // R-A2 would have ended 3 mm from where L-A2 does; what is left of it ends 5 mm away.
    let text = landmarks(&ENDS);
    assert!(text.contains("R-A2,4,40,40") && text.contains("L-A2,-4,40,40"));
    let text = text.replace("R-A2,4,40,40", "R-A2,-1,40,40");
    let (circle, notes) = Circle::at(&whole, &marked(&text).unwrap()).unwrap();
    assert!(notes.iter().any(|note| note.starts_with("R-A2 at node ") && note.ends_with("5.000 mm away")), "{notes:?}");
    assert_eq!(circle.variant(&whole, |_| true), COMPLETE);
}

/// Candidates and observed vessels count alike: what is kept is said by the caller.
#[test]
fn origin_makes_no_difference_to_a_mask() {
    let mut whole = network(&CIRCLE);
    for row in 0..whole.vessel_count() {
        whole.vessel_mut(row).origin = if row % 2 == 0 { Origin::Candidate } else { Origin::Observed };
    }
    assert_eq!(by_labels(&whole), COMPLETE);
}

/// The rows of every `VesselType` in Feature_Vessel.csv.
fn types(folder: &Path) -> BTreeSet<u32> {
    let text = std::fs::read_to_string(folder.join("Feature_Vessel.csv")).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at = header.iter().position(|name| *name == "VesselType").unwrap();
    text.lines().skip(1).filter_map(|line| line.split(',').nth(at)?.trim().parse::<f64>().ok()).map(|code| code as u32).collect()
}

/// INSIST (Padmos et al. 2021, 2022): tracings of patients, each vessel with its type. What is traced as a segment is there, and what is not
/// is not.
#[test]
fn real_tracings_have_the_segments_of_their_tables() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/insist-cow");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: {} is not there", folder.display());
        return;
    };
    let mut patients: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()).collect();
    patients.sort();
    assert!(patients.len() > 20);
    let mut wrong = Vec::new();
    for patient in &patients {
        let options = ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() };
        let document = read(&patient.join("Feature_Vessel.csv"), &options).unwrap();
        let Content::Centerlines(mut lines) = document.content else { panic!("no centerlines") };
        lines.weld(WELD_TOLERANCE);
        let network = contract(&lines, RadiusRule::Mean, Some(0.001)).unwrap().network;
        let network = split_where_labels_change(&network, &lines, RadiusRule::Mean);
        let (circle, _) = Circle::labelled(&network, LabelScheme::Names).unwrap();
        let variant = circle.variant(&network, |_| true);
        let types = types(patient);
        for (segment, code) in RING.into_iter().zip([7, 8, 11, 17, 18, 21, 22]) {
            if variant.has(segment) != types.contains(&code) {
                let name = patient.file_name().unwrap().to_string_lossy();
                wrong.push(format!("{name}: {segment} traced {} found {}", types.contains(&code), variant.has(segment)));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {} patients:\n{}", wrong.len(), patients.len(), wrong.join("\n"));
}
