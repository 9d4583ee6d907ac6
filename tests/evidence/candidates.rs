//! The rules of candidates, on random fragments: what is joined, what never is, how long and wide.

use std::collections::{BTreeMap, BTreeSet};

use crate::draw::Draw;
use crate::vessels;
use willis::internals::candidates::model::{Weights, posterior};
use willis::internals::candidates::over_connected::{Bounds, groups};
use willis::internals::candidates::resample::{CenterlineKind, Resampled};
use willis::internals::candidates::search::point_index::PointIndex;
use willis::internals::candidates::search::{EndCandidate, SearchOptions, search};
use willis::internals::candidates::{Attach, CandidateOptions, CandidateRadius, NEAREST, build, build_with_evidence};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::{Network, Node, Origin, PathPoint, RadiusRule, Vessel, Wall, contract};
use willis::internals::support::geometry::{Point, distance, norm_squared, sub};

/// Winding fragments in a box of 30 mm, points about 0.7 mm apart; every third has a side branch. Lengths in m.
fn fragments(draw: &mut Draw, count: usize) -> Vec<Vec<[f64; 4]>> {
    let mut lines: Vec<Vec<[f64; 4]>> = Vec::new();
    for i in 0..count {
        let start = if i % 3 == 2 {
            let parent = &lines[i - 1];
            parent[parent.len() / 2]
        } else {
            let position = [0, 1, 2].map(|_| draw.within(0.0, 0.03));
            [position[0], position[1], position[2], draw.within(4e-4, 1.5e-3)]
        };
        let heading = [0, 1, 2].map(|_| draw.within(-5e-4, 5e-4));
        let mut line = vec![start];
        for _ in 0..5 + draw.below(20) {
            let [x, y, z, r] = line[line.len() - 1];
            let mut step = |axis: usize| heading[axis] + draw.within(-3e-4, 3e-4);
            let next = [x + step(0), y + step(1), z + step(2)];
            line.push([next[0], next[1], next[2], r * draw.within(0.95, 1.04)]);
        }
        lines.push(line);
    }
    lines
}

fn assemble(lines: &[Vec<[f64; 4]>]) -> Network {
    let mut c = Centerlines::default();
    for (strand, line) in lines.iter().enumerate() {
        for (i, p) in line.iter().enumerate() {
            if i > 0 {
                c.links.push([c.points.len() as u32 - 1, c.points.len() as u32]);
            }
            c.ids.push(c.points.len() as u64);
            c.points.push([p[0], p[1], p[2]]);
            c.radii.push(p[3]);
            c.strand.push(strand as u32);
        }
    }
    c.weld(1e-9);
    contract(&c, RadiusRule::Mean, None).unwrap().network
}

fn free(network: &Network) -> Vec<bool> {
    network.degrees(|v| v.origin == Origin::Observed).into_iter().map(|d| d == 1).collect()
}

fn own(network: &Network, end: usize) -> usize {
    (0..network.vessel_count()).find(|row| network.ends(*row).contains(&end)).unwrap()
}

/// The mean radius over the last ten points of the vessel of a free end.
fn end_radius(network: &Network, end: usize) -> f64 {
    let row = own(network, end);
    let mut radii: Vec<f64> = network.vessel(row).path.iter().map(|p| p.radius).collect();
    if network.ends(row)[1] == end {
        radii.reverse();
    }
    radii.truncate(10);
    radii.iter().sum::<f64>() / radii.len() as f64
}

/// What candidates are looked for on: the same vessels, with points at one step.
fn seen(network: &Network) -> Resampled {
    Resampled::new(network, CenterlineKind::Tracing)
}

fn position(network: &Network, node: usize) -> Point {
    network.node(node).position.unwrap()
}

/// The candidates as (free end, other node, vessel).
fn candidates(graph: &Network) -> Vec<(usize, usize, &Vessel)> {
    graph.vessels().filter(|(_, v)| v.origin == Origin::Candidate).map(|([a, b], v)| (a, b, v)).collect()
}

fn each(check: impl Fn(&Network, &CandidateOptions, &Network)) {
    for seed in 0..30 {
        let network = assemble(&fragments(&mut Draw::new(seed), 12));
        for attach in [Attach::Centerline, Attach::Ends] {
            for (k, max_gap, max_radius, radius) in
                [(6, None, None, CandidateRadius::Min), (2, Some(5e-3), Some(7e-4), CandidateRadius::Mean)]
            {
                let params = CandidateOptions { k: Some(k), max_gap, attach, radius, max_radius, ..CandidateOptions::default() };
                check(&network, &params, &build(&network, &params).unwrap());
            }
        }
    }
}

