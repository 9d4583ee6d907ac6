//! What bridges and features may not depend on: the unit of length, the position, the axes, the numbers of the points.

use crate::draw::Draw;
use crate::extracted::extracted;
use crate::vessels;
use willis::internals::candidates::features::{
    Extraction, FEATURES, FEEDBACK_FEATURES, features, feedback_features, log_detour, measured, relative_size, root_features,
};
use willis::internals::candidates::search::{EndCandidate, SearchOptions, search};
use willis::internals::forest_posterior;
use willis::internals::forest_posterior::{Forests, marginals};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::{Network, Node, RadiusRule, contract};
use willis::internals::support::geometry::Point;

/// Points with their radii, and links, in mm.
#[derive(Clone, Default)]
struct Points {
    at: Vec<[f64; 4]>,
    links: Vec<[u32; 2]>,
}

/// Winding trees on a grid of half voxels, as extractions are: every distance is shared by many pairs.
fn trees(seed: u64) -> Points {
    const VOXEL: f64 = 0.62;
    let mut draw = Draw::new(seed);
    let mut points = Points::default();
    let grid = |x: f64, step: f64| (x / step).round() * step;
    for fragment in 0..14 {
        let mut starts = vec![(None, [0, 1, 2].map(|_| draw.within(0.0, 14.0)))];
        let radius = draw.within(0.3, 1.4);
        for branch in 0..=fragment % 4 {
            let (mut from, mut p): (Option<u32>, Point) = starts[draw.below(starts.len())];
            let mut heading = [0, 1, 2].map(|_| draw.within(-1.0, 1.0));
            for _ in 0..6 + draw.below(16) {
                heading = heading.map(|x| x + draw.within(-0.4, 0.4));
                let length = heading.iter().map(|x| x * x).sum::<f64>().sqrt();
                p = [0, 1, 2].map(|axis| p[axis] + VOXEL * heading[axis] / length);
                let [x, y, z] = p.map(|x| grid(x, 0.5 * VOXEL));
                let thin = radius * 0.8_f64.powi(branch) * draw.within(0.8, 1.25);
                let row = points.at.len() as u32;
                points.at.push([x, y, z, grid(thin, 0.25 * VOXEL).max(0.25 * VOXEL)]);
                if let Some(from) = from {
                    points.links.push([from, row]);
                }
                (from, starts) = (Some(row), [starts, vec![(Some(row), p)]].concat());
            }
        }
    }
    points
}

/// A straight vessel of 20 mm along x, 2 mm in radius, blood from its left end, and a thin one that ends 5 mm above its middle,
/// pointing down; a point each mm.
fn branch_above_a_vessel() -> Points {
    let mut points = Points::default();
    let parent = (-10..=10).map(|x| [f64::from(x), 0.0, 0.0, 2.0]);
    let child = (5..=15).map(|y| [0.0, f64::from(y), 0.0, 0.5]);
    for line in [parent.collect::<Vec<_>>(), child.collect()] {
        let first = points.at.len() as u32;
        points.links.extend((1..line.len() as u32).map(|i| [first + i - 1, first + i]));
        points.at.extend(line);
    }
    points
}

