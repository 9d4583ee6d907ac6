//! What is one vessel at a contact, on vessels drawn by hand. Truth: the drawings themselves, lengths added up in the comments.

use serde_json::json;
use willis::internals::network::{Network, Node, Origin, PathPoint, RadiusRule, Vessel};
use willis::internals::support::geometry::Point;
use willis::internals::training::contact_truth::ContactTruth;

/// The truth of vessels that nowhere join, each given by its points, mm: a station at every point, and a node of the skeleton that shows it.
/// `inside` are other nodes, each with the station that it shows.
fn truth(vessels: &[&[Point]], inside: &[(Point, usize)]) -> ContactTruth {
    let (mut points, mut adjacent) = (Vec::new(), Vec::new());
    for vessel in vessels {
        for (n, at) in vessel.iter().enumerate() {
            if n > 0 {
                let apart = (0..3).map(|k| (at[k] - vessel[n - 1][k]).powi(2)).sum::<f64>().sqrt();
                adjacent.push(json!([points.len() - 1, points.len(), apart, "there", [0.0, 0.0, 0.0], 1.0]));
            }
            points.push(*at);
        }
    }
    let row = |[x, y, z]: Point| [x, y, z, 0.5];
    let stations: Vec<[f64; 4]> = points.iter().copied().map(row).collect();
    let mut shown: Vec<Vec<usize>> = (1..=stations.len()).map(|id| vec![id]).collect();
    let mut nodes = stations.clone();
    for (at, station) in inside {
        nodes.push(row(*at));
        shown[*station].push(nodes.len());
    }
    let file = json!({"voxel_mm": 0.5, "nodes": nodes, "stations": stations, "station_nodes": shown, "adjacent": adjacent});
    ContactTruth::read(file.to_string().as_bytes()).expect("a truth")
}

/// A network with observed vessels through points (mm), from node to node, a contact between nodes 0 and 1, and a candidate where given.
fn opened(nodes: &[Point], vessels: &[(usize, usize, &[Point])], candidate: Option<[usize; 2]>) -> Network {
    let mut network = Network::new();
    for (row, at) in nodes.iter().enumerate() {
        network.add_node(Node { id: row.to_string(), position: Some(at.map(|x| x / 1e3)), ..Node::default() });
    }
    let line = |points: &[Point]| {
        let path = points.iter().map(|at| PathPoint { position: at.map(|x| x / 1e3), radius: 5e-4, id: None });
        Vessel::along(path.collect(), RadiusRule::Mean)
    };
    for (a, b, between) in vessels {
        let points = [&[nodes[*a]], *between, &[nodes[*b]]].concat();
        network.add_vessel([*a, *b], line(&points));
    }
    for (ends, origin) in candidate.map(|ends| (ends, Origin::Candidate)).into_iter().chain([([0, 1], Origin::Contact)]) {
        network.add_vessel(ends, Vessel::new(1e-4, 5e-4, origin));
    }
    network
}

/// Points every half millimetre along x, at y and z = 0.
fn along_x(from: i32, to: i32) -> Vec<Point> {
    (2 * from..=2 * to).map(|n| [f64::from(n) / 2.0, 0.0, 0.0]).collect()
}

fn along_y(from: f64, count: u32) -> Vec<Point> {
    (0..count).map(|n| [0.0, from + 0.5 * f64::from(n), 0.0]).collect()
}

#[test]
fn what_lies_between_two_points_of_a_line_says_nothing() {
    // X runs along x. Y begins at (0, 1.6, 0). The skeleton leads from X to Y, and its node at (0, 0.9, 0) is still in the lumen of X.
    let (x, y, inside) = (along_x(-6, 6), along_y(1.6, 10), [0.0, 0.9, 0.0]);
    let nodes = [[0.0; 3], [0.0; 3], [-6.0, 0.0, 0.0], [6.0, 0.0, 0.0], y[9]];
    let spur = [&[inside], &y[..9]].concat();
    let network = opened(&nodes, &[(2, 0, &x[1..12]), (0, 3, &x[13..24]), (1, 4, &spur)], None);
    // (0, 1.1, 0) is more than a millimetre away and nearer to that node than to Y, but it is no point of the line.
    assert_eq!(truth(&[&x, &y], &[(inside, 12)]).contacts(&network), [Some(false)]);
    // Were Y the other half of the left of X, they would be one vessel.
    let bent = [&x[..13], &[inside], &y].concat();
    assert_eq!(truth(&[&bent, &x[13..]], &[]).contacts(&network), [Some(true)]);
}