#[test]
fn the_random_fragments_are_worth_it() {
    let mut cuts = 0;
    each(|network, _, graph| assert!(graph.node_count() >= network.node_count() && !candidates(graph).is_empty()));
    for seed in 0..30 {
        let network = assemble(&fragments(&mut Draw::new(seed), 12));
        cuts += build(&network, &CandidateOptions::default()).unwrap().node_count() - network.node_count();
    }
    assert!(cuts > 100, "{cuts}");
}

/// Not its own vessel, no pair twice, none that a vessel joins already; from free ends, at most k from each.
#[test]
fn excluded_pairs_are_not_joined() {
    each(|network, params, graph| {
        let is_free = free(network);
        let mut pairs: BTreeSet<[usize; 2]> = network.vessels().map(|([a, b], _)| [a.min(b), a.max(b)]).collect();
        let mut from = vec![0; network.node_count()];
        for (end, other, _) in candidates(graph) {
            assert!(end < network.node_count() && is_free[end]);
            from[end] += 1;
            assert!(pairs.insert([end.min(other), end.max(other)]), "{end} and {other} again");
            let there = position(graph, other);
            let on_own = network.vessel(own(network, end)).path.iter().any(|p| distance(p.position, there) < 1e-12);
            assert!(!on_own, "{end} to {other} on its own vessel");
            assert!(params.attach == Attach::Centerline || is_free[other]);
        }
        assert!(from.into_iter().all(|n| n <= params.k.unwrap_or(NEAREST)));
    });
}

/// A straight gap, no longer than the reach of 20 steps and 5 end diameters, nor than `max_gap`. 1e-12 for what a
/// figure in millimetres rounds.
#[test]
fn a_candidate_is_as_long_as_its_gap_and_within_reach() {
    each(|network, params, graph| {
        let seen = seen(network);
        for (end, other, vessel) in candidates(graph) {
            let gap = distance(position(graph, end), position(graph, other));
            assert!((vessel.length - gap).abs() <= 1e-12 * gap);
            let reach = 20.0 * seen.step + 10.0 * end_radius(&seen.network, end);
            let reach = params.max_gap.map_or(reach, |most| reach.min(most));
            assert!(gap <= reach * (1.0 + 1e-9), "{params:?}: {end} to {other}: {gap} of {reach}");
        }
    });
}

/// From its two ends: the mean over the last ten points at a free end, the local radius elsewhere; capped.
#[test]
fn a_candidate_is_as_wide_as_its_ends_allow() {
    each(|network, params, graph| {
        let (is_free, seen) = (free(network), seen(network).network);
        for (end, other, vessel) in candidates(graph) {
            let a = end_radius(&seen, end);
            let b = if other < network.node_count() && is_free[other] {
                end_radius(&seen, other)
            } else {
                graph.node(other).radius.unwrap()
            };
            let radius = if params.radius == CandidateRadius::Min { a.min(b) } else { 0.5 * (a + b) };
            let radius = params.max_radius.map_or(radius, |most| radius.min(most));
            assert!((vessel.radius - radius).abs() <= 1e-12 * radius, "{params:?}: {} for {radius}", vessel.radius);
            assert!((vessel.prior, vessel.certain) == (1.0, false));
        }
    });
}

/// Nodes keep their rows, vessels their order; the parts of a vessel follow one another and are as long as the whole.
#[test]
fn split_vessels_keep_their_length_and_order() {
    each(|network, _, graph| {
        for row in 0..network.node_count() {
            assert_eq!(network.node(row).id, graph.node(row).id);
        }
        let ids: BTreeSet<&str> = graph.nodes().map(|n| n.id.as_str()).collect();
        assert_eq!(ids.len(), graph.node_count());
        let mut parts = graph.vessels().filter(|(_, v)| v.origin == Origin::Observed);
        for (ends, vessel) in network.vessels() {
            let (mut length, mut resistance, mut at) = (0.0, 0.0, ends[0]);
            while length == 0.0 || at != ends[1] {
                let ([from, to], part) = parts.next().unwrap();
                assert_eq!(from, at);
                assert!(length == 0.0 || from >= network.node_count());
                assert_eq!(part.label, vessel.label);
                (length, at) = (length + part.length, to);
                resistance += part.length * part.radius;
            }
            assert!((length - vessel.length).abs() <= 1e-12 * length);
            // The mean radius over arc length adds up too.
            assert!((resistance / length - vessel.radius).abs() <= 1e-12 * vessel.radius);
        }
        assert!(parts.next().is_none());
    });
}