/// Solved by hand: d = 5, D = 2 · 0.5 + 1 = 2, r = 2, h = 1; no bend; met at a right angle, 10 mm from either end; no rival.
#[test]
fn the_features_of_a_branch_above_a_vessel() {
    let points = branch_above_a_vessel();
    let (rows, roots) = found(&points, &in_order(&points), true);
    let at = |x: f64, y: f64| points.at.iter().position(|p| p[0] == x && p[1] == y).expect("a point") as u32;
    let (_, inside, row) = rows.iter().find(|r| r.0 == [at(0.0, 5.0), at(0.0, 0.0)]).expect("the bridge");
    assert!(!inside);
    // Beyond the wall at 2 it is 3 mm, 1.5 widths; ln r_c/r_p = ln 1/4.
    let thin = 0.25_f64.ln();
    let expected = [
        ("is_end", 0.0),
        ("gap", 2.5),
        ("gap_end", 0.0),
        ("gap_branch", 2.5),
        ("wall", 1.5_f64.ln()),
        ("wall_branch", 1.5),
        ("wall_over_1_5", 0.0),
        ("wall_over_3", 0.0),
        ("touch_branch", 0.0),
        ("resolution_branch", 2_f64.ln()),
        ("bend_child", 0.0),
        ("bend_child_sq", 0.0),
        ("bend_gap", 0.0),
        ("bend_far", 0.0),
        ("bend_parent", 0.0),
        ("bend_parent_sq", 0.0),
        ("turn", 0.0),
        ("ratio_end", 0.0),
        ("ratio_end_sq", 0.0),
        ("ratio_branch", thin),
        ("ratio_branch_sq", thin * thin),
        ("kink", 0.0),
        ("kink_wide", 0.0),
        ("kink_excess", 0.0),
        ("orientation", 0.0),
        ("near_tip", (-2_f64).exp()),
        ("near_junction", 0.0),
        ("rank", 0.0),
        ("margin", -2.0),
        ("mutual", 0.0),
        ("blocked", 0.0),
        ("share_parent", 1.01_f64.ln()),
        ("fed_parent", 1.0),
    ];
    assert_eq!(expected.len(), FEATURES.len());
    for (name, value) in expected {
        let column = FEATURES.iter().position(|(n, _)| *n == name).expect("a feature");
        assert!((row[column] - value).abs() < 1e-12, "{name}: {} instead of {value}", row[column]);
    }
    // one, inlet, slim, share, width, resolution, clutter, radius_variation, free_ends, junctions, then inlet, slim, share and width
    // times clutter; the child before the parent by its second column.
    let clutter = 2_f64.ln() - 3.0;
    let child = [1.0, 0.0, 6_f64.ln(), 0.51_f64.ln(), 0.25_f64.ln(), 0.5_f64.ln(), clutter, 0.0, 2_f64.ln(), 0.0];
    let parent = [1.0, 1.0, 5_f64.ln(), 1.01_f64.ln(), 0.0, 2_f64.ln(), clutter, 0.0, 2_f64.ln(), 0.0];
    let crossed = |z: [f64; 10]| [z.to_vec(), [1, 2, 3, 4].map(|k| z[k] * clutter).to_vec()].concat();
    for (x, y) in roots.concat().iter().zip([crossed(child), crossed(parent)].concat()) {
        assert!((x - y).abs() < 1e-12, "{roots:?}");
    }
}

