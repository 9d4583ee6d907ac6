//! The phantoms: lengths, radii and resistances against the published table, the layout against its own promises, and
//! every broken extraction against the network it was made of.

use std::collections::HashSet;

use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::pascals;
use willis::internals::network::{Condition, Frame, Network, Role, cycles, fragments};
use willis::internals::phantom::circle::TABLE;
use willis::internals::phantom::curve::{Bow, course};
use willis::internals::phantom::{
    Anatomy, BranchingTree, BreakKind, Breaks, Recipe, Truth, branching_tree, break_up, cerebral, circle_of_willis, without,
};
use willis::internals::support::geometry::distance;

const SPACING: f64 = 5e-4;

fn bases() -> [Network; 3] {
    [Anatomy::CircleOfWillis, Anatomy::Cerebral, Anatomy::Tree]
        .map(|kind| kind.network(&Recipe { spacing: Some(SPACING), ..Recipe::default() }).unwrap())
}

fn arc_length(network: &Network, row: usize) -> f64 {
    network.vessel(row).path.windows(2).map(|p| distance(p[0].position, p[1].position)).sum()
}

fn conductance(node: &willis::internals::network::Node) -> Option<f64> {
    match node.condition {
        Some(Condition::Resistance { resistance, .. }) => Some(1.0 / resistance),
        _ => None,
    }
}

fn count_parts(lines: &Centerlines, joined: &[[u64; 2]]) -> usize {
    let mut parts = petgraph::unionfind::UnionFind::<usize>::new(lines.points.len());
    for [a, b] in &lines.links {
        parts.union(*a as usize, *b as usize);
    }
    for [a, b] in joined {
        parts.union(*a as usize - 1, *b as usize - 1);
    }
    (0..lines.points.len()).map(|p| parts.find(p)).collect::<HashSet<_>>().len()
}

fn degrees(lines: &Centerlines) -> Vec<usize> {
    let mut degree = vec![0; lines.points.len()];
    lines.links.iter().flatten().for_each(|point| degree[*point as usize] += 1);
    degree
}

/// The network's graph as the paper draws it.
#[test]
fn the_circle_has_the_graph_of_the_published_table() {
    let network = circle_of_willis(SPACING);
    assert_eq!((network.vessel_count(), network.node_count(), cycles(&network)), (33, 30, 4));
    assert_eq!(network.degrees(|_| true).iter().filter(|d| **d == 1).count(), 12);
    assert_eq!(fragments(&network, |_, _| true).count, 1);
    let role = |role| network.nodes().filter(|n| n.role == Some(role)).count();
    assert_eq!((role(Role::Inlet), role(Role::Outlet)), (1, 11));
    assert_eq!(network.node(0).condition, Some(Condition::Pressure(pascals(100.0))));
    let labels: HashSet<&str> = network.vessels().map(|(_, v)| v.label.as_str()).collect();
    assert_eq!(labels.len(), 33);
}

/// The table's R1 column, summed apart from this code: 1/1.8e8 + 2 (1/5.43e9 + 1/2.68e9 + 1/5.97e9 + 1/8.48e9 + 1/1.108e10).
#[test]
fn the_terminal_conductances_add_up_to_the_tables() {
    let total: f64 = circle_of_willis(SPACING).nodes().filter_map(conductance).sum();
    assert!((total / 7.421_511_18e-9 - 1.0).abs() < 1e-9, "{total:e}");
}

#[test]
fn every_course_has_the_length_of_its_row() {
    for spacing in [2e-4, SPACING, 1e-3, 3e-3] {
        let network = circle_of_willis(spacing);
        for (row, published) in TABLE.iter().enumerate() {
            let ([a, b], vessel) = (network.ends(row), network.vessel(row));
            assert_eq!((vessel.length, vessel.radius), (published.length, published.radius));
            assert!((arc_length(&network, row) / published.length - 1.0).abs() < 1e-9, "{}", published.label);
            assert_eq!(network.node(a).position, Some(vessel.path[0].position));
            assert_eq!(network.node(b).position, Some(vessel.path[vessel.path.len() - 1].position));
        }
    }
}

/// openBF's copy of the published table, from which ours was typed: guards against slips, not against openBF's own.
#[test]
fn the_table_agrees_with_openbfs_copy() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/openbf-models/circle_of_willis.yaml");
    let Ok(text) = std::fs::read_to_string(path) else {
        println!("skipped: {path} is not there");
        return;
    };
    let vessels: Vec<&str> = text.split("- label:").skip(1).collect();
    assert_eq!(vessels.len(), TABLE.len());
    for (block, row) in vessels.iter().zip(&*TABLE) {
        let value = |key: &str| {
            let line = block.lines().find_map(|line| line.trim().strip_prefix(key)?.strip_prefix(':'));
            line.map(|word| word.trim().parse::<f64>().unwrap())
        };
        let nodes = [value("sn").unwrap() as usize, value("tn").unwrap() as usize];
        assert_eq!((nodes, value("L"), value("R1")), (row.nodes, Some(row.length), row.terminal), "{}", row.label);
        assert_eq!([value("Rp"), value("Rd")], [Some(row.radius); 2], "{}", row.label);
    }
}