/// Between free ends alone, brute force: each end to the k nearest others within its reach, its own vessel's left out.
#[test]
fn ends_are_joined_to_their_nearest_neighbours() {
    each(|network, params, graph| {
        if params.attach == Attach::Centerline {
            return;
        }
        let (is_free, seen) = (free(network), seen(network));
        let ends: Vec<usize> = (0..network.node_count()).filter(|n| is_free[*n]).collect();
        let mut expected = BTreeSet::new();
        for end in &ends {
            let reach = 20.0 * seen.step + 10.0 * end_radius(&seen.network, *end);
            let reach = params.max_gap.map_or(reach, |most| reach.min(most));
            let others = ends.iter().filter(|o| !network.ends(own(network, *end)).contains(o));
            let mut near: Vec<(f64, usize)> =
                others.map(|o| (distance(position(network, *end), position(network, *o)), *o)).filter(|n| n.0 <= reach).collect();
            near.sort_by(|a, b| a.partial_cmp(b).unwrap());
            expected.extend(near.iter().take(params.k.unwrap_or(NEAREST)).map(|(_, o)| [*end.min(o), *end.max(o)]));
        }
        let got: BTreeSet<[usize; 2]> = candidates(graph).iter().map(|(a, b, _)| [*a.min(b), *a.max(b)]).collect();
        assert_eq!(got, expected);
    });
}

/// The places that candidates join, in micrometres, free of rows and directions.
fn joined(graph: &Network) -> BTreeSet<[[i64; 3]; 2]> {
    let place = |node: usize| position(graph, node).map(|x| (x * 1e6).round() as i64);
    candidates(graph).into_iter().map(|(a, b, _)| [place(a).min(place(b)), place(a).max(place(b))]).collect()
}

/// The order of the polylines in the file and the direction of each are nobody's choice, and change nothing: between free
/// ends, whose random distances do not tie, and to branches while k leaves none out (those of one junction can tie in
/// their nearest point, and then the k-th place goes by row).
#[test]
fn the_order_and_direction_of_vessels_is_irrelevant() {
    let all = CandidateOptions { k: Some(1000), ..CandidateOptions::default() };
    for params in [all, CandidateOptions { attach: Attach::Ends, ..CandidateOptions::default() }] {
        for seed in 0..20 {
            let mut draw = Draw::new(seed);
            let mut lines = fragments(&mut draw, 12);
            let base = joined(&build(&assemble(&lines), &params).unwrap());
            draw.shuffle(&mut lines);
            for line in &mut lines {
                if draw.below(2) == 0 {
                    line.reverse();
                }
            }
            assert!(base == joined(&build(&assemble(&lines), &params).unwrap()), "seed {seed}, {params:?}");
        }
    }
}

/// No length in the rules: a network four times as large has the same graph.
#[test]
fn the_graph_does_not_depend_on_the_unit() {
    let ends = |graph: &Network| graph.vessels().map(|(ends, _)| ends).collect::<Vec<_>>();
    for seed in 0..20 {
        let mut lines = fragments(&mut Draw::new(seed), 12);
        let base = ends(&build(&assemble(&lines), &CandidateOptions::default()).unwrap());
        lines.iter_mut().flatten().flatten().for_each(|x| *x *= 4.0);
        assert_eq!(base, ends(&build(&assemble(&lines), &CandidateOptions::default()).unwrap()), "seed {seed}");
    }
}

/// A vessel along the x axis from `from` to `to` in mm, a point every 0.5 mm.
fn straight(from: f64, to: f64, y: f64, radius_mm: f64) -> Vessel {
    let n = ((to - from) / 0.5).abs().round() as u32;
    let points = (0..=n).map(|i| PathPoint {
        position: [(from + (to - from) * f64::from(i) / f64::from(n)) * 1e-3, y * 1e-3, 0.0],
        radius: radius_mm * 1e-3,
        id: None,
    });
    Vessel::along(points.collect(), RadiusRule::Mean)
}