/// By hand, a mm a point: a vessel from (-10, 0) to (10, 0), 2 mm in radius up to x = 3 and 1 beyond, blood from its left end; a child
/// from (0, 5) up to (0, 15); a third from (6, 5) up to (6, 15).
#[test]
fn the_feedback_on_a_branch_of_a_tapering_vessel() {
    let mut points = branch_above_a_vessel();
    points.at.iter_mut().filter(|p| p[1] == 0.0 && p[0] > 3.0).for_each(|p| p[3] = 1.0);
    let first = points.at.len() as u32;
    points.at.extend((5..=15).map(|y| [6.0, f64::from(y), 0.0, 0.5]));
    points.links.extend((1..11).map(|i| [first + i - 1, first + i]));
    let network = contract(&centerlines(&points, &in_order(&points)), RadiusRule::Mean, None).expect("vessels").network;
    let node = |x: f64, y: f64| {
        let there = |n: &Node| n.position.is_some_and(|p| (p[0] - x).hypot(p[1] - y) < 1e-9);
        network.nodes().position(there).expect("a node")
    };
    let extraction = extracted(&network, &[node(-10.0, 0.0)]).expect("positions");
    let end = |x: f64, y: f64| extraction.end_at[node(x, y)].expect("a free end");
    let on_vessel = |x: f64| extraction.position.iter().position(|p| p[1] == 0.0 && (p[0] - x).abs() < 1e-9).expect("a point");
    let bridges = [
        (end(0.0, 5.0), on_vessel(3.0)),
        (end(6.0, 5.0), on_vessel(5.0)),
        (end(6.0, 15.0), node(0.0, 15.0)),
        (end(0.0, 15.0), node(10.0, 0.0)),
        (end(10.0, 0.0), node(6.0, 5.0)),
    ];
    let bridges = bridges.map(|(end, point)| EndCandidate { end, point, within: false });
    let fragment = |place: usize| extraction.fragment[place];
    let log_weights = [0.3, -0.2, 0.5, -1.0, 0.1];
    let each = bridges.iter().zip(log_weights).map(|(b, log_weight)| forest_posterior::Edge {
        child: extraction.ends[b.end].fragment,
        parent: fragment(b.point),
        log_weight,
    });
    let roots: Vec<f64> = vec![0.2, -0.3, -0.4];
    let forests = Forests::new(roots.clone(), each.collect()).expect("forests");
    let all = marginals(&forests);
    let got = feedback_features(&extraction, &bridges, &forests, &all);
    let p = &all.edges;
    let [vessel, child, third] = [node(-10.0, 0.0), node(0.0, 5.0), node(6.0, 5.0)].map(fragment);
    // Blood enters the vessel on the left with the inlet, on the right with the last bridge.
    let more = all.roots[vessel] - p[4];
    // From the child's end to the right with the flow, from the third's to the left against it.
    let conf2 = [-more * 3.0 / 34_f64.sqrt(), more / 26_f64.sqrt()];
    // A walk steps from one to another with odds w and dies with odds v; it may end in the vessel before it comes to the child.
    let w = log_weights.map(f64::exp);
    let [vessel_root, child_root, third_root] = [vessel, child, third].map(|f| roots[f].exp());
    let stays = vessel_root / (vessel_root + w[4]);
    let back = w[1] / (w[1] + w[2] + third_root);
    let without_child = stays / (1.0 - (1.0 - stays) * back);
    let by_child = (w[0] + w[3]) / (w[0] + w[3] + child_root);
    let ln_2 = 2_f64.ln();
    let expected = [
        [conf2[0], more * ln_2, 0.0, 0.0, without_child, p[1]],
        // The vessel's own bridge to this end of the third is no claim of another.
        [conf2[1], more * ln_2, 0.0, 0.0, stays, p[0]],
        // The child's upper end may hang on the vessel instead.
        [0.0, 0.0, p[3], 0.0, by_child * stays, 0.0],
        // The vessel's right end may hang on the third; the third claims the child's upper end.
        [0.0, 0.0, p[4], p[2], without_child, 0.0],
        // The child claims the vessel's right end; nothing but the vessel is fed.
        [0.0, 0.0, 0.0, p[3], 0.0, 0.0],
    ];
    assert!(p.iter().all(|p| *p > 0.01) && more.abs() > 0.01);
    for (row, values) in expected.iter().enumerate() {
        for (name, (value, got)) in FEEDBACK_FEATURES.iter().zip(values.iter().zip(got.row(row))) {
            assert!((value - got).abs() < 1e-12, "{name} of bridge {row}: {got} instead of {value}");
        }
    }
}