#[test]
fn vessels_without_a_common_node_do_not_touch() {
    let network = circle_of_willis(SPACING);
    for a in 0..network.vessel_count() {
        for b in 0..a {
            let (ends, other) = (network.ends(a), network.ends(b));
            let (v, w) = (network.vessel(a), network.vessel(b));
            // The table itself puts 20 mm of arch between radii that add up to 22.7 mm.
            let arch = v.label == "Aortic arch II" && w.label == "Ascending aorta";
            if arch || ends.iter().any(|end| other.contains(end)) {
                continue;
            }
            let apart = v.path.iter().flat_map(|p| w.path.iter().map(move |q| distance(p.position, q.position)));
            let apart = apart.fold(f64::INFINITY, f64::min);
            assert!(apart > v.radius + w.radius + 3e-4, "{} {}: {apart}", v.label, w.label);
        }
    }
}

#[test]
fn right_is_plus_x_and_the_circle_lies_above_the_heart() {
    let network = circle_of_willis(SPACING);
    assert_eq!(network.frame, Frame::Ras);
    for (_, vessel) in network.vessels().filter(|(_, v)| v.label != "L-CCA" && v.label != "R-CCA") {
        let x = vessel.path.iter().map(|p| p.position[0]).sum::<f64>();
        match vessel.label.split_once('-') {
            Some(("L", _)) => assert!(x < 0.0, "{}", vessel.label),
            Some(("R", _)) => assert!(x > 0.0, "{}", vessel.label),
            _ => {}
        }
    }
    let z = |id: usize| network.node(id - 1).position.unwrap()[2];
    assert!(z(22) > z(15) && z(15) > z(2) && z(2) > z(1) && z(9) < z(5));
}

#[test]
fn the_cerebral_part_is_one_ring_with_four_inlets() {
    let network = cerebral(&circle_of_willis(SPACING));
    assert_eq!((network.vessel_count(), network.node_count(), cycles(&network)), (20, 20, 1));
    assert_eq!(fragments(&network, |_, _| true).count, 1);
    let inlets: Vec<&str> = network.nodes().filter(|n| n.role == Some(Role::Inlet)).map(|n| n.id.as_str()).collect();
    assert_eq!(inlets, ["6", "7", "8", "10"]);
    assert_eq!(network.nodes().filter_map(conductance).count(), 6);
}

/// Murray: r³ is kept at every branching, so the ends together take the flow of the root.
#[test]
fn the_tree_keeps_murrays_law() {
    let tree = BranchingTree { generations: 4, ..BranchingTree::default() };
    let network = branching_tree(&tree);
    assert_eq!((network.vessel_count(), network.node_count(), cycles(&network)), (31, 32, 0));
    let total: f64 = network.nodes().filter_map(conductance).sum();
    assert!((total * pascals(100.0) * 6e7 / 250.0 - 1.0).abs() < 1e-12);
    for node in 0..network.node_count() {
        let mut cubes: Vec<f64> =
            network.vessels().filter(|(ends, _)| ends.contains(&node)).map(|(_, v)| v.radius.powi(3)).collect();
        cubes.sort_by(f64::total_cmp);
        assert!(cubes.len() == 1 || (cubes[2] / (cubes[0] + cubes[1]) - 1.0).abs() < 1e-12);
    }
    for row in 0..network.vessel_count() {
        assert!((arc_length(&network, row) / network.vessel(row).length - 1.0).abs() < 1e-9);
    }
    let again = |seed| branching_tree(&BranchingTree { seed, ..tree.clone() }).vessel(5).radius.to_bits();
    assert!(again(0) == again(0) && again(0) != again(1));
}

#[test]
fn a_seed_gives_the_same_bits_and_another_seed_others() {
    for network in bases() {
        let json = |truth: &Truth| {
            let mut out = Vec::new();
            truth.write_json(&mut out).unwrap();
            out
        };
        let (lines, truth) = break_up(&network, &Breaks::default()).unwrap();
        let (again, truth_again) = break_up(&network, &Breaks::default()).unwrap();
        assert_eq!((&lines, json(&truth)), (&again, json(&truth_again)));
        assert_ne!(lines, break_up(&network, &Breaks { seed: 1, ..Breaks::default() }).unwrap().0);
    }
}