#[test]
fn a_line_that_comes_back_to_the_same_vessel_is_not_that_vessel() {
    // X goes along x to 3, along y to 4 and back to (-4, 4, 0). Y leads from (0, 0, 0) to where it touches X again, (0, 4, 0).
    let corner = |points: &[(f64, f64)]| points.iter().map(|(x, y)| [*x, *y, 0.0]).collect::<Vec<Point>>();
    let first =
        corner(&[(1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (3.0, 2.0), (3.0, 3.0), (3.0, 4.0), (2.0, 4.0), (1.0, 4.0)]);
    let second = corner(&[(-1.0, 4.0), (-2.0, 4.0), (-3.0, 4.0)]);
    let before = corner(&[(-3.0, 0.0), (-2.0, 0.0), (-1.0, 0.0)]);
    let y = corner(&[(0.0, 1.2), (0.0, 2.0), (0.0, 2.8)]);
    let x = [
        corner(&[(-4.0, 0.0)]),
        before.clone(),
        corner(&[(0.0, 0.0)]),
        first.clone(),
        corner(&[(0.0, 4.0)]),
        second.clone(),
        corner(&[(-4.0, 4.0)]),
    ]
    .concat();
    let nodes = [[0.0; 3], [0.0; 3], [-4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [-4.0, 4.0, 0.0]];
    let network = opened(&nodes, &[(2, 0, &before), (0, 3, &first), (3, 4, &second), (1, 3, &y)], None);
    // From (3, 2, 0), 5 mm along X, to (0, 4, 0) it is another 5 mm, less than 5 + 4 by way of the contact. But the point at (0, 4, 0) is
    // where lines meet, and says nothing of Y.
    assert_eq!(truth(&[&x, &y], &[]).contacts(&network), [Some(false)]);
    // On a line without other points further out than a millimetre it is all there is.
    let short = opened(&nodes, &[(2, 0, &before), (0, 3, &first), (3, 4, &second), (1, 3, &[])], None);
    assert_eq!(truth(&[&x, &y], &[]).contacts(&short), [Some(true)]);
}

#[test]
fn a_candidate_does_not_end_what_a_side_shows() {
    // One vessel, cut at (0, 0, 0). On its right a candidate goes off half a millimetre away.
    let x = along_x(-6, 6);
    let nodes = [[0.0; 3], [0.0; 3], [-6.0, 0.0, 0.0], [0.5, 0.0, 0.0], [6.0, 0.0, 0.0], [0.5, 3.0, 0.0]];
    let vessels: [(usize, usize, &[Point]); 3] = [(2, 0, &x[1..12]), (1, 3, &[]), (3, 4, &x[14..24])];
    assert_eq!(truth(&[&x], &[]).contacts(&opened(&nodes, &vessels, Some([3, 5]))), [Some(true)]);
    // Without what lies beyond it, the right side shows nothing.
    assert_eq!(truth(&[&x], &[]).contacts(&opened(&nodes, &vessels[..2], Some([3, 5]))), [None]);
    // Two vessels end to end, of which the truth says that nothing joins them.
    assert_eq!(truth(&[&x[..12], &x[13..]], &[]).contacts(&opened(&nodes, &vessels, None)), [Some(false)]);
}

/// A way along vessels has no negative length, along which a search would never end, and a voxel has a size.
#[test]
fn lengths_that_no_vessel_has_are_refused() {
    let of = |voxel: f64, length: f64| {
        let nodes = [[0.0, 0.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.5]];
        let adjacent = json!([[0, 1, length, "there", [0.0, 0.0, 0.0], 1.0]]);
        let file =
            json!({"voxel_mm": voxel, "nodes": nodes, "stations": nodes, "station_nodes": [[1], [2]], "adjacent": adjacent});
        ContactTruth::read(file.to_string().as_bytes()).map(drop).map_err(|fault| fault.in_file("a.json".as_ref()).to_string())
    };
    assert_eq!(of(0.5, 1.0), Ok(()));
    for (found, words) in [(of(0.5, -1.0), "adjacent 0: -1 mm"), (of(0.0, 1.0), "voxel_mm: 0"), (of(-0.5, 1.0), "voxel_mm: -0.5")]
    {
        assert!(found.as_ref().is_err_and(|said| said.contains(words)), "{found:?}");
    }
}