/// On a loop blood comes from both sides; elsewhere on the same fragment it does not.
#[test]
fn a_loop_has_no_direction() {
    // A ring of 24 points, 2 mm from its centre at 0, with a tail along +x to 12, and a vessel above each.
    let mut points = Points::default();
    let angle = |i: u32| f64::from(i) * std::f64::consts::TAU / 24.0;
    points.at.extend((0..24).map(|i| [2.0 * angle(i).cos(), 2.0 * angle(i).sin(), 0.0, 0.3]));
    points.links.extend((0..24).map(|i| [i, (i + 1) % 24]));
    points.at.extend((5..=24).map(|x| [0.5 * f64::from(x), 0.0, 0.0, 0.3]));
    points.links.extend((0..20).map(|i| [if i == 0 { 0 } else { 23 + i }, 24 + i]));
    for x in [-2.0, 6.25] {
        let first = points.at.len() as u32;
        points.at.extend((2..12).map(|z| [x, 0.0, 0.5 * f64::from(z), 0.2]));
        points.links.extend((1..10).map(|i| [first + i - 1, first + i]));
    }
    let network = contract(&centerlines(&points, &in_order(&points)), RadiusRule::Mean, None).expect("vessels").network;
    let inlet = network.nodes().position(|n| n.position.is_some_and(|p| p[0] > 11.9)).expect("the tail's end");
    let extraction = extracted(&network, &[inlet]).expect("positions");
    let bridges: Vec<EndCandidate> =
        search(&extraction, &SearchOptions::default()).unwrap().into_iter().filter(|b| !b.within).collect();
    let forests = weighed(&extraction, &bridges);
    let got = feedback_features(&extraction, &bridges, &forests, &marginals(&forests));
    let (mut on_ring, mut on_tail) = (0, 0);
    for (bridge, x) in bridges.iter().zip(got.rows()).filter(|(b, _)| extraction.end_at[b.point].is_none()) {
        let p = extraction.position[bridge.point];
        let ring = p[0].hypot(p[1]) < 2.1 && p[2] == 0.0;
        let tail = p[0] > 2.1 && p[2] == 0.0;
        assert!(!ring || x[0] == 0.0);
        on_ring += usize::from(ring);
        on_tail += usize::from(tail && x[0].abs() > 1e-3);
    }
    assert!(on_ring > 2 && on_tail > 2, "{on_ring} {on_tail}");
}

/// Two free ends 1 mm apart of a vessel along a square of 3 mm: the path is 11 mm.
#[test]
fn a_gap_in_a_ring_has_a_detour() {
    let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
    let side = |k: usize, i: usize| {
        [0, 1].map(|axis| corners[k][axis] + (corners[(k + 1) % 4][axis] - corners[k][axis]) * i as f64 / 3.0)
    };
    let mut points = Points::default();
    points.at.extend((0..12).map(|i| side(i / 3, i % 3)).map(|[x, y]| [x, y, 0.0, 0.4]));
    points.links.extend((1..12).map(|i| [i - 1, i]));
    let network = contract(&centerlines(&points, &in_order(&points)), RadiusRule::Mean, None).expect("vessels").network;
    let extraction = extracted(&network, &[]).expect("positions");
    let bridges = [EndCandidate { end: 0, point: extraction.ends[1].point, within: true }];
    let measured = &measured(&extraction, &bridges)[0];
    assert!((log_detour(measured) - 11_f64.ln()).abs() < 1e-12 && relative_size(measured) == 0.0);
}