fn located(vessels: Vec<([usize; 2], Vessel)>, radius_of_nodes: Option<f64>) -> Network {
    let mut network = Network::new();
    let nodes = vessels.iter().flat_map(|(ends, _)| *ends).max().unwrap() + 1;
    for row in 0..nodes {
        let (ends, vessel) = vessels.iter().find(|(ends, _)| ends.contains(&row)).unwrap();
        let point = if ends[0] == row { &vessel.path[0] } else { &vessel.path[vessel.path.len() - 1] };
        network.add_node(Node {
            id: row.to_string(),
            position: Some(point.position),
            radius: radius_of_nodes,
            ..Node::default()
        });
    }
    for (ends, vessel) in vessels {
        network.add_vessel(ends, vessel);
    }
    network
}

/// A vessel of a ready graph states its length, which is not that of its points, its resistance and its wall. Where candidates divide it, the
/// parts have these together: lengths and resistances in a row add up.
#[test]
fn divided_vessels_keep_what_is_stated_of_the_whole() {
    let wall = Some(Wall::Elastic { young: 4e5, thickness: 1e-4 });
    let whole = Vessel { length: 0.025, resistance: Some(3e9), wall, kept: Some(true), ..straight(0.0, 20.0, 0.0, 0.5) };
    let end = [8.0, 4.0, 3.5].map(|y| PathPoint { position: [7e-3, y * 1e-3, 0.0], radius: 5e-4, id: None });
    let network = located(vec![([0, 1], whole), ([2, 3], Vessel::along(end.to_vec(), RadiusRule::Mean))], Some(5e-4));
    let graph = build(&network, &CandidateOptions::default()).unwrap();
    let parts = || graph.vessels().filter(|(_, vessel)| vessel.wall == wall).map(|(_, vessel)| vessel);
    assert!(parts().count() > 1 && parts().all(|part| part.kept == Some(true)));
    assert!((parts().map(|part| part.length).sum::<f64>() - 0.025).abs() < 1e-12);
    assert!((parts().map(|part| part.resistance.expect("stated")).sum::<f64>() / 3e9 - 1.0).abs() < 1e-12);
    // A vessel of even width resists in proportion to its length.
    assert!(parts().all(|part| (part.resistance.expect("stated") / part.length / (3e9 / 0.025) - 1.0).abs() < 1e-9));
}

/// A junction at x = 0 of three vessels of 1 mm and an end that points at it from 3 mm above. A ready graph need not give
/// the radius of its nodes; the candidate must still have one that the vessels there have.
#[test]
fn a_junction_without_a_radius_takes_that_of_its_vessels() {
    let down = [4.0, 3.0].map(|y| PathPoint { position: [0.0, y * 1e-3, 0.0], radius: 1e-3, id: None });
    let up = [-5.0, 0.0].map(|y| PathPoint { position: [0.0, y * 1e-3, 0.0], radius: 1e-3, id: None });
    let vessels = vec![
        ([0, 1], straight(-5.0, 0.0, 0.0, 1.0)),
        ([1, 2], straight(0.0, 5.0, 0.0, 1.0)),
        ([3, 1], Vessel::along(up.to_vec(), RadiusRule::Mean)),
        ([4, 5], Vessel::along(down.to_vec(), RadiusRule::Mean)),
    ];
    let graph = build(&located(vessels, None), &CandidateOptions::default()).unwrap();
    let to_the_junction: Vec<&Vessel> =
        candidates(&graph).into_iter().filter(|(a, b, _)| *b == 1 && *a == 5).map(|(_, _, v)| v).collect();
    assert!(!to_the_junction.is_empty());
    for vessel in candidates(&graph).into_iter().map(|(_, _, v)| v) {
        assert!((vessel.radius - 1e-3).abs() < 1e-15, "{} m", vessel.radius);
    }
}

/// A point at 1 mm from the end is met; the free end of that branch, 1.5 mm further, is where snapping moves the candidate:
/// never beyond `max_gap`.
#[test]
fn snapping_keeps_to_the_longest_gap() {
    let end = [8.0, 4.0, 3.5].map(|y| PathPoint { position: [1.0 * 1e-3, y * 1e-3, 0.0], radius: 5e-4, id: None });
    let vessels = vec![([0, 1], straight(0.0, 20.0, 0.0, 0.5)), ([2, 3], Vessel::along(end.to_vec(), RadiusRule::Mean))];
    let network = located(vessels, Some(5e-4));
    let params = CandidateOptions { max_gap: Some(3.55e-3), ..CandidateOptions::default() };
    let graph = build(&network, &params).unwrap();
    for (a, b, vessel) in candidates(&graph) {
        assert!(vessel.length <= 3.55e-3, "{a} to {b}: {} m", vessel.length);
    }
}

