//! The Circle of Willis as a network: the published lengths, radii and resistances along plausible courses.

use super::alastruey::{NODES, ROOT, TABLE};
use super::{curve::course, layout, part::part};
use crate::network::{Condition, INLET_PRESSURE_MMHG, Network, Node, PathPoint, RadiusRule, Role, Vessel};
use crate::units::pascals;

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
            position: Some(layout::position(number)),
            role: Some(Role::Inner),
            ..Node::default()
        });
    }
    make_inlet(&mut network, ROOT - 1);
    for row in &TABLE {
        let [a, b] = row.nodes.map(layout::position);
        let points = course(a, b, row.length, layout::bow(row.label), spacing);
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
pub(super) fn make_inlet(network: &mut Network, row: usize) {
    let node = network.node_mut(row);
    node.role = Some(Role::Inlet);
    node.condition = Some(Condition::Pressure(pascals(INLET_PRESSURE_MMHG)));
}