/// Every base at many seeds and two levels of damage.
fn each_extraction(check: impl Fn(&Network, &Breaks, &Centerlines, &Truth)) {
    for network in bases() {
        for seed in 0..20 {
            let mild = Breaks { seed, ..Breaks::default() };
            let hard =
                Breaks { junction_gaps: 1.0, double_gaps: 0.5, vessel_gaps: 2.0, lost_ends: 0.5, spacing: 1e-3, ..mild.clone() };
            for params in [mild, hard] {
                let (lines, truth) = break_up(&network, &params).unwrap();
                check(&network, &params, &lines, &truth);
            }
        }
    }
}

#[test]
fn right_bridges_restore_the_parts_of_the_network() {
    each_extraction(|network, _, lines, truth| {
        let bridges: Vec<_> = truth.breaks.iter().map(|gap| gap.ids).collect();
        let spurious = truth.spurious.iter().filter(|s| **s).count();
        assert_eq!(count_parts(lines, &[]), truth.spurious.len());
        assert_eq!(count_parts(lines, &bridges), fragments(network, |_, _| true).count + spurious);
    });
}

#[test]
fn bridges_end_at_loose_ends_of_the_right_vessel() {
    each_extraction(|_, _, lines, truth| {
        let degree = degrees(lines);
        for gap in &truth.breaks {
            let [a, b] = gap.ids.map(|id| id as usize - 1);
            assert_eq!((degree[b], truth.points[b]), (1, Some(gap.vessel)));
            assert!(gap.kind == BreakKind::Junction || (degree[a] == 1 && truth.points[a] == Some(gap.vessel)));
            assert!(truth.points[a].is_some() && gap.length() > 0.0);
        }
    });
}

/// Links join neighbours on the true course only: within a point distance and jitter, and never two sides of a gap.
#[test]
fn no_link_crosses_a_gap() {
    each_extraction(|_, params, lines, truth| {
        let gaps: HashSet<[u64; 2]> = truth.breaks.iter().flat_map(|gap| [gap.ids, [gap.ids[1], gap.ids[0]]]).collect();
        for [a, b] in lines.links.iter().map(|link| link.map(|p| p as usize)) {
            assert!(!gaps.contains(&[lines.ids[a], lines.ids[b]]));
            assert!(distance(lines.points[a], lines.points[b]) < 4.0 * params.spacing);
            assert_eq!(lines.strand[a], lines.strand[b]);
        }
        assert!(truth.breaks.iter().all(|gap| gap.length() > 1.3 * params.spacing));
    });
}

/// Where the whole anatomy has sides, so has what is broken.
#[test]
fn the_frame_is_that_of_the_anatomy() {
    let [circle, cerebral, tree] = bases();
    let lost = without(&cerebral, &["AComm"]).unwrap();
    let of = |network: &Network| break_up(network, &Breaks::default()).unwrap().0.frame;
    assert_eq!([circle.frame, cerebral.frame, lost.frame, of(&lost)], [Frame::Ras; 4]);
    assert_eq!([tree.frame, of(&tree)], [Frame::Unknown; 2]);
}

/// Without jitter every point lies on its vessel, none of them inside a missing stretch.
#[test]
fn missing_stretches_are_empty() {
    for network in bases() {
        for seed in 0..5 {
            let (lines, truth) = break_up(&network, &Breaks { seed, jitter: 0.0, ..Breaks::default() }).unwrap();
            for gap in &truth.breaks {
                let path = &network.vessel(gap.vessel).path;
                let mut arc = 0.0;
                let mut inside = Vec::new();
                for pair in path.windows(2) {
                    arc += distance(pair[0].position, pair[1].position);
                    if arc > gap.stretch[0] + 0.9 * SPACING && arc < gap.stretch[1] - 0.9 * SPACING {
                        inside.push(pair[1].position);
                    }
                }
                let of_vessel = (0..lines.points.len()).filter(|p| truth.points[*p] == Some(gap.vessel));
                for point in of_vessel {
                    assert!(inside.iter().all(|p| distance(*p, lines.points[point]) > 0.5 * SPACING));
                }
            }
        }
    }
}

#[test]
fn spurious_bits_touch_nothing() {
    let mut seen = 0;
    for network in bases() {
        for seed in 0..3 {
            let (lines, truth) = break_up(&network, &Breaks { seed, spurious: 1.0, ..Breaks::default() }).unwrap();
            for point in (0..lines.points.len()).filter(|p| truth.points[*p].is_none()) {
                assert!(truth.spurious[lines.strand[point] as usize]);
                seen += 1;
                for (_, vessel) in network.vessels() {
                    for p in &vessel.path {
                        assert!(distance(p.position, lines.points[point]) > vessel.radius + SPACING);
                    }
                }
                for other in (0..lines.points.len()).filter(|p| lines.strand[*p] != lines.strand[point]) {
                    assert!(distance(lines.points[other], lines.points[point]) > SPACING);
                }
            }
        }
    }
    assert!(seen > 100);
}