/// On winding trees: as a search of all of the fragment from each free end has it, which does not end where the candidates are reached.
#[test]
fn a_detour_is_that_of_a_search_of_everything() {
    let mut count = 0;
    for seed in 0..20 {
        let points = clean(trees(seed));
        let network = contract(&centerlines(&points, &in_order(&points)), RadiusRule::Mean, None).expect("vessels").network;
        let extraction = extracted(&network, &[]).expect("positions");
        let bridges = search(&extraction, &SearchOptions::default()).unwrap();
        for (bridge, measured) in bridges.iter().zip(measured(&extraction, &bridges)).filter(|(bridge, _)| bridge.within) {
            let whole = extraction.graph.to_nearest(&[extraction.ends[bridge.end].point])[bridge.point];
            assert_eq!(measured.detour, Some((whole / measured.gap).min(200.0)), "{seed}");
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
}

/// Nothing, a lone point, and vessels of which only the nodes are known.
#[test]
fn what_has_no_points_is_no_error() {
    let of = |network: &Network| {
        let extraction = extracted(network, &[]).expect("positions");
        let bridges = search(&extraction, &SearchOptions::default()).unwrap();
        assert!(features(&extraction, &bridges).iter().chain(&root_features(&extraction)).all(|x| x.is_finite()));
        bridges.len()
    };
    let mut network = Network::new();
    assert_eq!(of(&network), 0);
    let at = |x: f64| Node { id: x.to_string(), position: Some([x * 1e-3, 0.0, 0.0]), ..Node::default() };
    network.add_node(at(0.0));
    assert_eq!(of(&network), 0);
    for x in [1.0, 5.0, 6.0, 10.0] {
        network.add_node(at(x));
    }
    network.add_vessel([1, 2], vessels::tube(4.0, 0.5));
    network.add_vessel([3, 4], vessels::tube(4.0, 0.5));
    // To each other across 1 mm, and the first one to the lone point.
    assert!(of(&network) >= 3);
    network.add_node(Node { id: "nowhere".into(), ..Node::default() });
    let error = extracted(&network, &[]).err().expect("an error").to_string();
    assert!(error.contains("nowhere") && error.contains("position"), "{error}");
}

/// A bridge by its end, its target and whether it is inside; its features.
type Row = ([u32; 2], bool, Vec<f64>);

/// Forests with some weights that depend on the bridges alone.
fn weighed(extraction: &Extraction, bridges: &[EndCandidate]) -> Forests {
    let x = features(extraction, bridges);
    let each = bridges.iter().zip(x.rows()).map(|(bridge, x)| forest_posterior::Edge {
        child: extraction.ends[bridge.end].fragment,
        parent: extraction.fragment[bridge.point],
        log_weight: -x[1] - x[2],
    });
    let roots = root_features(extraction).rows().into_iter().map(|z| z[2] - 4.0).collect();
    Forests::new(roots, each.collect()).expect("forests")
}

/// Points with their names.
fn centerlines(points: &Points, names: &[u32]) -> Centerlines {
    let mut lines = Centerlines::default();
    for (row, p) in points.at.iter().enumerate() {
        lines.add_point([p[0], p[1], p[2]], p[3], u64::from(names[row]), row as u32);
    }
    for link in &points.links {
        lines.add_link(*link, "");
    }
    lines
}

/// What is found of points, each called by its name in `names`; the extraction's inlet is the point called 0, or none is known.
fn found(points: &Points, names: &[u32], inlet: bool) -> (Vec<Row>, Vec<Vec<f64>>) {
    let network = contract(&centerlines(points, names), RadiusRule::Mean, None).expect("vessels").network;
    let inlets: Vec<usize> = network.nodes().position(|n| n.id == "0").into_iter().filter(|_| inlet).collect();
    let extraction = extracted(&network, &inlets).expect("positions");
    let bridges = search(&extraction, &SearchOptions::default()).unwrap();
    let name = |point: usize| match extraction.place[point] {
        willis::internals::candidates::NetworkPoint::Node(node) => network.node(node).id.parse().expect("a number"),
        willis::internals::candidates::NetworkPoint::Along { vessel, point } => {
            network.vessel(vessel).path[point].id.expect("a number") as u32
        }
    };
    let columns = features(&extraction, &bridges);
    let between: Vec<EndCandidate> = bridges.iter().copied().filter(|b| !b.within).collect();
    let forests = weighed(&extraction, &between);
    let feedback = feedback_features(&extraction, &between, &forests, &marginals(&forests));
    let mut feedback = feedback.rows().into_iter();
    let rows = bridges.iter().zip(columns.rows()).map(|(b, x)| {
        let more = if b.within { vec![0.0; FEEDBACK_FEATURES.len()] } else { feedback.next().expect("a row").to_vec() };
        ([extraction.ends[b.end].point, b.point].map(name), b.within, [x.to_vec(), more].concat())
    });
    let mut rows: Vec<Row> = rows.collect();
    rows.sort_by_key(|row| (row.0, row.1));
    let mut roots: Vec<Vec<f64>> = root_features(&extraction).rows().into_iter().map(|r| r.to_vec()).collect();
    roots.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    (rows, roots)
}

fn in_order(points: &Points) -> Vec<u32> {
    (0..points.at.len() as u32).collect()
}

/// Links that have a length, and what they join.
fn clean(mut points: Points) -> Points {
    let at = points.at.clone();
    points.links.retain(|[a, b]| at[*a as usize][..3] != at[*b as usize][..3]);
    points
}

fn same(seed: u64, what: &str, one: &(Vec<Row>, Vec<Vec<f64>>), other: &(Vec<Row>, Vec<Vec<f64>>)) {
    let bridges = |f: &(Vec<Row>, _)| f.0.iter().map(|(ends, inside, _)| (*ends, *inside)).collect::<Vec<_>>();
    let (a, b) = (bridges(one), bridges(other));
    let apart = a.iter().filter(|x| !b.contains(x)).chain(b.iter().filter(|x| !a.contains(x))).collect::<Vec<_>>();
    assert!(apart.is_empty(), "{what} {seed}: {apart:?}");
    for (x, y) in one.0.iter().zip(&other.0) {
        for (at, name) in FEATURES.iter().map(|(n, _)| n).chain(FEEDBACK_FEATURES).enumerate() {
            assert!((x.2[at] - y.2[at]).abs() < 1e-9, "{what} {seed}: {name} of {:?}: {} or {}", x.0, x.2[at], y.2[at]);
        }
    }
    for (x, y) in one.1.iter().flatten().zip(other.1.iter().flatten()) {
        assert!((x - y).abs() < 1e-9, "{what} {seed}: a root's {x} or {y}");
    }
}

fn each(what: &str, change: impl Fn(&mut [f64; 4])) {
    for seed in 0..40 {
        let points = clean(trees(seed));
        let mut changed = points.clone();
        changed.at.iter_mut().for_each(&change);
        let names = in_order(&points);
        same(seed, what, &found(&points, &names, seed % 2 == 0), &found(&changed, &names, seed % 2 == 0));
    }
}

#[test]
fn the_random_trees_are_worth_it() {
    let (mut between, mut inside, mut at_ends, mut told) = (0, 0, 0, [0; 7]);
    let column = |name: &str| FEATURES.iter().position(|(n, _)| *n == name).expect("a feature");
    for seed in 0..40 {
        let points = clean(trees(seed));
        for (_, own, x) in found(&points, &in_order(&points), true).0 {
            *(if own { &mut inside } else { &mut between }) += 1;
            at_ends += usize::from(x[column("is_end")] == 1.0);
            // The orientation, and each feature of the feedback.
            let says = [&x[column("orientation")..=column("orientation")], &x[FEATURES.len()..]].concat();
            told.iter_mut().zip(says).for_each(|(told, x)| *told += usize::from(x.abs() > 0.01));
        }
    }
    assert!(between > 5_000 && inside > 50 && at_ends > 2_000, "{between} {inside} {at_ends}");
    assert!(told.iter().all(|told| *told > 100), "{told:?}");
}

#[test]
fn the_unit_of_length_does_not_matter() {
    each("metres", |p| *p = p.map(|x| x / 1e3));
    each("resolution", |p| *p = p.map(|x| x / 0.62));
}

#[test]
fn position_and_axes_do_not_matter() {
    each("moved", |p| *p = [p[0] + 124.0, p[1] - 31.0, p[2] + 6.2, p[3]]);
    each("turned", |p| *p = [-p[1], p[2], -p[0], p[3]]);
    each("mirrored", |p| p[0] = -p[0]);
}

#[test]
fn the_numbers_of_the_points_do_not_matter() {
    for seed in 0..40 {
        let points = clean(trees(seed));
        let mut draw = Draw::new(seed + 1000);
        // new_row[old row]
        let mut new_row = in_order(&points);
        draw.shuffle(&mut new_row);
        let mut changed = points.clone();
        let mut names = new_row.clone();
        for (old, new) in new_row.iter().enumerate() {
            changed.at[*new as usize] = points.at[old];
            names[*new as usize] = old as u32;
        }
        for link in &mut changed.links {
            *link = [new_row[link[1] as usize], new_row[link[0] as usize]];
        }
        draw.shuffle(&mut changed.links);
        let inlet = seed % 2 == 0;
        same(seed, "renumbered", &found(&points, &in_order(&points), inlet), &found(&changed, &names, inlet));
    }
}