/// Neighbours at equal distance come in node order: of four ends on a square around an end, k = 2 takes the first two.
#[test]
fn equal_distances_come_in_node_order() {
    let out = |angle: f64| {
        let points = [2.0, 4.0].map(|r| PathPoint {
            position: [r * 1e-3 * angle.cos().round(), r * 1e-3 * angle.sin().round(), 0.0],
            radius: 5e-4,
            id: None,
        });
        Vessel::along(points.to_vec(), RadiusRule::Mean)
    };
    let center = [0.0, -3.0].map(|z| PathPoint { position: [0.0, 0.0, z * 1e-3], radius: 5e-4, id: None });
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut vessels: Vec<_> = (0..4).map(|i| ([2 * i, 2 * i + 1], out(quarter * i as f64))).collect();
    vessels.push(([8, 9], Vessel::along(center.to_vec(), RadiusRule::Mean)));
    let params = CandidateOptions { k: Some(2), attach: Attach::Ends, max_gap: Some(2.5e-3), ..CandidateOptions::default() };
    let graph = build(&located(vessels, Some(5e-4)), &params).unwrap();
    let from_center: Vec<usize> = candidates(&graph).iter().filter(|c| c.0 == 8).map(|c| c.1).collect();
    let to_center: BTreeSet<usize> = candidates(&graph).iter().filter(|c| c.1 == 8).map(|c| c.0).collect();
    // Every end sees the center alone within 2.5 mm; the center's own two are among those, met from the other side.
    assert_eq!((from_center, to_center), (vec![], BTreeSet::from([0, 2, 4, 6])));
    let params = CandidateOptions { max_gap: Some(2.5e-3), k: Some(1), ..params };
    let mut vessels: Vec<_> = (0..4).map(|i| ([2 * i + 2, 2 * i + 3], out(quarter * i as f64))).collect();
    vessels.insert(0, ([0, 1], Vessel::along(center.to_vec(), RadiusRule::Mean)));
    let graph = build(&located(vessels, Some(5e-4)), &params).unwrap();
    assert_eq!(candidates(&graph)[0].1, 2);
}

#[test]
fn parameters_out_of_range_are_named() {
    let wrong = [
        ("k", CandidateOptions { k: Some(0), ..CandidateOptions::default() }),
        ("max_gap", CandidateOptions { max_gap: Some(0.0), ..CandidateOptions::default() }),
        ("max_candidate_radius", CandidateOptions { max_radius: Some(f64::NAN), ..CandidateOptions::default() }),
    ];
    for (name, params) in wrong {
        assert!(params.validate().unwrap_err().to_string().starts_with(name));
        assert!(build(&Network::new(), &params).is_err());
    }
    let error = build(&vessels::network(1, []), &CandidateOptions::default()).unwrap_err();
    assert!(error.to_string().contains("coordinates"));
}

