//! The Circle of Willis as a network: published lengths, radii and resistances, along plausible centerlines.
//!
//! Alastruey, Parker, Peiró, Byrd, Sherwin, *Modelling the circle of Willis to assess the effects of anatomical
//! variations and occlusions on cerebral flows*, J Biomech 40:1794-1805 (2007), table 1: 33 vessels between 30 nodes,
//! one inlet (the aortic root) and 11 outlets with a terminal resistance each. The radius is constant along a vessel.

use std::{str::FromStr, sync::LazyLock};

use super::curve::{Bow, course};
use super::{add_curved_vessel, add_node, state, widen_nodes};
use willis_core::error::{Error, Result};
use willis_core::network::{Condition, Frame, Network, Role, Vessel, metres};
use willis_core::support::{Point, suggestions::did_you_mean};

/// The complete network of [`TABLE`], with centerline points at about `spacing` (m; 0.5 mm is usual).
///
/// Node ids are the table's numbers. The aortic root is an inlet at 100 mmHg; the 11 ends carry the table's terminal
/// resistance to a venous pressure of 0. Every vessel is observed, and the arc length of its polyline is the table's
/// to rounding. Positions are RAS. Vessels without a common node do not touch, except the ascending aorta and arch II: the table puts
/// 20 mm of arch between them, and their radii add up to 22.7 mm.
///
/// # Panics
///
/// When `spacing` is not positive and finite.
pub fn circle_of_willis(spacing: f64) -> Network {
    assert!(spacing.is_finite() && spacing > 0.0, "spacing {spacing} m is not positive");
    let mut network = Network::new();
    network.frame = Frame::Ras;
    for position in &*POSITIONS {
        add_node(&mut network, *position, None);
    }
    state(&mut network, ROOT - 1, Role::Inlet, Condition::INLET);
    for row in &*TABLE {
        let ends = row.nodes.map(|number| number - 1);
        let [a, b] = ends.map(|node| POSITIONS[node]);
        let points = course(a, b, row.length, row.bow, spacing);
        widen_nodes(&mut network, ends, row.radius);
        if let Some(resistance) = row.terminal {
            state(&mut network, ends[1], Role::Outlet, Condition::Resistance { resistance, venous: 0.0 });
        }
        add_curved_vessel(&mut network, ends, points, row.length, row.radius, row.label);
    }
    network
}

/// The 20 vessels that an angiogram of the head shows: internal carotids, vertebrals, basilar, the circle and the
/// cerebral arteries. Their four proximal ends are inlets at 100 mmHg.
///
/// Vessels are chosen by label. Nodes that lose all their vessels go; the others keep id, order and condition.
pub fn cerebral(network: &Network) -> Network {
    const STEMS: [&str; 11] = ["ICA I", "ICA II", "VA", "BA", "PComm", "AComm", "M1", "A1", "A2", "P1", "P2"];
    let is_shown = |label: &str| {
        let stem = label.strip_prefix("L-").or_else(|| label.strip_prefix("R-")).unwrap_or(label);
        STEMS.contains(&stem)
    };
    let mut shown = restricted(network, |vessel| is_shown(&vessel.label));
    let degree = shown.degrees(|_| true);
    for row in (0..shown.node_count()).filter(|row| degree[*row] == 1) {
        if shown.node(row).condition.is_none() {
            state(&mut shown, row, Role::Inlet, Condition::INLET);
        }
    }
    shown
}

/// The network of the vessels that `keep` selects. Nodes that lose all their vessels go; the others keep id, order, role and
/// condition.
fn restricted(network: &Network, keep: impl Fn(&Vessel) -> bool) -> Network {
    let (rest, _) = network.subgraph(|row| keep(network.vessel(row)));
    let degree = rest.degrees(|_| true);
    rest.part(|node| degree[node] > 0).0
}

/// The anatomical variant without the vessels of these labels.
///
/// Boundary conditions stay where they were: a node that becomes an end is neither inlet nor outlet.
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
    let rest = restricted(network, |vessel| labels.iter().all(|label| label.as_ref() != vessel.label));
    for role in [Role::Inlet, Role::Outlet] {
        if !rest.nodes().any(|node| node.role == Some(role)) {
            let names: Vec<&str> = labels.iter().map(AsRef::as_ref).collect();
            let accepted = format!("leaves no {}; expected fewer vessels", role.name());
            return Err(Error::parameter("without", format!("\"{}\"", names.join(",")), accepted));
        }
    }
    Ok(rest)
}

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArteryRow {
    /// The usual name with its side. The whole middle cerebral artery is called M1.
    pub label: &'static str,
    /// The table's numbers of the two nodes, counted from 1.
    pub nodes: [usize; 2],
    /// Length, m.
    pub length: f64,
    /// Radius, m.
    pub radius: f64,
    /// Peripheral resistance at the second node, Pa s/m³, if the vessel ends there.
    pub terminal: Option<f64>,
    /// How it curves between its nodes, which the table does not say.
    pub bow: Bow,
}

/// The table's number of the aortic root, the inlet.
pub const ROOT: usize = 1;

/// The 33 vessels in the order of the table.
pub static TABLE: LazyLock<Vec<ArteryRow>> = LazyLock::new(|| {
    let row = |line: &'static str| {
        let columns: Vec<&str> = line.split(',').collect();
        ArteryRow {
            label: columns[0],
            nodes: [number(columns[1]), number(columns[2])],
            length: number(columns[3]),
            radius: number(columns[4]),
            terminal: (!columns[5].is_empty()).then(|| number(columns[5])),
            bow: Bow { side: [number(columns[6]), number(columns[7]), number(columns[8])], swings: number(columns[9]) },
        }
    };
    include_str!("alastruey_vessels.csv").lines().skip(1).map(row).collect()
});

/// The positions of the table's nodes 1 to 30, m.
static POSITIONS: LazyLock<Vec<Point>> = LazyLock::new(|| {
    let row = |line: &str| {
        let columns: Vec<f64> = line.split(',').take(3).map(number).collect();
        [0, 1, 2].map(|axis| metres(columns[axis]))
    };
    include_str!("alastruey_nodes.csv").lines().skip(1).map(row).collect()
});

/// A number of a table. The tables are part of the program, and every row of them is read with the first phantom: nothing that a user gives gets here.
fn number<T: FromStr>(word: &str) -> T {
    word.parse().unwrap_or_else(|_| panic!("{word} is no number"))
}
