//! The Circle of Willis as a network: the published lengths, radii and resistances along plausible courses.

use super::alastruey;
use super::alastruey::{NODES, ROOT, TABLE};
use super::curve::course;
use crate::error::{Error, Result};
use crate::network::{Condition, Network, Node, PathPoint, RadiusRule, Role, Vessel};
use crate::support::suggestions::did_you_mean;

/// The whole network of [`TABLE`], its centerlines sampled at about `spacing` (m; 0.5 mm is customary).
///
/// Node ids are the table's numbers. The aortic root is an inlet at 100 mmHg; the 11 ends carry the table's terminal
/// resistance to a venous pressure of 0. Every vessel is observed, and the arc length of its polyline is the table's
/// to rounding. No two vessels without a common node touch, but for the ascending aorta and arch II: the table puts
/// 20 mm of arch between them and their radii add up to 22.7 mm.
///
/// # Panics
///
/// When `spacing` is not positive and finite.
pub fn circle_of_willis(spacing: f64) -> Network {
    assert!(spacing.is_finite() && spacing > 0.0, "spacing {spacing} m is not positive");
    let mut network = Network::new();
    for number in 1..=NODES {
        network.add_node(Node {
            id: number.to_string(),
            position: Some(alastruey::position(number)),
            role: Some(Role::Inner),
            ..Node::default()
        });
    }
    make_inlet(&mut network, ROOT - 1);
    for row in &TABLE {
        let [a, b] = row.nodes.map(alastruey::position);
        let points = course(a, b, row.length, alastruey::bow(row.label), spacing);
        let path = points.into_iter().map(|position| PathPoint { position, radius: row.radius, id: None }).collect();
        let ends = row.nodes.map(|number| number - 1);
        for end in ends {
            let lumen = &mut network.node_mut(end).radius;
            *lumen = Some(lumen.map_or(row.radius, |r| r.max(row.radius)));
        }
        if let Some(resistance) = row.terminal {
            let node = network.node_mut(ends[1]);
            node.role = Some(Role::Outlet);
            node.condition = Some(Condition::Resistance { resistance, venous: 0.0 });
        }
        let along = Vessel::along(path, RadiusRule::Mean);
        network.add_vessel(ends, Vessel { length: row.length, radius: row.radius, label: row.label.to_owned(), ..along });
    }
    network
}

/// The 20 vessels that an angiogram of the head shows: internal carotids, vertebrals, basilar, the circle and the
/// cerebral arteries. Their four proximal ends are inlets at 100 mmHg.
///
/// Vessels are chosen by label; nodes that lose all their vessels go, the others keep id, order and condition.
pub fn cerebral(network: &Network) -> Network {
    const STEMS: [&str; 11] = ["ICA I", "ICA II", "VA", "BA", "PComm", "AComm", "M1", "A1", "A2", "P1", "P2"];
    let shown = |label: &str| {
        let stem = label.strip_prefix("L-").or_else(|| label.strip_prefix("R-")).unwrap_or(label);
        STEMS.contains(&stem)
    };
    let mut part = part(network, |vessel| shown(&vessel.label));
    let degree = part.degrees(|_| true);
    for row in (0..part.node_count()).filter(|row| degree[*row] == 1) {
        if part.node(row).condition.is_none() {
            make_inlet(&mut part, row);
        }
    }
    part
}

/// Makes a node an inlet at 100 mmHg.
pub(crate) fn make_inlet(network: &mut Network, row: usize) {
    let node = network.node_mut(row);
    node.role = Some(Role::Inlet);
    node.condition = Some(Condition::INLET);
}

/// The vessels that `keep` admits. Nodes that lose all their vessels go; the others keep id, order, role and condition.
pub(crate) fn part(network: &Network, keep: impl Fn(&Vessel) -> bool) -> Network {
    let degree = network.degrees(&keep);
    let mut part = Network::new();
    let mut row_of = vec![usize::MAX; network.node_count()];
    for (row, node) in network.nodes().enumerate().filter(|(row, _)| degree[*row] > 0) {
        row_of[row] = part.add_node(node.clone());
    }
    for (ends, vessel) in network.vessels().filter(|(_, vessel)| keep(vessel)) {
        part.add_vessel(ends.map(|end| row_of[end]), vessel.clone());
    }
    part
}

/// The anatomical variant that lacks the vessels of these labels.
///
/// Conditions stay where they were: an end that a missing vessel leaves behind is neither inlet nor outlet.
///
/// # Errors
///
/// No vessel has the label; no inlet or no outlet is left.
pub fn without(network: &Network, labels: &[impl AsRef<str>]) -> Result<Network> {
    let present: Vec<&str> = network.vessels().map(|(_, vessel)| vessel.label.as_str()).collect();
    if let Some(unknown) = labels.iter().map(AsRef::as_ref).find(|label| !present.contains(label)) {
        let meant = did_you_mean(unknown, present.iter().copied());
        let accepted = format!("{meant}expected labels among {}", present.join(", "));
        return Err(Error::parameter("without", format!("\"{unknown}\""), accepted));
    }
    let rest = part(network, |vessel| labels.iter().all(|label| label.as_ref() != vessel.label));
    for role in [Role::Inlet, Role::Outlet] {
        if !rest.nodes().any(|node| node.role == Some(role)) {
            let names: Vec<&str> = labels.iter().map(AsRef::as_ref).collect();
            let accepted = format!("leaves no {}; expected fewer vessels", role.name());
            return Err(Error::parameter("without", format!("\"{}\"", names.join(",")), accepted));
        }
    }
    Ok(rest)
}