/// 20,000 short vessels on a lattice of 5 mm. Each may be joined to the six around it, along the vessels 4 mm away and across 5 mm, and each to
/// each by way of others: the elimination of a cube of 28 x 28 x 26 places brings together 1.5 10⁹ pairs (counted by another program). So the
/// reason names that limit, not the reach of the fragments; and what it proposes works: shorter candidates join them in rows.
#[test]
fn a_lattice_of_fragments_is_refused_for_what_it_is() {
    const SIDE: usize = 28;
    let mut network = Network::new();
    for i in 0..20_000 {
        let at = [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(|step| 5e-3 * step as f64);
        let points: Vec<Point> = (0..3).map(|k| [at[0] + 5e-4 * f64::from(k), at[1], at[2]]).collect();
        let ends = [0, 2]
            .map(|k: usize| network.add_node(Node { id: format!("{i}.{k}"), position: Some(points[k]), ..Node::default() }));
        let path = points.iter().map(|position| PathPoint { id: None, position: *position, radius: 5e-4 }).collect();
        network.add_vessel(ends, Vessel { path, ..Vessel::new(1e-3, 5e-4, Origin::Observed) });
    }
    let weights = Weights::shipped().unwrap();
    let with = |options: &CandidateOptions| build_with_evidence(&network, &[], options, &weights).map(|(graph, _)| graph);
    let said = with(&CandidateOptions::default()).unwrap_err().to_string();
    assert!(said.starts_with("fragments 20000"), "{said}");
    assert!(said.contains("more than 500000000 pairs") && said.contains("`max_gap` below 5.000 mm"), "{said}");
    let joined = with(&CandidateOptions { max_gap: Some(4.5e-3), ..CandidateOptions::default() }).unwrap();
    assert!(joined.vessel_count() > 20_000 + 19_000);
}

/// What the book says of P ("What each P means"), on random fragments: P is the sum of the marginals of both directions between two
/// points, calibrated by that sum and by the whole input. The marginals of what excludes each other add up to 1 at the most, by the theory of forests: all ways of one fragment with its root
/// to 1, all between two fragments to 1, all together to the fragments less one. P is of each pair of points by itself, and adds up to more.
#[test]
fn what_each_p_means() {
    let weights = Weights::shipped().unwrap();
    let mut most = 0.0_f64;
    for seed in 0..24 {
        let network = assemble(&fragments(&mut Draw::new(seed), 24));
        let e = Resampled::new(&network, CenterlineKind::Tracing).extraction(&[]).unwrap();
        let found = posterior(&e, &search(&e, &SearchOptions::default()).unwrap(), &weights).unwrap();
        let (mut of_points, mut of_child) = (BTreeMap::new(), found.marginals.roots.clone());
        let (mut of_fragments, mut of_p) = (BTreeMap::new(), BTreeMap::new());
        let points = |c: &EndCandidate| {
            let [a, b] = [e.ends[c.end].point, c.point];
            [a.min(b), a.max(b)]
        };
        let sides = |c: &EndCandidate| {
            let [a, b] = points(c).map(|point| e.fragment[point]);
            [a.min(b), a.max(b)]
        };
        for (candidate, marginal) in found.table.candidates.iter().zip(&found.marginals.edges) {
            *of_points.entry(points(candidate)).or_insert(0.0) += marginal;
            *of_fragments.entry(sides(candidate)).or_insert(0.0) += marginal;
            of_child[e.ends[candidate.end].fragment] += marginal;
        }
        let [a, b, c] = weights.calibration;
        let [of_m, of_s, of_both] = weights.of_input;
        let n = found.marginals.roots.len() as f64;
        let attached = n - found.marginals.roots.iter().sum::<f64>();
        let (m, s) = (((attached + 1.0) / (n - attached + 1.0)).ln(), 10.0 / (n + 10.0));
        let of_input = of_m * m + of_s * s + of_both * m * s;
        let mut told = BTreeMap::new();
        for (candidate, p) in found.table.candidates.iter().zip(&found.probability) {
            let sum: f64 = of_points[&points(candidate)];
            let sum = sum.clamp(1e-12, 1.0 - 1e-12);
            let log_odds = (sum / (1.0 - sum)).ln();
            let expected = 1.0 / (1.0 + (-(a + b * log_odds + c * log_odds.min(0.0) + of_input)).exp());
            assert!((p - expected).abs() < 1e-12, "{p} for {expected}");
            if told.insert(points(candidate), *p).is_none() {
                *of_p.entry(sides(candidate)).or_insert(0.0) += p;
            }
        }
        let fragments = e.fragments.len() as f64;
        assert!(fragments > 5.0 && of_child.iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{of_child:?}");
        assert!(of_fragments.values().all(|sum| *sum <= 1.0 + 1e-9), "{of_fragments:?}");
        assert!(found.marginals.edges.iter().sum::<f64>() <= fragments - 1.0 + 1e-9);
        most = of_p.into_values().fold(most, f64::max);
    }
    assert!(most > 1.0, "{most}");
}

fn unit_box(at: [f64; 3]) -> Bounds {
    at.map(|x| [x, x + 1.0])
}

/// By hand: two boxes touch along x but not along y; a third is apart along z once these two are.
#[test]
fn boxes_that_a_plane_separates_are_apart() {
    let boxes = [[0.0, 0.0, 0.0], [0.5, 3.0, 0.0], [0.2, 0.5, 5.0], [0.9, 0.9, 0.0]].map(unit_box);
    let mut found = groups(&boxes);
    for group in &mut found {
        group.sort_unstable();
    }
    found.sort();
    assert_eq!(found, [vec![0, 3], vec![1], vec![2]]);
    let grid: Vec<Bounds> = (0..27_000).map(|i| unit_box([i % 30, i / 30 % 30, i / 900].map(|x| 2.0 * f64::from(x)))).collect();
    assert_eq!(groups(&grid).len(), grid.len());
}

/// Points of which many have coordinates in common, or all, and a cloud.
fn point_sets() -> Vec<Vec<Point>> {
    let lattice = (0..343).map(|i| [i % 7, i / 7 % 7, i / 49].map(f64::from)).collect();
    let line = (0..300).map(|i| [f64::from(i % 100), 1.0, 2.0]).collect();
    let plane = (0..400).map(|i| [3.0, f64::from(i % 20), f64::from(i / 20) * 0.1]).collect();
    let mut draw = Draw::new(3);
    let cloud = (0..400).map(|_| [0, 1, 2].map(|_| draw.within(0.0, 6.0))).collect();
    vec![lattice, line, plane, cloud, vec![[1.0; 3]; 50], vec![[0.5, 1.0, 2.0]], Vec::new()]
}

#[test]
fn the_tree_finds_what_brute_force_finds_ties_included() {
    for points in point_sets() {
        let index = PointIndex::new(points.clone());
        for p in points.iter().step_by(3).chain(&[[-3.0, 1.0, 0.5]]) {
            let squared: Vec<f64> = points.iter().map(|q| norm_squared(sub(*q, *p))).collect();
            let away: Vec<f64> = squared.iter().map(|d2| d2.sqrt()).collect();
            let least = away.iter().copied().fold(f64::INFINITY, f64::min);
            for reach in [0.0, 1.0, 1.5, 2.0] {
                let mut expected: Vec<(f64, usize)> =
                    squared.iter().copied().zip(0..).filter(|(d2, _)| *d2 <= reach * reach).collect();
                expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
                let expected: Vec<(f64, usize)> = expected.into_iter().map(|(d2, i)| (d2.sqrt(), i)).collect();
                assert_eq!(index.within(*p, reach), expected);
                assert_eq!(index.count(*p, reach), expected.len());
                let mut around = index.around(*p, reach);
                around.sort_by_key(|(_, i)| *i);
                let mut by_number = expected.clone();
                by_number.sort_by_key(|(_, i)| *i);
                assert_eq!(around, by_number);
                assert_eq!(index.first(*p, expected.len()), expected);
                let fewer = expected.len().saturating_sub(1);
                assert_eq!(index.first(*p, fewer), expected[..fewer]);
                let nearest = index.nearest(*p, reach);
                let all: Vec<usize> =
                    (0..points.len()).filter(|i| least <= reach * (1.0 + 1e-9) && away[*i] <= least * (1.0 + 1e-9)).collect();
                assert_eq!(nearest.points, all);
                assert_eq!(nearest.distance, if all.is_empty() { f64::INFINITY } else { least });
            }
        }
    }
}

/// A coordinate with a wrong exponent makes a vessel of 2e11 mm: it gets 200,000 points and not as many as memory holds.
#[test]
fn a_far_coordinate_makes_no_endless_vessel() {
    let line = |far: f64| {
        assemble(&[vec![[0.0, 0.0, 0.0, 1e-3], [5e-3, 0.0, 0.0, 1e-3], [1e-2, 0.0, 0.0, 1e-3], [far, 0.0, 0.0, 1e-3]]])
    };
    let points = |far: f64| Resampled::new(&line(far), CenterlineKind::Tracing).network.vessel(0).path.len();
    assert_eq!(points(2e8), 200_001);
    // One that no limit touches. By hand: the cube root of π · 1 mm² · 1 m over 30 is .4882 mm, which is 2,048 steps.
    assert_eq!(points(1.0), 2049);
}

/// Ten thousand fragments in a box of 5 mm: 20,000 ends, each with 40,000 points in its reach. By hand, 8e8 points, of which none is looked at.
#[test]
fn a_crowd_is_refused_by_the_count_of_its_points() {
    let mut draw = Draw::new(9);
    let mut lines = Vec::new();
    for _ in 0..10_000 {
        let [x, y, z] = [0, 1, 2].map(|_| draw.within(0.0, 5e-3));
        lines.push((0..4).map(|i| [x + 5e-4 * f64::from(i), y, z, 5e-4]).collect());
    }
    let error = build(&assemble(&lines), &CandidateOptions::default()).expect_err("refused");
    assert!(error.to_string().starts_with("free ends 20000, with more than 300000000 points within their reach"), "{error}");
}
