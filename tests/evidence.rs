//! What bridges and features may not depend on: the unit of length, the position, the axes, the numbers of the points.

mod common;

use common::Draw;
use willis::candidates::evidence::{Extraction, FEATURES, Search, features, root_features, search};
use willis::centerline::Centerlines;
use willis::geometry::Point;
use willis::network::{Network, Node, RadiusRule, contract};

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
    let (rows, roots) = found(&points, &in_order(&points));
    let at = |x: f64, y: f64| points.at.iter().position(|p| p[0] == x && p[1] == y).expect("a point") as u32;
    let (_, inside, row) = rows.iter().find(|r| r.0 == [at(0.0, 5.0), at(0.0, 0.0)]).expect("the bridge");
    assert!(!inside);
    let expected = [
        ("ln_gap", 2.5_f64.ln()),
        ("gap", 2.5),
        ("ln_voxels", 5_f64.ln()),
        ("wall", 1.5_f64.ln()),
        ("bend_child", 0.0),
        ("bend_far", 0.0),
        ("is_end", 0.0),
        ("t_sin", 1.0),
        ("too_wide", 0.0),
        ("kink", 0.0),
        ("near_tip", (-2_f64).exp()),
        ("near_junction", 0.0),
        ("rank", 0.0),
        ("margin", -2.0),
        ("blocked", 0.0),
        ("slim_parent", 5_f64.ln()),
        ("share_parent", 1.01_f64.ln()),
        ("fed_parent", 1.0),
        ("thick_end", 1.0),
        ("inner_taper", 0.0),
        ("confluence", 0.0),
        ("size", 0.25_f64.ln()),
        ("loop_ratio", 0.0),
    ];
    for (name, value) in expected {
        let column = FEATURES.iter().position(|(n, _)| *n == name).expect("a feature");
        assert!((row[column] - value).abs() < 1e-12, "{name}: {} instead of {value}", row[column]);
    }
    // inlet, slim, share, width, voxels, clutter; the child before the parent by its second column.
    let clutter = 2_f64.ln() - 3.0;
    let child = [1.0, 0.0, 6_f64.ln(), 0.51_f64.ln(), 0.25_f64.ln(), 0.5_f64.ln(), clutter];
    let parent = [1.0, 1.0, 5_f64.ln(), 1.01_f64.ln(), 0.0, 2_f64.ln(), clutter];
    for (x, y) in roots.concat().iter().zip([child, parent].concat()) {
        assert!((x - y).abs() < 1e-12, "{roots:?}");
    }
}

/// Nothing, a lone point, and vessels of which only the nodes are known.
#[test]
fn what_has_no_points_is_no_error() {
    let of = |network: &Network| {
        let extraction = Extraction::new(network, &[]).expect("positions");
        let bridges = search(&extraction, &Search::default());
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
    network.add_vessel([1, 2], common::tube(4.0, 0.5));
    network.add_vessel([3, 4], common::tube(4.0, 0.5));
    // To each other across 1 mm, and the first one to the lone point.
    assert!(of(&network) >= 3);
    network.add_node(Node { id: "nowhere".into(), ..Node::default() });
    let error = Extraction::new(&network, &[]).err().expect("an error").to_string();
    assert!(error.contains("nowhere") && error.contains("position"), "{error}");
}

/// A bridge by its end, its target and whether it is inside; its features.
type Row = ([u32; 2], bool, Vec<f64>);

/// What is found of points, each called by its name in `names`; the extraction's inlet is the point called 0.
fn found(points: &Points, names: &[u32]) -> (Vec<Row>, Vec<Vec<f64>>) {
    let mut lines = Centerlines::default();
    for (row, p) in points.at.iter().enumerate() {
        lines.add_point([p[0], p[1], p[2]], p[3], u64::from(names[row]), row as u32);
    }
    for link in &points.links {
        lines.add_link(*link, "");
    }
    let network = contract(&lines, RadiusRule::Mean, None).expect("vessels").network;
    let inlet = network.nodes().position(|n| n.id == "0").expect("a free end");
    let extraction = Extraction::new(&network, &[inlet]).expect("positions");
    let bridges = search(&extraction, &Search::default());
    let name = |point: usize| match extraction.place[point] {
        willis::candidates::Place::Node(node) => network.node(node).id.parse().expect("a number"),
        willis::candidates::Place::Along { vessel, point } => network.vessel(vessel).path[point].id.expect("a number") as u32,
    };
    let columns = features(&extraction, &bridges);
    let rows = bridges.iter().zip(columns.rows());
    let rows = rows.map(|(b, x)| ([extraction.ends[b.end].point, b.point].map(name), b.inside, x.to_vec()));
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
        for (at, (name, _)) in FEATURES.iter().enumerate() {
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
        same(seed, what, &found(&points, &names), &found(&changed, &names));
    }
}

#[test]
fn the_random_trees_are_worth_it() {
    let (mut between, mut inside, mut at_ends, mut known) = (0, 0, 0, 0);
    let column = |name: &str| FEATURES.iter().position(|(n, _)| *n == name).expect("a feature");
    for seed in 0..40 {
        let points = clean(trees(seed));
        for (_, own, x) in found(&points, &in_order(&points)).0 {
            *(if own { &mut inside } else { &mut between }) += 1;
            at_ends += usize::from(x[column("is_end")] == 1.0);
            known += usize::from(x[column("confluence")] != 0.0);
        }
    }
    assert!(between > 5_000 && inside > 50 && at_ends > 2_000 && known > 100, "{between} {inside} {at_ends} {known}");
}

#[test]
fn the_unit_of_length_does_not_matter() {
    each("metres", |p| *p = p.map(|x| x / 1e3));
    each("voxels", |p| *p = p.map(|x| x / 0.62));
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
        same(seed, "renumbered", &found(&points, &in_order(&points)), &found(&changed, &names));
    }
}