#[test]
fn points_are_numbered_as_a_file_would_and_linked_to_one_before() {
    each_extraction(|_, _, lines, truth| {
        let n = lines.points.len();
        assert_eq!([lines.radii.len(), lines.ids.len(), lines.strand.len(), truth.points.len()], [n; 4]);
        assert!(lines.ids.iter().zip(1..).all(|(id, row)| *id == row));
        assert!(lines.strand.windows(2).all(|s| s[1] == s[0] || s[1] == s[0] + 1));
        assert!(lines.radii.iter().all(|r| *r > 0.0));
        let first_links = &lines.links[..n - truth.spurious.len()];
        let children: HashSet<u32> = first_links.iter().map(|[_, child]| *child).collect();
        assert_eq!(children.len(), first_links.len());
        assert!(first_links.iter().all(|[parent, child]| parent < child));
    });
}

/// Over 400 seeds, 10 junctions: binomial, less a few second cuts at an AComm that is too short by then.
#[test]
fn junctions_break_as_often_as_asked() {
    let network = cerebral(&circle_of_willis(SPACING));
    let cuts: usize = (0..400)
        .map(|seed| {
            let params =
                Breaks { seed, junction_gaps: 0.4, double_gaps: 0.0, lost_ends: 0.0, vessel_gaps: 0.0, ..Breaks::default() };
            break_up(&network, &params).unwrap().1.breaks.len()
        })
        .sum();
    let (mean, deviation) = (400.0 * 10.0 * 0.4, (400.0 * 10.0 * 0.4 * 0.6_f64).sqrt());
    assert!((cuts as f64 - mean).abs() < 4.0 * deviation + 0.05 * mean, "{cuts} of about {mean}");
}

#[test]
fn the_default_damage_of_the_head_is_worth_mending() {
    let network = cerebral(&circle_of_willis(SPACING));
    let (lines, truth) = break_up(&network, &Breaks::default()).unwrap();
    let bits = truth.spurious.iter().filter(|s| **s).count();
    println!(
        "{} points, {} fragments, {bits} of them spurious, {} breaks",
        lines.points.len(),
        truth.spurious.len(),
        truth.breaks.len()
    );
    assert!(truth.spurious.len() - bits >= 4 && bits >= 1 && truth.breaks.len() >= 5 && truth.inlets.len() == 4);
}

#[test]
fn the_answer_is_json_with_the_documented_keys() {
    let (lines, truth) = break_up(&cerebral(&circle_of_willis(SPACING)), &Breaks::default()).unwrap();
    let mut out = Vec::new();
    truth.write_json(&mut out).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&out).unwrap();
    let keys: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(HashSet::from_iter(keys), HashSet::from(["vessels", "lost_vessels", "inlets", "fragments", "breaks", "points"]));
    assert_eq!(json["points"].as_array().unwrap().len(), lines.points.len());
    let (first, gap) = (&json["breaks"][0], &truth.breaks[0]);
    assert_eq!(first["ids"][0], gap.ids[0]);
    assert_eq!(first["label"], truth.vessels[gap.vessel].as_str());
    assert_eq!(first["gap_mm"], gap.length() * 1e3);
    assert!(first["kind"] == "junction" || first["kind"] == "vessel");
}

#[test]
fn kinds_are_read_by_name() {
    for kind in Anatomy::ALL {
        assert_eq!(kind.name().parse::<Anatomy>().unwrap(), kind);
    }
    let error = "circle".parse::<Anatomy>().unwrap_err();
    assert_eq!(error.to_string(), "phantom circle: expected circle-of-willis, cerebral, tree, arterial, capillary");
    assert!(
        error.is_usage() && Anatomy::Tree.network(&Recipe { spacing: Some(0.1), ..Recipe::default() }).unwrap_err().is_usage()
    );
}

#[test]
fn a_course_has_its_length_ends_and_even_steps() {
    for (length, swings) in [(1.0, 1), (1.0001, 1), (1.3, 1), (1.9, 3), (2.5, 2)] {
        let (a, b) = ([1.0, 2.0, 3.0], [1.0, 2.0, 4.0]);
        let points = course(a, b, length, Bow { side: [1.0, 1.0, 5.0], swings }, 0.01);
        let steps: Vec<f64> = points.windows(2).map(|p| distance(p[0], p[1])).collect();
        let total: f64 = steps.iter().sum();
        assert!((total - length).abs() < 1e-12, "{length} {total}");
        assert_eq!((points[0], points[points.len() - 1]), (a, b));
        assert!(steps.iter().all(|s| (0.008..0.0102).contains(s)), "{length}");
    }
}
